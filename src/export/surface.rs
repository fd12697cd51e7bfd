//! The surface that is exported: the whole, or a coarser one to look at.

use std::collections::HashMap;

use foldhash::fast::FixedState;
use nalgebra::{Point3, Vector3};

use graspd_core::mesh::Mesh;

/// Least number of triangles that a coarser surface may be asked to have at most.
pub const MIN_BUDGET: usize = 1_000;
/// Greatest such number.
pub const MAX_BUDGET: usize = 2_000_000;

/// By how much cells grow at least while there are too many triangles.
const GROWTH: f64 = 1.12;
/// Most times that they do; the first size is nearly right, and each time the excess shrinks to its root at least.
const MAX_TRIES: usize = 40;
/// Triangles of a smooth closed surface for each cell of a grid that it passes through, over area and cell: what
/// the first try is made with.
const TRIANGLES_PER_CELL: f64 = 3.0;
/// Cells along the longest side at most, so that their numbers are exact.
const MAX_CELLS: f64 = 1e6;

/// Triangles with the numbers that they have in the uploaded file.
#[derive(Debug, Clone)]
pub struct Surface {
    /// Positions in the mesh's frame and unit.
    pub vertices: Vec<Point3<f64>>,
    /// Counter-clockwise seen from outside.
    pub triangles: Vec<[u32; 3]>,
    /// For each triangle its number in the file; of a coarse surface, that of one that it stands for.
    pub source: Vec<u32>,
    /// Whether the mesh has more triangles than these.
    pub coarse: bool,
}

impl Surface {
    /// The surface of a mesh with at most `budget` triangles, from [`MIN_BUDGET`] on.
    ///
    /// One that has more is cut into cubes; the vertices in each become their mean, which lies in the cube, and
    /// triangles with two corners in one vanish. Every vertex is so within a cube's diagonal of the surface. The
    /// same mesh gives the same; O(vertices + triangles) a try, of which there are a few.
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
                // Nothing is left of a body in one cell.
                0 => 0.5,
                // Of a surface the number goes as the square of the cell.
                _ => (count as f64 / budget as f64).sqrt().max(GROWTH),
            };
        }
        sampled(mesh, budget)
    }

    /// Lowest and highest corner of the box around it.
    pub fn bounds(&self) -> [Point3<f64>; 2] {
        let ends = [f64::INFINITY, f64::NEG_INFINITY].map(|end| Point3::from([end; 3]));
        self.vertices.iter().fold(ends, |[low, high], vertex| {
            [low.inf(vertex), high.sup(vertex)]
        })
    }
}

/// The surface with one vertex for each cube of side `cell` that it has vertices in.
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
    triangles.sort_unstable();
    triangles.dedup_by_key(|(corners, _)| *corners);
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

/// The same triangle from its least corner on.
fn from_least([a, b, c]: [u32; 3]) -> [u32; 3] {
    match a.min(b).min(c) {
        least if least == a => [a, b, c],
        least if least == b => [b, c, a],
        _ => [c, a, b],
    }
}

/// The same without vertices that no triangle has.
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

/// Evenly chosen triangles, for a thicket that no grid makes smaller.
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
