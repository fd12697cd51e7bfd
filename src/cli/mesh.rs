//! The mesh that a command works on.

use std::path::PathBuf;

use clap::Args;

use super::exit::input_problem;
use crate::wire::{MeshOptions, Problem};
use graspd_core::mesh::Mesh;
use graspd_mesh_io::{Limits, MeshFormat};

/// A mesh file and how it is to be read.
#[derive(Args, Clone)]
pub struct MeshFile {
    /// Mesh file: STL, OBJ, PLY, OFF, GLB, glTF, 3MF or COLLADA
    mesh: PathBuf,

    #[command(flatten)]
    options: FileOptions,
}

/// How a mesh file is to be read.
#[derive(Args, Clone, Copy)]
pub struct FileOptions {
    /// Format of the file [default: recognised by its content]
    #[arg(long, value_name = "FORMAT", value_parser = format)]
    pub format: Option<MeshFormat>,

    /// Factor by which the coordinates of the file are multiplied, 1e-9 to 1e9
    #[arg(long, value_name = "FACTOR", default_value_t = 1.0, value_parser = scale)]
    pub scale: f64,
}

impl MeshFile {
    /// The name of the file, for display.
    pub fn name(&self) -> String {
        let name = self.mesh.file_name().unwrap_or(self.mesh.as_os_str());
        name.to_string_lossy().into_owned()
    }

    /// Reads and prepares the mesh, and returns it with its format.
    pub fn read(&self) -> Result<(MeshFormat, Mesh), Problem> {
        let bytes = std::fs::read(&self.mesh).map_err(|fault| {
            input_problem(format!("cannot read {}: {fault}", self.mesh.display()))
        })?;
        let options = MeshOptions {
            format: self.options.format,
            units: None,
            scale: self.options.scale,
        };
        prepared(&bytes, &options)
    }
}

/// Prepares the mesh in the bytes of a file. The user works on their own file and memory, so there are no limits.
pub fn prepared(bytes: &[u8], options: &MeshOptions) -> Result<(MeshFormat, Mesh), Problem> {
    let (format, mut raw) = graspd_mesh_io::read(bytes, options.format, &Limits::NONE)
        .map_err(|fault| input_problem(fault.to_string()))?;
    raw.scale(options.scale);
    let mesh = Mesh::prepare(raw).map_err(|fault| input_problem(fault.to_string()))?;
    Ok((format, mesh))
}

fn format(text: &str) -> Result<MeshFormat, String> {
    MeshFormat::from_name(text).ok_or_else(|| format!("must be {}", MeshFormat::NAMES))
}

fn scale(text: &str) -> Result<f64, String> {
    MeshOptions::scale_of(text).ok_or_else(|| format!("must be {}", MeshOptions::SCALES))
}
