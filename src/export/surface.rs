//! The surface that is exported: the whole, or a coarser one to look at.
//!
//! Coarsening is vertex clustering. Space is cut into cubes; all vertices in a cube become one, their
//! mean; triangles that lose a corner vanish, and of triangles that coincide one stays:
//!
//! ```text
//! cell = sqrt(3 * area / budget)
//! repeat at most MAX_TRIES times:
//!     merge the vertices of each cube of side `cell`, drop degenerate and duplicate triangles
//!     if 1 <= triangles <= budget: return
//!     if none is left: cell = cell / 2
//!     else:            cell = cell * max(sqrt(triangles / budget), GROWTH)
//! return every k-th triangle of the mesh
//! ```
//!
//! - **Invariant.** The mean of points in a cube lies in the cube, so every vertex is within a cube's
//!   diagonal of the surface, and a triangle keeps the number of one that it stands for.
//! - **Why it ends.** The number of tries is bounded. Usually there are two or three: the triangles of
//!   a surface go as the inverse square of the cell, so the excess shrinks at least to its root with
//!   each try. A thicket of needles, which no grid makes smaller, is sampled instead.
//! - **Cost.** O(vertices + triangles) time a try, and as much memory; plus sorting the triangles that
//!   are left. The same mesh gives the same surface.
//!
//! Clustering was chosen over edge collapse because the result is for looking at: it is linear, has no
//! cases that can fail on a defective mesh, and its error is bounded by the cell.

use std::collections::HashMap;

use foldhash::fast::FixedState;
use nalgebra::{Point3, Vector3};

use graspd_core::mesh::Mesh;

/// The least budget of triangles that a client may ask for.
pub const MIN_BUDGET: usize = 1_000;
/// The greatest budget of triangles that a client may ask for.
pub const MAX_BUDGET: usize = 2_000_000;

/// The least factor by which cells grow while there are too many triangles.
const GROWTH: f64 = 1.12;
/// The most tries; the first size is nearly right, and the excess shrinks at least to its root each time.
const MAX_TRIES: usize = 40;
/// Triangles for each cell that a smooth closed surface passes through, from which the first size follows.
const TRIANGLES_PER_CELL: f64 = 3.0;
/// The most cells along the longest side, so that their numbers are exact in `u32`.
const MAX_CELLS: f64 = 1e6;

/// Triangles with the numbers that they have in the uploaded file.
#[derive(Debug, Clone)]
pub struct Surface {
    /// Positions in the mesh's frame and unit.
    pub vertices: Vec<Point3<f64>>,
    /// Counter-clockwise seen from outside.
    pub triangles: Vec<[u32; 3]>,
    /// The number of each triangle in the file; on a coarse surface, of one that it stands for.
    pub source: Vec<u32>,
    /// Whether the mesh has more triangles than these.
    pub coarse: bool,
}

impl Surface {
    /// Returns the surface of a mesh with at most `budget` triangles, which is at least [`MIN_BUDGET`].
    pub fn of(mesh: &Mesh, budget: usize) -> Self {
        if mesh.triangles().len() <= budget {
            return Self {
                vertices: mesh.vertices().to_vec(),
                triangles: mesh.triangles().to_vec(),
                source: mesh.source().to_vec(),
                coarse: false,
            };
        }
        let [low, high] = mesh.report().bounds;
        let size = (high - low).max();
        let area: f64 = mesh.areas().sum();
        let mut cell = (TRIANGLES_PER_CELL * area / budget as f64).sqrt();
        cell = cell.clamp(size / MAX_CELLS, size);
        for _ in 0..MAX_TRIES {
            let body = clustered(mesh, &low, cell);
            let count = body.triangles.len();
            if (1..=budget).contains(&count) {
                return body;
            }
            cell *= match count {
                // The whole body fell into one cell.
                0 => 0.5,
                // The triangles of a surface go as the inverse square of the cell.
                _ => (count as f64 / budget as f64).sqrt().max(GROWTH),
            };
        }
        sampled(mesh, budget)
    }

    /// Returns the lowest and the highest corner of its bounding box.
    pub fn bounds(&self) -> [Point3<f64>; 2] {
        let ends = [f64::INFINITY, f64::NEG_INFINITY].map(|end| Point3::from([end; 3]));
        self.vertices.iter().fold(ends, |[low, high], vertex| {
            [low.inf(vertex), high.sup(vertex)]
        })
    }
}

/// Returns the surface with the vertices of each cube of side `cell` merged into one.
fn clustered(mesh: &Mesh, low: &Point3<f64>, cell: f64) -> Surface {
    let mut numbers: HashMap<[u32; 3], u32, FixedState> = HashMap::default();
    let mut sums: Vec<(Vector3<f64>, f64)> = Vec::new();
    let clusters: Vec<u32> = mesh
        .vertices()
        .iter()
        .map(|vertex| {
            let offset = vertex - low;
            let place = [0, 1, 2].map(|axis| (offset[axis] / cell) as u32);
            let number = *numbers.entry(place).or_insert(sums.len() as u32);
            match sums.get_mut(number as usize) {
                Some((sum, count)) => {
                    *sum += offset;
                    *count += 1.0;
                }
                None => sums.push((offset, 1.0)),
            }
            number
        })
        .collect();
    let mut triangles: Vec<([u32; 3], u32)> = mesh
        .triangles()
        .iter()
        .zip(mesh.source())
        .map(|(corners, &source)| (corners.map(|corner| clusters[corner as usize]), source))
        .filter(|([a, b, c], _)| a != b && b != c && c != a)
        .map(|(corners, source)| (from_least(corners), source))
        .collect();
    // Two sides of a thin wall may collapse onto each other: of equal triangles one stays.
    triangles.sort_unstable();
    triangles.dedup_by_key(|(corners, _)| *corners);
    // In the order of the file again, in which neighbours are mostly near each other.
    triangles.sort_unstable_by_key(|(_, source)| *source);
    let (triangles, source) = triangles.into_iter().unzip();
    used(Surface {
        vertices: sums
            .into_iter()
            .map(|(sum, count)| low + sum / count)
            .collect(),
        triangles,
        source,
        coarse: true,
    })
}

