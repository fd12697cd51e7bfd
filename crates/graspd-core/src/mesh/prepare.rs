//! The steps from triangles as a file has them to a body that can be grasped.
//!
//! ```text
//! check        coordinates are finite and not absurd, indices in range
//! weld         close vertices become one, triangles that collapse go
//! duplicates   copies of triangles go
//! flatness     a body has a normal somewhere and is thicker than the welding tolerance
//! orient       the winding of each part becomes consistent and outward
//! examine      where parts overlap, and which of the surface bounds matter; walls of cavities face the cavity
//! weigh        volume, centre of mass
//! ```
//!
//! The order matters. Only welding shows which triangles share an edge; copies would make every edge non-manifold;
//! the winding must be outward before a volume means anything. Each step is a file of its own. Nothing is scaled,
//! moved or filled: whatever the surface lacks is reported instead.

use nalgebra::{Point3, center};

use super::cover::State;
use super::mass::{self, Extent};
use super::{MAX_COORDINATE, MassSource, Mesh, MeshReport, RawMesh};
use super::{bodies, duplicate_faces, loose, matter, orient, triangle, warnings, weld};

/// Why triangles do not make a body. The messages are meant for whoever sent the mesh.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum PrepareError {
    /// There is nothing to prepare.
    #[error("the mesh has no triangles; export the surface as a triangle mesh")]
    NoTriangles,
    /// A coordinate of the vertex with this index is not finite, or too large.
    #[error(
        "vertex {0} (counted from 0) is not finite, or beyond {MAX_COORDINATE:e}; repair the mesh"
    )]
    BadVertex(usize),
    /// A corner of the triangle with this index is not among the vertices.
    #[error("triangle {0} (counted from 0) names a vertex that does not exist; repair the mesh")]
    BadIndex(usize),
    /// None of the triangles, of which there are so many, has a usable normal.
    #[error(
        "all {0} triangles are degenerate: each is a point or a line; check the unit and the export"
    )]
    AllDegenerate(usize),
    /// There is no body, for this reason: all vertices lie in one plane, or no volume is enclosed.
    #[error("the mesh is flat: {0}; a grasp needs a body with volume")]
    Flat(&'static str),
}

