//! File formats of meshes, by name.

use std::fmt;

/// A supported file format.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Format {
    /// Stereolithography, binary or ASCII.
    Stl,
    /// Wavefront OBJ; geometry only, materials are never opened.
    Obj,
    /// Polygon file format, ASCII or binary of either endianness.
    Ply,
    /// Geomview's object file format, as text.
    Off,
    /// glTF 2.0 in one binary file.
    Glb,
    /// glTF 2.0 as JSON, with its buffers inside.
    Gltf,
}

impl Format {
    /// Every supported format.
    pub const ALL: [Self; 6] = [
        Self::Stl,
        Self::Obj,
        Self::Ply,
        Self::Off,
        Self::Glb,
        Self::Gltf,
    ];

    /// The lower-case name, which is also the usual file extension.
    pub fn name(self) -> &'static str {
        match self {
            Self::Stl => "stl",
            Self::Obj => "obj",
            Self::Ply => "ply",
            Self::Off => "off",
            Self::Glb => "glb",
            Self::Gltf => "gltf",
        }
    }

    /// The format of that name in any case, or `None`.
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL
            .into_iter()
            .find(|format| format.name().eq_ignore_ascii_case(name))
    }
}

impl fmt::Display for Format {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Stl => "STL",
            Self::Obj => "OBJ",
            Self::Ply => "PLY",
            Self::Off => "OFF",
            Self::Glb => "GLB",
            Self::Gltf => "glTF",
        })
    }
}
