//! The place on the surface that is nearest to a point.
//!
//! Triangles stand in trees of boxes. No triangle of a box is nearer than the box, so a box that is farther away than
//! the nearest triangle so far is skipped with everything in it:
//!
//! ```text
//! least = ∞
//! for each tree, that with the nearest box first:
//!     least = the distance of the nearest triangle in it, if below least    (best first)
//! near = the triangles within least and a tolerance
//! the place is on the first triangle of the file among near
//! ```
//!
//! A point near an edge or a corner is equally near to several triangles but for rounding. The last two lines make the
//! answer depend on the mesh alone, not on the shape of the trees.
//!
//! One tree over all triangles would be as fast to search, but building it cannot be interrupted. So there are many,
//! each over a block of triangles that follow one another along a [curve](super::curve), whose boxes overlap little.
//!
//! **Cost:** O(n log n) to build. O(log n) for a point near the surface; for one that is equally far from much of it,
//! such as the centre of a ball, O(n).

use nalgebra::{Point3, UnitVector3, center};
use parry3d_f64::bounding_volume::Aabb;
use parry3d_f64::math::Vector;
use parry3d_f64::partitioning::{Bvh, BvhBuildStrategy};
use parry3d_f64::query::{PointQuery, PointQueryWithLocation};
use parry3d_f64::shape::Triangle;

use super::{BLOCK, Mesh, along_curve, triangle, weld};
use crate::interrupt::{Interrupt, Interrupted, uninterrupted};

/// Triangles that are nearest to within this, over the diagonal of the body, are equally near. A
/// point on an edge is computed from either triangle to some tens of units of 2⁻⁵².
pub const TIE_TOLERANCE: f64 = 1e-13;

/// The place on the surface that is nearest to a point, as [`Projector::project`] finds it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Projection {
    /// The place, in the mesh's frame and unit.
    pub position: Point3<f64>,
    /// Unit normal of the triangle, pointing INTO the body.
    pub normal: UnitVector3<f64>,
    /// Index of the triangle in the file as uploaded, from 0.
    pub triangle: u32,
    /// Weights of the triangle's corners that make the position, each from 0 to 1, sum 1. The
    /// corners are in the order of [`Mesh::triangles`]: outward winding.
    pub barycentric: [f64; 3],
    /// Distance of the point from the place, in the mesh's unit.
    pub distance: f64,
}

/// Projects points onto a surface. It holds trees over all triangles, so build it once for a mesh.
///
/// ```
/// use graspd_core::mesh::{Mesh, Projector, solids};
/// use nalgebra::Point3;
///
/// let mesh = Mesh::prepare(solids::cube(1.0))?;
/// let projector = Projector::new(&mesh);
/// let found = projector.project(&Point3::new(0.25, 0.5, 3.0)).unwrap();
/// assert!((found.position - Point3::new(0.25, 0.5, 1.0)).norm() < 1e-12);
/// assert!((found.distance - 2.0).abs() < 1e-12);
/// // Into the body, which is below its top.
/// assert_eq!(found.normal.as_slice(), [0.0, 0.0, -1.0]);
/// assert_eq!(projector.project(&Point3::new(f64::NAN, 0.0, 0.0)), None);
/// # Ok::<(), graspd_core::mesh::PrepareError>(())
/// ```
#[derive(Debug)]
pub struct Projector<'a> {
    mesh: &'a Mesh,
    middle: Point3<f64>,
    diagonal: f64,
    /// The exposed parts of the triangles that are not degenerate: index in [`Mesh::triangles`], part, and the corners
    /// about the middle of the box in units of its diagonal, so that no size or place loses digits.
    triangles: Vec<(usize, Option<u32>, Triangle)>,
    /// Each over triangles that follow one another along a curve.
    trees: Vec<Tree>,
}

/// The triangles of a part of the surface.
#[derive(Debug)]
struct Tree {
    nodes: Bvh,
    /// The triangle of each leaf.
    leaves: Vec<u32>,
}

impl<'a> Projector<'a> {
    /// Builds the trees. O(n log n).
    pub fn new(mesh: &'a Mesh) -> Self {
        uninterrupted(|interrupt| Self::interruptible(mesh, interrupt))
    }

