//! Files that are no mesh are named.

use super::*;

#[test]
fn what_is_sent_in_the_place_of_a_mesh_is_named_with_what_to_do() {
    let iges = format!("{:<72}S      1\n", "a part");
    for (bytes, name, advice) in [
        (
            "version https://git-lfs.github.com/spec/v1\noid sha256:46\nsize 184484\n",
            "Git LFS",
            "git lfs pull",
        ),
        ("ISO-10303-21;\nHEADER;\n", "a STEP file", "as STL"),
        (&iges, "an IGES file", "as STL"),
        ("#usda 1.0\n(\n)\n", "a USD file", "GLB"),
        ("PXR-USDC\0\0\0", "a USD file", "GLB"),
        (
            "# .PCD v0.7 - Point Cloud Data\nVERSION 0.7\n",
            "a PCD point cloud",
            "surface",
        ),
        ("VERSION .7\nFIELDS x y z\n", "a PCD point cloud", "surface"),
        (
            "<?xml version=\"1.0\"?>\n<!-- made > by -->\n<robot name=\"arm\"/>",
            "a URDF",
            "of the one body",
        ),
        ("<sdf version='1.7'></sdf>", "an SDF", "of the one body"),
        (
            "<!DOCTYPE html>\n<html><body>Sign in</body></html>",
            "a web page",
            "login",
        ),
        (
            "<svg:svg xmlns:svg=\"a\"></svg:svg>",
            "an SVG",
            "no surface",
        ),
        ("\u{FEFF}<x3d/>", "an X3D file", "GLB"),
        ("; FBX 7.7.0 project file\n", "an FBX file", "GLB"),
        ("\u{1f}\u{8b}", "matches none", "STL"),
    ] {
        let text = not_a_mesh(bytes);
        assert!(text.contains(name) && text.contains(advice), "{text}");
        let error = read(bytes.as_bytes(), Some(MeshFormat::Stl), &LIMITS).unwrap_err();
        let said = error.to_string();
        assert!(matches!(error, ReadError::NotAMesh { .. }), "{said}");
        assert!(said.contains(name) || name == "matches none", "{said}");
    }
    let gzip = b"\x1F\x8B\x08\0\0\0\0\0";
    assert!(not_a_mesh(gzip).contains("a gzip archive: unpack it"));
}

#[test]
fn the_header_of_binary_stl_may_name_anything() {
    for header in [
        "ISO-10303-21;",
        "%PDF-",
        "<html>",
        "PXR-USDC",
        "version https://git-lfs.github.com/spec/v1",
    ] {
        assert_eq!(
            good(stl_binary(&cube(1.0), header)).1.triangles.len(),
            12,
            "{header}"
        );
    }
}
