//! `graspd reproduce`: repeats the table and the grids of the paper, with all methods.

mod cases;
mod plot;
mod report;

use std::io::{self, IsTerminal};
use std::path::PathBuf;
use std::process::ExitCode;
use std::sync::atomic::{AtomicBool, Ordering};

use clap::Args;
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};

use self::cases::{CASES, Case, GENERATIONS, METHODS, POPULATIONS};
use super::exit::{EXIT_INPUT, input_problem, report_problem};
use super::mesh;
use super::work::{stop_on_interrupt, threads};
use crate::wire::{MeshOptions, PlanRequest, PlanResult, Problem};
use graspd_core::mesh::Mesh;
use graspd_core::{Interrupt, Interrupted};

/// Exit code of a process that Ctrl-C has ended.
const EXIT_INTERRUPTED: u8 = 130;

/// Flags of `graspd reproduce`.
#[derive(Args)]
#[command(
    after_help = "Writes reproduction.md, table.csv, grids.csv and plots as SVG. After Ctrl-C nothing is written.\n\n\
    Exit codes: 0 done; 1 a mesh cannot be used or a file cannot be written; 130 interrupted."
)]
pub struct Reproduce {
    /// Number of runs per average; the paper has 50
    #[arg(long, default_value_t = 10, value_parser = clap::value_parser!(u16).range(1..=1000))]
    runs: u16,

    /// Seed of the first run; each further run has the next one
    #[arg(long, default_value_t = 0)]
    seed: u64,

    /// Folder with meshes whose names start with box, knight, bunny or rabbit, and duck [default: bundled meshes]
    #[arg(long, value_name = "FOLDER")]
    meshes: Option<PathBuf>,

    /// Run only this case: box-7, knight-7, knight-4, bunny-4 or duck-4
    #[arg(long, value_name = "CASE", value_parser = ["box-7", "knight-7", "knight-4", "bunny-4", "duck-4"])]
    only: Option<String>,

    /// Leave out the grids over population and generations
    #[arg(long)]
    no_grids: bool,

    /// Folder to write to
    #[arg(long, value_name = "FOLDER", default_value = "reproduction")]
    output: PathBuf,

    /// Threads to plan with [default: all processors]
    #[arg(long, value_name = "COUNT", value_parser = clap::value_parser!(u16).range(1..=1024))]
    threads: Option<u16>,
}

/// The runs of one method on one case.
struct Row {
    method: &'static str,
    results: Vec<PlanResult>,
}

/// The results of a case.
struct Measured {
    case: &'static Case,
    /// Name of the mesh file.
    file: String,
    candidates: u64,
    rows: Vec<Row>,
    /// Qualities of the genetic algorithm by population and generations, in the order of [`POPULATIONS`] and
    /// [`GENERATIONS`]; empty without grids.
    grid: Vec<[Vec<f64>; 3]>,
}

/// Why the experiments ended early.
enum EarlyEnd {
    Interrupted,
    Problem(Problem),
}

impl Reproduce {
    /// Runs the experiments, writes the report and returns the exit code.
    pub fn run(self) -> ExitCode {
        let threads = match threads(self.threads) {
            Ok(threads) => threads,
            Err(problem) => {
                report_problem(&problem);
                return ExitCode::from(EXIT_INPUT);
            }
        };
        let stop = stop_on_interrupt();
        match threads.install(|| self.measure(&stop)) {
            Ok(measured) => match report::write(&self.output, &measured, self.runs, self.seed) {
                Ok(()) => ExitCode::SUCCESS,
                Err(fault) => super::fail(format_args!(
                    "cannot write to {}: {fault}",
                    self.output.display()
                )),
            },
            Err(EarlyEnd::Interrupted) => {
                super::print_error("graspd: interrupted; nothing was written");
                ExitCode::from(EXIT_INTERRUPTED)
            }
            Err(EarlyEnd::Problem(problem)) => {
                report_problem(&problem);
                ExitCode::from(EXIT_INPUT)
            }
        }
    }

    fn measure(&self, stop: &AtomicBool) -> Result<Vec<Measured>, EarlyEnd> {
        let is_selected = |case: &&Case| self.only.as_ref().is_none_or(|only| only == case.name);
        let cases: Vec<&'static Case> = CASES.iter().filter(is_selected).collect();
        let runs = u64::from(self.runs);
        let grid = |case: &Case| case.grid && !self.no_grids;
        let combinations = POPULATIONS.len() * GENERATIONS.len();
        let per_case = |case: &&Case| METHODS.len() + if grid(case) { combinations } else { 0 };
        let total = cases.iter().map(per_case).sum::<usize>() as u64 * runs;
        let bar = progress_bar(total);
        let mut all = Vec::new();
        for case in cases {
            bar.set_message(case.name);
            let (file, bytes) = case.file(self.meshes.as_deref()).map_err(|fault| {
                EarlyEnd::Problem(input_problem(format!("cannot read a mesh: {fault}")))
            })?;
            let (_, mesh) =
                mesh::prepared(&bytes, &MeshOptions::default()).map_err(EarlyEnd::Problem)?;
            let one = |method: &str, population: u32, generations: u32, run: u64| {
                let seed = self.seed.wrapping_add(run);
                let request = case.request(method, population, generations, seed);
                let result = planned(&mesh, &request, stop);
                bar.inc(1);
                result
            };
            let mut rows = Vec::new();
            for method in METHODS {
                let results =
                    (0..runs).map(|run| one(method, case.population, case.generations, run));
                rows.push(Row {
                    method,
                    results: results.collect::<Result<_, EarlyEnd>>()?,
                });
            }
            let mut cells = Vec::new();
            for population in POPULATIONS.into_iter().filter(|_| grid(case)) {
                let mut cell = [const { Vec::new() }; 3];
                for (generations, qualities) in GENERATIONS.into_iter().zip(&mut cell) {
                    for run in 0..runs {
                        let result = one("modified_ga", population, generations, run)?;
                        qualities.extend(result.quality);
                    }
                }
                cells.push(cell);
            }
            let candidates = rows.iter().flat_map(|row| &row.results).next();
            all.push(Measured {
                case,
                file,
                candidates: candidates.map_or(0, |result| result.candidates),
                rows,
                grid: cells,
            });
        }
        bar.finish_and_clear();
        Ok(all)
    }
}

fn planned(
    mesh: &Mesh,
    request: &serde_json::Value,
    stop: &AtomicBool,
) -> Result<PlanResult, EarlyEnd> {
    let request = PlanRequest::from_json(request, 0).map_err(|faults| {
        EarlyEnd::Problem(input_problem("a case is out of range".to_owned()).with_errors(faults))
    })?;
    let ask = || {
        stop.load(Ordering::Relaxed)
            .then_some(Interrupted::Cancelled)
    };
    let result = crate::run::plan(mesh, &request, Interrupt::new(&ask), &mut |_| {});
    let result = result.map_err(EarlyEnd::Problem)?;
    match stop.load(Ordering::Relaxed) {
        true => Err(EarlyEnd::Interrupted),
        false => Ok(result),
    }
}

/// A progress bar with an estimate of the remaining time, which is drawn on standard error if that is a terminal.
fn progress_bar(total: u64) -> ProgressBar {
    let style =
        ProgressStyle::with_template("{bar:30} {pos}/{len} runs {msg} {elapsed}, {eta} left")
            .unwrap_or_else(|_| ProgressStyle::default_bar());
    let target = match io::stderr().is_terminal() {
        true => ProgressDrawTarget::stderr(),
        false => ProgressDrawTarget::hidden(),
    };
    ProgressBar::with_draw_target(Some(total), target).with_style(style)
}
