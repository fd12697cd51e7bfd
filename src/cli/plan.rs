//! `graspd plan`

use std::io::{self, IsTerminal, Write};
use std::process::ExitCode;
use std::sync::atomic::Ordering;

use clap::Args;
use indicatif::{ProgressBar, ProgressStyle};

use super::exit::{EXIT_INPUT, EXIT_NO_GRASP, EXIT_USAGE, report_problem};
use super::mesh::MeshFile;
use super::output::PictureFile;
use super::settings::{Settings, report_faults};
use super::work::{stop_on_interrupt, threads};
use super::{plot, summary};
use crate::picture::{self, Background, DEFAULT_WIDTH, GraspOptions, PictureError, Viewpoint};
use crate::wire::{Chosen, PlanRequest, PlanResult, Problem, Progress};
use graspd_core::mesh::Mesh;
use graspd_core::{Interrupt, Interrupted};

/// Flags of `graspd plan`.
#[derive(Args)]
#[command(
    after_help = "Ctrl-C stops the search and prints the best grasp so far. A second Ctrl-C ends the command at once.\n\n\
    Exit codes: 0 a force-closure grasp was found; 1 the mesh cannot be used, or a file cannot be written; \
    2 a flag cannot be used; 3 no force-closure grasp was found."
)]
pub struct Plan {
    #[command(flatten)]
    mesh: MeshFile,

    /// Print the result as JSON, as the server would send it
    #[arg(long)]
    json: bool,

    /// Threads to plan with [default: all processors]
    #[arg(long, value_name = "COUNT", value_parser = clap::value_parser!(u16).range(1..=1024))]
    threads: Option<u16>,

    /// Draw the grasp on the body, with its numbers, into a .png or .svg
    #[arg(long, value_name = "FILE", value_parser = PictureFile::parse)]
    picture: Option<PictureFile>,

    #[command(flatten)]
    settings: Settings,
}

impl Plan {
    /// Plans a grasp, prints it and returns the exit code.
    pub fn run(self) -> ExitCode {
        let request = match self.settings.clone().request() {
            Ok(request) => request,
            Err(faults) => {
                report_faults(&faults);
                return ExitCode::from(EXIT_USAGE);
            }
        };
        let (mesh, result) = match self.plan(&request) {
            Ok(found) => found,
            Err(problem) => {
                report_problem(&problem);
                return ExitCode::from(EXIT_INPUT);
            }
        };
        // Print the result first, so that a failure of the picture does not lose it.
        let printed = self.print(&result);
        if let Some(file) = &self.picture
            && let Err(problem) = self.draw(file, &mesh, &result)
        {
            report_problem(&problem);
            return ExitCode::from(EXIT_INPUT);
        }
        match printed {
            Ok(()) if result.force_closure => ExitCode::SUCCESS,
            Ok(()) => ExitCode::from(EXIT_NO_GRASP),
            Err(fault) => super::cannot_print(&fault),
        }
    }

    fn plan(&self, request: &PlanRequest) -> Result<(Mesh, PlanResult), Problem> {
        let (_, mesh) = self.mesh.read()?;
        let stop = stop_on_interrupt();
        let bar = progress_bar(request);
        let pool = threads(self.threads)?;
        let result = pool.install(|| {
            let ask = || {
                stop.load(Ordering::Relaxed)
                    .then_some(Interrupted::Cancelled)
            };
            crate::run::plan(&mesh, request, Interrupt::new(&ask), &mut |progress| {
                show(&bar, progress);
            })
        });
        bar.finish_and_clear();
        Ok((mesh, result?))
    }

    fn draw(&self, file: &PictureFile, mesh: &Mesh, result: &PlanResult) -> Result<(), Problem> {
        let Some(grasp) = Chosen::Best.of(result) else {
            super::print_error(format_args!(
                "graspd: there is no grasp to draw, so no picture was written"
            ));
            return Ok(());
        };
        let options = GraspOptions {
            width: DEFAULT_WIDTH,
            background: Background::Transparent,
            view: Viewpoint::Both,
            legend: true,
        };
        let title = self.mesh.name();
        let drawn: Result<Vec<u8>, PictureError> = match file.is_svg {
            true => {
                picture::grasp_svg(mesh, result, &grasp, &title, &options).map(String::into_bytes)
            }
            false => picture::grasp_png(mesh, result, &grasp, &title, &options),
        };
        file.write(drawn)
    }

    fn print(&self, result: &PlanResult) -> io::Result<()> {
        let mut out = io::stdout().lock();
        if self.json {
            serde_json::to_writer(&mut out, result)?;
            if out.is_terminal() {
                writeln!(out)?;
            }
        } else {
            summary::write(&mut out, result)?;
            if plot::is_possible()
                && let Some(plot) = plot::convergence(result, plot::width())
            {
                write!(out, "\n{plot}")?;
            }
        }
        out.flush()
    }
}

/// A progress bar, which is drawn on standard error if that is a terminal.
fn progress_bar(request: &PlanRequest) -> ProgressBar {
    let style = ProgressStyle::with_template("{bar:30} {pos}/{len} generations {msg} {elapsed}")
        .unwrap_or_else(|_| ProgressStyle::default_bar());
    ProgressBar::new(request.generations.into()).with_style(style)
}

fn show(bar: &ProgressBar, progress: &Progress) {
    bar.set_position(progress.generation);
    let best = progress
        .best_quality
        .map_or("none yet".to_owned(), |quality| format!("{quality:.6}"));
    bar.set_message(format!("best {best}, {} evaluations", progress.evaluations));
}
