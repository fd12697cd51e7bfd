//! Files that are broken, hostile or no meshes: each is refused with its cause and place, and the server lives.

use crate::common::{Server, problem, server, small_box};

const OBJ: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n";
const OFF: &str = "OFF\n4 4 6\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n3 0 2 1\n3 0 1 3\n3 0 3 2\n3 1 2 3\n";
const PLY: &str = "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\n\
    property float z\nelement face 4\nproperty list uchar int vertex_indices\nend_header\n\
    0 0 0\n1 0 0\n0 1 0\n0 0 1\n3 0 2 1\n3 0 1 3\n3 0 3 2\n3 1 2 3\n";
const STL: &str = "solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\n\
    endloop\nendfacet\nendsolid a\n";
const DOCUMENT: &str = r#"{"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0]}],"nodes":[{"mesh":0}],
    "meshes":[{"primitives":[{"attributes":{"POSITION":0},"indices":1}]}],
    "accessors":[{"bufferView":0,"componentType":5126,"count":4,"type":"VEC3"},
    {"bufferView":1,"componentType":5125,"count":12,"type":"SCALAR"}],
    "bufferViews":[{"buffer":0,"byteLength":48},{"buffer":0,"byteOffset":48,"byteLength":48}],
    "buffers":[{"byteLength":96}]}"#;

/// What a file is, what it holds, the status it is refused with, and words of the reason.
struct Case {
    name: String,
    bytes: Vec<u8>,
    status: u16,
    words: &'static str,
}

#[derive(Default)]
struct Cases(Vec<Case>);

impl Cases {
    fn add(
        &mut self,
        name: impl Into<String>,
        bytes: impl Into<Vec<u8>>,
        status: u16,
        words: &'static str,
    ) {
        self.0.push(Case {
            name: name.into(),
            bytes: bytes.into(),
            status,
            words,
        });
    }

    /// A file of which something is replaced.
    fn changed(&mut self, file: &str, from: &str, to: &str, words: &'static str) {
        assert!(file.contains(from), "{from}");
        let start = file.split_whitespace().next().unwrap_or_default();
        let shown: String = to.chars().take(60).collect();
        self.add(
            format!("{start}: {shown}"),
            file.replacen(from, to, 1),
            422,
            words,
        );
    }

    fn document(&mut self, from: &str, to: &str, words: &'static str) {
        assert!(DOCUMENT.contains(from), "{from}");
        let shown: String = to.chars().take(60).collect();
        self.add(
            shown,
            glb(&DOCUMENT.replacen(from, to, 1), &buffer()),
            422,
            words,
        );
    }
}

fn buffer() -> Vec<u8> {
    let positions = [0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1].map(|x| f32::from(x as i8).to_le_bytes());
    let indices = [0_u32, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3].map(u32::to_le_bytes);
    [positions.concat(), indices.concat()].concat()
}

fn glb(json: &str, binary: &[u8]) -> Vec<u8> {
    let mut bytes = b"glTF\x02\0\0\0\0\0\0\0".to_vec();
    for (kind, data, filler) in [(b"JSON", json.as_bytes(), b' '), (b"BIN\0", binary, 0)] {
        let padded = data.len().next_multiple_of(4);
        bytes.extend((padded as u32).to_le_bytes());
        bytes.extend(kind);
        bytes.extend(data);
        bytes.resize(bytes.len() + padded - data.len(), filler);
    }
    let length = bytes.len() as u32;
    bytes[8..12].copy_from_slice(&length.to_le_bytes());
    bytes
}

/// The four bytes at a place replaced.
fn patched(bytes: &[u8], at: usize, value: u32) -> Vec<u8> {
    let mut bytes = bytes.to_vec();
    bytes[at..at + 4].copy_from_slice(&value.to_le_bytes());
    bytes
}

fn utf16(text: &str) -> Vec<u8> {
    text.encode_utf16().flat_map(u16::to_le_bytes).collect()
}

