//! Consistent, outward winding of each part.
//!
//! Normals must point out of the material, and files wind their triangles as they like. [`Parts`] gives each part of the
//! surface one winding; what remains is a choice between two for each part as a whole:
//!
//! ```text
//! for each part:
//!     closed:  reverse it if its signed volume is negative
//!     open:    keep the winding of most of its triangles
//! reverse all open parts if together they enclose a negative volume
//! if there are several open parts: reverse those that face what cannot be seen from outside
//! ```
//!
//! A closed surface wound outward has a positive signed volume, wherever the reference point is, so the sign decides.
//! Which closed parts bound cavities, and face inward in the end, is decided when parts are
//! [compared](super::overlap). An open part has no inside of its own; the file's majority is right unless all of it is
//! inside out, which the volume about the middle of the body betrays, or unless the file contradicts itself, which only
//! [looking](super::loose) shows.
//!
//! **Cost:** O(n log n).

use nalgebra::Point3;

use super::overlap::Said;
use super::parts::{Part, Parts};
use super::{loose, triangle};

/// Share of the triangles of a part that may be wound against the others while the winding of the part still counts as
/// what the file says.
const SLIPS: f64 = 0.05;

/// The parts of a surface, and what was found on the way.
#[derive(Debug)]
pub(super) struct Orientation {
    pub(super) parts: Vec<Part>,
    pub(super) border_edges: usize,
    pub(super) non_manifold_edges: usize,
    pub(super) unresolved_edges: usize,
    /// Every part is closed in itself.
    pub(super) closed: bool,
}

/// Reverses triangles until each part is consistent and faces outward.
///
/// `center` is a point amid the body, and `tolerance` that of welding. See the [module](self) for the rules.
pub(super) fn orient(
    vertices: &[Point3<f64>],
    triangles: &mut [[u32; 3]],
    center: &Point3<f64>,
    tolerance: f64,
) -> Orientation {
    let Parts {
        parts,
        turned,
        border_edges,
        non_manifold_edges,
        unresolved_edges,
    } = Parts::of(vertices, triangles);
    for (corners, _) in triangles
        .iter_mut()
        .zip(&turned)
        .filter(|(_, turned)| **turned)
    {
        corners.swap(1, 2);
    }

    // Of all open parts together.
    let mut open_volume = 0.0;
    for part in &parts {
        let volume = volume(part, vertices, triangles, center);
        let inside_out = match part.closed {
            true => volume < 0.0,
            // Most of it was reversed to agree with its first triangle.
            false => {
                let turned = part.triangles.iter().filter(|&&n| turned[n as usize]);
                turned.count() * 2 > part.triangles.len()
            }
        };
        if inside_out {
            reverse(part, triangles);
        }
        if !part.closed {
            open_volume += if inside_out { -volume } else { volume };
        }
    }
    if open_volume < 0.0 {
        let open = parts.iter().filter(|part| !part.closed);
        open.for_each(|part| reverse(part, triangles));
    }
    let inside_out = loose::inside_out(vertices, triangles, &parts, tolerance);
    for (part, _) in parts
        .iter()
        .zip(inside_out)
        .filter(|(_, reversed)| *reversed)
    {
        reverse(part, triangles);
    }
    Orientation {
        closed: parts.iter().all(|part| part.closed),
        parts,
        border_edges,
        non_manifold_edges,
        unresolved_edges,
    }
}

/// What the file says about parts that are wound outward now: `before` is how it has its triangles, the first of
/// `triangles`.
pub(super) fn said(
    vertices: &[Point3<f64>],
    triangles: &[[u32; 3]],
    before: &[[u32; 3]],
    parts: &[Part],
    center: &Point3<f64>,
) -> Vec<Said> {
    let of = |part: &Part| {
        let mut all = 0;
        let mut kept = 0;
        for &n in part
            .triangles
            .iter()
            .filter(|&&n| (n as usize) < before.len())
        {
            all += 1;
            kept += usize::from(before[n as usize] == triangles[n as usize]);
        }
        let minority = kept.min(all - kept);
        Said {
            outward: 2 * kept >= all,
            agreed: minority as f64 <= SLIPS * all as f64,
            volume: volume(part, vertices, triangles, center),
        }
    };
    parts.iter().map(of).collect()
}

/// Signed volume about `center`, with the winding at hand.
fn volume(
    part: &Part,
    vertices: &[Point3<f64>],
    triangles: &[[u32; 3]],
    center: &Point3<f64>,
) -> f64 {
    let members = part.triangles.iter();
    members
        .map(|&n| triangle::corners(vertices, triangles[n as usize]))
        .map(|corners| triangle::volume(&corners, center))
        .sum()
}

pub(super) fn reverse(part: &Part, triangles: &mut [[u32; 3]]) {
    for &n in &part.triangles {
        triangles[n as usize].swap(1, 2);
    }
}
