//! How good the grasps of each method are after how long, and how a search grows with the candidates.
//!
//! `cargo bench --bench planner` prints the tables; with `-- --write docs` it writes `docs/planner.md` and its
//! picture. `GRASPD_MESHES` names a folder with knight_21358.stl, bunny_33352.ply, duck_8228.obj and
//! box_1880.stl; else the example meshes are taken. `GRASPD_SEEDS` is the number of seeds, 5 when not set;
//! `GRASPD_LONG` the seconds of the long run of each case, 30 when not set. Runs on all processors.

mod bodies;
mod growth;

use std::fmt::Write as _;
use std::path::PathBuf;
use std::time::{Duration, Instant};

use graspd_core::contact::{Cone, ConeEdges, ContactModel, Friction};
use graspd_core::mesh::Mesh;
use graspd_core::search::{
    Budget, Initial, InitialMode, Method, Outcome, Search, SearchProblem, SearchProgress,
    SearchSettings, initial_grasp,
};
use graspd_core::wrench::{EdgeNorm, TorqueScale, WrenchModel, WrenchSpace};
use graspd_core::{Interrupt, Interrupted};

/// Seconds that the memetic search is given.
const TIMES: [f64; 3] = [0.2, 1.0, 10.0];

/// Climbers of the memetic search; the default of the service.
const POPULATION: usize = 8;

/// Climbers of the long run: more of them forget less.
const LONG_POPULATION: usize = 32;

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
    let growth = growth::measure();
    let text = report() + &growth::text(&growth);
    print!("{text}");
    if let Some(folder) = folder {
        let write =
            |name, text| std::fs::write(folder.join(name), text).expect("docs can be written");
        write("planner.md", text);
        write("planner-growth.svg", growth::picture(&growth));
    }
}

/// A number that the environment may give.
fn setting(name: &str, otherwise: u64) -> u64 {
    std::env::var(name).map_or(otherwise, |value| value.parse().expect("a number"))
}

fn report() -> String {
    let (seeds, long) = (setting("GRASPD_SEEDS", 5), setting("GRASPD_LONG", 30));
    let threads = rayon::current_num_threads();
    let mut out = format!(
        "# How good, how fast\n\nWritten by `make planner`; edit nothing here.\n\n\
         ## The paper's cases\n\n\
         Mean ε over seeds 0 to {}, {threads} threads, λ = max_radius, friction 0.2 with 8 edges where there is \
         any, contacts at centroids, not polished. `modified_ga` at the paper's population and generations from \
         Algorithm 1's grasp. Best: the greatest ε of all runs of this page. Time to GA: median time of the \
         memetic search to the genetic algorithm's mean.\n\n\
         | case | GA | s | memetic 0.2 s | 1 s | 10 s | 1 s: least, greatest | best | 1 s / best | 1 s / GA | time to GA, ms |\n\
         |---|--:|--:|--:|--:|--:|---|--:|--:|--:|--:|\n",
        seeds - 1
    );
    let mut long_runs = format!(
        "\n## Best seen\n\nOne memetic run of {long} s for each case, population {LONG_POPULATION}, seed 0; \
         contacts are triangles of the file, from 0.\n\n| case | ε of the long run | contacts |\n|---|--:|---|\n"
    );
    let cases = CASES.map(|(name, contacts, friction, population, generations)| {
        let (name, mesh) = bodies::of_case(name);
        let problem = problem(&mesh, contacts, friction);
        let kind = if friction { "μ 0.2" } else { "frictionless" };
        let case = format!("{name}, {contacts} {kind}, {} candidates", problem.len());
        eprintln!("{case}");
        let row = compare(&problem, population, generations, seeds);
        (case, problem, row)
    });
    // After all that is timed, so that the machine need not be idle any more.
    for (case, problem, mut row) in cases {
        eprintln!("{case}: long run");
        let best = run(&problem, 0, LONG_POPULATION, long as f64, &mut |_| ());
        row.best = row.best.max(quality(&best));
        let _ = writeln!(out, "| {case} | {row}");
        let triangles = best.best.as_ref().map(|(grasp, _)| {
            let of = |&index: &u32| problem.candidates()[index as usize].triangle.to_string();
            grasp.iter().map(of).collect::<Vec<_>>().join(", ")
        });
        let _ = writeln!(
            long_runs,
            "| {case} | {:.6} | {} |",
            quality(&best),
            triangles.unwrap_or_default()
        );
    }
    out + &long_runs
}

/// The results of the runs on one case.
struct Row {
    /// Mean ε and seconds of the genetic algorithm.
    paper: f64,
    seconds: f64,
    /// ε of the memetic search, for each of [`TIMES`] and each seed.
    found: Vec<Vec<f64>>,
    /// Greatest ε of all.
    best: f64,
    /// Median milliseconds to `paper`.
    reached: f64,
}

