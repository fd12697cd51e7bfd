//! From a place on the surface to others.
//!
//! A step in space is taken along the surface: straight on inside a triangle, and over an edge at the same angle to it,
//! as if the two triangles were unfolded into a plane. On a polyhedron that is a straightest geodesic, but for the
//! corners, which a walk misses almost surely.
//!
//! ```text
//! left = the step
//! repeat:
//!     the weights of the three corners change linearly along left
//!     if none becomes negative before the end of left: go there, done
//!     go to where the first of them is zero, which is a point on the side opposite that corner
//!     the neighbour is what lies beyond that side; at a border: done
//!     left = what is left of it, turned about the edge into the plane of the neighbour
//! ```
//!
//! Going by weights rather than by coordinates keeps the place in its triangle to the last bit: a weight that becomes
//! zero is set to zero, and none is ever negative. Degenerate triangles have no plane to walk in. They are passed
//! through, from the side that is entered to the nearer one of the others.
//!
//! **Why it ends:** every round crosses an edge, and after [`MAX_CROSSINGS`] of them the walk stops where it is. **Cost:**
//! O(crossings); O(n) to learn what lies beyond every edge.

use nalgebra::{Point3, UnitVector3, Vector3};

use super::edges::Edges;
use super::{BLOCK, Mesh, triangle};
use crate::interrupt::{Interrupt, Interrupted, uninterrupted};

/// The most edges that one walk crosses; it ends on the next one.
pub const MAX_CROSSINGS: usize = 256;

/// A place on the surface, with the normal of its triangle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SurfaceContact {
    /// Index in [`Mesh::triangles`].
    pub triangle: usize,
    /// Weights of the triangle's corners that make the position, each from 0 to 1, sum 1.
    pub barycentric: [f64; 3],
    /// In the mesh's frame and unit.
    pub position: Point3<f64>,
    /// Unit normal of the triangle, pointing INTO the body.
    pub normal: UnitVector3<f64>,
    /// Index of the triangle in the file as uploaded, from 0.
    pub source: u32,
}

/// The triangle beyond a side of another. A side has the number of the corner opposite to it.
#[derive(Debug, Clone, Copy)]
struct Neighbour {
    triangle: u32,
    /// The side by which it is entered.
    side: u8,
}

/// The surface of a mesh as something to walk on. It holds what lies beyond every edge, so build it once for a mesh.
#[derive(Debug)]
pub struct Surface<'a> {
    mesh: &'a Mesh,
    /// For each triangle what lies beyond its sides: nothing at a border, nor where more than two triangles meet or
    /// the winding turns over.
    neighbours: Vec<[Option<Neighbour>; 3]>,
}

impl<'a> Surface<'a> {
    /// Finds what lies beyond every edge. O(n) where few triangles meet at a vertex.
    pub fn new(mesh: &'a Mesh) -> Self {
        uninterrupted(|interrupt| Self::interruptible(mesh, interrupt))
    }

    /// The same; `interrupt` is checked every few milliseconds.
    pub fn interruptible(mesh: &'a Mesh, interrupt: Interrupt<'_>) -> Result<Self, Interrupted> {
        let mut neighbours = vec![[None; 3]; mesh.triangles.len()];
        let side = |triangle: u32, ends: [u32; 2]| {
            let corners = mesh.triangles[triangle as usize];
            corners.iter().position(|corner| !ends.contains(corner))
        };
        for (edge, uses) in Edges::interruptible(&mesh.triangles, interrupt)?
            .iter()
            .enumerate()
        {
            if edge.is_multiple_of(BLOCK) {
                interrupt.check()?;
            }
            let &[one, other] = uses else { continue };
            if one.ascending == other.ascending {
                continue;
            }
            let ends = one.vertices();
            if let (Some(a), Some(b)) = (side(one.triangle, ends), side(other.triangle, ends)) {
                for (from, at, to, entry) in [
                    (one.triangle, a, other.triangle, b),
                    (other.triangle, b, one.triangle, a),
                ] {
                    neighbours[from as usize][at] = Some(Neighbour {
                        triangle: to,
                        side: entry as u8,
                    });
                }
            }
        }
        Ok(Self { mesh, neighbours })
    }

