//! A grasp of two contacts as the pose of a gripper with two parallel jaws.
//!
//! Two contacts fix where the jaws touch and leave the rotation about the line between them free: the
//! direction in which the hand approaches. It is chosen here by a fixed rule, which every file states:
//!
//! 1. towards the centre of mass, where that is clearly beside the line;
//! 2. else from above (−z of the mesh);
//! 3. else, with upright jaws, along +y.
//!
//! The pose follows in closed form. `docs/exports.md` has the mapping in full.

use nalgebra::{Matrix3, Point3, Rotation3, Unit, UnitQuaternion, Vector3};

use crate::picture::marks::perpendicular;
use crate::wire::{ChosenGrasp, PlanResult, Units};

/// The centre of mass decides the approach if its distance from the line of the jaws is more than this
/// share of the opening.
const NEAR: f64 = 0.05;
/// The opening of the jaws before the grasp, relative to the distance of the contacts.
pub(super) const CLEARANCE: f64 = 1.25;
/// The assumptions, a line each; written into every file.
pub(super) const ASSUMPTIONS: [&str; 8] = [
    "A grasp of two contacts as the pose of a gripper with two parallel jaws. Frame mesh is that of the uploaded file, \
     in metres.",
    "Frame gripper: origin midway between the contacts, x from contact 1 to contact 2, along which the jaws close, \
     z the way that the hand comes.",
    "It is no link of your hand: put the pose of its wrist or base in such a frame behind this one.",
    "The contacts leave the turn about x free. z is chosen towards the centre of mass; where that is between the jaws, \
     along -z of the mesh; with upright jaws along +y.",
    "Whether hand and arm clear the body is not looked at.",
    "Joint opening is the distance of the jaws, a quarter wider before the grasp: rename it and convert its values.",
    "The quality is epsilon of the grasp, no probability; 0 without force closure.",
    "The mapping in full is in docs/exports.md of graspd.",
];

/// Why a grasp has no pose of such a gripper.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum PoseError {
    #[error(
        "the grasp has {0} contacts, and a gripper with two parallel jaws has two; plan with contacts=2 and \
         contact_model=soft"
    )]
    Contacts(usize),
    #[error(
        "the normals of the two contacts are not opposed: jaws that close along the line between them would slip, \
         since friction holds up to {allowed:.1} degrees and contact {contact} is {angle:.1} degrees off"
    )]
    NotOpposed {
        contact: usize,
        angle: f64,
        allowed: f64,
    },
    #[error("the two contacts are in one place, so no jaws can close along the line between them")]
    Coincident,
    #[error(
        "the unit of the mesh is not known, and these formats are in metres; say it with ?units="
    )]
    NoUnit,
}

/// The pose of the gripper and its opening, in metres and the mesh's frame.
///
/// The origin is midway between the contacts. x points from contact 1 to contact 2, the line along which the jaws
/// close; z is the approach, perpendicular to x; y = z × x.
#[derive(Debug, Clone, PartialEq)]
pub struct GripperPose {
    pub position: Point3<f64>,
    pub orientation: UnitQuaternion<f64>,
    /// The distance of the contacts.
    pub opening: f64,
    /// ε of the grasp; 0 without force closure.
    pub quality: f64,
}

impl GripperPose {
    /// Returns the pose of a grasp. `units` is the unit of the mesh where the result does not say.
    ///
    /// # Errors
    /// See [`PoseError`].
    pub fn of(
        result: &PlanResult,
        grasp: &ChosenGrasp<'_>,
        units: Option<Units>,
    ) -> Result<Self, PoseError> {
        let [first, second] = grasp.contacts else {
            return Err(PoseError::Contacts(grasp.contacts.len()));
        };
        let ends = [first, second].map(|contact| Point3::from(contact.position));
        let between = ends[1] - ends[0];
        let x = Unit::try_new(between, 0.0).ok_or(PoseError::Coincident)?;
        let allowed = result.friction.unwrap_or_default().atan();
        for (number, contact, towards) in [(1, first, x), (2, second, -x)] {
            let angle = towards.angle(&Vector3::from(contact.normal));
            // Contacts on the edge of the cone may be given by rounded numbers.
            if angle > allowed + 1e-9 {
                return Err(PoseError::NotOpposed {
                    contact: number,
                    angle: angle.to_degrees(),
                    allowed: allowed.to_degrees(),
                });
            }
        }
        let meters = result.units.or(units).ok_or(PoseError::NoUnit)?.meters();
        let middle = nalgebra::center(&ends[0], &ends[1]);
        let z = approach(
            &x,
            &(Point3::from(result.center_of_mass) - middle),
            between.norm(),
        );
        let axes = Matrix3::from_columns(&[x.into_inner(), z.cross(&x), z.into_inner()]);
        let turn = Rotation3::from_matrix_unchecked(axes);
        Ok(Self {
            position: middle * meters,
            orientation: UnitQuaternion::from_rotation_matrix(&turn),
            opening: between.norm() * meters,
            quality: grasp.quality.unwrap_or_default(),
        })
    }
}