impl std::fmt::Display for Row {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let means: Vec<f64> = self.found.iter().map(|values| mean(values)).collect();
        let least = self.found[1].iter().copied().fold(f64::INFINITY, f64::min);
        write!(
            f,
            "{:.4} | {:.3} | {:.4} | {:.4} | {:.4} | {least:.4}, {:.4} | {:.4} | {:.3} | {:.2} | {:.0} |",
            self.paper,
            self.seconds,
            means[0],
            means[1],
            means[2],
            greatest(&self.found[1]),
            self.best,
            means[1] / self.best,
            means[1] / self.paper,
            self.reached,
        )
    }
}

fn compare(problem: &SearchProblem, population: usize, generations: usize, seeds: u64) -> Row {
    let (paper, seconds) = compare_genetic(problem, population, generations, seeds);
    let mut reached = Vec::new();
    let mut found: Vec<Vec<f64>> = Vec::new();
    for limit in TIMES {
        let of_seed = |seed| {
            let begun = Instant::now();
            let mut at = None;
            let outcome = run(problem, seed, POPULATION, limit, &mut |progress| {
                if at.is_none() && progress.best.is_some_and(|best| best >= paper) {
                    at = Some(begun.elapsed());
                }
            });
            reached.extend(at.map(|at| at.as_secs_f64() * 1e3));
            quality(&outcome)
        };
        found.push((0..seeds).map(of_seed).collect());
    }
    reached.sort_by(f64::total_cmp);
    let best = found.iter().map(|values| greatest(values));
    Row {
        paper,
        seconds,
        best: best.fold(0.0, f64::max),
        reached: reached.get(reached.len() / 2).copied().unwrap_or(f64::NAN),
        found,
    }
}

/// Mean ε and seconds of the genetic algorithm, started from Algorithm 1's grasp.
fn compare_genetic(
    problem: &SearchProblem,
    population: usize,
    generations: usize,
    seeds: u64,
) -> (f64, f64) {
    let begun = Instant::now();
    let of_seed = |seed| {
        let search = Search {
            problem,
            settings: &genetic_settings(population, generations),
            seed,
            budget: &mut Budget::new(None),
            interrupt: Interrupt::never(),
            observe: &mut |_| {},
        };
        quality(&from_first_grasp(
            search,
            Method::ModifiedGa,
            InitialMode::Strict,
        ))
    };
    let found: Vec<f64> = (0..seeds).map(of_seed).collect();
    (mean(&found), begun.elapsed().as_secs_f64() / seeds as f64)
}

/// A memetic search of so many seconds, watched.
fn run(
    problem: &SearchProblem,
    seed: u64,
    population: usize,
    seconds: f64,
    watch: &mut (dyn FnMut(&SearchProgress) + Send),
) -> Outcome {
    let begun = Instant::now();
    let limit = Duration::from_secs_f64(seconds);
    let ask = || (begun.elapsed() >= limit).then_some(Interrupted::TimeLimit);
    search(
        problem,
        seed,
        &memetic_settings(population, 1_000_000),
        &mut Budget::new(None),
        Interrupt::new(&ask),
        watch,
    )
}

fn search(
    problem: &SearchProblem,
    seed: u64,
    settings: &SearchSettings,
    budget: &mut Budget,
    interrupt: Interrupt<'_>,
    observe: &mut (dyn FnMut(&SearchProgress) + Send),
) -> Outcome {
    let search = Search {
        problem,
        settings,
        seed,
        budget,
        interrupt,
        observe,
    };
    from_first_grasp(search, Method::Memetic, InitialMode::Weak)
}

/// Runs Algorithm 1, then a method from its grasp.
fn from_first_grasp(search: Search<'_>, method: Method, mode: InitialMode) -> Outcome {
    let first = initial_grasp(
        search.problem,
        mode,
        search.seed,
        &mut *search.budget,
        search.interrupt,
        &mut *search.observe,
    );
    let first = match first {
        Initial::Found { grasp, quality } => Some((grasp, quality)),
        _ => None,
    };
    search.run(method, first)
}

fn quality(outcome: &Outcome) -> f64 {
    outcome.best.as_ref().map_or(0.0, |(_, quality)| *quality)
}

fn greatest(values: &[f64]) -> f64 {
    values.iter().copied().fold(0.0, f64::max)
}

fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}

/// The paper's, but for its size.
fn genetic_settings(population: usize, generations: usize) -> SearchSettings {
    SearchSettings {
        population,
        generations,
        crossover_probability: 0.9,
        mutation_probability: 0.2,
        elitism: 1,
        target_quality: None,
    }
}

/// The defaults of the service, but for their size.
fn memetic_settings(population: usize, generations: usize) -> SearchSettings {
    SearchSettings {
        crossover_probability: 0.7,
        ..genetic_settings(population, generations)
    }
}

fn problem(mesh: &Mesh, contacts: usize, friction: bool) -> SearchProblem {
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
    SearchProblem::new(mesh.candidates(), model, contacts).expect("more candidates than contacts")
}
