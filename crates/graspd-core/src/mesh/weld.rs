//! Points that are one point, and triangles that are none.
//!
//! STL repeats each vertex in every triangle, and other exporters write one vertex several times with different
//! last digits. Before edges can be found, such copies must become one vertex. Triangles whose corners then
//! coincide are no triangles and are dropped.
//!
//! ```text
//! for each corner of each triangle, in the order of the file:
//!     representative = an earlier representative within the tolerance, else the corner itself
//! drop triangles with two equal corners, then the points that no triangle uses
//! ```
//!
//! **Invariant:** no two representatives are within the tolerance of each other, since the second would have gone to
//! the first. A vertex never goes to one that has itself gone elsewhere, so a chain of close points cannot pull a
//! fine mesh together: nothing moves by more than one tolerance.
//!
//! **How representatives are found:** in a grid whose cells are two tolerances wide. The ball of one tolerance
//! about a point touches at most two cells along each axis, eight in all, and a cell holds few representatives
//! because they keep their distance. Points with the same bits as an earlier one are looked up first: in STL they
//! are the rule.
//!
//! **Cost:** O(n) expected, whatever the vertices are. The hash is seeded at random, so that it is hard to make a file
//! whose cells collide; the result does not depend on the seed.

use std::collections::HashMap;

use foldhash::fast::RandomState;
use nalgebra::{Point3, Vector3};

use super::RawMesh;

/// Vertices closer than this times the diagonal of the bounding box are one vertex.
///
/// Four units in the last place of the single-precision numbers that STL stores: one vertex
/// written twice, after two different ways of computing it, differs by one or two. Ten thousand
/// triangles side by side along the diagonal are still 200 times this far apart.
pub const WELD_TOLERANCE: f64 = 4.0 * f32::EPSILON as f64;

/// Least welding tolerance, in the mesh's unit.
///
/// Squared areas (fourth powers of lengths) then stay far above the least double, 1e-308, even
/// when multiplied with each other. A body so small collapses as a whole and is reported so.
const MIN_TOLERANCE: f64 = 1e-40;

/// Side of a grid cell in tolerances. Two make a ball of one tolerance touch at most eight
/// cells, and keep the representatives in a cell few: they are more than a tolerance apart.
const CELL: f64 = 2.0;

/// Bits for a cell's position along one axis.
const CELL_BITS: u32 = 21;

// The diagonal has fewer cells than that many bits can count.
const _: () = assert!(1.0 / (CELL * WELD_TOLERANCE) + 2.0 < (1u64 << CELL_BITS) as f64);

/// A mesh whose vertices are all used and further than `tolerance` apart, and whose triangles
/// have three different ones.
#[derive(Debug)]
pub(super) struct Welded {
    /// In order of first use.
    pub(super) vertices: Vec<Point3<f64>>,
    pub(super) triangles: Vec<[u32; 3]>,
    /// For each triangle its index in the raw mesh.
    pub(super) source: Vec<u32>,
    /// In the mesh's unit.
    pub(super) tolerance: f64,
}

/// Joins vertices and drops the triangles that collapse.
///
/// The result depends on nothing but the order of the file. Indices must be in range and coordinates finite.
pub(super) fn weld(raw: &RawMesh) -> Welded {
    // Vertices that no triangle uses must not stretch the box, from which the tolerance follows.
    let used = || {
        raw.triangles
            .iter()
            .flatten()
            .map(|&index| raw.vertices[index as usize])
    };
    let (low, high) = bounds(used());
    let tolerance = (WELD_TOLERANCE * (high - low).norm()).max(MIN_TOLERANCE);
    let mut grid = Grid::new(low, tolerance);
    let mut merged = vec![None; raw.vertices.len()];
    let mut triangles = Vec::with_capacity(raw.triangles.len());
    let mut source = Vec::with_capacity(raw.triangles.len());
    for (n, indices) in (0..=u32::MAX).zip(&raw.triangles) {
        let corners = indices.map(|index| {
            let index = index as usize;
            *merged[index].get_or_insert_with(|| grid.representative(raw.vertices[index]))
        });
        if corners[0] != corners[1] && corners[1] != corners[2] && corners[2] != corners[0] {
            triangles.push(corners);
            source.push(n);
        }
    }
    Welded {
        vertices: compact(&grid.points, &mut triangles),
        triangles,
        source,
        tolerance,
    }
}

/// Least and greatest corner of the bounding box; infinite and reversed when there is no point.
pub(super) fn bounds(points: impl Iterator<Item = Point3<f64>>) -> (Point3<f64>, Point3<f64>) {
    points.fold(
        (
            Point3::from([f64::INFINITY; 3]),
            Point3::from([f64::NEG_INFINITY; 3]),
        ),
        |(low, high), point| (low.inf(&point), high.sup(&point)),
    )
}

