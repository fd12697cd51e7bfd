//! Which two of the triangles at an edge bound the same solid there.
//!
//! Where solids touch along an edge, four or more triangles meet at it. Seen along the edge they stand like the spokes
//! of a wheel. Between two of them there is matter or none, and the winding says on which side of a triangle its matter
//! is. So each triangle whose matter lies ahead, turning to the left, belongs together with the next one whose matter
//! lies behind it, as an opening bracket with the closing one:
//!
//! ```text
//! sort the triangles by the angle at which they stand about the edge
//! among equal angles, those that close come before those that open     (a wall that two solids share)
//! match brackets around the wheel: a closing one with the last open one that belongs to the same piece of the surface,
//! or else with the last open one
//! ```
//!
//! Pieces are what hangs together over edges of two triangles alone. They keep apart solids that overlap and are flush
//! along an edge, where spokes are equal or brackets cross. Where they do not help, any match closes the parts, which may
//! then be one part that crosses itself, and [`Pairs::ambiguous`] says so.
//!
//! The wheel has no beginning, so it is turned twice: what is left open after the first turn is closed in the second.
//!
//! **Cost:** O(k log k) for k triangles at the edge of few pieces, O(k²) at worst for at most [`MOST`].

use std::cmp::Ordering;

use nalgebra::{Point3, Vector3};

use super::edges::EdgeUse;
use super::triangle;

/// Triangles whose angles about the edge differ by no more than this, radians, stand in one plane. Welding moves a
/// corner by a millionth of the size.
const SAME_ANGLE: f64 = 1e-5;

/// Most triangles at an edge that are paired; no real body has as many.
const MOST: usize = 1000;

/// What belongs together at an edge.
#[derive(Debug, Default)]
pub(super) struct Pairs {
    /// By their places among the uses of the edge.
    pub(super) pairs: Vec<(usize, usize)>,
    /// Whether some triangles could be matched in another way.
    pub(super) ambiguous: bool,
}

