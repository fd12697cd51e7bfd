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
                "the surface is open along {} edges, {}; repair it, or leave it if the holes are where no finger \
                 goes",
                report.border_edges,
                counted(report.holes, "hole", "holes")
            ),
        );
    }
    if report.unresolved_edges > 0 {
        warn(
            WarningKind::NonManifold,
            format!(
                "at {} edges more than two triangles meet, or two that face opposite ways; normals there may \
                 be wrong: repair the mesh",
                report.unresolved_edges
            ),
        );
    }
    match report.mass_from {
        MassSource::Solid | MassSource::Union => {}
        MassSource::Capped if report.holes == 0 => {}
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
    if report.unexamined {
        warn(
            WarningKind::Overlap,
            format!(
                "the mesh has {} pieces that are too close together to look for those that overlap; where some do, \
                 fingers may be planned on what is buried, and what they share weighs double: unite the solids \
                 before export",
                report.components
            ),
        );
    }
    if report.overlapping_parts > 0 {
        let precision = report.volume_bound.map_or_else(String::new, |bound| {
            format!(", the volume to {bound:.1e} of itself")
        });
        warn(
            WarningKind::Overlap,
            format!(
                "{} solids overlap and are taken as one body: {} with their centres in matter are no candidates, and \
                 the mass is that of the union{precision}",
                report.overlapping_parts,
                counted(report.buried_triangles, "triangle", "triangles")
            ),
        );
    } else if report.buried_triangles > 0 {
        warn(
            WarningKind::Overlap,
            format!(
                "solids touch: {} of the walls between them are no candidates; set enclosed if fingers can get there",
                counted(report.buried_triangles, "triangle", "triangles")
            ),
        );
    }
    if report.enclosed_triangles > 0 {
        warn(
            WarningKind::Enclosed,
            format!(
                "{} in sealed cavities are no candidates, since no finger gets there; set enclosed if one can",
                counted(report.enclosed_triangles, "triangle", "triangles")
            ),
        );
    }
    if !report.bodies.is_empty() {
        warn(
            WarningKind::SeveralBodies,
            format!(
                "the mesh has {} bodies that do not touch; choose one with component, or all of them as one rigid \
                 body with component all",
                report.body_count
            ),
        );
    }
    if report.unverified_normals > 0 {
        warn(
            WarningKind::UnverifiedNormals,
            format!(
                "{} belong to open faces for which nothing confirms which side is outside; where a normal is wrong, a \
                 finger would have to pull: close the surface, or check the normals of the contacts",
                counted(report.unverified_normals, "triangle", "triangles")
            ),
        );
    }
    if report.area_ratio > EVEN_RATIO {
        warn(
            WarningKind::UnevenTriangles,
            "the triangles differ much in size; unless candidates says otherwise, memetic searches places that are \
             spread evenly over the surface instead of their centroids"
                .to_owned(),
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

fn counted(count: usize, one: &str, many: &str) -> String {
    format!("{count} {}", if count == 1 { one } else { many })
}
