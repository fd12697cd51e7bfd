//! How good the grasps of each method are after how long, and how a search grows with the candidates.
//!
//! `cargo bench --bench planner` prints the tables; with `-- --write docs` it writes `docs/planner.md`.
//! `GRASPD_MESHES` names a folder with knight_21358.stl, bunny_33352.ply, duck_8228.obj and box_1880.stl; else
//! the example meshes are taken. `GRASPD_SEEDS` is the number of seeds, 5 when not set. Runs on all processors.

use std::fmt::Write as _;
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use graspd::core::contact::{Cone, ConeEdges, ContactModel, Friction};
use graspd::core::mesh::{self, Limits, Mesh, RawMesh};
use graspd::core::search::{
    GeneticSettings, Initial, InitialMode, Outcome, Problem, Progress, Stop, initial_grasp,
    memetic, modified_ga,
};
use graspd::core::wrench::{EdgeNorm, TorqueScale, WrenchModel, WrenchSpace};

/// Seconds that the memetic search is given.
const TIMES: [f64; 3] = [0.2, 1.0, 10.0];

/// The paper's five: mesh, contacts, friction, population and generations.
const CASES: [(&str, usize, bool, usize, usize); 5] = [
    ("box", 7, false, 400, 30),
    ("knight", 7, false, 200, 20),
    ("knight", 4, true, 200, 20),
    ("bunny", 4, true, 200, 20),
    ("duck", 4, true, 200, 20),
];

fn main() {
    // As a test it only has to compile.
    if !std::env::args().any(|argument| argument == "--bench") {
        return;
    }
    let mut arguments = std::env::args().skip_while(|argument| argument != "--write");
    let folder = arguments.nth(1).map(PathBuf::from);
    let text = report();
    print!("{text}");
    if let Some(folder) = folder {
        std::fs::write(folder.join("planner.md"), text).expect("docs can be written");
    }
}

fn report() -> String {
    let seeds = std::env::var("GRASPD_SEEDS").map_or(5, |count| count.parse().expect("a number"));
    let mut out = String::from(
        "# How good, how fast\n\nWritten by `cargo bench --bench planner -- --write docs`; edit nothing here.\n\n\
         ## The paper's cases\n\n\
         Mean ε over seeds 0, 1, ..., λ = max_radius, friction 0.2 with 8 edges where there is any, contacts at \
         centroids, not polished. `modified_ga` at the paper's population and generations from Algorithm 1's \
         grasp. Best: the best of all runs of this table. Time to GA: median time of the memetic search to the \
         genetic algorithm's mean.\n\n\
         | case | GA | s | memetic 0.2 s | 1 s | 10 s | 1 s: least, greatest | best | 1 s / best | 1 s / GA | time to GA, ms |\n\
         |---|--:|--:|--:|--:|--:|---|--:|--:|--:|--:|\n",
    );
    for (name, contacts, friction, population, generations) in CASES {
        let (name, mesh) = body(name);
        let problem = problem(&mesh, contacts, friction);
        let row = compare(&problem, population, generations, seeds);
        let _ = writeln!(
            out,
            "| {name}, {contacts} {}, {} candidates | {row}",
            if friction { "μ 0.2" } else { "frictionless" },
            problem.len()
        );
    }
    out += "\n## Growth with the candidates\n\nFour contacts, μ 0.2, seed 1: the duck and the box with every triangle \
            cut into four again and again; until eight climbers have arrived at optima that are proven over all \
            candidates.\n\n| body | candidates | evaluations | s | ε |\n|---|--:|--:|--:|--:|\n";
    for (name, cuts) in [
        ("box", 0),
        ("duck", 0),
        ("duck", 1),
        ("duck", 2),
        ("duck", 3),
    ] {
        let (name, mesh) = body(name);
        let mesh = finer(mesh, cuts);
        let problem = problem(&mesh, 4, true);
        let begun = Instant::now();
        let mut evaluations = 0;
        let mut go = |_: &Progress| ControlFlow::Continue(());
        let outcome = search(&problem, 1, &settings(8, 1), &mut evaluations, &mut go);
        let _ = writeln!(
            out,
            "| {name} | {} | {evaluations} | {:.2} | {:.5} |",
            problem.len(),
            begun.elapsed().as_secs_f64(),
            quality(&outcome)
        );
    }
    out
}