/// Pairs of triangles, by their places in `uses`, that bound the same solid at an edge; none unless as many triangles
/// run along the edge in one direction as in the other.
pub(super) fn pairs(
    uses: &[EdgeUse],
    vertices: &[Point3<f64>],
    triangles: &[[u32; 3]],
    piece_of: &[u32],
) -> Pairs {
    let ascending = uses.iter().filter(|edge| edge.ascending).count();
    if ascending * 2 != uses.len() || uses.is_empty() || uses.len() > MOST {
        return Pairs::default();
    }
    let [low, high] = uses[0].ends();
    let (from, to) = (vertices[low as usize], vertices[high as usize]);
    let along = (to - from).normalize();
    // Two directions across the edge that make a frame with it.
    let across = along.cross(&Vector3::ith(along.iamin(), 1.0)).normalize();
    let up = along.cross(&across);
    let angle = |edge: &EdgeUse| {
        let corners = triangles[edge.triangle as usize];
        let apex = corners.iter().find(|corner| ![low, high].contains(corner));
        let arm = apex.map_or(across, |&apex| vertices[apex as usize] - from);
        arm.dot(&up).atan2(arm.dot(&across))
    };
    let mut spokes: Vec<(f64, usize)> = (0..uses.len()).map(|n| (angle(&uses[n]), n)).collect();
    spokes.sort_by(|a, b| a.0.total_cmp(&b.0));
    // Begin behind a gap, so that no plane is cut in two where the angle jumps.
    let begin = (0..spokes.len()).find(|&n| {
        let before = if n == 0 {
            spokes[spokes.len() - 1].0 - std::f64::consts::TAU
        } else {
            spokes[n - 1].0
        };
        spokes[n].0 - before > SAME_ANGLE
    });
    let begin = begin.unwrap_or(0);
    if begin > 0 {
        spokes[..begin]
            .iter_mut()
            .for_each(|spoke| spoke.0 += std::f64::consts::TAU);
    }
    spokes.rotate_left(begin);
    // Matter of a triangle that ascends lies at lesser angles, since its normal is the edge times its arm.
    // Among equals the larger goes first, then what is lower, which does not depend on the order of the file.
    let rank = |n: usize| {
        let corners = triangle::corners(vertices, triangles[uses[n].triangle as usize]);
        let at = triangle::centroid(&corners);
        [-triangle::area(&corners), at.x, at.y, at.z]
    };
    let by_rank = |a: &usize, b: &usize| rank(*a).partial_cmp(&rank(*b)).unwrap_or(Ordering::Equal);
    let mut wheel: Vec<usize> = Vec::with_capacity(spokes.len());
    let mut ambiguous = false;
    for plane in spokes.chunk_by(|a, b| b.0 - a.0 <= SAME_ANGLE) {
        let of = |ascending: bool| {
            let members = plane
                .iter()
                .map(|(_, n)| *n)
                .filter(|n| uses[*n].ascending == ascending);
            let mut members: Vec<usize> = members.collect();
            if members.len() > 1 {
                members.sort_by(by_rank);
            }
            members
        };
        let (closing, opening) = (of(true), of(false));
        ambiguous |= closing.len() > 1 || opening.len() > 1;
        wheel.extend(closing.into_iter().chain(opening));
    }
    let piece = |n: usize| piece_of[uses[n].triangle as usize];
    let (mut open, mut found): (Vec<usize>, Vec<(usize, usize)>) = (Vec::new(), Vec::new());
    let mut closed = vec![false; uses.len()];
    let mut all_of_one_piece = true;
    for (turn, &n) in wheel.iter().chain(&wheel).enumerate() {
        if !uses[n].ascending {
            if turn < wheel.len() {
                open.push(n);
            }
            continue;
        }
        let own = open.iter().rposition(|&opened| piece(opened) == piece(n));
        // In the first turn its own may still come.
        let still_to_come = || {
            turn < wheel.len()
                && wheel
                    .iter()
                    .any(|&m| !uses[m].ascending && piece(m) == piece(n))
        };
        if closed[n] || own.is_none() && still_to_come() {
            continue;
        }
        if let Some(at) = own.or(open.len().checked_sub(1)) {
            closed[n] = true;
            all_of_one_piece &= own.is_some();
            found.push((open.remove(at), n));
        }
    }
    ambiguous &= !all_of_one_piece;
    Pairs {
        pairs: found,
        ambiguous,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::edges::Edges;
    use crate::mesh::{RawMesh, solids};

    /// The pairs at the edges where more than two triangles meet, by triangle.
    fn paired(raw: &RawMesh) -> Vec<(u32, u32)> {
        let edges = Edges::new(&raw.triangles);
        // Without knowing any piece.
        let pieces: Vec<u32> = vec![0; raw.triangles.len()];
        let crowded = edges.iter().filter(|uses| uses.len() > 2);
        let pairs = crowded.flat_map(|uses| {
            let found = pairs(uses, &raw.vertices, &raw.triangles, &pieces).pairs;
            assert_eq!(2 * found.len(), uses.len());
            let triangle = |n: usize| uses[n].triangle;
            found
                .into_iter()
                .map(move |(a, b)| (triangle(a), triangle(b)))
        });
        pairs.collect()
    }

    #[test]
    fn triangles_of_one_solid_belong_together() {
        let cube = solids::cube(1.0);
        // Side by side with a wall in common, and along an edge.
        for by in [
            [1.0, 0.0, 0.0],
            [0.0, -1.0, 0.0],
            [1.0, 1.0, 0.0],
            [0.0, 1.0, -1.0],
        ] {
            for raw in [
                solids::join(&[cube.clone(), solids::moved(&cube, by)]),
                solids::join(&[solids::moved(&cube, by), cube.clone()]),
            ] {
                let welded = crate::mesh::weld::weld(&raw);
                let raw = RawMesh {
                    vertices: welded.vertices,
                    triangles: welded.triangles,
                    ..RawMesh::default()
                };
                let found = paired(&raw);
                assert!(!found.is_empty());
                assert!(
                    found.iter().all(|(a, b)| (*a < 12) == (*b < 12)),
                    "{by:?}: {found:?}"
                );
            }
        }
    }
}
