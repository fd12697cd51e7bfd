//! Motions of the body that the contacts leave free.

use nalgebra::{Point3, UnitVector3, Vector3};

use super::contact::Contact;
use super::wrench::{Wrench, WrenchModel};

/// A rotation that moves no contact farther than this share of the translation counts as none, and an advance
/// per radian of less than this share of the body's size makes no screw. Coordinates stored in single
/// precision, and normals computed from them, turn a direction by up to 10⁻⁶.
pub const MOTION_TOLERANCE: f64 = 1e-6;

/// A motion of the body that no contact hinders, in the mesh's frame, at unspecified speed.
///
/// If the fingers stay where they are, the motion separates the body from them or slides it along them; no
/// force that they can exert has negative power along it.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "schema", derive(utoipa::ToSchema))]
#[cfg_attr(feature = "schema", schema(as = FreeMotion))]
pub struct Motion {
    pub kind: MotionKind,
    /// Unit direction of a translation, or the axis of a right-handed rotation or screw.
    #[cfg_attr(feature = "schema", schema(value_type = [f64; 3]))]
    pub axis: UnitVector3<f64>,
    /// The point of the axis that is nearest to the centre of mass; absent for a translation.
    #[cfg_attr(feature = "serde", serde(skip_serializing_if = "Option::is_none"))]
    #[cfg_attr(feature = "schema", schema(value_type = Option<[f64; 3]>))]
    pub point: Option<Point3<f64>>,
    /// Advance of a screw, in the mesh's unit per radian; negative for a left-handed screw.
    #[cfg_attr(feature = "serde", serde(skip_serializing_if = "Option::is_none"))]
    pub pitch: Option<f64>,
}

/// The kind of a motion.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "schema", derive(utoipa::ToSchema))]
#[cfg_attr(feature = "serde", serde(rename_all = "snake_case"))]
pub enum MotionKind {
    Translation,
    Rotation,
    Screw,
}

impl Motion {
    /// Returns a motion that no contact hinders, given a unit `direction` = (a; b) of the wrench space along
    /// which the grasp can exert nothing.
    ///
    /// The centre of mass moves at −a and the body turns at −λ·b, so the power of any contact wrench w along
    /// the motion is −direction·w ≥ 0. If the grasp leaves several motions free, this is one of them. `None`
    /// for a zero direction.
    pub fn unhindered(
        model: &WrenchModel,
        contacts: &[Contact],
        direction: &Wrench,
    ) -> Option<Self> {
        let reach = contacts
            .iter()
            .map(|contact| (contact.position - model.center).norm())
            .fold(0.0, f64::max);
        // Contacts that are all at the centre of mass turn in place: any length will do for them.
        let reach = if reach > 0.0 {
            reach
        } else {
            model.torque_scale.recip()
        };
        let velocity: Vector3<f64> = -direction.fixed_rows::<3>(0);
        let spin: Vector3<f64> = -direction.fixed_rows::<3>(3) * model.torque_scale;
        let (travel, turn) = (velocity.norm(), spin.norm() * reach);
        if turn <= MOTION_TOLERANCE * travel {
            return Some(Self {
                kind: MotionKind::Translation,
                axis: UnitVector3::try_new(velocity, 0.0)?,
                point: None,
                pitch: None,
            });
        }
        let axis = UnitVector3::try_new(spin, 0.0)?;
        let point = model.center + axis.cross(&velocity) / spin.norm();
        let advance = velocity.dot(&axis);
        let is_rotation = advance.abs() <= MOTION_TOLERANCE * travel.max(turn);
        Some(Self {
            kind: match is_rotation {
                true => MotionKind::Rotation,
                false => MotionKind::Screw,
            },
            axis,
            point: Some(point),
            pitch: (!is_rotation).then(|| advance / spin.norm()),
        })
    }

