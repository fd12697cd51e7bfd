//! The report of a mesh together with its unit.

use crate::wire::Units;
use graspd_core::mesh::{Mesh, MeshReport, MeshWarning, WarningKind};

/// Sizes, in metres, of bodies that anybody would grasp: from a crumb to a car.
const PLAUSIBLE: [f64; 2] = [1e-3, 5.0];

/// The report of a mesh with a warning when the body is very small or large for its unit.
pub fn mesh_report(mesh: &Mesh, units: Option<Units>) -> MeshReport {
    let mut report = mesh.report().clone();
    let [low, high] = report.bounds;
    let size = (high - low).amax();
    let doubt = units.and_then(|units| doubt(size, units));
    report.warnings.extend(doubt.map(|detail| MeshWarning {
        kind: WarningKind::Size,
        detail,
    }));
    report
}

/// Says why a body of this size is implausible; `None` when it is plausible.
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
