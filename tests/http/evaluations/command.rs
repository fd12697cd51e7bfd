//! `graspd evaluate`.

use super::*;

#[test]
fn the_exit_code_of_the_command_gives_the_outcome() {
    let folder = tempfile::tempdir().unwrap();
    let mesh = folder.path().join("box.stl");
    std::fs::write(&mesh, small_box()).unwrap();
    let held = json!([four()]).to_string();
    let both = json!([four(), [{"triangle": 1}]]).to_string();
    let planned = json!({"quality": 0.1, "contacts": [{"triangle": 1, "position": [0, 0, 0]}]});
    for (grasps, flags, code, said) in [
        (held.as_str(), &[][..], 0, ""),
        (&both, &[], 3, ""),
        (&planned.to_string(), &[], 3, ""),
        (&held, &["--friction", "0"], 3, ""),
        (
            &held,
            &["--friction", "much"],
            2,
            "--friction: must be a number",
        ),
        (&held, &["--seed", "1"], 2, "--seed"),
        (
            "[[{\"triangle\": 1000}]]",
            &[],
            1,
            "/grasps/0/0/triangle: the mesh has no triangle",
        ),
        ("[[{\"face\": 1}]]", &[], 1, "/grasps/0/0/face: unknown"),
        ("[[", &[], 1, "Malformed JSON"),
        ("7", &[], 1, "must be a JSON object"),
        (
            &held,
            &["--center-of-mass", "0,0,1e9"],
            1,
            "/center_of_mass",
        ),
    ] {
        let output = command(&mesh, grasps, flags);
        let error = String::from_utf8(output.stderr).unwrap();
        assert_eq!(
            output.status.code(),
            Some(code),
            "{grasps} {flags:?}: {error}"
        );
        assert!(error.contains(said), "{error}");
    }
    let output = command(&mesh, &both, &[]);
    let shown = String::from_utf8(output.stdout).unwrap();
    for words in [
        "grasp 0: force closure, quality 0.",
        "grasp 1: no force closure: ",
        "Nothing hinders a ",
        "isotropy",
    ] {
        assert!(shown.contains(words), "{shown}");
    }
    let output = command(&folder.path().join("none.stl"), &held, &[]);
    assert_eq!(output.status.code(), Some(1));
}