    /// The mesh that this is the surface of.
    pub fn mesh(&self) -> &'a Mesh {
        self.mesh
    }

    /// The place in a triangle, given by its index in [`Mesh::triangles`], with these weights of its corners.
    ///
    /// `None` when the triangle does not exist or is degenerate, or when the weights are not from 0 to 1 or do not sum
    /// to 1.
    pub fn place(&self, triangle: usize, barycentric: [f64; 3]) -> Option<SurfaceContact> {
        let weights = barycentric.iter().all(|w| (0.0..=1.0).contains(w))
            && (barycentric.iter().sum::<f64>() - 1.0).abs() <= 8.0 * f64::EPSILON;
        (weights && self.is_usable(triangle)).then(|| self.at(triangle, barycentric))
    }

    /// The centroid of a triangle, by its index in [`Mesh::triangles`]; `None` as [`Self::place`].
    pub fn centroid(&self, triangle: usize) -> Option<SurfaceContact> {
        self.place(triangle, [1.0 / 3.0; 3])
    }

    /// Walks straight on from a place, along the tangential part of `step`, and returns where that ends.
    ///
    /// Over an edge the walk goes on at the same angle to it, as if the two triangles were unfolded into a plane. It ends
    /// early at a border and after [`MAX_CROSSINGS`] edges. A place in a degenerate triangle is not left, and neither is
    /// any by a step that is not finite.
    ///
    /// ```
    /// use graspd_core::mesh::{Mesh, Surface, solids};
    /// use nalgebra::{Point3, Vector3};
    ///
    /// let mesh = Mesh::prepare(solids::cube(1.0))?;
    /// let surface = Surface::new(&mesh);
    /// // From the bottom outward, over the edge, and up the side by as much as is left.
    /// let from = surface.centroid(0).unwrap();
    /// let to = surface.walk(&from, &Vector3::new(1.0 - from.position.x + 0.25, 0.0, 0.0));
    /// assert!((to.position - Point3::new(1.0, from.position.y, 0.25)).norm() < 1e-12);
    /// # Ok::<(), graspd_core::mesh::PrepareError>(())
    /// ```
    pub fn walk(&self, from: &SurfaceContact, step: &Vector3<f64>) -> SurfaceContact {
        let mut left = *step;
        let (mut index, mut weights) = (from.triangle, from.barycentric);
        if !self.is_usable(index) || !step.iter().all(|x| x.is_finite()) {
            return *from;
        }
        for _ in 0..=MAX_CROSSINGS {
            let rates = self.gradients(index).map(|gradient| gradient.dot(&left));
            // The share of what is left that is gone in this triangle.
            let mut share = 1.0;
            let mut exit = None;
            for side in 0..3 {
                if rates[side] < 0.0 && weights[side] < -rates[side] * share {
                    share = weights[side] / -rates[side];
                    exit = Some(side);
                }
            }
            for side in 0..3 {
                weights[side] = (weights[side] + rates[side] * share).max(0.0);
            }
            let Some(exit) = exit else { break };
            weights[exit] = 0.0;
            normalize(&mut weights);
            let position = self.position(index, &weights);
            let Some(next) = self.beyond(index, exit, &position) else {
                break;
            };
            left *= 1.0 - share;
            let (along, inward) = self.frame(index, exit);
            let (next_along, next_inward) = self.frame(next.triangle as usize, next.side as usize);
            // Unfolded, inward of the one triangle is outward of the other, and neighbours run through their common
            // edge in opposite directions.
            left = -next_along * left.dot(&along) - next_inward * left.dot(&inward);
            (index, weights) = (next.triangle as usize, self.entry(next, &position));
        }
        normalize(&mut weights);
        self.at(index, weights)
    }

    /// The distances of a place from the three sides of its triangle, each with the unit tangent away from the side.
    /// `None` for a place in a degenerate triangle.
    pub fn sides(&self, place: &SurfaceContact) -> Option<[(f64, Vector3<f64>); 3]> {
        self.is_usable(place.triangle).then(|| {
            let gradients = self.gradients(place.triangle);
            [0, 1, 2].map(|side| {
                let steepness = gradients[side].norm();
                let distance = place.barycentric[side] / steepness;
                (distance, gradients[side] / steepness)
            })
        })
    }

    fn corners(&self, index: usize) -> [Point3<f64>; 3] {
        triangle::corners(&self.mesh.vertices, self.mesh.triangles[index])
    }

    /// Whether the triangle exists and has a normal.
    fn is_usable(&self, index: usize) -> bool {
        index < self.mesh.triangles.len()
            && !triangle::is_degenerate(&self.corners(index), self.mesh.tolerance)
    }

    fn position(&self, index: usize, weights: &[f64; 3]) -> Point3<f64> {
        let [a, b, c] = self.corners(index);
        a + (b - a) * weights[1] + (c - a) * weights[2]
    }

    fn at(&self, index: usize, barycentric: [f64; 3]) -> SurfaceContact {
        let normal = -triangle::normal(&self.corners(index));
        SurfaceContact {
            triangle: index,
            barycentric,
            position: self.position(index, &barycentric),
            normal: UnitVector3::new_normalize(normal),
            source: self.mesh.source[index],
        }
    }

    /// Gradients of the three weights in the plane of the triangle.
    fn gradients(&self, index: usize) -> [Vector3<f64>; 3] {
        let corners = self.corners(index);
        let normal = triangle::normal(&corners);
        let over = normal / normal.norm_squared();
        [0, 1, 2].map(|side| over.cross(&(corners[(side + 2) % 3] - corners[(side + 1) % 3])))
    }

    /// Unit vectors along a side in the direction of the winding, and from it into the triangle.
    fn frame(&self, index: usize, side: usize) -> (Vector3<f64>, Vector3<f64>) {
        let corners = self.corners(index);
        let along = (corners[(side + 2) % 3] - corners[(side + 1) % 3]).normalize();
        let inward = triangle::normal(&corners).normalize().cross(&along);
        (along, inward)
    }

    /// The usable triangle beyond a side that is crossed at `position`. A degenerate one on the way is left by the nearer
    /// of its other sides.
    fn beyond(&self, index: usize, side: usize, position: &Point3<f64>) -> Option<Neighbour> {
        let mut next = self.neighbours[index][side]?;
        for _ in 0..MAX_CROSSINGS {
            let (index, side) = (next.triangle as usize, next.side as usize);
            if self.is_usable(index) {
                return Some(next);
            }
            let others = [(side + 1) % 3, (side + 2) % 3];
            let distance = others.map(|side| {
                let (share, from, along) = self.foot(index, side, position);
                (from + along * share - position).norm_squared()
            });
            let exit = others[usize::from(distance[1] < distance[0])];
            next = self.neighbours[index][exit]?;
        }
        None
    }

    /// The weights of the point nearest to `position` on the side by which a triangle is entered.
    fn entry(&self, next: Neighbour, position: &Point3<f64>) -> [f64; 3] {
        let side = next.side as usize;
        let (share, ..) = self.foot(next.triangle as usize, side, position);
        let mut weights = [0.0; 3];
        weights[(side + 1) % 3] = 1.0 - share;
        weights[(side + 2) % 3] = share;
        weights
    }

    /// The point on a side that is nearest to `position`, as the share of the side before it, and the side's start and
    /// extent.
    fn foot(
        &self,
        index: usize,
        side: usize,
        position: &Point3<f64>,
    ) -> (f64, Point3<f64>, Vector3<f64>) {
        let corners = self.corners(index);
        let from = corners[(side + 1) % 3];
        let along = corners[(side + 2) % 3] - from;
        let share = (position - from).dot(&along) / along.norm_squared();
        (share.clamp(0.0, 1.0), from, along)
    }
}

