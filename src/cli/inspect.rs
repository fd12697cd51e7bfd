//! `graspd inspect`

use std::io::{self, IsTerminal, Write};
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use clap::Args;

use super::mesh::MeshFile;
use super::plan::{EXIT_INPUT, input_problem, tell};
use crate::core::mesh::Mesh;
use crate::picture::{self, Background, Options, PictureError};
use crate::run::figures;
use crate::wire::{MeshReport, Problem, Units};

/// Flags of `graspd inspect`.
#[derive(Args)]
#[command(
    after_help = "The picture has two opposite views, z up: from the front (-y), right and above, and from the \
    back, left and below. Border edges are red, non-manifold ones magenta, the inside of the surface is bluish, \
    and the disc in black and white quarters is the centre of mass.\n\n\
    Exit codes: 0 the mesh can be used; 1 it cannot, or a file cannot be written; 2 a flag cannot be used."
)]
pub struct Inspect {
    #[command(flatten)]
    mesh: MeshFile,

    /// Unit of the coordinates once they are scaled: m, cm, mm, um, in or ft; an odd size is then told
    #[arg(long, value_name = "UNIT", value_parser = units)]
    units: Option<Units>,

    /// Print the report as JSON, as the server has it
    #[arg(long)]
    json: bool,

    /// Draw the mesh: into a .png, or with its report into a .svg
    #[arg(long, value_name = "FILE", value_parser = Picture::parse)]
    picture: Option<Picture>,
}

impl Inspect {
    /// Reads, draws and prints.
    pub fn run(self) -> ExitCode {
        match self.inspect() {
            Ok(mesh) => match self.print(&mesh) {
                Ok(()) => ExitCode::SUCCESS,
                Err(fault) => super::unwritten(&fault),
            },
            Err(problem) => {
                tell(&problem);
                ExitCode::from(EXIT_INPUT)
            }
        }
    }

    fn inspect(&self) -> Result<Mesh, Problem> {
        let mesh = self.mesh.read()?;
        if let Some(picture) = &self.picture {
            picture.write(&mesh, self.units, &self.mesh.name())?;
        }
        Ok(mesh)
    }

    fn print(&self, mesh: &Mesh) -> io::Result<()> {
        let report = MeshReport::new(mesh.report(), self.units);
        let mut out = io::stdout().lock();
        if self.json {
            serde_json::to_writer(&mut out, &report)?;
            if out.is_terminal() {
                writeln!(out)?;
            }
        } else {
            for (name, value) in figures(mesh.report().format.map(Into::into), &report) {
                writeln!(out, "{name:<22} {value}")?;
            }
            for (n, warning) in report.warnings.iter().enumerate() {
                let space = if n == 0 { "\n" } else { "" };
                writeln!(out, "{space}warning: {}", warning.detail)?;
            }
        }
        out.flush()
    }
}

/// A file to draw into.
#[derive(Debug, Clone)]
struct Picture {
    path: PathBuf,
    with_report: bool,
}

impl Picture {
    fn parse(text: &str) -> Result<Self, String> {
        let path = PathBuf::from(text);
        let is = |kind: &str| {
            path.extension()
                .is_some_and(|found| found.eq_ignore_ascii_case(kind))
        };
        match (is("png"), is("svg")) {
            (false, false) => Err("the name has to end in .png or .svg".to_owned()),
            (_, with_report) => Ok(Self { path, with_report }),
        }
    }

    fn write(&self, mesh: &Mesh, units: Option<Units>, title: &str) -> Result<(), Problem> {
        let bytes = self.bytes(mesh, units, title);
        let bytes = bytes.map_err(|fault| input_problem(fault.to_string()))?;
        write(&self.path, &bytes)
    }

    fn bytes(
        &self,
        mesh: &Mesh,
        units: Option<Units>,
        title: &str,
    ) -> Result<Vec<u8>, PictureError> {
        if self.with_report {
            let background = Background::Transparent;
            let options = Options {
                background,
                ..Options::default()
            };
            picture::sheet(mesh, units, title, &options).map(String::into_bytes)
        } else {
            picture::preview(mesh, &Options::default())
        }
    }
}

fn write(path: &Path, bytes: &[u8]) -> Result<(), Problem> {
    std::fs::write(path, bytes).map_err(|fault| {
        let detail = format!("cannot write {}: {fault}", path.display());
        Problem::new(500, "unwritable", "No picture", detail)
    })
}

fn units(text: &str) -> Result<Units, String> {
    Units::named(text).ok_or_else(|| format!("{} is wanted", Units::NAMES))
}
