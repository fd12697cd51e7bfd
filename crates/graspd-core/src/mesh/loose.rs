//! Parts of a surface that are not closed: which side of each is outside, and whether that is sure.
//!
//! Faces that were never stitched together, or that lost a strip between them, enclose nothing in the strict sense. Their
//! windings can contradict each other, and no edge says so. What is outside can still be seen: from there rays leave the
//! body in many directions, and from within hardly any (Takayama, Jacobson, Kavan and Sorkine-Hornung, "A simple method
//! for correcting facet orientations in polygon meshes based on ray casting", J. Computer Graphics Techniques 3, 2014).
//!
//! ```text
//! for each open part: rays from points on both of its sides
//!     more of them leave from behind by a clear margin:    reverse it
//!     no clear difference:                                 leave it as it is
//! ```
//!
//! Whether the result can be relied upon, the winding number of the whole surface says: right above a surface that
//! bounds matter it is near 0, right below it near 1. A part where it is not has normals that are taken on trust.
//!
//! **Cost:** O(n log n) for a tree over the surface, and a number of rays that is [bounded](MAX_RAYS).

use nalgebra::{Point3, Vector3};
use rayon::prelude::*;

use super::parts::Part;
use super::tree::Tree;
use super::triangle;

/// Most rays in all.
const MAX_RAYS: usize = 1 << 20;

/// Rays from either side of a part, when there are few parts.
const RAYS: usize = 128;

/// Points of a part that are looked at.
const POINTS: usize = 16;

/// How many more rays must leave from one side than from the other, as a share of all from one side.
const MARGIN: f64 = 0.1;

/// How far the winding number may be from 0 above a surface and from 1 below it.
const DOUBT: f64 = 0.25;

/// Distance of the points from the surface, in welding tolerances.
const STEP: f64 = 4.0;

/// For each part whether it is open and faces inward. There must be at least two open parts: of one, nothing hides
/// either side from the surroundings better than its own volume does.
pub(super) fn inside_out(
    vertices: &[Point3<f64>],
    triangles: &[[u32; 3]],
    parts: &[Part],
    tolerance: f64,
) -> Vec<bool> {
    let open = parts.iter().filter(|part| !part.closed).count();
    if open < 2 {
        return vec![false; parts.len()];
    }
    let tree = tree(vertices, triangles);
    let rays = (MAX_RAYS / (2 * open)).clamp(8, RAYS);
    let faces_inward = |part: &Part| {
        if part.closed {
            return false;
        }
        let [front, back] = [1.0, -1.0].map(|side| {
            let points = points(vertices, triangles, part, POINTS);
            let leaves = |ray: &usize| {
                let (point, normal) = points[ray % points.len()];
                let normal = normal * side;
                let origin = point + normal * (STEP * tolerance);
                tree.first_hit(&origin, &direction(&normal, *ray, rays), f64::MAX)
                    .is_none()
            };
            (0..rays).filter(leaves).count() as f64
        });
        back - front > MARGIN * rays as f64
    };
    parts.par_iter().map(faces_inward).collect()
}

/// How many triangles belong to open parts for which the winding number does not confirm what is outside.
pub(super) fn on_trust(
    vertices: &[Point3<f64>],
    triangles: &[[u32; 3]],
    parts: &[Part],
    tolerance: f64,
) -> usize {
    let tree = tree(vertices, triangles);
    let doubtful = |part: &&Part| {
        let points = points(vertices, triangles, part, POINTS);
        let confirmed = points.iter().filter(|(point, normal)| {
            let step = normal * (STEP * tolerance);
            let above = tree.winding(&(point + step)).abs();
            let below = (tree.winding(&(point - step)) - 1.0).abs();
            above <= DOUBT && below <= DOUBT
        });
        2 * confirmed.count() < points.len()
    };
    let open = parts.par_iter().filter(|part| !part.closed);
    open.filter(doubtful).map(|part| part.triangles.len()).sum()
}

fn tree(vertices: &[Point3<f64>], triangles: &[[u32; 3]]) -> Tree {
    let numbers: Vec<u32> = (0..triangles.len() as u32).collect();
    Tree::new(vertices, triangles, &numbers)
}

/// Centroids of some triangles of a part with their unit normals; the first triangle at least, whatever its shape.
fn points(
    vertices: &[Point3<f64>],
    triangles: &[[u32; 3]],
    part: &Part,
    count: usize,
) -> Vec<(Point3<f64>, Vector3<f64>)> {
    let step = part.triangles.len().div_ceil(count);
    let some = part.triangles.iter().step_by(step);
    let point = |&number: &u32| {
        let corners = triangle::corners(vertices, triangles[number as usize]);
        let normal = triangle::normal(&corners).try_normalize(0.0);
        (
            triangle::centroid(&corners),
            normal.unwrap_or_else(Vector3::z),
        )
    };
    some.map(point).collect()
}

/// A direction to the side of the normal, of so many that spread evenly over the hemisphere (Vogel 1979).
pub(super) fn direction(normal: &Vector3<f64>, ray: usize, of: usize) -> Vector3<f64> {
    let across = normal.cross(&Vector3::ith(normal.iamin(), 1.0)).normalize();
    let up = normal.cross(&across);
    let golden = std::f64::consts::PI * (3.0 - 5_f64.sqrt());
    let sine = (ray as f64 / of as f64).sqrt();
    let (turn, cosine) = (golden * ray as f64, (1.0 - sine * sine).sqrt());
    normal * cosine + (across * turn.cos() + up * turn.sin()) * sine
}