fn no_meshes(cases: &mut Cases) {
    cases.add("empty", "", 415, "empty");
    cases.add("blank", " \n\n\t", 415, "none of them");
    cases.add("prose", "a chair is no mesh", 415, "none of them");
    let page = "<html><body>404</body></html>";
    cases.add("page", page, 415, "a web page");
    cases.add("other JSON", r#"{"v": [1, 2, 3]}"#, 415, "none of them");
    cases.add("zeros", vec![0; 50_000], 415, "none of them");
    for (name, start) in [
        ("a PNG", b"\x89PNG\r\n\x1A\n\0\0\0\rIHDR".as_slice()),
        ("a JPEG", b"\xFF\xD8\xFF\xE0\0\x10JFIF\0"),
        ("a GIF", b"GIF89a\x01\0"),
        ("a PDF", b"%PDF-1.7\n\0"),
        ("a zip archive", b"PK\x03\x04\x14\0\0\0"),
        ("a gzip archive", b"\x1F\x8B\x08\0\0\0\0\0"),
        ("a 7z archive", b"7z\xBC\xAF\x27\x1C\0\x04"),
        ("a program", b"\x7FELF\x02\x01\x01\0"),
    ] {
        // Compressed data claims nothing about its size that would be believed.
        cases.add(name, [start, &[0xAA; 5000]].concat(), 415, name);
    }
    for text in [OBJ, OFF, PLY, STL, DOCUMENT] {
        cases.add("UTF-16", utf16(text), 415, "UTF-16");
    }
}

fn stl(cases: &mut Cases) {
    let binary = small_box();
    for end in [84, 85, 96, 133, 134, 5000] {
        cases.add(
            format!("stl cut at {end}"),
            &binary[..end],
            422,
            "cut short",
        );
    }
    cases.add(
        "stl of 4e9",
        patched(&binary, 80, 150_000_000),
        422,
        "cut short",
    );
    cases.add(
        "stl of none",
        patched(&binary[..84], 80, 0),
        422,
        "no triangles",
    );
    let place = "triangle 2";
    for value in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
        cases.add(
            "stl not finite",
            patched(&binary, 84 + 100 + 12, value.to_bits()),
            422,
            place,
        );
    }
    cases.add(
        "stl 1e38",
        patched(&binary, 84 + 100 + 12, 1e38_f32.to_bits()),
        422,
        place,
    );
    let zeros = [&[b' '; 80][..], &12_u32.to_le_bytes(), &[0; 600]].concat();
    cases.add("stl of points", zeros, 422, "degenerate");
    cases.add("ascii cut", &STL[..60], 422, "line 5");
    cases.add("ascii without end", &STL[..STL.len() - 11], 422, "endsolid");
    cases.changed(STL, "vertex 1 0 0", "vertex 1 0", "line 6");
    cases.changed(STL, "vertex 1 0 0", "vertex 1 nan 0", "not a finite");
    cases.changed(STL, "vertex 1 0 0", "vertex 1 1e31 0", "beyond");
    cases.changed(STL, "vertex 1 0 0", "vertex one 0 0", "`one`");
    cases.changed(STL, "outer loop", "outer", "line 4");
    cases.changed(STL, "endfacet", "facet", "endfacet");
    cases.add(
        "ascii of none",
        "solid a\nendsolid a\n",
        422,
        "no triangles",
    );
    cases.add("ascii flat", STL, 422, "flat");
    cases.add(
        "ascii long line",
        format!("solid a\nfacet normal 0 0 {}", "1".repeat(9_000_000)),
        422,
        "line 2",
    );
}

fn obj(cases: &mut Cases) {
    for (from, to, words) in [
        ("f 2 3 4", "f 2 3 5", "vertex 5"),
        ("f 2 3 4", "f 2 3 99999999999", "out of range"),
        ("f 2 3 4", "f 2 3 0", "counts from 1"),
        ("f 2 3 4", "f 2 3 -9", "before the first"),
        ("f 2 3 4", "f 2 3", "at least three"),
        ("f 2 3 4", "f", "without corners"),
        ("f 2 3 4", "f 2 3 x", "`x`"),
        ("f 2 3 4", "f 2 3 4.5", "not a vertex number"),
        ("v 1 0 0", "v 1 0", "line 2"),
        ("v 1 0 0", "v 1 0 nan", "line 2"),
        ("v 1 0 0", "v 1 0 -inf", "line 2"),
        ("v 1 0 0", "v 1 0 1e31", "beyond"),
        ("v 1 0 0", "v 1 0 1,5", "`1,5`"),
    ] {
        cases.changed(OBJ, from, to, words);
    }
    cases.add("obj of points", &OBJ[..32], 422, "a point cloud");
    cases.add("obj of 1e-60", OBJ.replace('1', "1e-60"), 422, "");
    cases.add(
        "obj flat",
        "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n",
        422,
        "flat",
    );
    cases.add("obj of points", "v 0 0 0\nf 1 1 1\n", 422, "degenerate");
    let comb: String = (0..60_000)
        .map(|i| format!("v {i} {} 0\n", i % 2 * 9))
        .collect();
    let corners: String = (1..=60_000).map(|i| format!(" {i}")).collect();
    cases.add(
        "comb",
        format!("{comb}v 0 -1 5\nf{corners} 60001\n"),
        422,
        "triangles before export",
    );
}