/// The points that triangles use, in the order of first use; the corners are numbered anew.
fn compact(points: &[Point3<f64>], triangles: &mut [[u32; 3]]) -> Vec<Point3<f64>> {
    let mut place = vec![None; points.len()];
    let mut kept = Vec::with_capacity(points.len());
    for index in triangles.iter_mut().flatten() {
        let old = *index as usize;
        *index = *place[old].get_or_insert_with(|| {
            kept.push(points[old]);
            (kept.len() - 1) as u32
        });
    }
    kept
}

/// Representatives found so far, in cells of a grid.
struct Grid {
    low: Point3<f64>,
    tolerance: f64,
    points: Vec<Point3<f64>>,
    /// The last representative put into each cell.
    heads: HashMap<u64, u32, RandomState>,
    /// For each representative the one before it in its cell.
    next: Vec<Option<u32>>,
    /// Points that were looked up, by their bits: a copy always goes where the first one went.
    seen: HashMap<[u64; 3], u32, RandomState>,
}

impl Grid {
    fn new(low: Point3<f64>, tolerance: f64) -> Self {
        Self {
            low,
            tolerance,
            points: Vec::new(),
            heads: HashMap::default(),
            next: Vec::new(),
            seen: HashMap::default(),
        }
    }

    /// The representative of `point`, which is itself when none is near.
    fn representative(&mut self, point: Point3<f64>) -> u32 {
        // Adding zero makes one of the two zeros.
        let bits = point.coords.map(|x| (x + 0.0).to_bits()).into();
        if let Some(&index) = self.seen.get(&bits) {
            return index;
        }
        let index = self.near(&point).unwrap_or_else(|| self.insert(point));
        self.seen.insert(bits, index);
        index
    }

    /// Looks into every cell that the ball of one tolerance touches.
    fn near(&self, point: &Point3<f64>) -> Option<u32> {
        let reach = Vector3::repeat(self.tolerance);
        let (from, to) = (self.cell(&(point - reach)), self.cell(&(point + reach)));
        for x in from[0]..=to[0] {
            for y in from[1]..=to[1] {
                for z in from[2]..=to[2] {
                    let mut at = self.heads.get(&key([x, y, z])).copied();
                    while let Some(index) = at {
                        let distance = (self.points[index as usize] - point).norm();
                        if distance <= self.tolerance {
                            return Some(index);
                        }
                        at = self.next[index as usize];
                    }
                }
            }
        }
        None
    }

    fn insert(&mut self, point: Point3<f64>) -> u32 {
        let index = self.points.len() as u32;
        self.points.push(point);
        let cell = key(self.cell(&point));
        self.next.push(self.heads.insert(cell, index));
        index
    }

    /// Counted from one tolerance below the lowest point, so that the least is 0.
    fn cell(&self, point: &Point3<f64>) -> [u64; 3] {
        (point - self.low)
            .map(|x| ((x / self.tolerance + 1.0) / CELL) as u64)
            .into()
    }
}

fn key([x, y, z]: [u64; 3]) -> u64 {
    x << (2 * CELL_BITS) | y << CELL_BITS | z
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::solids;

    #[test]
    fn copies_of_a_vertex_become_one_whatever_cell_they_fall_into() {
        for shift in 0..40 {
            let raw = solids::soup(&solids::cube(1.0));
            let noise = 0.3 * WELD_TOLERANCE;
            let vertices = raw
                .vertices
                .iter()
                .enumerate()
                .map(|(n, v)| {
                    let along = Vector3::repeat(f64::from(shift) * 0.1 * WELD_TOLERANCE);
                    v + along + Vector3::repeat(if n % 2 == 0 { noise } else { -noise })
                })
                .collect();
            let welded = weld(&RawMesh { vertices, ..raw });
            assert_eq!(welded.vertices.len(), 8);
            assert_eq!(welded.triangles.len(), 12);
        }
    }

    #[test]
    fn chains_of_close_points_do_not_collapse() {
        let raw = solids::strip(10_000, 0.7 * WELD_TOLERANCE);
        let welded = weld(&raw);
        assert!(welded.vertices.len() > 4_900, "{}", welded.vertices.len());
    }

    #[test]
    fn unused_vertices_neither_stay_nor_stretch_the_tolerance() {
        let mut raw = solids::cube(1.0);
        raw.vertices.push(Point3::new(1e9, 0.0, 0.0));
        let welded = weld(&raw);
        assert_eq!(welded.vertices.len(), 8);
        assert!(welded.tolerance < 1e-5);
    }
}
