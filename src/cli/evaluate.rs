//! `graspd evaluate`

use std::io::{self, IsTerminal, Read, Write};
use std::path::PathBuf;
use std::process::ExitCode;
use std::sync::atomic::Ordering;

use clap::Args;
use serde_json::Value;

use super::exit::{EXIT_INPUT, EXIT_NO_GRASP, EXIT_USAGE, input_problem, report_problem};
use super::mesh::MeshFile;
use super::settings::{QualityFlags, flag};
use super::summary;
use super::work::{stop_on_interrupt, threads};
use crate::run::EvaluationFault;
use crate::wire::settings::SETTINGS;
use crate::wire::{
    EvaluationRequest, Evaluations, FieldError, MAX_EVALUATION_BYTES, Problem, json,
};
use graspd_core::{Interrupt, Interrupted};

/// Flags of `graspd evaluate`.
#[derive(Args)]
#[command(
    after_help = "GRASPS is a list of grasps, or an object with that list as `grasps` and with settings, or the \
    output of `graspd plan --json`, of which only the contacts are used. A grasp is a list of contacts: \
    {\"triangle\": 17}, {\"point\": [x, y, z]}, which is projected to the surface, or \
    {\"point\": [x, y, z], \"normal\": [x, y, z]} with the normal into the body.\n\n\
    Exit codes: 0 all grasps are force closure; 1 the mesh or the grasps cannot be used; 2 a flag cannot be \
    used; 3 a grasp is not force closure."
)]
pub struct Evaluate {
    #[command(flatten)]
    mesh: MeshFile,

    /// JSON file with the grasps; - reads standard input
    grasps: PathBuf,

    /// Print the evaluations as JSON, as the server would send them
    #[arg(long)]
    json: bool,

    /// Threads to evaluate with [default: all processors]
    #[arg(long, value_name = "COUNT", value_parser = clap::value_parser!(u16).range(1..=1024))]
    threads: Option<u16>,

    #[command(flatten)]
    settings: QualityFlags,
}

impl Evaluate {
    /// Evaluates the grasps, prints the evaluations and returns the exit code.
    pub fn run(self) -> ExitCode {
        let request = match self.request() {
            Ok(request) => request,
            Err(problem) => {
                report_problem(&problem);
                return ExitCode::from(EXIT_INPUT);
            }
        };
        let request = match request {
            Ok(request) => request,
            Err(faults) => return refuse(&faults),
        };
        match self.evaluate(&request) {
            Ok(found) => match self.print(&found) {
                Ok(()) if found.evaluations.iter().all(|grasp| grasp.force_closure) => {
                    ExitCode::SUCCESS
                }
                Ok(()) => ExitCode::from(EXIT_NO_GRASP),
                Err(fault) => super::cannot_print(&fault),
            },
            Err(problem) => {
                report_problem(&problem);
                ExitCode::from(EXIT_INPUT)
            }
        }
    }

    /// Combines the file and the flags into a request; a flag overrides the file.
    fn request(&self) -> Result<Result<EvaluationRequest, Vec<FieldError>>, Problem> {
        let bytes = self.read_grasps()?;
        let mut value = match json::read_up_to(&bytes, MAX_EVALUATION_BYTES)? {
            Value::Array(grasps) => serde_json::json!({ "grasps": grasps }),
            Value::Object(result) if result.get("contacts") == Some(&serde_json::json!([])) => {
                let detail = "this plan has no contacts: no grasp was found";
                return Err(input_problem(detail.to_owned()));
            }
            Value::Object(result) if result.contains_key("contacts") => {
                serde_json::json!({ "grasps": [planned(&result["contacts"])] })
            }
            other => other,
        };
        if let Value::Object(object) = &mut value {
            match self.settings.object() {
                Ok(given) => object.extend(given),
                Err(fault) => return Ok(Err(vec![fault])),
            }
        }
        Ok(EvaluationRequest::from_json(&value))
    }

    fn read_grasps(&self) -> Result<Vec<u8>, Problem> {
        let limit = MAX_EVALUATION_BYTES as u64 + 1;
        let mut bytes = Vec::new();
        let read = if self.grasps.as_os_str() == "-" {
            io::stdin().lock().take(limit).read_to_end(&mut bytes)
        } else {
            std::fs::File::open(&self.grasps)
                .and_then(|file| file.take(limit).read_to_end(&mut bytes))
        };
        read.map_err(|fault| {
            input_problem(format!("cannot read {}: {fault}", self.grasps.display()))
        })?;
        Ok(bytes)
    }

    fn evaluate(&self, request: &EvaluationRequest) -> Result<Evaluations, Problem> {
        let (_, mesh) = self.mesh.read()?;
        let stop = stop_on_interrupt();
        let ask = || {
            stop.load(Ordering::Relaxed)
                .then_some(Interrupted::Cancelled)
        };
        let found = threads(self.threads)?
            .install(|| crate::run::evaluate(&mesh, request, Interrupt::new(&ask)));
        found.map_err(|fault| match fault {
            EvaluationFault::Problem(problem) => problem,
            EvaluationFault::Interrupted(_) => input_problem("interrupted".to_owned()),
        })
    }

    fn print(&self, found: &Evaluations) -> io::Result<()> {
        let mut out = io::stdout().lock();
        if self.json {
            serde_json::to_writer(&mut out, found)?;
            if out.is_terminal() {
                writeln!(out)?;
            }
        } else {
            summary::write_evaluations(&mut out, found)?;
        }
        out.flush()
    }
}

/// Converts the contacts of a planning result. A contact at the centroid of its triangle is given by the triangle; a fixed
/// or polished one by its position and normal.
fn planned(contacts: &Value) -> Vec<Value> {
    let contacts = contacts.as_array().into_iter().flatten();
    contacts
        .map(|contact| {
            let shares = contact["barycentric"].as_array();
            let slid = shares.is_some_and(|shares| shares.iter().any(|share| *share != shares[0]));
            if slid || contact["fixed"] == Value::Bool(true) {
                serde_json::json!({ "point": contact["position"], "normal": contact["normal"] })
            } else {
                serde_json::json!({ "triangle": contact["triangle"] })
            }
        })
        .collect()
}

/// Prints the faults: those of a setting by its flag, others by their place in the file.
fn refuse(faults: &[FieldError]) -> ExitCode {
    let mut code = EXIT_USAGE;
    for FieldError { pointer, detail } in faults {
        let name = pointer.trim_start_matches('/');
        let field = name.split('/').next().unwrap_or_default();
        if SETTINGS.iter().any(|setting| setting.name == field) {
            super::print_error(format_args!("graspd: --{}: {detail}", flag(name)));
        } else {
            code = EXIT_INPUT;
            super::print_error(format_args!("graspd: {pointer}: {detail}"));
        }
    }
    ExitCode::from(code)
}
