//! `graspd inspect`

use std::io::{self, IsTerminal, Write};
use std::process::ExitCode;

use clap::Args;

use super::exit::{EXIT_INPUT, report_problem};
use super::mesh::MeshFile;
use super::output::PictureFile;
use crate::picture::{self, Background, Options, PictureError};
use crate::run::{figures, mesh_report};
use crate::wire::{Problem, Units};
use graspd_core::mesh::Mesh;
use graspd_mesh_io::MeshFormat;

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

    /// Unit of the scaled coordinates: m, cm, mm, um, in or ft; implausible sizes are then reported
    #[arg(long, value_name = "UNIT", value_parser = units)]
    units: Option<Units>,

    /// Print the report as JSON, as the server sends it
    #[arg(long)]
    json: bool,

    /// Draw the mesh into a .png, or with its report into a .svg
    #[arg(long, value_name = "FILE", value_parser = PictureFile::parse)]
    picture: Option<PictureFile>,
}

impl Inspect {
    /// Reads the mesh, draws it, prints the report and returns the exit code.
    pub fn run(self) -> ExitCode {
        match self.inspect() {
            Ok((format, mesh)) => match self.print(format, &mesh) {
                Ok(()) => ExitCode::SUCCESS,
                Err(fault) => super::cannot_print(&fault),
            },
            Err(problem) => {
                report_problem(&problem);
                ExitCode::from(EXIT_INPUT)
            }
        }
    }

    fn inspect(&self) -> Result<(MeshFormat, Mesh), Problem> {
        let (format, mesh) = self.mesh.read()?;
        if let Some(picture) = &self.picture {
            picture.write(self.draw(format, &mesh, picture.is_svg))?;
        }
        Ok((format, mesh))
    }

    fn draw(
        &self,
        format: MeshFormat,
        mesh: &Mesh,
        with_report: bool,
    ) -> Result<Vec<u8>, PictureError> {
        match with_report {
            true => {
                let background = Background::Transparent;
                let options = Options {
                    background,
                    ..Options::default()
                };
                let sheet = picture::sheet(mesh, format, self.units, &self.mesh.name(), &options);
                sheet.map(String::into_bytes)
            }
            false => picture::preview(mesh, &Options::default()),
        }
    }

    fn print(&self, format: MeshFormat, mesh: &Mesh) -> io::Result<()> {
        let report = mesh_report(mesh, self.units);
        let mut out = io::stdout().lock();
        if self.json {
            serde_json::to_writer(&mut out, &report)?;
            if out.is_terminal() {
                writeln!(out)?;
            }
        } else {
            for (name, value) in figures(format, &report) {
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

fn units(text: &str) -> Result<Units, String> {
    Units::named(text).ok_or_else(|| format!("must be {}", Units::NAMES))
}