/// Scales weights that rounding has moved so that they sum to one again.
fn normalize(weights: &mut [f64; 3]) {
    let sum: f64 = weights.iter().sum();
    *weights = weights.map(|w| (w / sum).min(1.0));
}

#[cfg(test)]
mod tests {
    use rand::{Rng, SeedableRng};
    use rand_pcg::Pcg64;

    use super::*;
    use crate::mesh::{RawMesh, solids};

    fn uniform(rng: &mut Pcg64) -> f64 {
        (rng.next_u64() >> 11) as f64 / (1_u64 << 53) as f64
    }

    fn vector(rng: &mut Pcg64) -> Vector3<f64> {
        Vector3::from_fn(|_, _| 2.0 * uniform(rng) - 1.0)
    }

    fn place(surface: &Surface<'_>, rng: &mut Pcg64) -> SurfaceContact {
        let n = surface.mesh().triangles().len();
        let index = (uniform(rng) * n as f64) as usize;
        let (a, b) = (uniform(rng), uniform(rng));
        let (a, b) = if a + b > 1.0 {
            (1.0 - a, 1.0 - b)
        } else {
            (a, b)
        };
        surface.place(index, [1.0 - a - b, a, b]).unwrap()
    }

    fn check(surface: &Surface<'_>, place: &SurfaceContact) {
        let mesh = surface.mesh();
        let corners = triangle::corners(mesh.vertices(), mesh.triangles()[place.triangle]);
        let weighted: Vector3<f64> = corners
            .iter()
            .zip(place.barycentric)
            .map(|(corner, weight)| corner.coords * weight)
            .sum();
        assert!((weighted - place.position.coords).norm() < 1e-12);
        assert!(place.barycentric.iter().all(|w| (0.0..=1.0).contains(w)));
        assert!((place.barycentric.iter().sum::<f64>() - 1.0).abs() < 1e-14);
        assert_eq!(place.source, mesh.source()[place.triangle]);
        let candidate = mesh.candidate_of(place.source).unwrap();
        assert_eq!(place.normal, candidate.normal);
    }