fn ply(cases: &mut Cases) {
    for end in [4, 20, 40, 60, 100, 140, 170] {
        cases.add(format!("ply cut at {end}"), &PLY[..end], 422, "line");
    }
    for (from, to, words) in [
        ("element vertex 4", "element vertex 4000000000", "line 3"),
        (
            "element vertex 4",
            "element vertex 18446744073709551615",
            "line 3",
        ),
        ("element vertex 4", "element vertex -4", "valid count"),
        ("element face 4", "element face 4000000000", "line 7"),
        ("element face 4", "element face 5", "send the whole file"),
        (
            "format ascii 1.0",
            "format klingon 1.0",
            "not a known encoding",
        ),
        ("format ascii 1.0\n", "", "before any format"),
        (
            "property float x",
            "property quaternion x",
            "not a valid property",
        ),
        ("property float x", "property float w", "no property x"),
        ("vertex_indices", "colours", "no list vertex_indices"),
        ("3 1 2 3", "3 1 2 4", "vertex 4"),
        ("3 1 2 3", "3 1 2 -1", "not a vertex index"),
        ("3 1 2 3", "3 1 2 1.5", "not a vertex index"),
        ("3 1 2 3", "2 1 2", "at least three"),
        ("3 1 2 3", "4000000000 1 2 3", "does not fit"),
        ("3 1 2 3", "-1 1 2 3", "length -1 is not possible"),
        ("1 0 0", "1 nan 0", "vertex 1"),
        ("1 0 0", "1 x 0", "`x`"),
        ("end_header\n", "", "line"),
    ] {
        cases.changed(PLY, from, to, words);
    }
    let binary = PLY.replace("ascii", "binary_little_endian");
    let header = binary.find("end_header\n").expect("a header") + 11;
    cases.add(
        "binary cut",
        [&binary.as_bytes()[..header], &[0; 40]].concat(),
        422,
        "promises 4",
    );
    let long = [&binary.as_bytes()[..header], &[0; 48], &[255; 16]].concat();
    cases.add("binary list", long, 422, "byte");
}

fn off(cases: &mut Cases) {
    for end in [4, 6, 12, 20, 30, 45] {
        cases.add(format!("off cut at {end}"), &OFF[..end], 422, "line");
    }
    for (from, to, words) in [
        ("4 4 6", "4000000000 4 6", "the file ends before"),
        ("4 4 6", "4 18446744073709551615 6", "before face 4"),
        ("4 4 6", "-4 4 6", "`-4`"),
        ("4 4 6", "4", "number of faces is missing"),
        ("1 0 0", "1 0", "coordinate is missing"),
        ("1 0 0", "1 nan 0", "line 4"),
        ("1 0 0", "1 1e31 0", "beyond"),
        ("3 1 2 3", "3 1 2 4", "vertex 4"),
        ("3 1 2 3", "3 1 2", "vertex number is missing"),
        ("3 1 2 3", "4000000000 1 2 3", "vertex number is missing"),
        ("OFF", "4OFF", "three dimensions"),
        ("OFF", "OFF BINARY", "binary OFF"),
    ] {
        cases.changed(OFF, from, to, words);
    }
}

