//! The edges that keep a surface from being closed.

use super::Mesh;
use super::edges::Edges;

/// The edges that do not join exactly two triangles in consistent winding; each is given by its two vertices.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct DefectiveEdges {
    /// Edges with one triangle.
    pub border: Vec<[u32; 2]>,
    /// Edges with three or more triangles, or with two that no winding makes consistent.
    pub non_manifold: Vec<[u32; 2]>,
}

impl Mesh {
    /// Returns the edges that [`MeshReport::border_edges`](super::MeshReport::border_edges) and
    /// [`MeshReport::non_manifold_edges`](super::MeshReport::non_manifold_edges) count, by indices into
    /// [`Self::vertices`]. O(n log n), and O(1) when the mesh is watertight.
    pub fn defective_edges(&self) -> DefectiveEdges {
        let mut found = DefectiveEdges::default();
        if self.report.watertight {
            return found;
        }
        for uses in Edges::new(&self.triangles).iter() {
            match uses {
                [only] => found.border.push(only.vertices()),
                // Preparation made the winding consistent wherever that is possible.
                [a, b] if a.ascending != b.ascending => {}
                [first, ..] => found.non_manifold.push(first.vertices()),
                [] => {}
            }
        }
        found
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::Point3;

    use super::super::solids::{cube, tetrahedron};
    use super::*;
    use crate::mesh::RawMesh;

    fn defects(raw: RawMesh) -> DefectiveEdges {
        let mesh = Mesh::prepare(raw).unwrap();
        let found = mesh.defective_edges();
        let report = mesh.report();
        assert_eq!(found.border.len(), report.border_edges);
        assert_eq!(found.non_manifold.len(), report.non_manifold_edges);
        found
    }

    #[test]
    fn a_closed_body_has_none() {
        assert_eq!(defects(cube(1.0)), DefectiveEdges::default());
    }

    #[test]
    fn the_rim_of_a_hole_is_border() {
        let mut raw = tetrahedron();
        raw.triangles.pop();
        let mesh = Mesh::prepare(raw.clone()).unwrap();
        let found = defects(raw);
        let corners = [1.0, 2.0, 3.0].map(|n| {
            let mut at = Point3::origin();
            at[n as usize - 1] = 1.0;
            at
        });
        assert_eq!(found.border.len(), 3);
        for vertex in found.border.iter().flatten() {
            assert!(corners.contains(&mesh.vertices()[*vertex as usize]));
        }
        assert!(found.non_manifold.is_empty());
    }

    #[test]
    fn a_fin_makes_an_edge_non_manifold() {
        let mut raw = tetrahedron();
        raw.vertices.push(Point3::new(-1.0, -1.0, 0.5));
        raw.triangles.push([0, 3, 4]);
        let mesh = Mesh::prepare(raw.clone()).unwrap();
        let found = defects(raw);
        assert_eq!((found.border.len(), found.non_manifold.len()), (2, 1));
        let ends = found.non_manifold[0].map(|n| mesh.vertices()[n as usize]);
        assert!(ends.contains(&Point3::origin()) && ends.contains(&Point3::new(0.0, 0.0, 1.0)));
    }

    #[test]
    fn two_triangles_that_cannot_agree_are_non_manifold() {
        // A Möbius strip of five quads.
        let vertices = (0..5).flat_map(|n| {
            let (around, tilt) = (f64::from(n) * 1.256_637, f64::from(n) * 0.628_318_5);
            [-0.3, 0.3].map(|side: f64| {
                let from_axis = 1.0 + side * tilt.cos();
                Point3::new(
                    from_axis * around.cos(),
                    from_axis * around.sin(),
                    side * tilt.sin(),
                )
            })
        });
        let quads = (0..5u32).flat_map(|n| {
            let (a, b) = (2 * n, 2 * n + 1);
            let [c, d] = if n == 4 { [1, 0] } else { [a + 2, b + 2] };
            [[a, b, c], [b, d, c]]
        });
        let raw = RawMesh {
            vertices: vertices.collect(),
            triangles: quads.collect(),
            ..RawMesh::default()
        };
        let found = defects(raw);
        assert!(!found.non_manifold.is_empty());
        assert_eq!(found.border.len(), 10);
    }
}