    #[test]
    fn walks_end_on_the_surface_and_no_farther_than_they_are_long() {
        let mut rng = Pcg64::seed_from_u64(1);
        for raw in [
            solids::torus(2.0, 0.7, 24, 12),
            solids::sphere(1.0, 12, 18),
            solids::l_shape(),
            solids::hollow_cube(),
        ] {
            let mesh = Mesh::prepare(raw).unwrap().with_enclosed();
            let surface = Surface::new(&mesh);
            for _ in 0..500 {
                let from = place(&surface, &mut rng);
                let step = vector(&mut rng) * uniform(&mut rng).powi(6) * 4.0;
                let to = surface.walk(&from, &step);
                check(&surface, &to);
                assert!((to.position - from.position).norm() <= step.norm() + 1e-12);
            }
        }
    }

    #[test]
    fn within_a_plane_the_way_is_straight() {
        let mesh = Mesh::prepare(solids::cube(1.0)).unwrap();
        let surface = Surface::new(&mesh);
        let mut rng = Pcg64::seed_from_u64(2);
        for _ in 0..200 {
            let (from, to) = (place(&surface, &mut rng), place(&surface, &mut rng));
            if from.normal == to.normal {
                let reached = surface.walk(&from, &(to.position - from.position));
                assert!((reached.position - to.position).norm() < 1e-12);
            }
        }
    }