    /// Returns the velocity of a point of the body, at unit speed or unit angular velocity.
    pub fn velocity_at(&self, place: &Point3<f64>) -> Vector3<f64> {
        let Some(point) = self.point else {
            return self.axis.into_inner();
        };
        self.axis.cross(&(place - point)) + self.axis.into_inner() * self.pitch.unwrap_or(0.0)
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::Unit;

    use super::*;
    use crate::contact::ContactModel;
    use crate::wrench::{EdgeNorm, WrenchSpace};

    fn model(torque_scale: f64) -> WrenchModel {
        WrenchModel {
            contact_model: ContactModel::Frictionless,
            edge_norm: EdgeNorm::UnitEdge,
            space: WrenchSpace::L1,
            center: Point3::new(0.3, -0.2, 0.5),
            torque_scale,
        }
    }

    fn contact() -> Contact {
        Contact {
            position: Point3::new(1.0, 2.0, 3.0),
            normal: Unit::new_normalize(Vector3::new(0.2, 0.9, -0.4)),
        }
    }

    /// The wrench direction along which exactly the motion's opposite has power.
    fn dual(model: &WrenchModel, velocity: Vector3<f64>, spin: Vector3<f64>) -> Wrench {
        let b = spin / model.torque_scale;
        -Wrench::new(velocity.x, velocity.y, velocity.z, b.x, b.y, b.z).normalize()
    }

    #[test]
    fn power_of_a_contact_is_the_same_in_wrenches_and_in_velocities() {
        for torque_scale in [1e-3, 1.0, 1e3] {
            let model = model(torque_scale);
            let spin = Vector3::new(0.4, 0.1, -0.8);
            for velocity in [Vector3::new(0.3, -1.0, 0.2), spin.cross(&Vector3::x())] {
                let direction = dual(&model, velocity, spin);
                let motion = Motion::unhindered(&model, &[contact()], &direction).unwrap();
                let contact = contact();
                let force = Vector3::new(0.7, -0.3, 0.1);
                let power = force.dot(&motion.velocity_at(&contact.position)) * spin.norm();
                let at_contact = velocity + spin.cross(&(contact.position - model.center));
                assert!((power - force.dot(&at_contact)).abs() < 1e-12);
                let wrench = model.wrench(&contact.position, &force);
                let scaled = -direction.dot(&wrench) * dual_length(&model, &velocity, &spin);
                assert!((power - scaled).abs() < 1e-12);
            }
        }
    }

    fn dual_length(model: &WrenchModel, velocity: &Vector3<f64>, spin: &Vector3<f64>) -> f64 {
        velocity.norm().hypot(spin.norm() / model.torque_scale)
    }

    #[test]
    fn the_kind_does_not_depend_on_the_torque_scale() {
        let spin = Vector3::new(0.0, 0.0, 2.0);
        let line = Point3::new(1.0, 1.0, 0.0);
        for torque_scale in [1e-4, 1e-2, 1.0, 1e2, 1e4] {
            let model = model(torque_scale);
            let about_line = spin.cross(&(model.center - line));
            let of = |velocity, spin| {
                Motion::unhindered(&model, &[contact()], &dual(&model, velocity, spin)).unwrap()
            };
            let Motion {
                kind: MotionKind::Rotation,
                axis,
                point: Some(point),
                ..
            } = of(about_line, spin)
            else {
                panic!("no rotation");
            };
            assert!((axis.into_inner() - Vector3::z()).norm() < 1e-12);
            assert!((point.coords.xy() - line.coords.xy()).norm() < 1e-9);
            assert!((point.z - model.center.z).abs() < 1e-9);
            let advance = Vector3::new(0.0, 0.0, -0.5);
            let Motion {
                kind: MotionKind::Screw,
                pitch: Some(pitch),
                ..
            } = of(about_line + advance, spin)
            else {
                panic!("no screw");
            };
            assert!((pitch + 0.25).abs() < 1e-9);
            let slide = of(advance, Vector3::zeros());
            assert_eq!(slide.kind, MotionKind::Translation);
            assert_eq!(slide.axis.into_inner(), -Vector3::z());
        }
    }
}