    /// The same; `interrupt` is checked every few milliseconds.
    pub fn interruptible(mesh: &'a Mesh, interrupt: Interrupt<'_>) -> Result<Self, Interrupted> {
        interrupt.check()?;
        let (low, high) = weld::bounds(mesh.vertices.iter().copied());
        let (middle, diagonal) = (center(&low, &high), (high - low).norm());
        let mut triangles: Vec<(usize, Option<u32>, Triangle)> =
            Vec::with_capacity(mesh.triangles.len());
        for (index, &indices) in mesh.triangles.iter().enumerate() {
            if index.is_multiple_of(BLOCK) {
                interrupt.check()?;
            }
            let corners = triangle::corners(&mesh.vertices, indices);
            if triangle::is_degenerate(&corners, mesh.tolerance) {
                continue;
            }
            for part in mesh.cover.exposed_parts(index) {
                let corners = mesh.part(index, part);
                let [a, b, c] = corners.map(|corner| local(&corner, &middle, diagonal));
                triangles.push((index, part, Triangle::new(a, b, c)));
            }
        }
        let position = |i: usize| {
            let Vector { x, y, z } = triangles[i].2.a;
            Point3::new(x, y, z)
        };
        let order = along_curve(triangles.len(), position, interrupt)?;
        let mut trees = Vec::new();
        for leaves in order.chunks(BLOCK) {
            interrupt.check()?;
            let boxes = leaves.iter().map(|&i| triangles[i as usize].2.local_aabb());
            let boxes: Vec<Aabb> = boxes.collect();
            trees.push(Tree {
                nodes: Bvh::from_leaves(BvhBuildStrategy::Binned, &boxes),
                leaves: leaves.to_vec(),
            });
        }
        Ok(Self {
            mesh,
            middle,
            diagonal,
            triangles,
            trees,
        })
    }

    /// Returns the nearest place that is exposed, on a triangle that is not degenerate; of triangles that are equally
    /// near, on the first in the file.
    ///
    /// `None` when the point is not finite, or so far away that its distance cannot be squared.
    pub fn project(&self, point: &Point3<f64>) -> Option<Projection> {
        self.project_on(point, |near| near.min())
    }

    /// As [`Self::project`], but of triangles that are equally near, as on either side of an edge, on the one whose inward
    /// normal is nearest to `inward`. So the order of the triangles in the file plays no part, except among coplanar ones.
    pub fn project_facing(
        &self,
        point: &Point3<f64>,
        inward: &UnitVector3<f64>,
    ) -> Option<Projection> {
        let normal = |triangle: u32| {
            let (index, _, _) = &self.triangles[triangle as usize];
            let corners = triangle::corners(&self.mesh.vertices, self.mesh.triangles[*index]);
            -triangle::normal(&corners).normalize()
        };
        self.project_on(point, |near| {
            let normals = near.map(|triangle| (triangle, normal(triangle)));
            normals
                .min_by(|(a, x), (b, y)| {
                    let nearer = y.dot(inward).total_cmp(&x.dot(inward));
                    // Where two faces lean alike, their own directions decide, and the number only between equals.
                    let components = x.iter().zip(y.iter()).map(|(x, y)| x.total_cmp(y));
                    components
                        .fold(nearer, std::cmp::Ordering::then)
                        .then(a.cmp(b))
                })
                .map(|(triangle, _)| triangle)
        })
    }

