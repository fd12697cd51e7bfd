//! Constraints of a request, put on one mesh.

use nalgebra::{Point3, UnitVector3, Vector3};

use super::place::{MAX_FAULTS, PlacedContact, Placer, unplaceable};
use crate::wire::{self, Corners, FieldError, HalfSpace, Problem, Sphere};
use graspd_core::constraints::{Approach, Constraints, Region, Spacing};
use graspd_core::mesh::Mesh;
use graspd_core::wrench::WrenchModel;

/// Takes every member into account; also gives where the fixed contacts come from, in their order.
///
/// Fails when a region names a triangle that the mesh does not have, or a fixed contact cannot be placed.
pub(super) fn constraints(
    mesh: &Mesh,
    model: &WrenchModel,
    wanted: &wire::Constraints,
) -> Result<(Constraints, Vec<PlacedContact>), Problem> {
    let wire::Constraints {
        include,
        exclude,
        min_contact_distance,
        max_contact_distance,
        approach_directions,
        max_normal_angle,
        fixed_contacts,
    } = wanted;
    let mut faults = Vec::new();
    let placer = Placer::new(mesh, model);
    let mut places = Vec::with_capacity(fixed_contacts.len());
    for (i, contact) in fixed_contacts.iter().enumerate() {
        match placer.place(contact) {
            Ok(place) => places.push(place),
            Err((member, detail)) => faults.push(FieldError {
                pointer: format!("/constraints/fixed_contacts/{i}/{member}"),
                detail,
            }),
        }
    }
    let constraints = Constraints {
        include: regions(mesh, "include", include, &mut faults),
        exclude: regions(mesh, "exclude", exclude, &mut faults),
        approach: max_normal_angle.map(|angle| Approach {
            directions: approach_directions.iter().map(unit).collect(),
            max_angle: angle.to_radians(),
        }),
        spacing: Spacing {
            min: *min_contact_distance,
            max: *max_contact_distance,
        },
        fixed: places.iter().map(|place| place.site.contact).collect(),
    };
    if faults.is_empty() {
        return Ok((constraints, places));
    }
    faults.truncate(MAX_FAULTS);
    Err(unplaceable(faults))
}

fn regions(
    mesh: &Mesh,
    name: &'static str,
    regions: &[wire::Region],
    faults: &mut Vec<FieldError>,
) -> Vec<Region> {
    let triangles = mesh.report().triangles_read;
    let numbered = regions.iter().enumerate();
    numbered
        .map(|(i, region)| match region {
            wire::Region::Box(Corners { min, max }) => Region::Box {
                min: Point3::from(*min),
                max: Point3::from(*max),
            },
            wire::Region::HalfSpace(HalfSpace { point, normal }) => Region::HalfSpace {
                point: Point3::from(*point),
                normal: unit(normal),
            },
            wire::Region::Sphere(Sphere { center, radius }) => Region::Sphere {
                center: Point3::from(*center),
                radius: *radius,
            },
            wire::Region::Triangles(indices) => {
                let unknown = indices
                    .iter()
                    .position(|&index| index as usize >= triangles);
                faults.extend(unknown.map(|j| FieldError {
                    pointer: format!("/constraints/{name}/{i}/triangles/{j}"),
                    detail: format!(
                        "the mesh has no triangle {}; its triangles are 0 to {}",
                        indices[j],
                        triangles.saturating_sub(1)
                    ),
                }));
                Region::Triangles(indices.iter().copied().collect())
            }
        })
        .collect()
}

/// A direction of a request is never zero.
fn unit(direction: &[f64; 3]) -> UnitVector3<f64> {
    UnitVector3::new_normalize(Vector3::from(*direction))
}