/// Rotates the corners so that the least comes first: equal triangles become equal arrays, and the
/// winding stays.
fn from_least([a, b, c]: [u32; 3]) -> [u32; 3] {
    match a.min(b).min(c) {
        least if least == a => [a, b, c],
        least if least == b => [b, c, a],
        _ => [c, a, b],
    }
}

/// Removes the vertices that no triangle uses.
fn used(body: Surface) -> Surface {
    let mut numbers = vec![u32::MAX; body.vertices.len()];
    let mut vertices = Vec::new();
    let mut triangles = body.triangles;
    for corner in triangles.iter_mut().flatten() {
        let number = &mut numbers[*corner as usize];
        if *number == u32::MAX {
            *number = vertices.len() as u32;
            vertices.push(body.vertices[*corner as usize]);
        }
        *corner = *number;
    }
    Surface {
        vertices,
        triangles,
        ..body
    }
}

/// Returns evenly chosen triangles, for a thicket of needles that no grid makes smaller.
fn sampled(mesh: &Mesh, budget: usize) -> Surface {
    let step = mesh.triangles().len().div_ceil(budget);
    used(Surface {
        vertices: mesh.vertices().to_vec(),
        triangles: mesh.triangles().iter().copied().step_by(step).collect(),
        source: mesh.source().iter().copied().step_by(step).collect(),
        coarse: true,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use graspd_core::mesh::{RawMesh, solids};

    #[test]
    fn a_small_mesh_is_exported_as_it_is() {
        let mesh = Mesh::prepare(solids::sphere(1.0, 20, 40)).unwrap();
        let body = Surface::of(&mesh, mesh.triangles().len());
        assert!(!body.coarse);
        assert_eq!(body.triangles, mesh.triangles());
        assert_eq!(body.source, mesh.source());
    }

    #[test]
    fn needles_are_made_fewer_too() {
        // Long triangles about one line, each with corners of its own.
        let mut vertices = Vec::new();
        for number in 0..20_000 {
            let (sine, cosine) = (f64::from(number) * 0.37).sin_cos();
            let shift = f64::from(number) * 1e-5;
            let near = [shift, 1e-4 * cosine, 1e-4 * sine];
            let wide = [shift, -1e-4 * sine, 1e-4 * cosine];
            let far = [shift + 1.0, 2e-4 * sine, 1e-4 * cosine];
            vertices.extend([near, wide, far].map(Point3::from));
        }
        let corners: Vec<u32> = (0..60_000).collect();
        let needles = RawMesh {
            vertices,
            triangles: corners.as_chunks().0.to_vec(),
            ..RawMesh::default()
        };
        let mesh = Mesh::prepare(needles).unwrap();
        assert!(mesh.triangles().len() > 10_000);
        for budget in [1_000, 5_000] {
            let body = Surface::of(&mesh, budget);
            assert!((1..=budget).contains(&body.triangles.len()));
        }
        let some = sampled(&mesh, 1_000);
        assert!(some.coarse && (500..=1_000).contains(&some.triangles.len()));
        assert_eq!(some.source.len(), some.triangles.len());
        assert_eq!(some.vertices.len(), 3 * some.triangles.len());
    }

    #[test]
    fn a_coarser_surface_keeps_the_budget_and_the_form() {
        let mesh = Mesh::prepare(solids::sphere(1.0, 200, 400)).unwrap();
        for budget in [1_000, 5_000, 40_000] {
            let body = Surface::of(&mesh, budget);
            let count = body.triangles.len();
            assert!(
                body.coarse && count <= budget && count > budget / 4,
                "{count}"
            );
            assert_eq!(body.source.len(), count);
            let known = |source: &u32| mesh.source().binary_search(source).is_ok();
            assert!(body.source.iter().all(known));
            // A radius of one; a cube of the coarsest grid is 0.2 wide.
            let radius = |vertex: &Point3<f64>| vertex.coords.norm();
            let worst = body.vertices.iter().map(|v| (radius(v) - 1.0).abs());
            assert!(
                worst.fold(0.0, f64::max) < 12.0 / (budget as f64),
                "{budget}"
            );
            // What a triangle stands for is near it.
            let candidates = mesh.candidates();
            for (corners, source) in body.triangles.iter().zip(&body.source) {
                let [a, b, c] = corners.map(|corner| body.vertices[corner as usize]);
                let middle = (a.coords + b.coords + c.coords) / 3.0;
                let at = candidates.binary_search_by_key(source, |c| c.triangle);
                let there = candidates[at.expect("a candidate")].position;
                let side = (12.0 / budget as f64).sqrt() * 3.0;
                assert!((there.coords - middle).norm() < side, "{budget}");
            }
        }
    }
}