/// Returns the approach by the rule at the head of this file.
fn approach(x: &Unit<Vector3<f64>>, to_center: &Vector3<f64>, opening: f64) -> Unit<Vector3<f64>> {
    let across = |direction: Vector3<f64>| direction - x.into_inner() * x.dot(&direction);
    Unit::try_new(across(*to_center), NEAR * opening)
        .or_else(|| Unit::try_new(across(-Vector3::z()), NEAR))
        .or_else(|| Unit::try_new(across(Vector3::y()), NEAR))
        .unwrap_or_else(|| perpendicular(x))
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::super::samples::{best, contact, pose_of_jaws, result};
    use super::*;

    /// Returns the contacts that follow from a pose.
    fn contacts_of(gripper: &GripperPose) -> [Point3<f64>; 2] {
        let half = gripper.orientation * Vector3::x() * (gripper.opening / 2.0);
        [gripper.position - half, gripper.position + half]
    }

    fn approach_of(gripper: &GripperPose) -> Vector3<f64> {
        gripper.orientation * Vector3::z()
    }

    proptest! {
        #[test]
        fn a_pose_gives_the_contacts_back(
            a in prop::array::uniform3(-50.0..50.0),
            b in prop::array::uniform3(-50.0..50.0),
            center in prop::array::uniform3(-50.0..50.0),
        ) {
            let [from, to] = [a, b].map(Point3::from);
            prop_assume!((to - from).norm() > 1e-3);
            let gripper = pose_of_jaws([a, b], center, Some(Units::Cm));
            for (found, wanted) in contacts_of(&gripper).iter().zip([from, to]) {
                prop_assert!((found * 100.0 - wanted).norm() < 1e-9);
            }
            // Across the jaws, and not away from the centre of mass where that counts.
            let z = approach_of(&gripper);
            prop_assert!(z.dot(&(to - from)).abs() < 1e-9 * (to - from).norm());
            let there = Point3::from(center) - nalgebra::center(&from, &to);
            let beside = there.cross(&(to - from).normalize()).norm();
            if beside > 2.0 * NEAR * (to - from).norm() {
                prop_assert!((z.dot(&there) / beside - 1.0).abs() < 1e-9);
            }
        }
    }

    #[test]
    fn the_hand_comes_from_where_it_is_said() {
        let level = [[-1.0, 0.0, 0.0], [1.0, 0.0, 0.0]];
        let upright = [[0.0, 0.0, -1.0], [0.0, 0.0, 1.0]];
        let [down, front] = [-Vector3::z(), Vector3::y()];
        for (ends, center, wanted) in [
            (level, [0.0; 3], down),
            (level, [0.7, 0.0, 0.0], down),
            // Nearly between the jaws, then clearly not.
            (level, [0.0, 0.09, 0.0], down),
            (level, [0.0, 0.11, 0.0], front),
            (level, [0.5, -3.0, 0.0], -front),
            (upright, [0.0; 3], front),
            (upright, [0.0, 0.0, 5.0], front),
            (upright, [3.0, 0.0, 0.0], Vector3::x()),
        ] {
            let z = approach_of(&pose_of_jaws(ends, center, Some(Units::M)));
            assert!((z - wanted).norm() < 1e-12, "{ends:?} {center:?}: {z}");
        }
        let leaning = [[0.0, 0.0, -1.0], [1.0, 0.0, 1.0]];
        let z = approach_of(&pose_of_jaws(leaning, [0.5, 0.0, 0.0], Some(Units::M)));
        assert!(z.z < -0.4 && z.x > 0.8 && z.y.abs() < 1e-12, "{z}");
    }

    #[test]
    fn jaws_hold_what_friction_holds_and_nothing_beyond() {
        // Friction 0.5 holds 26.565 degrees.
        let tilted = |degrees: f64| {
            let (sine, cosine) = degrees.to_radians().sin_cos();
            (cosine, sine)
        };
        for (first, second, refused) in [
            (0.0, 0.0, None),
            (26.56, -26.56, None),
            (0.5_f64.atan().to_degrees(), 0.0, None),
            (26.57, 0.0, Some((1, 26.57))),
            (0.0, 26.57, Some((2, 26.57))),
            (90.0, 0.0, Some((1, 90.0))),
            (180.0, 180.0, Some((1, 180.0))),
        ] {
            let [a, b] = [first, second].map(tilted);
            let contacts = vec![
                contact([-1.0, 0.0, 0.0], [a.0, a.1, 0.0]),
                contact([1.0, 0.0, 0.0], [-b.0, 0.0, b.1]),
            ];
            let result = result(contacts);
            let found = GripperPose::of(&result, &best(&result), Some(Units::M));
            match (found, refused) {
                (Ok(_), None) => {}
                (
                    Err(PoseError::NotOpposed {
                        contact,
                        angle,
                        allowed,
                    }),
                    Some((which, wanted)),
                ) => {
                    assert!(contact == which && (angle - wanted).abs() < 1e-9);
                    assert!((allowed - 26.565).abs() < 1e-3);
                }
                (found, _) => panic!("{first} {second}: {found:?}"),
            }
        }
        // Without friction only what is straight.
        let frictionless = |slope: f64| {
            let normals = [[1.0, slope, 0.0], [-1.0, 0.0, 0.0]];
            let ends = [[-1.0, 0.0, 0.0], [1.0, 0.0, 0.0]];
            let mut result = result(vec![
                contact(ends[0], normals[0]),
                contact(ends[1], normals[1]),
            ]);
            result.friction = None;
            GripperPose::of(&result, &best(&result), Some(Units::M))
        };
        assert!(frictionless(0.0).is_ok() && frictionless(1e-3).is_err());
    }

    #[test]
    fn what_is_no_pose_says_why() {
        let ends = [[-1.0, 0.0, 0.0], [1.0, 0.0, 0.0]].map(|end| contact(end, end.map(|x| -x)));
        let of = |contacts: Vec<_>, units| {
            let result = result(contacts);
            GripperPose::of(&result, &best(&result), units)
        };
        let [a, b] = ends.clone();
        for count in [1, 3, 4] {
            let contacts = ends.iter().cycle().take(count).cloned().collect();
            let refused = of(contacts, Some(Units::M));
            assert_eq!(refused.unwrap_err(), PoseError::Contacts(count));
        }
        let one_place = vec![a.clone(), contact(a.position, [-1.0, 0.0, 0.0])];
        let refused = of(one_place, Some(Units::M)).unwrap_err();
        assert_eq!(refused, PoseError::Coincident);
        let refused = of(vec![a, b], None).unwrap_err();
        assert_eq!(refused, PoseError::NoUnit);
        assert!(refused.to_string().contains("?units="));
    }

    #[test]
    fn the_unit_of_the_result_counts_and_else_the_one_given() {
        let ends = [[0.0, 0.0, 2.0], [8.0, 0.0, 2.0]];
        for units in Units::ALL {
            let gripper = pose_of_jaws(ends, [4.0, 0.0, 2.0], Some(units));
            let meters = units.meters();
            assert!((gripper.opening / (8.0 * meters) - 1.0).abs() < 1e-12);
            let middle = Point3::new(4.0, 0.0, 2.0) * meters;
            assert!((gripper.position - middle).norm() < 1e-12 * meters);
        }
        let mut known = result(
            ends.map(|end| contact(end, [4.0 - end[0], 0.0, 0.0]))
                .into(),
        );
        known.units = Some(Units::Mm);
        let gripper = GripperPose::of(&known, &best(&known), None).unwrap();
        assert!((gripper.opening - 0.008).abs() < 1e-15);
    }
}