    /// Projects on the triangle that `choose` takes of those that are nearest.
    fn project_on(
        &self,
        point: &Point3<f64>,
        choose: impl FnOnce(&mut dyn Iterator<Item = u32>) -> Option<u32>,
    ) -> Option<Projection> {
        let there = local(point, &self.middle, self.diagonal);
        let distance = |triangle: u32| nearest(&self.triangles[triangle as usize].2, there).1;
        let bound = |bounds: &Aabb| bounds.distance_to_local_point(there, true);
        let bounds = self.trees.iter().map(|tree| bound(&tree.nodes.root_aabb()));
        let (first, _) = bounds.enumerate().min_by(|a, b| a.1.total_cmp(&b.1))?;
        // What is found in the nearest tree rules most of the others out.
        let others = (0..self.trees.len()).filter(|&other| other != first);
        let mut least = f64::MAX;
        for tree in std::iter::once(first).chain(others) {
            let tree = &self.trees[tree];
            let found = tree.nodes.find_best(
                least,
                |node, _| bound(&node.aabb()),
                |leaf, _| Some(distance(tree.leaves[leaf as usize])),
            );
            least = found.map_or(least, |(_, found)| least.min(found));
        }
        // Distances are compared as squares, whose rounding grows with the distance itself.
        let reach = least + TIE_TOLERANCE * (1.0 + least);
        let near = self.trees.iter().flat_map(|tree| {
            let leaves = tree.nodes.leaves(|node| bound(&node.aabb()) <= reach);
            leaves.map(|leaf| tree.leaves[leaf as usize])
        });
        let mut near = near.filter(|&triangle| least < f64::MAX && distance(triangle) <= reach);
        let first = choose(&mut near)?;

        let (index, part, shape) = &self.triangles[first as usize];
        let (weights, _) = nearest(shape, there);
        let barycentric = self.mesh.cover.of_whole(*part, weights);
        let corners = triangle::corners(&self.mesh.vertices, self.mesh.triangles[*index]);
        let [a, b, c] = corners;
        let position = a + (b - a) * barycentric[1] + (c - a) * barycentric[2];
        Some(Projection {
            position,
            normal: UnitVector3::new_normalize(-triangle::normal(&corners)),
            triangle: self.mesh.source[*index],
            barycentric,
            distance: (position - point).norm(),
        })
    }
}

fn local(point: &Point3<f64>, middle: &Point3<f64>, diagonal: f64) -> Vector {
    let v = (point - middle) / diagonal;
    Vector::new(v.x, v.y, v.z)
}

/// Barycentric coordinates of the nearest point, and how far it is.
fn nearest(shape: &Triangle, point: Vector) -> ([f64; 3], f64) {
    let (projection, location) = shape.project_local_point_and_get_location(point, false);
    let weights = location
        .barycentric_coordinates()
        .unwrap_or([1.0, 0.0, 0.0]);
    (weights, (projection.point - point).length())
}

#[cfg(test)]
mod tests {
    use nalgebra::Vector3;
    use rand::{Rng, SeedableRng};
    use rand_pcg::Pcg64;

    use super::*;
    use crate::mesh::{NoCandidate, RawMesh, solids};

    fn uniform(rng: &mut Pcg64) -> f64 {
        (rng.next_u64() >> 11) as f64 / (1_u64 << 53) as f64
    }

    fn random_point(rng: &mut Pcg64, size: f64) -> Point3<f64> {
        Point3::from(Vector3::from_fn(|_, _| size * (2.0 * uniform(rng) - 1.0)))
    }

    /// Distance of a point from a triangle by its plane where the foot is inside, else by its edges.
    fn slow_distance(corners: &[Point3<f64>; 3], point: &Point3<f64>) -> f64 {
        let normal = triangle::normal(corners).normalize();
        let foot = point - normal * normal.dot(&(point - corners[0]));
        let sides = [0, 1, 2].map(|i| (corners[i], corners[(i + 1) % 3]));
        if sides
            .iter()
            .all(|(a, b)| (b - a).cross(&(foot - a)).dot(&normal) >= 0.0)
        {
            return (foot - point).norm();
        }
        sides
            .iter()
            .map(|(a, b)| {
                let along = (point - a).dot(&(b - a)) / (b - a).norm_squared();
                (a + (b - a) * along.clamp(0.0, 1.0) - point).norm()
            })
            .fold(f64::INFINITY, f64::min)
    }

