//! The pose of a gripper for Isaac Sim.

use super::pose::{ASSUMPTIONS, CLEARANCE, GripperPose};

/// Writes a pose as `isaac_grasp` 1.0, the YAML of Isaac Sim's grasp editor.
pub fn yaml(pose: &GripperPose) -> String {
    let [x, y, z] = pose.position.coords.map(decimal).into();
    let [i, j, k, w] = pose.orientation.coords.map(decimal).into();
    let confidence = decimal(pose.quality.min(1.0));
    let (opening, wider) = (decimal(pose.opening), decimal(pose.opening * CLEARANCE));
    let comments: String = ASSUMPTIONS.map(|line| format!("# {line}\n")).concat();
    format!(
        "{comments}\
         format: isaac_grasp\n\
         format_version: 1.0\n\
         object_frame_link: mesh\n\
         gripper_frame_link: gripper\n\
         grasps:\n  \
           grasp_0:\n    \
             confidence: {confidence}\n    \
             position: [{x}, {y}, {z}]\n    \
             orientation: {{w: {w}, xyz: [{i}, {j}, {k}]}}\n    \
             cspace_position:\n      opening: {opening}\n    \
             pregrasp_cspace_position:\n      opening: {wider}\n"
    )
}

/// Writes a number with a point and without an exponent: readers of YAML 1.1 take `1e-7` for text.
fn decimal(number: f64) -> String {
    let text = number.to_string();
    match text.contains('.') {
        true => text,
        false => text + ".0",
    }
}

#[cfg(test)]
mod tests {
    use super::super::moveit;
    use super::super::samples::{best, contact, pose_of_jaws, result};
    use super::*;
    use crate::wire::Units;

    #[test]
    fn every_number_of_the_yaml_is_a_number_to_every_reader() {
        // YAML 1.1 takes 1e-7 for text and 2 for a whole number.
        let tiny = pose_of_jaws(
            [[0.0, 1e-7, -3e-20], [1.0, 0.0, 0.0]],
            [0.5; 3],
            Some(Units::Um),
        );
        let text = yaml(&tiny);
        let is_number = |word: &str| {
            let mut parts = word.trim_start_matches('-').split('.');
            let digits = |part: &str| !part.is_empty() && part.bytes().all(|b| b.is_ascii_digit());
            parts.by_ref().take(2).filter(|part| digits(part)).count() == 2 && parts.count() == 0
        };
        let lines = text.lines().filter(|line| line.starts_with("    "));
        let words: Vec<&str> = lines
            .flat_map(|line| line.split(&[' ', ',', '[', ']', '{', '}'][..]))
            .filter(|word| !word.is_empty() && !word.ends_with(':'))
            .collect();
        assert_eq!(words.len(), 1 + 3 + 4 + 1 + 1, "{text}");
        for word in words {
            assert!(is_number(word), "{word} in {text}");
        }
        assert!(text.contains("\nformat: isaac_grasp\nformat_version: 1.0\n"));
    }

    #[test]
    fn confidence_is_a_share_and_the_quality_is_what_it_is() {
        let ends = [[-1.0, 0.0, 0.0], [1.0, 0.0, 0.0]].map(|end| contact(end, end.map(|x| -x)));
        let mut result = result(ends.into());
        for (quality, confidence) in [(Some(0.25), "0.25"), (Some(1.5), "1.0"), (None, "0.0")] {
            result.quality = quality;
            let gripper = GripperPose::of(&result, &best(&result), Some(Units::M)).unwrap();
            let wanted = format!("confidence: {confidence}\n");
            assert!(yaml(&gripper).contains(&wanted), "{wanted}");
            assert_eq!(
                moveit::message(&gripper)["grasp_quality"],
                quality.unwrap_or(0.0)
            );
        }
    }
}
