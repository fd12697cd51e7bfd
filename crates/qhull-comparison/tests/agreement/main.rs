//! The engine agrees with Qhull on grasps from real meshes: margin on both sides of zero, its sign, rank
//! and volume.
//!
//! So does it on regular grasps, whose wrenches lie in common flats but for rounding.
//!
//! `GRASPD_AGREEMENT` is the number of grasps of either kind, 3,000 when not set; `GRASPD_MESHES` a folder with more
//! meshes. Sets on which the two differ are written to `target/tmp/disagreements/`; `GRASPD_REPLAY` names
//! such a file to be looked at instead.

mod arbiter;
mod compare;
mod regular;
mod samples;

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use compare::{Judge, Verdict};
use graspd_core::wrench::Wrench;
use testkit::grasps::Sampler;

#[test]
fn engine_and_qhull_agree() {
    if let Some(path) = std::env::var_os("GRASPD_REPLAY") {
        let verdict = Judge::new().compare(&kept(Path::new(&path)));
        println!("{verdict:?}");
        assert!(!matches!(verdict, Verdict::Wrong(_)), "{verdict:?}");
        return;
    }
    let wanted = wanted();
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("disagreements");
    let _ = std::fs::remove_dir_all(&folder);
    std::fs::create_dir_all(&folder).expect("a folder for disagreements");
    let mut judge = Judge::new();
    let mut counts: BTreeMap<String, usize> = BTreeMap::new();
    let mut worst = 0.0_f64;
    let mut wrong = Vec::new();
    samples::for_each(&meshes(), wanted, |label, wrenches| {
        let verdict = judge.compare(wrenches);
        let kind = match &verdict {
            Verdict::Agree { closure: true } => "agree, closure".to_owned(),
            Verdict::Agree { closure: false } => "agree, no closure".to_owned(),
            Verdict::AgreeForTheirLength { by }
            | Verdict::AgreeButThin { by }
            | Verdict::QhullWrong { by }
            | Verdict::QhullVolumeWrong { by }
            | Verdict::IllConditioned { by } => {
                worst = worst.max(*by);
                format!("{verdict:?}")
                    .split(' ')
                    .next()
                    .unwrap_or_default()
                    .to_owned()
            }
            Verdict::Wrong(_) => "WRONG".to_owned(),
            other => format!("{other:?}"),
        };
        let number = counts.entry(kind.clone()).or_default();
        *number += 1;
        if !matches!(verdict, Verdict::Agree { .. } | Verdict::Flat) && *number <= 40 {
            keep(
                &folder.join(format!("{kind}-{number}.txt")),
                label,
                &verdict,
                wrenches,
            );
        }
        if let Verdict::Wrong(problem) = verdict {
            println!("{label}: {problem}");
            wrong.push(format!("{label}: {problem}"));
        }
    });
    println!("{counts:#?}\ngreatest difference: {worst:e}");
    let shown: Vec<_> = wrong.iter().take(20).collect();
    assert!(wrong.is_empty(), "{} sets: {shown:#?}", wrong.len());
    assert!(
        counts
            .get("agree, closure")
            .is_some_and(|n| n * 10 > wanted)
    );
    assert!(
        counts
            .get("agree, no closure")
            .is_some_and(|n| n * 10 > wanted)
    );
}

/// How many grasps to compare.
fn wanted() -> usize {
    match std::env::var("GRASPD_AGREEMENT") {
        Ok(count) => count.parse().expect("GRASPD_AGREEMENT is a number"),
        Err(_) => 3_000,
    }
}

#[test]
fn regular_grasps_agree() {
    let wanted = wanted();
    let mut sampler = Sampler::new(17);
    let mut judge = regular::Judge::new();
    let mut counts: BTreeMap<regular::Outcome, usize> = BTreeMap::new();
    let mut wrong = Vec::new();
    for number in 0..wanted {
        let case = regular::case(&mut sampler);
        match judge.compare(&case) {
            Ok(outcome) => *counts.entry(outcome).or_default() += 1,
            Err(problem) => wrong.push(format!("{number}: {problem} {case:?}")),
        }
    }
    println!("{counts:#?}");
    for problem in wrong.iter().take(20) {
        println!("{problem}");
    }
    assert!(wrong.is_empty(), "{} grasps", wrong.len());
    let closed = counts.get(&regular::Outcome::Closure);
    assert!(closed.is_some_and(|n| n * 4 > wanted), "{counts:?}");
}

/// Sets on which the two once differed; `exact.py` in this folder says who was wrong.
#[test]
fn kept_sets_agree() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/agreement/kept");
    let mut judge = Judge::new();
    let files = std::fs::read_dir(folder).expect("the kept sets");
    let wrong: Vec<String> = files
        .map(|file| file.expect("a file").path())
        .filter_map(|path| match judge.compare(&kept(&path)) {
            Verdict::Wrong(problem) => Some(format!("{}: {problem}", path.display())),
            _ => None,
        })
        .collect();
    assert!(wrong.is_empty(), "{wrong:#?}");
}

/// The meshes of the repository and those of `GRASPD_MESHES`, by name.
fn meshes() -> Vec<PathBuf> {
    let own = testkit::cases::examples();
    let mut found: Vec<PathBuf> = ["box.stl", "knight.stl", "rabbit.ply", "duck.obj"]
        .map(|name| own.join(name))
        .into();
    if let Some(folder) = std::env::var_os("GRASPD_MESHES").map(PathBuf::from) {
        let files = std::fs::read_dir(&folder).expect("the folder GRASPD_MESHES");
        let mut given: Vec<PathBuf> = files.map(|file| file.expect("a file").path()).collect();
        given.retain(|path| {
            path.extension()
                .is_some_and(|e| e == "stl" || e == "ply" || e == "obj")
        });
        given.sort();
        found.extend(given);
    }
    found
}

fn keep(path: &Path, label: &str, verdict: &Verdict, wrenches: &[Wrench]) {
    let mut text = format!("# {label}\n# {verdict:?}\n");
    for wrench in wrenches {
        let numbers: Vec<String> = wrench.iter().map(|x| format!("{x:?}")).collect();
        writeln!(text, "{}", numbers.join(" ")).expect("text grows");
    }
    std::fs::write(path, text).expect("a disagreement is kept");
}

/// The set that [`keep`] wrote.
fn kept(path: &Path) -> Vec<Wrench> {
    let text = std::fs::read_to_string(path).expect("a kept set");
    let lines = text.lines().filter(|line| !line.starts_with('#'));
    let numbers = lines.map(|line| line.split(' ').map(|x| x.parse().expect("a number")));
    numbers.map(Wrench::from_iterator).collect()
}
