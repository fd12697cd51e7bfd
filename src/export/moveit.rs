//! The pose of a gripper for MoveIt.

use nalgebra::Vector3;
use serde_json::{Value, json};

use super::pose::{ASSUMPTIONS, CLEARANCE, GripperPose};

/// The length of approach and retreat, relative to the distance of the contacts.
const TRAVEL: f64 = 1.0;

/// Writes a pose as the message `moveit_msgs/Grasp` of ROS 2 in JSON. The assumptions are in `_comment`,
/// which is not a field of the message.
pub fn message(pose: &GripperPose) -> Value {
    let header = || json!({"stamp": {"sec": 0, "nanosec": 0}, "frame_id": "mesh"});
    let [x, y, z] = pose.position.coords.into();
    let turn = pose.orientation.quaternion();
    let posture = |opening: f64| {
        json!({
            "header": header(), "joint_names": ["opening"],
            "points": [{"positions": [opening], "velocities": [], "accelerations": [], "effort": [],
                "time_from_start": {"sec": 0, "nanosec": 0}}],
        })
    };
    let translation = |direction: Vector3<f64>| {
        let [x, y, z] = direction.into();
        json!({
            "direction": {"header": header(), "vector": {"x": x, "y": y, "z": z}},
            "desired_distance": TRAVEL * pose.opening, "min_distance": 0.5 * TRAVEL * pose.opening,
        })
    };
    let along = pose.orientation * Vector3::z();
    json!({
        "_comment": ASSUMPTIONS,
        "id": "grasp_0",
        "pre_grasp_posture": posture(pose.opening * CLEARANCE),
        "grasp_posture": posture(pose.opening),
        "grasp_pose": {
            "header": header(),
            "pose": {
                "position": {"x": x, "y": y, "z": z},
                "orientation": {"x": turn.i, "y": turn.j, "z": turn.k, "w": turn.w},
            },
        },
        "grasp_quality": pose.quality,
        "pre_grasp_approach": translation(along),
        "post_grasp_retreat": translation(-along),
        "post_place_retreat": translation(-along),
        "max_contact_force": 0.0,
        "allowed_touch_objects": [],
    })
}

#[cfg(test)]
mod tests {
    use super::super::samples::pose_of_jaws;
    use super::*;
    use crate::wire::Units;

    #[test]
    fn the_message_has_the_fields_of_its_definition() {
        let keys = |value: &Value| -> Vec<String> {
            let mut keys: Vec<String> = value.as_object().unwrap().keys().cloned().collect();
            keys.sort();
            keys
        };
        let gripper = pose_of_jaws(
            [[-1.0, 0.0, 0.0], [1.0, 0.0, 0.0]],
            [0.0, 3.0, 0.0],
            Some(Units::M),
        );
        let message = message(&gripper);
        // moveit_msgs/Grasp and GripperTranslation, trajectory_msgs/JointTrajectory.
        let mut fields = vec![
            "_comment",
            "id",
            "pre_grasp_posture",
            "grasp_posture",
            "grasp_pose",
            "grasp_quality",
            "pre_grasp_approach",
            "post_grasp_retreat",
            "post_place_retreat",
            "max_contact_force",
            "allowed_touch_objects",
        ];
        fields.sort_unstable();
        assert_eq!(keys(&message), fields);
        for (name, opening) in [("pre_grasp_posture", 2.5), ("grasp_posture", 2.0)] {
            let posture = &message[name];
            assert_eq!(keys(posture), ["header", "joint_names", "points"]);
            let point = &posture["points"][0];
            assert_eq!(point["positions"], json!([opening]));
            assert_eq!(
                keys(point),
                [
                    "accelerations",
                    "effort",
                    "positions",
                    "time_from_start",
                    "velocities"
                ]
            );
        }
        for (name, y) in [
            ("pre_grasp_approach", 1.0),
            ("post_grasp_retreat", -1.0),
            ("post_place_retreat", -1.0),
        ] {
            let translation = &message[name];
            assert_eq!(
                keys(translation),
                ["desired_distance", "direction", "min_distance"]
            );
            let vector = &translation["direction"]["vector"];
            assert!((vector["y"].as_f64().unwrap() - y).abs() < 1e-12, "{name}");
            assert_eq!(translation["direction"]["header"]["frame_id"], "mesh");
        }
    }
}
