//! Consistent, outward winding.
//!
//! Normals must point out of the material, and files wind their triangles as they like. [`Parts`] gives each part
//! of the surface one winding; what remains is a choice between two for each part as a whole:
//!
//! ```text
//! for each part:
//!     closed:  reverse it if its signed volume is negative
//!     open:    keep the winding of most of its triangles
//! reverse the closed parts that lie inside an odd number of others: they bound cavities
//! reverse all open parts if together they enclose a negative volume
//! ```
//!
//! A closed surface wound outward has a positive signed volume, wherever the reference point is, so the sign
//! decides. The wall of a cavity faces the other way, into the empty space, so a hollow body stays hollow. An
//! open part has no inside of its own; the files' majority is right unless all of it is inside out, which the
//! volume about the middle of the body betrays.
//!
//! **Cost:** O(n log n), and the bounded search for [cavities].

use nalgebra::Point3;

use super::parts::{Part, Parts};
use super::{cavities, triangle};

/// What was found on the way.
#[derive(Debug)]
pub(super) struct Orientation {
    pub(super) components: usize,
    pub(super) flipped: usize,
    pub(super) border_edges: usize,
    pub(super) non_manifold_edges: usize,
    /// Every part is closed in itself, so the signed volume is that of the solid.
    pub(super) closed: bool,
}

/// Reverses triangles until the surface is consistent and faces away from the material.
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
    } = Parts::of(triangles);
    let before = triangles.to_vec();
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

    let cavities = cavities::cavities(vertices, triangles, &parts, tolerance);
    for (part, is_cavity) in parts.iter().zip(cavities) {
        if is_cavity || (!part.closed && open_volume < 0.0) {
            reverse(part, triangles);
        }
    }

    let changed = before.iter().zip(&*triangles).filter(|(a, b)| a != b);
    Orientation {
        components: parts.len(),
        flipped: changed.count(),
        border_edges,
        non_manifold_edges,
        closed: parts.iter().all(|part| part.closed),
    }
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

fn reverse(part: &Part, triangles: &mut [[u32; 3]]) {
    for &n in &part.triangles {
        triangles[n as usize].swap(1, 2);
    }
}
