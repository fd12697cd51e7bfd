//! `graspd inspect`

use std::io::{self, IsTerminal, Write};
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use clap::Args;

use super::plan::{EXIT_INPUT, input_problem, read_mesh, tell};
use crate::core::mesh::Mesh;
use crate::picture::{self, Background, Options, PictureError};
use crate::run::{figures, warnings};
use crate::wire::{MeshReport, Problem};

/// Flags of `graspd inspect`.
#[derive(Args)]
#[command(
    after_help = "The picture has two opposite views, z up: from the front (-y), right and above, and from the \
    back, left and below. Border edges are red, non-manifold ones magenta, the inside of the surface is bluish, \
    and the disc in black and white quarters is the centre of mass.\n\n\
    Exit codes: 0 the mesh can be used; 1 it cannot, or a file cannot be written; 2 a flag cannot be used."
)]
pub struct Inspect {
    /// Mesh file: STL, OBJ or PLY
    mesh: PathBuf,

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
        let mesh = read_mesh(&self.mesh)?;
        if let Some(picture) = &self.picture {
            let title = self.mesh.file_name().unwrap_or(self.mesh.as_os_str());
            picture.write(&mesh, &title.to_string_lossy())?;
        }
        Ok(mesh)
    }

    fn print(&self, mesh: &Mesh) -> io::Result<()> {
        let report = MeshReport::from(mesh.report());
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
            for (n, sentence) in warnings(&report).iter().enumerate() {
                let space = if n == 0 { "\n" } else { "" };
                writeln!(out, "{space}{sentence}")?;
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

    fn write(&self, mesh: &Mesh, title: &str) -> Result<(), Problem> {
        let bytes = self.bytes(mesh, title);
        let bytes = bytes.map_err(|fault| input_problem(fault.to_string()))?;
        write(&self.path, &bytes)
    }

    fn bytes(&self, mesh: &Mesh, title: &str) -> Result<Vec<u8>, PictureError> {
        if self.with_report {
            let background = Background::Transparent;
            let options = Options {
                background,
                ..Options::default()
            };
            picture::sheet(mesh, title, &options).map(String::into_bytes)
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
