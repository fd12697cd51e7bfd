//! Reasons not to trust a grasp of a mesh as it is.

use super::report::{EVEN_RATIO, MassSource, MeshReport, MeshWarning, WarningKind};

/// The warnings that follow from the other members of the report.
pub(super) fn warnings(report: &MeshReport) -> Vec<MeshWarning> {
    let mut found = Vec::new();
    let mut warn = |kind, detail: String| found.push(MeshWarning { kind, detail });
    if report.border_edges > 0 {
        warn(
            WarningKind::Open,
            format!(
                "the surface is open along {} edges, {} holes; repair it, or leave it if the holes are where \
                 no finger goes",
                report.border_edges, report.holes
            ),
        );
    }
    if report.non_manifold_edges > 0 {
        warn(
            WarningKind::NonManifold,
            format!(
                "at {} edges more than two triangles meet, or two that face opposite ways; normals there may \
                 be wrong: repair the mesh",
                report.non_manifold_edges
            ),
        );
    }
    match report.mass_from {
        MassSource::Solid => {}
        MassSource::Capped => warn(
            WarningKind::Mass,
            "volume and centre of mass are those of the solid with its holes capped; give center_of_mass if \
             you know it"
                .to_owned(),
        ),
        MassSource::Surface => warn(
            WarningKind::Mass,
            "the surface encloses no solid, so the centre of mass is that of a thin shell; give \
             center_of_mass if you know it"
                .to_owned(),
        ),
    }
    if report.area_ratio > EVEN_RATIO {
        warn(
            WarningKind::UnevenTriangles,
            format!(
                "the areas of the triangles vary by a factor of {:.3} (95th over 5th percentile), more than \
                 {EVEN_RATIO}: their centroids cover the surface unevenly; search uniform candidates",
                report.area_ratio
            ),
        );
    }
    if report.degenerate_triangles > 0 {
        warn(
            WarningKind::Degenerate,
            format!(
                "{} of {} triangles were left out because they have no area",
                report.degenerate_triangles, report.triangles_read
            ),
        );
    }
    if report.duplicate_triangles > 0 {
        warn(
            WarningKind::Duplicates,
            format!(
                "{} triangles were dropped because the same ones are there already",
                report.duplicate_triangles
            ),
        );
    }
    found
}
