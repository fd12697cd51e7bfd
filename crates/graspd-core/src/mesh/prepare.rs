//! The steps from triangles as a file has them to a body that can be grasped.

use nalgebra::{Point3, center};

use super::caps::{self, Caps};
use super::{MAX_COORDINATE, MassSource, Mesh, MeshReport, RawMesh};
use super::{copies, mass, orient, triangle, warnings, weld};

/// Volume below which a closed surface encloses nothing, over its area times its diagonal.
///
/// Summing signed tetrahedra leaves rounding of about 1e-13 of that product for a million
/// triangles. A plate that is just thick enough to pass for a body, one welding tolerance
/// (5e-7 of the diagonal), still has half of that.
const ZERO_VOLUME: f64 = 1e-9;

/// Greatest area of the caps that close all holes, over that of the surface. A box scanned without its floor
/// stays below, and an empty half of a ball, which is no solid, is at 0.5.
const LARGEST_CAPS: f64 = 0.25;

/// How far the volumes along the three axes may be apart, over the volume.
const WORST_VOLUME: f64 = 1e-6;

/// Why triangles do not make a body. The messages are meant for whoever sent the mesh.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum PrepareError {
    /// There is nothing to prepare.
    #[error("the mesh has no triangles; export the surface as a triangle mesh")]
    NoTriangles,
    /// A vertex, by its index, is no place in space.
    #[error(
        "vertex {0} (counted from 0) is not finite, or beyond {MAX_COORDINATE:e}; repair the mesh"
    )]
    BadVertex(usize),
    /// A triangle, by its index, has a corner that is no vertex.
    #[error("triangle {0} (counted from 0) names a vertex that does not exist; repair the mesh")]
    BadIndex(usize),
    /// No triangle, of so many, has a usable normal.
    #[error(
        "all {0} triangles are degenerate: each is a point or a line; check the unit and the export"
    )]
    AllDegenerate(usize),
    /// There is no body, and why: all in one plane, or no volume enclosed.
    #[error("the mesh is flat: {0}; a grasp needs a body with volume")]
    Flat(&'static str),
}

impl Mesh {
    /// Welds vertices, drops copies, makes the winding consistent and outward, and weighs the body.
    ///
    /// Nothing is scaled, moved or filled. Open and non-manifold surfaces are accepted and said to
    /// be so in the report. One whose holes are small is weighed as if flat caps closed them, as a scan
    /// without the spot that the body stood on; any other as a shell. Triangles thinner than the welding tolerance
    /// ([`WELD_TOLERANCE`](super::WELD_TOLERANCE) of the diagonal) are no candidates. The same input gives the same mesh to the last bit;
    /// O(n log n).
    ///
    /// # Errors
    /// See [`PrepareError`]; the readers of `graspd-mesh-io` hand over no bad vertex or index.
    pub fn prepare(raw: RawMesh) -> Result<Self, PrepareError> {
        check(&raw)?;
        let weld::Welded {
            vertices,
            mut triangles,
            mut source,
            tolerance,
        } = weld::weld(&raw);
        let (vertices_read, triangles_read) = (raw.vertices.len(), raw.triangles.len());
        // A large file would else be in memory twice while edges are sorted.
        drop(raw);
        let collapsed = triangles_read - triangles.len();
        let duplicate_triangles = copies::drop_copies(&mut triangles, &mut source);
        let mut areas: Vec<f64> = triangles
            .iter()
            .map(|&indices| triangle::corners(&vertices, indices))
            .filter(|corners| !triangle::is_degenerate(corners, tolerance))
            .map(|corners| triangle::area(&corners))
            .collect();
        if areas.is_empty() {
            return Err(PrepareError::AllDegenerate(triangles_read));
        }
        let (low, high) = weld::bounds(vertices.iter().copied());
        let middle = center(&low, &high);
        let diagonal = (high - low).norm();
        if mass::thickness(&vertices, &middle, diagonal) <= tolerance {
            return Err(PrepareError::Flat("all its vertices lie in one plane"));
        }

        let found = orient::orient(&vertices, &mut triangles, &middle, tolerance);
        let (area, center_of_surface) = mass::surface(&vertices, &triangles, &middle);
        let caps = (!found.closed)
            .then(|| caps::caps(&vertices, &triangles))
            .flatten();
        let mass_from = match (found.closed, &caps) {
            (true, _) => MassSource::Solid,
            (false, Some(caps)) if caps.area(&vertices) <= LARGEST_CAPS * area => {
                MassSource::Capped
            }
            _ => MassSource::Surface,
        };
        let solid = match mass_from {
            MassSource::Solid => Some(mass::solid(&vertices, &triangles, &middle, diagonal)),
            MassSource::Capped => caps.as_ref().map(|caps| {
                let (vertices, triangles) = caps.applied(&vertices, &triangles);
                mass::solid(&vertices, &triangles, &middle, diagonal)
            }),
            MassSource::Surface => None,
        };
        if let (MassSource::Solid, Some(solid)) = (mass_from, &solid)
            && solid.volume <= ZERO_VOLUME * area * diagonal
        {
            return Err(PrepareError::Flat("its surface encloses no volume"));
        }
        // A surface that crosses itself counts some space negatively. When that moves the centre
        // out of the box, or nothing is left, the numbers are not those of any solid.
        let solid = solid.filter(|solid| {
            solid.volume > ZERO_VOLUME * area * diagonal
                && solid.error <= WORST_VOLUME
                && low <= solid.center
                && solid.center <= high
        });
        let center_of_mass = solid.map_or(center_of_surface, |solid| solid.center);

        let mut report = MeshReport {
            vertices_read,
            triangles_read,
            vertices: vertices.len(),
            triangles: triangles.len(),
            degenerate_triangles: collapsed + triangles.len() - areas.len(),
            duplicate_triangles,
            components: found.components,
            flipped_triangles: found.flipped,
            border_edges: found.border_edges,
            non_manifold_edges: found.non_manifold_edges,
            watertight: found.border_edges == 0 && found.non_manifold_edges == 0,
            holes: caps.as_ref().map_or(0, Caps::count),
            mass_from: match solid {
                Some(_) => mass_from,
                None => MassSource::Surface,
            },
            volume: solid.map(|solid| solid.volume),
            volume_error: solid.map(|solid| solid.error),
            area,
            center_of_mass,
            bounds: [low, high],
            bounding_radius: mass::radius_about(&vertices, &center_of_mass),
            candidates: areas.len(),
            area_ratio: area_ratio(&mut areas),
            warnings: Vec::new(),
        };
        report.warnings = warnings::warnings(&report);
        Ok(Self {
            vertices,
            triangles,
            source,
            tolerance,
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
