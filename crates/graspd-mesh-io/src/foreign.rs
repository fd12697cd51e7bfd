//! Files that are often sent instead of a mesh, so that the refusal can name them and say what to do.
//!
//! Each is recognised by its first bytes, XML by its root element. None of these begins a mesh file of a supported
//! format, except that the free header of a binary STL file may begin with anything.

use super::xml;

/// A kind of file that is no mesh.
pub(super) struct Kind {
    /// With its article, as a message has it.
    pub(super) name: &'static str,
    pub(super) advice: &'static str,
}

const fn named(name: &'static str, advice: &'static str) -> Kind {
    Kind { name, advice }
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
static KINDS: [(&[&[u8]], Kind); 31] = [
    (
        &[b"version https://git-lfs.github.com/spec/"],
        named(
            "a Git LFS pointer",
            "the mesh itself is elsewhere; fetch it with `git lfs pull` and send that",
        ),
    ),
    (&[b"ISO-10303-21"], named("a STEP file", CAD)),
    (
        &[b"DBRep_DrawableShape", b"CASCADE Topology"],
        named("an Open CASCADE BREP file", CAD),
    ),
    (
        &[b"**ABCDEFGHIJKLMNOPQRSTUVWXYZ"],
        named("a Parasolid file", CAD),
    ),
    (&[b"ACIS BinaryFile"], named("an ACIS file", CAD)),
    (
        &[
            b"AC1015", b"AC1018", b"AC1021", b"AC1024", b"AC1027", b"AC1032",
        ],
        named("a DWG drawing", CAD),
    ),
    (
        &[b"\xD0\xCF\x11\xE0\xA1\xB1\x1A\xE1"],
        named("a file of a CAD or office program", CAD),
    ),
    (&[b"#usda ", b"PXR-USDC"], named("a USD file", USD)),
    (
        &[b"Kaydara FBX Binary", b"; FBX "],
        named("an FBX file", SCENE),
    ),
    (&[b"BLENDER"], named("a Blender file", SCENE)),
    (&[b"#VRML "], named("a VRML file", SCENE)),
    (&[b"# vtk DataFile"], named("a VTK file", SCENE)),
    (
        &[b"$MeshFormat"],
        named("a Gmsh mesh", "export its surface as STL"),
    ),
    (
        &[b"DRACO"],
        named(
            "a file compressed with Draco",
            "decode it, as with draco_decoder, and send the PLY or OBJ file",
        ),
    ),
    (
        &[b"# .PCD ", b"VERSION .7\n", b"VERSION 0.7\n"],
        named("a PCD point cloud", POINTS),
    ),
    (&[b"LASF"], named("a LAS point cloud", POINTS)),
    (&[b"ASTM-E57"], named("an E57 point cloud", POINTS)),
    (
        &[b"\x93NUMPY"],
        named(
            "a NumPy array",
            "write the mesh as PLY or STL, as with trimesh",
        ),
    ),
    (
        &[b"\x89HDF\r\n"],
        named(
            "an HDF5 file",
            "write the mesh as PLY or STL, as with trimesh",
        ),
    ),
    (&[b"\x1F\x8B\x08"], named("a gzip archive", UNPACK)),
    (&[b"BZh91AY&SY"], named("a bzip2 archive", UNPACK)),
    (&[b"\xFD7zXZ\0"], named("an xz archive", UNPACK)),
    (&[b"\x28\xB5\x2F\xFD"], named("a Zstandard archive", UNPACK)),
    (&[b"7z\xBC\xAF\x27\x1C"], named("a 7z archive", UNPACK)),
    (&[b"Rar!\x1A\x07"], named("a RAR archive", UNPACK)),
    (&[b"\x89PNG"], named("a PNG image", NOTHING)),
    (&[b"\xFF\xD8\xFF"], named("a JPEG image", NOTHING)),
    (&[b"GIF87a", b"GIF89a"], named("a GIF image", NOTHING)),
    (&[b"%PDF-"], named("a PDF document", NOTHING)),
    (&[b"RIFF"], named("a sound, a video or an image", NOTHING)),
    (&[b"\x7FELF", b"MZ\x90\0"], named("a program", NOTHING)),
];

/// Recognised by the section letter and the line number in the last columns of its first line.
static IGES: Kind = named("an IGES file", CAD);

/// XML documents by their root element.
static ROOTS: [(&[u8], Kind); 8] = [
    (b"robot", named("a URDF description of a robot", ROBOT)),
    (
        b"sdf",
        named("an SDF description of a robot or a world", ROBOT),
    ),
    (b"mujoco", named("a MuJoCo model", ROBOT)),
    (
        b"amf",
        named("an AMF file", "export the body as 3MF or STL"),
    ),
    (b"X3D", named("an X3D file", SCENE)),
    (b"VTKFile", named("a VTK file", SCENE)),
    (b"svg", named("an SVG drawing", NOTHING)),
    (
        b"html",
        named(
            "a web page",
            "a download may have needed a login; fetch the file itself",
        ),
    ),
];

/// The kind of a file that is no mesh, or `None` when its first bytes are of none that is known.
pub(super) fn kind(bytes: &[u8]) -> Option<&'static Kind> {
    let text = bytes
        .strip_prefix(b"\xEF\xBB\xBF")
        .unwrap_or(bytes)
        .trim_ascii_start();
    let begins = |word: &&[u8]| bytes.starts_with(word) || text.starts_with(word);
    let mut kinds = KINDS.iter();
    let found = kinds.find(|(words, _)| words.iter().any(begins));
    let found = found
        .map(|(_, kind)| kind)
        .or_else(|| (bytes.get(72..80)? == b"S      1").then_some(&IGES));
    found.or_else(|| {
        let root = xml::root(text)?;
        let mut roots = ROOTS.iter();
        roots
            .find(|(name, _)| root.eq_ignore_ascii_case(name))
            .map(|(_, kind)| kind)
    })
}
