//! Whether a closed part of a surface encloses some space twice, found by lines through it.
//!
//! A line enters and leaves a body by turns. Where it enters a second time before it has left, the part crosses itself,
//! as a tube that runs through its own wall. To find all such places, every triangle would have to be compared with
//! those near it, which takes longer than everything else that preparation does. Lines in a grid find every overlap that
//! is wider than a cell of the grid, and only then triangles are compared.
//!
//! ```text
//! for each axis, for each triangle, for each line along the axis through it:
//!     note the line, the part, the height, and whether the line enters or leaves
//! sort the notes; the part crosses itself if its count of entries less exits is ever not 0 or 1
//! ```
//!
//! A part of which the edges say that it [may be several solids](super::pairing) is not probed but always compared.
//!
//! **Why no line counts an edge twice:** the side of an edge on which a line passes is computed from the edge alone, its
//! lesser vertex first, so both triangles there get the same answer to the last bit.
//!
//! **Cost:** O(n), with a small constant: most triangles of a fine mesh lie between lines.

use nalgebra::Point3;
use rayon::prelude::*;

use super::parts::Part;
use super::{BLOCK, tree::Bounds, triangle};

/// Lines along each side of the box.
const LINES: usize = 48;

/// Where in its cell a line is: nowhere near a coordinate that anybody writes.
const OFFSET: f64 = 0.618_033_988_749_894_9;

/// A line meets a triangle.
#[derive(Debug, Clone, Copy)]
struct Crossing {
    line: u32,
    height: f64,
    enters: bool,
}

/// For each part, wound outward where it is closed, whether it encloses some space twice; `tolerance` is the length
/// below which that is rounding.
pub(super) fn crosses_itself(
    vertices: &[Point3<f64>],
    triangles: &[[u32; 3]],
    parts: &[Part],
    bounds: &Bounds,
    tolerance: f64,
) -> Vec<bool> {
    let crosses = |part: &Part| {
        let probed = |axis: usize| {
            let lines = Lines {
                vertices,
                triangles,
                bounds,
                axis,
            };
            lines.overlap(&part.triangles, tolerance)
        };
        part.closed && (part.ambiguous || (0..3).any(probed))
    };
    parts.par_iter().map(crosses).collect()
}

/// Lines along one axis.
struct Lines<'a> {
    vertices: &'a [Point3<f64>],
    triangles: &'a [[u32; 3]],
    bounds: &'a Bounds,
    axis: usize,
}

impl Lines<'_> {
    fn overlap(&self, part: &[u32], tolerance: f64) -> bool {
        let blocks = part.par_chunks(BLOCK).map(|block| {
            let mut found = Vec::new();
            block
                .iter()
                .for_each(|&number| self.cross(number, &mut found));
            found
        });
        let mut crossings: Vec<Crossing> = blocks.collect::<Vec<_>>().concat();
        crossings.sort_by(|a, b| {
            a.line
                .cmp(&b.line)
                .then(a.height.total_cmp(&b.height))
                .then(b.enters.cmp(&a.enters))
        });
        crossings.chunk_by(|a, b| a.line == b.line).any(|line| {
            let mut depth = 0_i32;
            line.windows(2).any(|pair| {
                depth += if pair[0].enters { 1 } else { -1 };
                !(0..=1).contains(&depth) && pair[1].height - pair[0].height > tolerance
            })
        })
    }

    /// Adds the crossings of the lines through a triangle.
    fn cross(&self, number: u32, found: &mut Vec<Crossing>) {
        let indices = self.triangles[number as usize];
        let corners = triangle::corners(self.vertices, indices);
        let [first, second] = [(self.axis + 1) % 3, (self.axis + 2) % 3];
        let range = |along: usize| {
            let low = self.bounds.low[along];
            let cell = (self.bounds.high[along] - low) / LINES as f64;
            let place = |x: f64| (x - low) / cell - OFFSET;
            let [a, b, c] = corners.map(|corner| corner[along]);
            let begin = place(a.min(b).min(c)).ceil().max(0.0);
            let end = (place(a.max(b).max(c)).floor() + 1.0).min(LINES as f64);
            (begin as usize..end.max(0.0) as usize, low, cell)
        };
        let (columns, left, width) = range(first);
        if columns.is_empty() {
            return;
        }
        let (rows, bottom, depth) = range(second);
        for row in rows {
            let y = bottom + (row as f64 + OFFSET) * depth;
            for column in columns.clone() {
                let x = left + (column as f64 + OFFSET) * width;
                let is_left = |from: usize, to: usize| {
                    let ordered = indices[from] < indices[to];
                    let (low, high) = if ordered { (from, to) } else { (to, from) };
                    let (a, b) = (&corners[low], &corners[high]);
                    let cross = (b[first] - a[first]) * (y - a[second])
                        - (b[second] - a[second]) * (x - a[first]);
                    (cross >= 0.0) == ordered
                };
                let sides = [is_left(0, 1), is_left(1, 2), is_left(2, 0)];
                if sides[0] != sides[1] || sides[1] != sides[2] {
                    continue;
                }
                let normal = triangle::normal(&corners);
                let a = &corners[0];
                let rise = normal[first] * (x - a[first]) + normal[second] * (y - a[second]);
                let heights = corners.map(|corner| corner[self.axis]);
                let [low, high] = [f64::min, f64::max].map(|pick| heights.into_iter().reduce(pick));
                let height = (a[self.axis] - rise / normal[self.axis])
                    .max(low.unwrap_or_default())
                    .min(high.unwrap_or_default());
                found.push(Crossing {
                    line: (row * LINES + column) as u32,
                    height,
                    // Seen from above, a triangle whose corners run to the left faces up, so the line leaves there.
                    enters: !sides[0],
                });
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::parts::Parts;
    use crate::mesh::{RawMesh, solids};

    fn crosses(raw: &RawMesh) -> Vec<bool> {
        let parts = Parts::of(&raw.vertices, &raw.triangles).parts;
        let bounds = Bounds::of(&raw.vertices);
        crosses_itself(&raw.vertices, &raw.triangles, &parts, &bounds, 1e-6)
    }

    #[test]
    fn a_part_that_runs_through_itself_is_found() {
        for raw in [
            solids::cube(1.0),
            solids::l_shape(),
            solids::torus(3.0, 1.0, 90, 60),
            solids::sphere(1.0, 60, 90),
        ] {
            assert_eq!(crosses(&raw), [false]);
        }
        assert_eq!(crosses(&solids::spiral(1.2)), [true]);
        assert_eq!(crosses(&solids::spiral(0.9)), [false]);
        // Two bodies that cross each other do not cross themselves.
        let ring = solids::torus(3.0, 1.0, 30, 20);
        let two = solids::join(&[ring.clone(), solids::moved(&ring, [1.0, 0.0, 0.0])]);
        assert_eq!(crosses(&two), [false, false]);
    }
}
