//! Files that a command writes in addition to its output.

use std::path::{Path, PathBuf};

use super::exit::input_problem;
use crate::picture::PictureError;
use crate::wire::Problem;

/// A file to draw into; the extension of its name determines the format.
#[derive(Debug, Clone)]
pub struct PictureFile {
    path: PathBuf,
    /// Whether the picture is an SVG, rather than a PNG.
    pub is_svg: bool,
}

impl PictureFile {
    /// Parses the value of a flag.
    pub fn parse(text: &str) -> Result<Self, String> {
        let path = PathBuf::from(text);
        let is = |kind: &str| {
            path.extension()
                .is_some_and(|found| found.eq_ignore_ascii_case(kind))
        };
        match (is("png"), is("svg")) {
            (false, false) => Err("the name must end in .png or .svg".to_owned()),
            (_, is_svg) => {
                let folder = path.parent().unwrap_or(Path::new(""));
                match folder.as_os_str().is_empty() || folder.is_dir() {
                    true => Ok(Self { path, is_svg }),
                    false => Err(format!("there is no folder {}", folder.display())),
                }
            }
        }
    }

    pub fn write(&self, bytes: Result<Vec<u8>, PictureError>) -> Result<(), Problem> {
        let bytes = bytes.map_err(|fault| input_problem(fault.to_string()))?;
        std::fs::write(&self.path, bytes).map_err(|fault| {
            let detail = format!("cannot write {}: {fault}", self.path.display());
            Problem::new(500, "unwritable", "No picture", detail)
        })
    }
}
