//! The quality engine beside Qhull, in one process and one thread.
//!
//! `cargo bench -p qhull-comparison -- [--quick] [--write FOLDER]` prints the report; with
//! `--write` it is left in a folder, with its picture. `GRASPD_MESHES` names a folder with the meshes of
//! the paper; without it those of the repository are used.

mod measure;
mod picture;
mod report;

use std::path::PathBuf;
use std::time::Duration;

use measure::Effort;

/// Some fifty seconds in all.
const FULL: Effort = Effort {
    rounds: 5,
    qhull: Duration::from_millis(120),
    engine: Duration::from_millis(20),
};

/// Some fifteen.
const QUICK: Effort = Effort {
    rounds: 3,
    qhull: Duration::from_millis(40),
    engine: Duration::from_millis(5),
};

fn main() {
    // Cargo adds this when it runs a bench; without it this is a test run, with nothing to measure.
    if !std::env::args().any(|argument| argument == "--bench") {
        return;
    }
    let mut effort = FULL;
    let mut folder: Option<PathBuf> = None;
    let mut arguments = std::env::args().skip(1);
    while let Some(argument) = arguments.next() {
        match argument.as_str() {
            // What cargo adds.
            "--bench" => {}
            "--quick" => effort = QUICK,
            "--write" => folder = arguments.next().map(PathBuf::from),
            other => panic!("{other}: not an option; --quick and --write FOLDER are"),
        }
    }
    let bodies = testkit::cases::bodies();
    let growth = report::growth(&bodies, effort);
    let text = report::text(&bodies, effort, &growth);
    println!("{text}");
    if let Some(folder) = folder {
        std::fs::write(folder.join("quality.md"), text).expect("quality.md is written");
        let picture = picture::svg(&growth);
        std::fs::write(folder.join("quality-growth.svg"), picture).expect("the picture is written");
    }
}