/// One row, after the name of the case.
fn compare(problem: &Problem, population: usize, generations: usize, seeds: u64) -> String {
    let mut genetic = Vec::new();
    let mut seconds = 0.0;
    for seed in 0..seeds {
        let begun = Instant::now();
        let mut evaluations = 0;
        let mut go = |_: &Progress| ControlFlow::Continue(());
        let first = initial_grasp(
            problem,
            InitialMode::Strict,
            seed,
            None,
            &mut evaluations,
            &mut go,
        );
        let first = match first {
            Initial::Found { grasp, .. } => Some(grasp),
            _ => None,
        };
        let settings = settings(population, generations);
        let outcome = modified_ga(problem, &settings, seed, first, &mut evaluations, &mut go);
        genetic.push(quality(&outcome));
        seconds += begun.elapsed().as_secs_f64() / seeds as f64;
    }
    let paper = mean(&genetic);
    let mut reached = Vec::new();
    let mut found: Vec<Vec<f64>> = Vec::new();
    for limit in TIMES {
        let of_seed = |seed| {
            let begun = Instant::now();
            let mut at = None;
            let mut watch = |progress: &Progress| {
                if at.is_none() && progress.best.is_some_and(|best| best >= paper) {
                    at = Some(begun.elapsed());
                }
                match begun.elapsed() < Duration::from_secs_f64(limit) {
                    true => ControlFlow::Continue(()),
                    false => ControlFlow::Break(Stop::TimeLimit),
                }
            };
            let outcome = search(problem, seed, &settings(8, 100_000), &mut 0, &mut watch);
            reached.extend(at.map(|at| at.as_secs_f64() * 1e3));
            quality(&outcome)
        };
        found.push((0..seeds).map(of_seed).collect());
    }
    reached.sort_by(f64::total_cmp);
    let greatest = |values: &[f64]| values.iter().copied().fold(0.0, f64::max);
    let least = found[1].iter().copied().fold(f64::INFINITY, f64::min);
    let best = found
        .iter()
        .map(|values| greatest(values))
        .fold(0.0, f64::max);
    let means: Vec<f64> = found.iter().map(|values| mean(values)).collect();
    format!(
        "{paper:.4} | {seconds:.2} | {:.4} | {:.4} | {:.4} | {least:.4}, {:.4} | {best:.4} | {:.3} | {:.2} | {:.0} |",
        means[0],
        means[1],
        means[2],
        greatest(&found[1]),
        means[1] / best,
        means[1] / paper,
        reached.get(reached.len() / 2).copied().unwrap_or(f64::NAN),
    )
}

fn search(
    problem: &Problem,
    seed: u64,
    settings: &GeneticSettings,
    evaluations: &mut u64,
    observe: &mut (dyn FnMut(&Progress) -> ControlFlow<Stop> + Send),
) -> Outcome {
    let first = initial_grasp(
        problem,
        InitialMode::Weak,
        seed,
        None,
        evaluations,
        &mut *observe,
    );
    let first = match first {
        Initial::Found { grasp, quality } => Some((grasp, quality)),
        _ => None,
    };
    memetic(problem, settings, seed, first, evaluations, observe)
}

fn quality(outcome: &Outcome) -> f64 {
    outcome.best.as_ref().map_or(0.0, |(_, quality)| *quality)
}

fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}

fn settings(population: usize, generations: usize) -> GeneticSettings {
    let memetic = population < 50;
    GeneticSettings {
        population,
        generations,
        crossover_probability: if memetic { 0.7 } else { 0.9 },
        mutation_probability: 0.2,
        elitism: 1,
        evaluation_limit: None,
        target_quality: None,
    }
}

fn problem(mesh: &Mesh, contacts: usize, friction: bool) -> Problem {
    let center = mesh.report().center_of_mass;
    let contact_model = match (friction, Friction::new(0.2), ConeEdges::new(8)) {
        (true, Some(friction), Some(edges)) => ContactModel::Hard {
            friction,
            cone: Cone::Pyramid(edges),
        },
        _ => ContactModel::Frictionless,
    };
    let model = WrenchModel {
        contact_model,
        edge_norm: EdgeNorm::UnitEdge,
        space: WrenchSpace::L1,
        center,
        torque_scale: TorqueScale::MaxRadius.value(mesh, &center),
    };
    Problem::new(mesh.candidates(), model, contacts).expect("more candidates than contacts")
}

/// A mesh of the folder, or the example that stands for it, with its file's name.
fn body(name: &str) -> (String, Mesh) {
    let own = Path::new(env!("CARGO_MANIFEST_DIR")).join("examples/meshes");
    let folder = std::env::var_os("GRASPD_MESHES").map_or(own, PathBuf::from);
    let mut files: Vec<PathBuf> = std::fs::read_dir(&folder)
        .expect("a folder of meshes")
        .map(|file| file.expect("a file").path())
        .collect();
    files.sort();
    let stands_for = |path: &&PathBuf| {
        let stem = path.file_stem().unwrap_or_default().to_string_lossy();
        stem.starts_with(name) || (name == "bunny" && stem.starts_with("rabbit"))
    };
    let file = files.iter().find(stands_for).expect("the mesh of the case");
    let bytes = std::fs::read(file).expect("a readable file");
    let limits = Limits {
        triangles: 1 << 24,
        vertices: 1 << 24,
    };
    let (format, raw) = mesh::read(&bytes, None, &limits).expect("a mesh");
    let mesh = Mesh::prepare(raw, format).expect("a usable mesh");
    (
        file.file_name()
            .unwrap_or_default()
            .to_string_lossy()
            .into_owned(),
        mesh,
    )
}

/// The mesh with every triangle cut into four, `cuts` times.
fn finer(mut mesh: Mesh, cuts: usize) -> Mesh {
    for _ in 0..cuts {
        let mut vertices = mesh.vertices().to_vec();
        let mut triangles = Vec::with_capacity(4 * mesh.triangles().len());
        for &[a, b, c] in mesh.triangles() {
            let mut middle = |i: u32, j: u32| {
                let (i, j) = (i.min(j), i.max(j));
                vertices.push(nalgebra::center(
                    &vertices[i as usize],
                    &vertices[j as usize],
                ));
                vertices.len() as u32 - 1
            };
            let (ab, bc, ca) = (middle(a, b), middle(b, c), middle(c, a));
            triangles.extend([[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]);
        }
        mesh = Mesh::prepare(
            RawMesh {
                vertices,
                triangles,
            },
            None,
        )
        .expect("as good as before");
    }
    mesh
}
