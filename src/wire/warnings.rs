//! What to know of a mesh before a grasp of it is trusted.

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use super::Units;
use graspd_core::mesh::{EVEN_RATIO, MassFrom, Report};

/// Lengths that a body to be grasped has, in metres: from a crumb to a car.
const PLAUSIBLE: [f64; 2] = [1e-3, 5.0];

/// Something about a mesh that may make a grasp of it worth less than it seems.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
pub struct MeshWarning {
    pub kind: WarningKind,
    /// What was found and what to do.
    pub detail: String,
}

/// What a warning is about.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum WarningKind {
    /// The surface has holes.
    Open,
    /// Three or more triangles meet at an edge, or the surface has one side only.
    NonManifold,
    /// The centre of mass is not that of a closed solid.
    Mass,
    /// Triangles differ much in size.
    UnevenTriangles,
    /// The same triangle came more than once.
    Duplicates,
    /// The body is very small or large for its unit.
    Size,
}

/// The warnings about a mesh in this unit.
pub(super) fn warnings(report: &Report, units: Option<Units>) -> Vec<MeshWarning> {
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
        MassFrom::Solid => {}
        MassFrom::Capped => warn(
            WarningKind::Mass,
            "volume and centre of mass are those of the solid with its holes capped; give center_of_mass if \
             you know it"
                .to_owned(),
        ),
        MassFrom::Surface => warn(
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
    if report.duplicate_triangles > 0 {
        warn(
            WarningKind::Duplicates,
            format!(
                "{} triangles were dropped because the same ones are there already",
                report.duplicate_triangles
            ),
        );
    }
    let [low, high] = report.bounds;
    let size = (high - low).amax();
    if let Some(units) = units
        && let Some(detail) = doubt(size, units)
    {
        warn(WarningKind::Size, detail);
    }
    found
}

/// What is odd about a body of this size.
fn doubt(size: f64, units: Units) -> Option<String> {
    let meters = size * units.meters();
    let [least, most] = PLAUSIBLE;
    if (least..=most).contains(&meters) {
        return None;
    }
    let fits = |other: &&Units| (10.0 * least..=most / 5.0).contains(&(size * other.meters()));
    let likely = [Units::Mm, Units::M, Units::Cm, Units::In]
        .iter()
        .find(fits)
        .copied();
    let advice = match likely {
        Some(other) => format!("is the unit {}? Or give the scale", other.name()),
        None => "check unit and scale".to_owned(),
    };
    let name = units.name();
    Some(format!(
        "the body measures {size:.4} {name}, {meters:.3e} m; {advice}"
    ))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes_that_nobody_grasps_are_doubted() {
        for (size, units) in [
            (59.0, Units::Mm),
            (0.2, Units::M),
            (3.0, Units::In),
            (1.0, Units::Ft),
        ] {
            assert_eq!(doubt(size, units), None, "{size}");
        }
        let doubts = [
            (59.0, Units::M, "is the unit mm?"),
            (0.2, Units::Mm, "is the unit m?"),
            (1e9, Units::M, "check unit"),
            (1e-9, Units::M, "check unit"),
        ];
        for (size, units, words) in doubts {
            let said = doubt(size, units).unwrap();
            assert!(said.contains(words), "{said}");
        }
    }
}