    #[test]
    fn no_triangle_is_nearer_and_the_position_is_the_one_that_the_weights_say() {
        let mut rng = Pcg64::seed_from_u64(1);
        for raw in [
            solids::torus(2.0, 0.7, 24, 12),
            solids::l_shape(),
            solids::hollow_cube(),
        ] {
            let mesh = Mesh::prepare(raw).unwrap().with_enclosed();
            let projector = Projector::new(&mesh);
            for _ in 0..300 {
                let point = random_point(&mut rng, 4.0);
                let found = projector.project(&point).unwrap();
                let least = mesh
                    .triangles()
                    .iter()
                    .map(|&t| slow_distance(&triangle::corners(mesh.vertices(), t), &point))
                    .fold(f64::INFINITY, f64::min);
                assert!((found.distance - least).abs() < 1e-12);
                assert!(((found.position - point).norm() - least).abs() < 1e-12);

                let index = mesh.source().binary_search(&found.triangle).unwrap();
                let corners = triangle::corners(mesh.vertices(), mesh.triangles()[index]);
                let weighted: Vector3<f64> = corners
                    .iter()
                    .zip(found.barycentric)
                    .map(|(corner, weight)| corner.coords * weight)
                    .sum();
                assert!((weighted - found.position.coords).norm() < 1e-12);
                assert!(found.barycentric.iter().all(|w| (0.0..=1.0).contains(w)));
                assert!((found.barycentric.iter().sum::<f64>() - 1.0).abs() < 1e-14);
                let candidate = mesh.candidate_of(found.triangle).unwrap();
                assert_eq!(found.normal, candidate.normal);
            }
        }
    }

    #[test]
    fn of_triangles_that_share_the_nearest_place_the_first_is_taken() {
        let mesh = Mesh::prepare(solids::sphere(1.0, 8, 12)).unwrap();
        let projector = Projector::new(&mesh);
        for (index, vertex) in mesh.vertices().iter().enumerate() {
            let first = mesh
                .triangles()
                .iter()
                .position(|t| t.contains(&(index as u32)))
                .unwrap();
            let outside = Point3::from(vertex.coords * 1.5);
            let found = projector.project(&outside).unwrap();
            assert_eq!(found.triangle, mesh.source()[first]);
            assert!((found.position - vertex).norm() < 1e-12);
        }
    }

    #[test]
    fn neither_size_nor_place_of_the_body_matters() {
        let point = Point3::new(1.7, 0.2, 0.9);
        let project = |factor: f64, shift: f64| {
            let moved = |v: &Point3<f64>| v * factor + Vector3::repeat(shift);
            let mut raw = solids::torus(2.0, 0.7, 24, 12);
            raw.vertices = raw.vertices.iter().map(moved).collect();
            let mesh = Mesh::prepare(raw).unwrap();
            let found = Projector::new(&mesh).project(&moved(&point)).unwrap();
            (found.triangle, found.distance / factor)
        };
        let (triangle, distance) = project(1.0, 0.0);
        for (factor, shift) in [(1e-25, 0.0), (1e25, 0.0), (1.0, 1e3)] {
            let (there, far) = project(factor, shift);
            assert_eq!(there, triangle);
            assert!((far - distance).abs() < 1e-11);
        }
    }

    #[test]
    fn a_point_that_is_nowhere_has_no_projection() {
        let mesh = Mesh::prepare(solids::cube(1.0)).unwrap();
        let projector = Projector::new(&mesh);
        for x in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, 1e200] {
            assert_eq!(projector.project(&Point3::new(x, 0.0, 0.0)), None);
        }
        assert!(projector.project(&Point3::new(1e100, 0.0, 0.0)).is_some());
    }

    #[test]
    fn triangles_of_the_file_are_told_apart_from_slivers_and_from_none() {
        let RawMesh {
            vertices,
            mut triangles,
            ..
        } = solids::cube(1.0);
        triangles.insert(3, [0, 0, 1]);
        let raw = RawMesh {
            vertices,
            triangles,
            ..RawMesh::default()
        };
        let mesh = Mesh::prepare(raw).unwrap();
        for candidate in mesh.candidates() {
            assert_eq!(mesh.candidate_of(candidate.triangle), Ok(candidate));
        }
        assert_eq!(mesh.candidate_of(3), Err(NoCandidate::Degenerate(3)));
        let none = NoCandidate::NoSuchTriangle {
            triangle: 13,
            last: 12,
        };
        assert_eq!(mesh.candidate_of(13), Err(none));
    }
}