    /// Unfolded, four faces of a cube are a strip whose ends meet.
    #[test]
    fn a_walk_around_a_cube_comes_back() {
        let mesh = Mesh::prepare(solids::cube(1.0)).unwrap();
        let surface = Surface::new(&mesh);
        let mut rng = Pcg64::seed_from_u64(3);
        for _ in 0..50 {
            let from = place(&surface, &mut rng);
            for axis in 0..3 {
                if from.normal[axis] == 0.0 {
                    let around = surface.walk(&from, &(Vector3::ith(axis, 4.0)));
                    assert!((around.position - from.position).norm() < 1e-12);
                    let half = surface.walk(&from, &(Vector3::ith(axis, 2.0)));
                    let opposite = from.position - half.position;
                    assert!((half.normal.into_inner() + from.normal.into_inner()).norm() < 1e-12);
                    assert!((opposite.dot(&from.normal).abs() - 1.0).abs() < 1e-12);
                }
            }
        }
    }

    #[test]
    fn a_border_ends_the_walk() {
        let mut raw = solids::cube(1.0);
        // Without its top, z = 1.
        let at_top = |&n: &u32| raw.vertices[n as usize].z == 1.0;
        raw.triangles.retain(|t| !t.iter().all(at_top));
        let mesh = Mesh::prepare(raw).unwrap();
        let surface = Surface::new(&mesh);
        let mut rng = Pcg64::seed_from_u64(4);
        for _ in 0..100 {
            let from = place(&surface, &mut rng);
            if from.normal.z == 0.0 {
                let to = surface.walk(&from, &Vector3::new(0.0, 0.0, 3.0));
                let above = Point3::new(from.position.x, from.position.y, 1.0);
                assert!((to.position - above).norm() < 1e-12);
            }
        }
    }

    /// A square pyramid whose base is cut by a triangle without area.
    fn with_sliver() -> RawMesh {
        let at = |x: f64, y: f64, z: f64| Point3::new(x, y, z);
        RawMesh {
            vertices: vec![
                at(0.0, 0.0, 0.0),
                at(1.0, 0.0, 0.0),
                at(1.0, 1.0, 0.0),
                at(0.0, 1.0, 0.0),
                at(0.5, 0.5, 1.0),
                at(0.5, 0.5, 0.0),
            ],
            triangles: vec![
                [0, 2, 1],
                [0, 5, 2],
                [0, 3, 5],
                [5, 3, 2],
                [0, 1, 4],
                [1, 2, 4],
                [2, 3, 4],
                [3, 0, 4],
            ],
            ..RawMesh::default()
        }
    }

    #[test]
    fn a_sliver_is_passed_through() {
        let mesh = Mesh::prepare(with_sliver()).unwrap();
        assert_eq!(mesh.report().degenerate_triangles, 1);
        let surface = Surface::new(&mesh);
        let sliver = mesh.source().binary_search(&1).unwrap();
        assert_eq!(surface.centroid(sliver), None);
        for (x, y) in [(0.8, 0.1), (0.95, 0.7), (0.6, 0.5)] {
            let from = surface.place(0, [1.0 - x, y, x - y]).unwrap();
            assert!((from.position - Point3::new(x, y, 0.0)).norm() < 1e-12);
            let to = surface.walk(&from, &Vector3::new(y - x, x - y, 0.0));
            assert!((to.position - Point3::new(y, x, 0.0)).norm() < 1e-12);
        }
    }

    #[test]
    fn what_is_no_place_is_refused_and_not_left() {
        let mesh = Mesh::prepare(solids::cube(1.0)).unwrap();
        let surface = Surface::new(&mesh);
        assert_eq!(surface.centroid(12), None);
        for weights in [[0.5, 0.6, -0.1], [0.5; 3], [f64::NAN, 0.5, 0.5]] {
            assert_eq!(surface.place(0, weights), None);
        }
        let mut from = surface.centroid(0).unwrap();
        for step in [f64::NAN, f64::INFINITY] {
            assert_eq!(surface.walk(&from, &Vector3::repeat(step)), from);
        }
        let around = surface.walk(&from, &Vector3::repeat(1e9));
        check(&surface, &around);
        from.triangle = 12;
        assert_eq!(surface.walk(&from, &Vector3::x()), from);
        assert_eq!(surface.sides(&from), None);
    }
}
