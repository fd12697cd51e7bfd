//! Files that are often sent in the place of a mesh, so that the refusal can name them and say what to do.
//!
//! Each is recognised by its first bytes, XML by its root element. None of these begins a mesh file of a supported
//! format, except that the free header of a binary STL file may begin with anything.

use super::xml;

/// A kind of file that is no mesh.
pub(super) struct Kind {
    /// With its article, as a message has it.
    pub(super) name: &'static str,
    pub(super) advice: &'static str,
    begins: &'static [&'static [u8]],
}

const CAD: &str = "it describes exact surfaces; export the body from the CAD program as STL or 3MF";
const ROBOT: &str =
    "it refers to mesh files by name; send the mesh file of the one body to be grasped";
const USD: &str = "export the body as GLB, as from Blender or usdview";
const UNPACK: &str = "unpack it and send the mesh file in it";
const POINTS: &str = "it holds points without a surface; reconstruct the surface, as with Open3D or MeshLab, and send that";
const SCENE: &str = "export the body as GLB or OBJ from the program that it was made with";
const NOTHING: &str = "it holds no surface";

/// Kinds that begin with one of a few fixed words, leading white space and a byte-order mark aside.
static KINDS: [Kind; 31] = [
    Kind {
        name: "a Git LFS pointer",
        advice: "the mesh itself is elsewhere; fetch it with `git lfs pull` and send that",
        begins: &[b"version https://git-lfs.github.com/spec/"],
    },
    Kind {
        name: "a STEP file",
        advice: CAD,
        begins: &[b"ISO-10303-21"],
    },
    Kind {
        name: "an Open CASCADE BREP file",
        advice: CAD,
        begins: &[b"DBRep_DrawableShape", b"CASCADE Topology"],
    },
    Kind {
        name: "a Parasolid file",
        advice: CAD,
        begins: &[b"**ABCDEFGHIJKLMNOPQRSTUVWXYZ"],
    },
    Kind {
        name: "an ACIS file",
        advice: CAD,
        begins: &[b"ACIS BinaryFile"],
    },
    Kind {
        name: "a DWG drawing",
        advice: CAD,
        begins: &[
            b"AC1015", b"AC1018", b"AC1021", b"AC1024", b"AC1027", b"AC1032",
        ],
    },
    Kind {
        name: "a file of a CAD or office program",
        advice: CAD,
        begins: &[b"\xD0\xCF\x11\xE0\xA1\xB1\x1A\xE1"],
    },
    Kind {
        name: "a USD file",
        advice: USD,
        begins: &[b"#usda ", b"PXR-USDC"],
    },
    Kind {
        name: "an FBX file",
        advice: SCENE,
        begins: &[b"Kaydara FBX Binary", b"; FBX "],
    },
    Kind {
        name: "a Blender file",
        advice: SCENE,
        begins: &[b"BLENDER"],
    },
    Kind {
        name: "a VRML file",
        advice: SCENE,
        begins: &[b"#VRML "],
    },
    Kind {
        name: "a VTK file",
        advice: SCENE,
        begins: &[b"# vtk DataFile"],
    },
    Kind {
        name: "a Gmsh mesh",
        advice: "export its surface as STL",
        begins: &[b"$MeshFormat"],
    },
    Kind {
        name: "a file compressed with Draco",
        advice: "decode it, as with draco_decoder, and send the PLY or OBJ file",
        begins: &[b"DRACO"],
    },
    Kind {
        name: "a PCD point cloud",
        advice: POINTS,
        begins: &[b"# .PCD ", b"VERSION .7\n", b"VERSION 0.7\n"],
    },
    Kind {
        name: "a LAS point cloud",
        advice: POINTS,
        begins: &[b"LASF"],
    },
    Kind {
        name: "an E57 point cloud",
        advice: POINTS,
        begins: &[b"ASTM-E57"],
    },
    Kind {
        name: "a NumPy array",
        advice: "write the mesh as PLY or STL, as with trimesh",
        begins: &[b"\x93NUMPY"],
    },
    Kind {
        name: "an HDF5 file",
        advice: "write the mesh as PLY or STL, as with trimesh",
        begins: &[b"\x89HDF\r\n"],
    },
    Kind {
        name: "a gzip archive",
        advice: UNPACK,
        begins: &[b"\x1F\x8B\x08"],
    },
    Kind {
        name: "a bzip2 archive",
        advice: UNPACK,
        begins: &[b"BZh91AY&SY"],
    },
    Kind {
        name: "an xz archive",
        advice: UNPACK,
        begins: &[b"\xFD7zXZ\0"],
    },
    Kind {
        name: "a Zstandard archive",
        advice: UNPACK,
        begins: &[b"\x28\xB5\x2F\xFD"],
    },
    Kind {
        name: "a 7z archive",
        advice: UNPACK,
        begins: &[b"7z\xBC\xAF\x27\x1C"],
    },
    Kind {
        name: "a RAR archive",
        advice: UNPACK,
        begins: &[b"Rar!\x1A\x07"],
    },
    Kind {
        name: "a PNG image",
        advice: NOTHING,
        begins: &[b"\x89PNG"],
    },
    Kind {
        name: "a JPEG image",
        advice: NOTHING,
        begins: &[b"\xFF\xD8\xFF"],
    },
    Kind {
        name: "a GIF image",
        advice: NOTHING,
        begins: &[b"GIF87a", b"GIF89a"],
    },
    Kind {
        name: "a PDF document",
        advice: NOTHING,
        begins: &[b"%PDF-"],
    },
    Kind {
        name: "a sound, a video or an image",
        advice: NOTHING,
        begins: &[b"RIFF"],
    },
    Kind {
        name: "a program",
        advice: NOTHING,
        begins: &[b"\x7FELF", b"MZ\x90\0"],
    },
];

