//! A grasp of two contacts as the pose of a gripper with two parallel jaws.
//!
//! Contacts say where the jaws touch, and not which way the hand comes from: that is chosen here, always in the
//! same manner, and said in what is written. `docs/exports.md` has the mapping in full.

use nalgebra::{Matrix3, Point3, Rotation3, Unit, UnitQuaternion, Vector3};
use serde_json::{Value, json};

use super::solids::perpendicular;
use crate::wire::{ChosenGrasp, PlanResult, Units};

/// Share of the opening below which the centre of mass does not tell where the hand should come from.
const NEAR: f64 = 0.05;
/// How far the jaws open before they close, over the distance of the contacts.
const CLEARANCE: f64 = 1.25;
/// How far the hand comes and goes, over the distance of the contacts.
const WAY: f64 = 1.0;

/// Why contacts are no pose of such a gripper.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum NoGripper {
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
    #[error(
        "the unit of the mesh is not known, and these formats are in metres; say it with ?units="
    )]
    NoUnit,
}

/// Where the hand is and how far it opens, in metres and the mesh's frame.
///
/// The origin is midway between the contacts. x points from contact 1 to contact 2, along which the jaws close;
/// z is the way that the hand comes, towards the centre of mass and across x; y = z × x.
#[derive(Debug, Clone, PartialEq)]
pub struct Gripper {
    pub position: Point3<f64>,
    pub orientation: UnitQuaternion<f64>,
    /// Distance of the contacts.
    pub opening: f64,
    quality: f64,
}

impl Gripper {
    /// The pose that a grasp gives, with `units` where the result does not say.
    ///
    /// # Errors
    /// See [`NoGripper`].
    pub fn of(
        result: &PlanResult,
        grasp: &ChosenGrasp<'_>,
        units: Option<Units>,
    ) -> Result<Self, NoGripper> {
        let [first, second] = grasp.contacts else {
            return Err(NoGripper::Contacts(grasp.contacts.len()));
        };
        let ends = [first, second].map(|contact| Point3::from(contact.position));
        let between = ends[1] - ends[0];
        let x = Unit::new_normalize(between);
        let allowed = result.friction.unwrap_or_default().atan();
        for (number, contact, towards) in [(1, first, x), (2, second, -x)] {
            let angle = towards.angle(&Vector3::from(contact.normal));
            // The edges of a cone may be given by rounded numbers.
            if angle > allowed + 1e-9 || !angle.is_finite() {
                return Err(NoGripper::NotOpposed {
                    contact: number,
                    angle: angle.to_degrees(),
                    allowed: allowed.to_degrees(),
                });
            }
        }
        let meters = result.units.or(units).ok_or(NoGripper::NoUnit)?.meters();
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

    /// As `isaac_grasp` 1.0, the YAML of Isaac Sim's grasp editor.
    pub fn isaac(&self) -> String {
        let [x, y, z] = self.position.coords.into();
        let turn = self.orientation.quaternion();
        format!(
            "# A grasp of two contacts as the pose of a gripper with two parallel jaws, in the frame of the mesh and\n\
             # metres. Gripper frame: origin midway between the jaws, x along which they close, z the way that the\n\
             # hand comes. The contacts leave the turn about x free; z points towards the centre of mass.\n\
             # `opening` is the distance of the jaws: rename it to the joint of your gripper and convert its value.\n\
             # Confidence is the quality epsilon, 0 without force closure.\n\
             format: isaac_grasp\n\
             format_version: \"1.0\"\n\
             object_frame_link: mesh\n\
             gripper_frame_link: gripper\n\
             grasps:\n  \
               grasp_0:\n    \
                 confidence: {:?}\n    \
                 position: [{x:?}, {y:?}, {z:?}]\n    \
                 orientation: {{w: {:?}, xyz: [{:?}, {:?}, {:?}]}}\n    \
                 cspace_position:\n      opening: {:?}\n    \
                 pregrasp_cspace_position:\n      opening: {:?}\n",
            self.quality,
            turn.w,
            turn.i,
            turn.j,
            turn.k,
            self.opening,
            self.opening * CLEARANCE,
        )
    }

    /// As the message `moveit_msgs/Grasp` in JSON, with what its fields are taken to mean in `_comment`.
    pub fn moveit(&self) -> Value {
        let header = || json!({"stamp": {"sec": 0, "nanosec": 0}, "frame_id": "mesh"});
        let [x, y, z] = self.position.coords.into();
        let turn = self.orientation.quaternion();
        let posture = |opening: f64| {
            json!({
                "header": header(), "joint_names": ["opening"],
                "points": [{"positions": [opening], "velocities": [], "accelerations": [], "effort": [],
                    "time_from_start": {"sec": 0, "nanosec": 0}}],
            })
        };
        let way = |direction: Vector3<f64>| {
            let [x, y, z] = direction.into();
            json!({
                "direction": {"header": header(), "vector": {"x": x, "y": y, "z": z}},
                "desired_distance": WAY * self.opening, "min_distance": 0.5 * WAY * self.opening,
            })
        };
        let along = self.orientation * Vector3::z();
        json!({
            "_comment": "Frame mesh: that of the uploaded file, in metres. Gripper frame: origin midway between the \
                two contacts, x from contact 1 to contact 2, along which the jaws close, z the way that the hand \
                comes. The contacts leave the turn about x free; z points towards the centre of mass. Joint \
                `opening` is the distance of the jaws: rename it and convert its values for your gripper.",
            "id": "grasp_0",
            "pre_grasp_posture": posture(self.opening * CLEARANCE),
            "grasp_posture": posture(self.opening),
            "grasp_pose": {
                "header": header(),
                "pose": {
                    "position": {"x": x, "y": y, "z": z},
                    "orientation": {"x": turn.i, "y": turn.j, "z": turn.k, "w": turn.w},
                },
            },
            "grasp_quality": self.quality,
            "pre_grasp_approach": way(along),
            "post_grasp_retreat": way(-along),
            "post_place_retreat": way(-along),
            "max_contact_force": 0.0,
            "allowed_touch_objects": [],
        })
    }
}

/// The way that the hand comes: towards the centre of mass where that is clearly beside the line of the jaws, else
/// from above, else, with upright jaws, from the front (+y).
fn approach(x: &Unit<Vector3<f64>>, to_center: &Vector3<f64>, opening: f64) -> Unit<Vector3<f64>> {
    let across = |direction: Vector3<f64>| direction - x.into_inner() * x.dot(&direction);
    Unit::try_new(across(*to_center), NEAR * opening)
        .or_else(|| Unit::try_new(across(-Vector3::z()), NEAR))
        .or_else(|| Unit::try_new(across(Vector3::y()), NEAR))
        .unwrap_or_else(|| perpendicular(x))
}