impl Mesh {
    /// Welds vertices, drops copies, makes the winding consistent and outward, and weighs the body.
    ///
    /// Nothing is scaled, moved or filled. Open and non-manifold surfaces are accepted; the
    /// [report](Self::report) says so. A surface whose holes are small is weighed as if flat caps closed them, such as a
    /// scan without the spot that the body stood on; any other open surface as a shell. Triangles thinner than the
    /// welding tolerance ([`WELD_TOLERANCE`](super::WELD_TOLERANCE) of the diagonal) are no candidates. The same input
    /// gives the same mesh to the last bit. O(n log n).
    ///
    /// # Errors
    /// See [`PrepareError`]; the readers of `graspd-mesh-io` hand over no bad vertex or index.
    ///
    /// # Examples
    ///
    /// A wedge whose triangles are wound at random still has its volume, and its normals point inward:
    ///
    /// ```
    /// use graspd_core::mesh::{MassSource, Mesh, RawMesh};
    /// use nalgebra::Point3;
    ///
    /// let raw = RawMesh {
    ///     vertices: [[0.0, 0.0, 0.0], [3.0, 0.0, 0.0], [0.0, 2.0, 0.0], [0.0, 0.0, 1.0]]
    ///         .map(Point3::from)
    ///         .to_vec(),
    ///     triangles: vec![[0, 1, 2], [0, 1, 3], [0, 2, 3], [1, 2, 3]],
    ///     ..RawMesh::default()
    /// };
    /// let mesh = Mesh::prepare(raw)?;
    /// let report = mesh.report();
    /// assert_eq!(report.mass_from, MassSource::Solid);
    /// assert!((report.volume.unwrap() - 1.0).abs() < 1e-12);
    /// assert_eq!(report.flipped_triangles, 2);
    /// for candidate in mesh.candidates() {
    ///     let to_center = report.center_of_mass - candidate.position;
    ///     assert!(candidate.normal.dot(&to_center) > 0.0);
    /// }
    /// # Ok::<(), graspd_core::mesh::PrepareError>(())
    /// ```
    ///
    /// A sheet is no body:
    ///
    /// ```
    /// # use graspd_core::mesh::{Mesh, RawMesh};
    /// # use nalgebra::Point3;
    /// # let corners = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]].map(Point3::from);
    /// let sheet = RawMesh { vertices: corners.to_vec(), triangles: vec![[0, 1, 2]], ..RawMesh::default() };
    /// let refused = Mesh::prepare(sheet).unwrap_err();
    /// assert!(refused.to_string().starts_with("the mesh is flat"));
    /// ```
    pub fn prepare(raw: RawMesh) -> Result<Self, PrepareError> {
        check(&raw)?;
        let weld::Welded {
            vertices,
            mut triangles,
            mut source,
            tolerance,
        } = weld::weld(&raw);
        let (vertices_read, triangles_read) = (raw.vertices.len(), raw.triangles.len());
        let (reader_warnings, named_parts) = (raw.warnings, raw.parts);
        // A large file would else be in memory twice while edges are sorted.
        drop((raw.vertices, raw.triangles));
        let collapsed = triangles_read - triangles.len();
        let duplicate_triangles = duplicate_faces::drop_duplicates(&mut triangles, &mut source);
        let is_usable = |indices: [u32; 3]| {
            !triangle::is_degenerate(&triangle::corners(&vertices, indices), tolerance)
        };
        if !triangles.iter().any(|&indices| is_usable(indices)) {
            return Err(PrepareError::AllDegenerate(triangles_read));
        }
        let (low, high) = weld::bounds(vertices.iter().copied());
        let extent = Extent {
            low,
            high,
            center: center(&low, &high),
            diagonal: (high - low).norm(),
        };
        if mass::thickness(&vertices, &extent) <= tolerance {
            return Err(PrepareError::Flat("all its vertices lie in one plane"));
        }
        let before = triangles.clone();
        let orientation = orient::orient(&vertices, &mut triangles, &extent.center, tolerance);
        let (border_edges, non_manifold_edges, unresolved_edges) = (
            orientation.border_edges,
            orientation.non_manifold_edges,
            orientation.unresolved_edges,
        );
        let matter = matter::examine(
            &vertices,
            &mut triangles,
            &before,
            orientation,
            &extent,
            tolerance,
        );
        let weight = mass::weigh(&vertices, &triangles, &matter.bounded(), &extent)
            .ok_or(PrepareError::Flat("its surface encloses no volume"))?;
        let unverified_normals = match weight.mass_from {
            MassSource::Surface => loose::on_trust(&vertices, &triangles, &matter.parts, tolerance),
            _ => 0,
        };
        let flipped = before.iter().zip(&triangles).filter(|(a, b)| a != b);

        let (mut buried_triangles, mut enclosed_triangles) = (0, 0);
        let mut areas = Vec::new();
        let mut usable = 0;
        for (index, &indices) in triangles.iter().enumerate() {
            if !is_usable(indices) {
                continue;
            }
            usable += 1;
            match matter.cover.state(index, &triangle::CENTROID) {
                State::Buried => buried_triangles += 1,
                State::Enclosed => enclosed_triangles += 1,
                State::Exposed => {
                    areas.push(triangle::area(&triangle::corners(&vertices, indices)));
                }
            }
        }
        let mut report = MeshReport {
            vertices_read,
            triangles_read,
            vertices: vertices.len(),
            triangles: triangles.len(),
            degenerate_triangles: collapsed + triangles.len() - usable,
            duplicate_triangles,
            components: matter.parts.len(),
            flipped_triangles: flipped.count(),
            border_edges,
            non_manifold_edges,
            unresolved_edges,
            overlapping_parts: matter.overlapping_parts,
            unexamined: matter.unexamined,
            buried_triangles,
            enclosed_triangles,
            unverified_normals,
            body_count: matter
                .body_of
                .iter()
                .max()
                .map_or(1, |&last| last as usize + 1),
            bodies: bodies::describe(
                &vertices,
                &triangles,
                &matter.body_of,
                &source,
                &named_parts,
            ),
            watertight: border_edges == 0 && non_manifold_edges == 0,
            holes: weight.holes,
            mass_from: weight.mass_from,
            volume: weight.volume,
            volume_error: weight.volume_error,
            volume_bound: weight.bounds.map(|[volume, _]| volume),
            center_bound: weight.bounds.map(|[_, center]| center),
            area: weight.area,
            center_of_mass: weight.center_of_mass,
            bounds: [low, high],
            bounding_radius: mass::radius_about(&vertices, &weight.center_of_mass),
            candidates: areas.len(),
            area_ratio: area_ratio(&mut areas),
            warnings: reader_warnings,
        };
        let found = warnings::warnings(&report);
        report.warnings.extend(found);
        Ok(Self {
            vertices,
            triangles,
            source,
            tolerance,
            cover: matter.cover,
            body_of: matter.body_of,
            named_parts,
            is_component: false,
            report,
        })
    }
}

fn check(raw: &RawMesh) -> Result<(), PrepareError> {
    if raw.triangles.is_empty() {
        return Err(PrepareError::NoTriangles);
    }
    let sane = |v: &Point3<f64>| v.iter().all(|x| x.abs() <= MAX_COORDINATE);
    if let Some(n) = raw.vertices.iter().position(|v| !sane(v)) {
        return Err(PrepareError::BadVertex(n));
    }
    let exists = |&index: &u32| (index as usize) < raw.vertices.len();
    match raw.triangles.iter().position(|t| !t.iter().all(exists)) {
        Some(n) => Err(PrepareError::BadIndex(n)),
        None => Ok(()),
    }
}

/// 95th over 5th percentile, each interpolated between its neighbours.
fn area_ratio(areas: &mut [f64]) -> f64 {
    let mut percentile = |share: f64| {
        let rank = share * (areas.len() - 1) as f64;
        let (_, &mut below, rest) =
            areas.select_nth_unstable_by(rank.floor() as usize, f64::total_cmp);
        let above = rest.iter().copied().min_by(f64::total_cmp);
        below + (above.unwrap_or(below) - below) * rank.fract()
    };
    percentile(0.95) / percentile(0.05)
}