/// Recognised by the section letter and the line number in the last columns of its first line.
static IGES: Kind = Kind {
    name: "an IGES file",
    advice: CAD,
    begins: &[],
};

/// XML documents by their root element.
static ROOTS: [(&[u8], Kind); 8] = [
    (
        b"robot",
        Kind {
            name: "a URDF description of a robot",
            advice: ROBOT,
            begins: &[],
        },
    ),
    (
        b"sdf",
        Kind {
            name: "an SDF description of a robot or a world",
            advice: ROBOT,
            begins: &[],
        },
    ),
    (
        b"mujoco",
        Kind {
            name: "a MuJoCo model",
            advice: ROBOT,
            begins: &[],
        },
    ),
    (
        b"amf",
        Kind {
            name: "an AMF file",
            advice: "export the body as 3MF or STL",
            begins: &[],
        },
    ),
    (
        b"X3D",
        Kind {
            name: "an X3D file",
            advice: SCENE,
            begins: &[],
        },
    ),
    (
        b"VTKFile",
        Kind {
            name: "a VTK file",
            advice: SCENE,
            begins: &[],
        },
    ),
    (
        b"svg",
        Kind {
            name: "an SVG drawing",
            advice: NOTHING,
            begins: &[],
        },
    ),
    (
        b"html",
        Kind {
            name: "a web page",
            advice: "a download may have needed a login; fetch the file itself",
            begins: &[],
        },
    ),
];

/// The kind of a file that is no mesh, or `None` when its first bytes are of none that is known.
pub(super) fn kind(bytes: &[u8]) -> Option<&'static Kind> {
    let text = bytes
        .strip_prefix(b"\xEF\xBB\xBF")
        .unwrap_or(bytes)
        .trim_ascii_start();
    let mut kinds = KINDS.iter();
    let found = kinds.find(|kind| {
        kind.begins
            .iter()
            .any(|&word| bytes.starts_with(word) || text.starts_with(word))
    });
    let found = found.or_else(|| (bytes.get(72..80)? == b"S      1").then_some(&IGES));
    found.or_else(|| {
        let root = xml::root(text)?;
        let mut roots = ROOTS.iter();
        roots
            .find(|(name, _)| root.eq_ignore_ascii_case(name))
            .map(|(_, kind)| kind)
    })
}
