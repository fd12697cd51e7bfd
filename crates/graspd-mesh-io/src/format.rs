//! The formats of mesh files: their names and media types.

use std::fmt;

use serde::{Deserialize, Serialize};

/// A supported file format.
// The first line is also the description of the schema, whose users do not know this crate.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(utoipa::ToSchema))]
#[serde(rename_all = "lowercase")]
pub enum MeshFormat {
    Stl,
    Obj,
    Ply,
    Off,
    Glb,
    Gltf,
    #[serde(rename = "3mf")]
    ThreeMf,
    Dae,
}

/// What people and programs call a format.
struct Description {
    /// Lower case; also the usual file extension.
    name: &'static str,
    /// As people write it.
    title: &'static str,
    /// Lower case, the preferred one first.
    media_types: &'static [&'static str],
}

impl MeshFormat {
    /// Every supported format.
    pub const ALL: [Self; 8] = [
        Self::Stl,
        Self::Obj,
        Self::Ply,
        Self::Off,
        Self::Glb,
        Self::Gltf,
        Self::ThreeMf,
        Self::Dae,
    ];

    /// The names of all formats, as a message lists them.
    pub const NAMES: &str = "stl, obj, ply, off, glb, gltf, 3mf or dae";

    /// The titles of all formats, as a message lists them.
    pub const TITLES: &str = "STL, OBJ, PLY, OFF, GLB, glTF, 3MF or COLLADA";

    const fn description(self) -> Description {
        match self {
            Self::Stl => Description {
                name: "stl",
                title: "STL",
                media_types: &[
                    "model/stl",
                    "model/x.stl-binary",
                    "model/x.stl-ascii",
                    "application/sla",
                    "application/vnd.ms-pki.stl",
                ],
            },
            Self::Obj => Description {
                name: "obj",
                title: "OBJ",
                media_types: &["model/obj", "text/prs.wavefront-obj"],
            },
            Self::Ply => Description {
                name: "ply",
                title: "PLY",
                media_types: &["model/ply", "application/ply"],
            },
            Self::Off => Description {
                name: "off",
                title: "OFF",
                media_types: &["model/vnd.off", "model/off", "application/off"],
            },
            Self::Glb => Description {
                name: "glb",
                title: "GLB",
                media_types: &["model/gltf-binary"],
            },
            Self::Gltf => Description {
                name: "gltf",
                title: "glTF",
                media_types: &["model/gltf+json"],
            },
            Self::ThreeMf => Description {
                name: "3mf",
                title: "3MF",
                media_types: &[
                    "model/3mf",
                    "application/vnd.ms-package.3dmanufacturing-3dmodel+xml",
                ],
            },
            Self::Dae => Description {
                name: "dae",
                title: "COLLADA",
                media_types: &["model/vnd.collada+xml"],
            },
        }
    }

    /// The lower-case name, which is also the usual file extension.
    pub const fn name(self) -> &'static str {
        self.description().name
    }

    /// The preferred media type of its files.
    pub const fn media_type(self) -> &'static str {
        self.description().media_types[0]
    }

    /// The format with that name or title in any case, or `None`.
    ///
    /// ```
    /// # use graspd_mesh_io::MeshFormat;
    /// assert_eq!(MeshFormat::from_name("STL"), Some(MeshFormat::Stl));
    /// assert_eq!(MeshFormat::from_name("step"), None);
    /// ```
    pub fn from_name(name: &str) -> Option<Self> {
        let mut all = Self::ALL.into_iter();
        all.find(|format| {
            let Description {
                name: own, title, ..
            } = format.description();
            own.eq_ignore_ascii_case(name) || title.eq_ignore_ascii_case(name)
        })
    }

    /// The format that a media type in lower case, without parameters, stands for, or `None`.
    ///
    /// ```
    /// # use graspd_mesh_io::MeshFormat;
    /// assert_eq!(MeshFormat::from_media_type("application/sla"), Some(MeshFormat::Stl));
    /// ```
    pub fn from_media_type(media_type: &str) -> Option<Self> {
        let mut all = Self::ALL.into_iter();
        all.find(|format| format.description().media_types.contains(&media_type))
    }
}

impl fmt::Display for MeshFormat {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.description().title)
    }
}