fn gltf(cases: &mut Cases) {
    let whole = glb(DOCUMENT, &buffer());
    for end in [4, 8, 11, 12, 16, 20, 300, whole.len() - 1] {
        cases.add(format!("glb cut at {end}"), &whole[..end], 422, "cut short");
    }
    cases.add("glb 1", patched(&whole, 4, 1), 422, "version 1");
    cases.add(
        "glb chunk",
        patched(&whole, 12, u32::MAX),
        422,
        "beyond the end",
    );
    cases.add("glb kind", patched(&whole, 16, 7), 422, "first chunk");
    cases.add("glb length", patched(&whole, 8, u32::MAX), 422, "cut short");
    for (from, to, words) in [
        (r#""count":4"#, r#""count":4000000000"#, "/accessors/0"),
        (
            r#""count":4"#,
            r#""count":18446744073709551615"#,
            "/accessors/0",
        ),
        (r#""count":4"#, r#""count":-4"#, "line 3"),
        (r#""count":12"#, r#""count":13"#, "/accessors/1"),
        (r#""count":12"#, r#""count":11"#, "whole triangles"),
        (
            r#""byteOffset":48"#,
            r#""byteOffset":18446744073709551615"#,
            "/bufferViews/1",
        ),
        (
            r#""byteLength":96"#,
            r#""byteLength":960000000000"#,
            "/buffers/0",
        ),
        (
            r#""componentType":5125"#,
            r#""componentType":5126"#,
            "/accessors/1",
        ),
        (
            r#""componentType":5126"#,
            r#""componentType":1"#,
            "/accessors/0",
        ),
        (r#""bufferView":0,"#, "", "no bufferView"),
        (
            r#""buffer":0,"byteLength":48}"#,
            r#""buffer":9,"byteLength":48}"#,
            "/bufferViews/0",
        ),
        (
            r#""byteLength":48}"#,
            r#""byteLength":48,"byteStride":0}"#,
            "every 0 bytes",
        ),
        (r#"{"mesh":0}"#, r#"{"children":[0]}"#, "/nodes/0"),
        (
            r#"{"mesh":0}"#,
            r#"{"children":[1]},{"children":[2]},{"children":[0]}"#,
            "reached twice",
        ),
        (r#"{"mesh":0}"#, r#"{"children":[7]}"#, "/nodes/7"),
        (r#"{"mesh":0}"#, r#"{"mesh":5}"#, "/meshes/5"),
        (r#"{"mesh":0}"#, r#"{"mesh":0,"matrix":[1,2,3]}"#, "line"),
        (
            r#"{"mesh":0}"#,
            r#"{"mesh":0,"scale":[1e300,1,1]}"#,
            "beyond",
        ),
        (
            r#"{"byteLength":96}"#,
            r#"{"uri":"/etc/passwd","byteLength":96}"#,
            "never opened",
        ),
        (
            r#"{"byteLength":96}"#,
            r#"{"uri":"https://a.b/c.bin","byteLength":96}"#,
            "never opened",
        ),
        (
            r#"{"byteLength":96}"#,
            r#"{"uri":"data:;base64,@@@@","byteLength":96}"#,
            "base64 is broken",
        ),
        (
            r#""scene":0"#,
            r#""extensionsRequired":["KHR_draco_mesh_compression"]"#,
            "KHR_draco",
        ),
        (
            r#""asset":{"version":"2.0"}"#,
            r#""asset":{"version":"1.0"}"#,
            "version 1.0",
        ),
        (r#""asset":{"version":"2.0"}"#, r#""asset":{}"#, "version"),
    ] {
        cases.document(from, to, words);
    }
    let deep = format!("{{\"asset\":{}", "[".repeat(1_000_000));
    cases.add("glTF nested", deep, 422, "JSON");
    cases.add("glTF cut", &DOCUMENT[..200], 422, "JSON");
    cases.add("glTF without buffer", DOCUMENT, 422, "/buffers/0");
    let many = format!("\"nodes\":[{}{{\"mesh\":0}}]", "{},".repeat(300_000));
    cases.document("\"nodes\":[{\"mesh\":0}]", &many, "262144");
}

/// What is wrong with the answer to a file.
async fn fault(server: &Server, case: &Case) -> Option<String> {
    let request = server
        .post("/meshes")
        .header("content-type", "application/octet-stream");
    let answer = request
        .body(case.bytes.clone())
        .send()
        .await
        .expect("an answer");
    let status = answer.status().as_u16();
    if status != case.status {
        let body = answer.text().await.unwrap_or_default();
        return Some(format!("{}: {status}, {body}", case.name));
    }
    let said = problem(answer, case.status).await;
    let detail = said["detail"].as_str().unwrap_or_default();
    let fits = detail.contains(case.words) && detail.len() < 600 && !detail.contains('\0');
    (!fits).then(|| format!("{} ({}): {detail}", case.name, case.words))
}

#[tokio::test(flavor = "multi_thread")]
async fn every_malformed_file_is_refused_with_cause_and_place() {
    let server = server().await;
    let mut cases = Cases::default();
    no_meshes(&mut cases);
    stl(&mut cases);
    obj(&mut cases);
    ply(&mut cases);
    off(&mut cases);
    gltf(&mut cases);
    assert!(cases.0.len() >= 140, "{}", cases.0.len());
    let mut faults = Vec::new();
    for case in &cases.0 {
        faults.extend(fault(&server, case).await);
    }
    assert!(faults.is_empty(), "{}", faults.join("\n"));
    assert_eq!(server.kept_files(), [""; 0]);
    assert_eq!(
        server.json("/meshes").await["meshes"],
        serde_json::json!([])
    );
    // Every worker that reads is still there.
    server.mesh(small_box()).await;
    server.json("/healthz").await;
}
