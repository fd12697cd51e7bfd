//! Constraints of a request, put on one mesh.

use nalgebra::{Point3, UnitVector3, Vector3};

use super::place::{MAX_FAULTS, PlacedContact, Placer, unplaceable};
use super::settings::out_of_range;
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
        include: regions(mesh, "include", include, &mut faults)?,
        exclude: regions(mesh, "exclude", exclude, &mut faults)?,
        approach: match max_normal_angle {
            Some(angle) => Some(Approach {
                directions: approach_directions
                    .iter()
                    .map(|direction| unit(direction, "approach_directions"))
                    .collect::<Result<_, _>>()?,
                max_angle: angle.to_radians(),
            }),
            None => None,
        },
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
) -> Result<Vec<Region>, Problem> {
    let triangles = mesh.report().triangles_read;
    let numbered = regions.iter().enumerate();
    numbered
        .map(|(i, region)| match region {
            wire::Region::Box(Corners { min, max }) => Ok(Region::Box {
                min: Point3::from(*min),
                max: Point3::from(*max),
            }),
            wire::Region::HalfSpace(HalfSpace { point, normal }) => Ok(Region::HalfSpace {
                point: Point3::from(*point),
                normal: unit(normal, name)?,
            }),
            wire::Region::Sphere(Sphere { center, radius }) => Ok(Region::Sphere {
                center: Point3::from(*center),
                radius: *radius,
            }),
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
                Ok(Region::Triangles(indices.iter().copied().collect()))
            }
        })
        .collect()
}

fn unit(vector: &[f64; 3], member: &str) -> Result<UnitVector3<f64>, Problem> {
    UnitVector3::try_new(Vector3::from(*vector), 0.0)
        .ok_or_else(|| out_of_range(&format!("constraints/{member}")))
}
