//! Given contacts, put on a mesh: by triangle, by projection, or where they are.

use std::sync::OnceLock;

use nalgebra::{Point3, Unit, Vector3};

use crate::wire::{ContactSpec, FieldError, Problem};
use graspd_core::contact::{Contact, Site};
use graspd_core::mesh::{Mesh, Projector};
use graspd_core::plan::{FARTHEST_CENTER, TORQUE_SCALES};
use graspd_core::wrench::WrenchModel;

/// Faults of contacts after which no more are reported.
pub(super) const MAX_FAULTS: usize = 20;

/// A contact with its position in the triangle it touches.
#[derive(Clone, Copy)]
pub(super) struct PlacedContact {
    pub site: Site,
    pub barycentric: Option<[f64; 3]>,
    /// Distance by which projection moved the point.
    pub distance: Option<f64>,
}

/// Puts contacts on one mesh.
pub(super) struct Placer<'m> {
    mesh: &'m Mesh,
    /// Built when the first point has to be projected.
    projector: OnceLock<Projector<'m>>,
    center: Point3<f64>,
    reach: f64,
}

impl<'m> Placer<'m> {
    pub(super) fn new(mesh: &'m Mesh, model: &WrenchModel) -> Self {
        // The bounds for the mesh's own settings hold here too: farther out a contact's torque hides its
        // force, or its force is lost in the rounding of torques.
        let reach = (FARTHEST_CENTER * mesh.radius_about(&model.center))
            .min(TORQUE_SCALES.end() / model.torque_scale);
        Self {
            mesh,
            projector: OnceLock::new(),
            center: model.center,
            reach,
        }
    }

    /// Puts a contact on the mesh.
    ///
    /// # Errors
    /// The member at fault and its fault.
    pub(super) fn place(
        &self,
        contact: &ContactSpec,
    ) -> Result<PlacedContact, (&'static str, String)> {
        match *contact {
            ContactSpec::Triangle(triangle) => {
                let candidate = self.mesh.candidate_of(triangle);
                let candidate = candidate.map_err(|fault| ("triangle", fault.to_string()))?;
                Ok(PlacedContact {
                    site: Site::from(&candidate),
                    barycentric: Some([1.0 / 3.0; 3]),
                    distance: None,
                })
            }
            ContactSpec::Projected(point) => {
                let projector = self.projector.get_or_init(|| Projector::new(self.mesh));
                let found = projector.project(&Point3::from(point)).ok_or_else(|| {
                    let detail = "is too far away from the mesh to be projected".to_owned();
                    ("point", detail)
                })?;
                Ok(PlacedContact {
                    site: Site {
                        contact: Contact {
                            position: found.position,
                            normal: found.normal,
                        },
                        triangle: Some(found.triangle),
                    },
                    barycentric: Some(found.barycentric),
                    distance: Some(found.distance),
                })
            }
            ContactSpec::Free { point, normal } => {
                let position = Point3::from(point);
                if (position - self.center).norm() > self.reach {
                    let detail = format!(
                        "is more than {FARTHEST_CENTER} times the size of the mesh away from the centre \
                         of mass, or so far that torque_scale makes its torques more than 1e6 times as \
                         large as forces; give it in the frame and unit of the mesh"
                    );
                    return Err(("point", detail));
                }
                Ok(PlacedContact {
                    site: Site {
                        contact: Contact {
                            position,
                            normal: Unit::new_normalize(Vector3::from(normal)),
                        },
                        triangle: None,
                    },
                    barycentric: None,
                    distance: None,
                })
            }
        }
    }
}

/// The problem that reports contacts which cannot be placed on the mesh.
pub(super) fn unplaceable(faults: Vec<FieldError>) -> Problem {
    Problem::new(
        422,
        "invalid-request",
        "Invalid request",
        "some contacts cannot be placed on this mesh; see errors",
    )
    .with_errors(faults)
}
