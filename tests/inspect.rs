//! `graspd inspect` as a shell runs it.

use std::path::Path;
use std::process::{Command, Output};

use graspd::run::mesh_report;
use graspd_core::mesh::Mesh;
use graspd_mesh_io::{Limits, read};

const OPEN: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\n";
const CLOSED: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n";

fn inspect(folder: &Path, arguments: &[&str]) -> Output {
    Command::new(testkit::process::binary())
        .arg("inspect")
        .args(arguments)
        .current_dir(folder)
        .output()
        .unwrap()
}

fn folder() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    for (name, text) in [("open.obj", OPEN), ("closed.obj", CLOSED), ("none.obj", "")] {
        std::fs::write(folder.path().join(name), text).unwrap();
    }
    folder
}

#[test]
fn the_table_has_the_figures_and_warnings_only_for_faults() {
    let folder = folder();
    let text = |name: &str| {
        let output = inspect(folder.path(), &[name]);
        assert_eq!(output.status.code(), Some(0));
        String::from_utf8(output.stdout).unwrap()
    };
    let value = |text: &str, name: &str| {
        let mut lines = text.lines().filter_map(|line| line.strip_prefix(name));
        lines.next().map(|value| value.trim().to_owned())
    };
    let (closed, open) = (text("closed.obj"), text("open.obj"));
    for (name, wanted) in [
        ("format", "obj"),
        ("border edges", "0"),
        ("watertight", "yes"),
        ("volume", "0.166667"),
        ("centre of mass", "0.25, 0.25, 0.25"),
        ("size", "1, 1, 1"),
        ("candidates", "4"),
    ] {
        assert_eq!(value(&closed, name).as_deref(), Some(wanted), "{closed}");
    }
    assert!(!closed.contains("warning"), "{closed}");
    assert_eq!(value(&open, "border edges").as_deref(), Some("3"));
    assert!(
        open.contains("warning: the surface is open along 3 edges"),
        "{open}"
    );
}

#[test]
fn the_json_is_the_report() {
    let folder = folder();
    let output = inspect(folder.path(), &["open.obj", "--json"]);
    assert_eq!(output.status.code(), Some(0));
    let (_, raw) = read(OPEN.as_bytes(), None, &Limits::NONE).unwrap();
    let mesh = Mesh::prepare(raw).unwrap();
    let report = serde_json::to_vec(&mesh_report(&mesh, None)).unwrap();
    assert_eq!(output.stdout, report);
}

#[test]
fn pictures_are_written_in_the_format_of_their_name() {
    let folder = folder();
    for (name, start) in [
        ("a.png", &b"\x89PNG\r\n\x1a\n"[..]),
        ("b.SVG", &b"<svg "[..]),
    ] {
        let output = inspect(folder.path(), &["open.obj", "--picture", name]);
        assert_eq!(output.status.code(), Some(0));
        assert!(output.stdout.starts_with(b"format "));
        let bytes = std::fs::read(folder.path().join(name)).unwrap();
        assert!(bytes.starts_with(start), "{name}");
    }
}

#[test]
fn exit_codes_distinguish_faults() {
    let folder = folder();
    for (arguments, code, words) in [
        (&["none.obj"][..], 1, "Unusable input"),
        (&["absent.obj"], 1, "cannot read absent.obj"),
        (
            &["open.obj", "--picture", "absent/a.png"],
            2,
            "there is no folder absent",
        ),
        (
            &["open.obj", "--picture", "a.gif"],
            2,
            "must end in .png or .svg",
        ),
    ] {
        let output = inspect(folder.path(), arguments);
        let said = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(code), "{said}");
        assert!(said.contains(words), "{said}");
        assert!(output.stdout.is_empty());
    }
}
