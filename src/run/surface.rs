//! The mesh that a request is about: all of a mesh, or one of its bodies, with or without what nothing reaches.

use std::borrow::Cow;

use crate::wire::{Component, FieldError, Problem, SurfaceSettings};
use graspd_core::mesh::{self, Mesh, MeshReport, MeshWarning, WarningKind};

/// The part of `mesh` that the settings choose.
///
/// # Errors
/// When the component does not exist, or when there are several bodies and none is chosen.
pub(super) fn chosen<'m>(
    mesh: &'m Mesh,
    settings: &SurfaceSettings,
) -> Result<Cow<'m, Mesh>, Problem> {
    let which = match &settings.component {
        None => {
            refuse_several(mesh.report().body_count as u64)?;
            None
        }
        Some(Component::Name(name)) if name == Component::ALL => None,
        Some(Component::Name(name)) => Some(mesh::Component::Name(name)),
        Some(Component::Number(number)) => Some(mesh::Component::Number(*number as usize)),
    };
    let chosen = match which {
        None => Cow::Borrowed(mesh),
        Some(which) => Cow::Owned(
            mesh.component(which)
                .map_err(|fault| unfit(fault.to_string()))?,
        ),
    };
    Ok(match settings.enclosed {
        Some(true) => Cow::Owned(chosen.with_enclosed()),
        _ => chosen,
    })
}

/// Refuses to treat so many bodies as one without being asked to.
///
/// # Errors
/// When there are several.
pub fn refuse_several(bodies: u64) -> Result<(), Problem> {
    match bodies {
        0 | 1 => Ok(()),
        _ => Err(unfit(format!(
            "the mesh has {bodies} bodies that do not touch, and a grasp holds one; give the number of one, from 0 to \
             {}, or the name of a part of the file, or \"all\" to take them as one rigid body",
            bodies - 1
        ))),
    }
}

fn unfit(detail: String) -> Problem {
    Problem::new(
        422,
        "unfit-settings",
        "Settings that do not fit the mesh",
        detail.as_str(),
    )
    .with_errors(vec![FieldError {
        pointer: "/component".to_owned(),
        detail,
    }])
}

/// The warnings of a mesh without which no grasp of it should be believed.
pub(super) fn doubts(report: &MeshReport) -> Vec<MeshWarning> {
    let matters = |warning: &&MeshWarning| {
        matches!(
            warning.kind,
            WarningKind::UnverifiedNormals | WarningKind::NonManifold
        ) || warning.kind == WarningKind::Overlap && report.unexamined
    };
    report.warnings.iter().filter(matters).cloned().collect()
}
