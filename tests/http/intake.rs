//! Units, scale, formats and candidates of meshes over HTTP.

use reqwest::StatusCode;
use serde_json::{Value, json};

use crate::common::{Server, file, pointers, problem, server, small_box, stl};

async fn upload(server: &Server, query: &str, bytes: Vec<u8>) -> Value {
    let answer = server
        .post(&format!("/meshes?{query}"))
        .header("content-type", "application/octet-stream")
        .body(bytes)
        .send()
        .await
        .unwrap();
    assert!(answer.status().is_success(), "{query}");
    answer.json().await.unwrap()
}

fn warned(report: &Value) -> Vec<&str> {
    let warnings = report["warnings"].as_array().unwrap().iter();
    warnings
        .map(|warning| warning["kind"].as_str().unwrap())
        .collect()
}

#[tokio::test(flavor = "multi_thread")]
async fn unit_and_scale_make_another_mesh_of_the_same_file() {
    let server = server().await;
    let plain = upload(&server, "format=stl", small_box()).await;
    assert_eq!((&plain["scale"], plain.get("units")), (&json!(1.0), None));
    let scaled = upload(&server, "format=stl&units=m&scale=0.5", small_box()).await;
    assert_ne!(plain["id"], scaled["id"]);
    assert_eq!(
        (&scaled["units"], &scaled["scale"]),
        (&json!("m"), &json!(0.5))
    );
    let volume = scaled["report"]["volume"].as_f64().unwrap();
    assert!((volume / 0.75 - 1.0).abs() < 1e-12, "{volume}");
    let form = file(small_box()).text("units", "m").text("scale", "0.5");
    let again = server.post("/meshes").multipart(form).send().await.unwrap();
    assert_eq!(again.status(), StatusCode::OK);
    assert_eq!(again.json::<Value>().await.unwrap()["id"], scaled["id"]);

    // A job takes the unit of its mesh, and finds contacts in its scale.
    let request = json!({"seed": 1, "method": "modified_ga", "population": 20, "generations": 3});
    let job = server
        .job(scaled["id"].as_str().unwrap(), request.clone())
        .await;
    let job = server.wait_for(&job, &["succeeded"]).await;
    assert_eq!(job["request"]["units"], "m");
    assert_eq!(job["result"]["units"], "m");
    assert_eq!(job["mesh_report"], scaled["report"]);
    let other = server.job(plain["id"].as_str().unwrap(), request).await;
    let other = server.wait_for(&other, &["succeeded"]).await;
    let [a, b] = [&job, &other].map(|job| job["result"]["quality"].as_f64().unwrap());
    assert!((a / b - 1.0).abs() < 1e-9, "{a} {b}");
    let form = file(small_box())
        .text("units", "m")
        .text("scale", "0.5")
        .text("seed", "1");
    let answer = server.post("/jobs").multipart(form).send().await.unwrap();
    assert_eq!(
        answer.json::<Value>().await.unwrap()["mesh_id"],
        scaled["id"]
    );

    for query in [
        "scale=0",
        "scale=nan",
        "scale=1e10",
        "units=parsec",
        "scale=1&scale=2",
    ] {
        let answer = server
            .post(&format!("/meshes?format=stl&{query}"))
            .body(small_box());
        problem(answer.send().await.unwrap(), 400).await;
    }
    for (name, value) in [
        ("scale", "-1"),
        ("scale", "big"),
        ("units", "parsec"),
        ("format", "dwg"),
    ] {
        for path in ["/meshes", "/jobs"] {
            let form = file(small_box()).text(name, value);
            let answer = server.post(path).multipart(form).send().await.unwrap();
            assert_eq!(pointers(&problem(answer, 422).await), [format!("/{name}")]);
        }
    }
    let id = plain["id"].as_str().unwrap();
    let answer = server
        .post("/jobs")
        .json(&json!({"mesh_id": id, "scale": 2}));
    assert_eq!(
        pointers(&problem(answer.send().await.unwrap(), 422).await),
        ["/scale"]
    );
}

#[tokio::test(flavor = "multi_thread")]
async fn the_report_warns_of_what_makes_a_grasp_doubtful() {
    let server = server().await;
    let whole = upload(&server, "format=stl&units=m", small_box()).await;
    assert_eq!(warned(&whole["report"]), [""; 0]);
    let tiny = upload(&server, "format=stl&units=um", small_box()).await;
    assert_eq!(warned(&tiny["report"]), ["size"]);
    let mut open = small_box();
    open.truncate(84 + 50 * 191);
    open[80..84].copy_from_slice(&191_u32.to_le_bytes());
    let open = upload(&server, "format=stl", open).await;
    assert_eq!(warned(&open["report"]), ["open", "mass"]);
    assert_eq!(open["report"]["mass_from"], "capped");
    assert!((open["report"]["volume"].as_f64().unwrap() - 6.0).abs() < 1e-6);
    let twice = [&small_box()[84..], &small_box()[84..]].concat();
    let twice = [&[0; 80][..], &384_u32.to_le_bytes(), &twice].concat();
    let twice = upload(&server, "format=stl", twice).await;
    assert_eq!(warned(&twice["report"]), ["duplicates"]);
    assert_eq!(twice["report"]["duplicate_triangles"], 192);
    assert_eq!(twice["report"]["watertight"], true);
}

/// A box of twelve triangles, and the same of 192.
fn coarse() -> Vec<u8> {
    crate::common::cuboid([1.0, 2.0, 3.0], 1)
}

#[tokio::test(flavor = "multi_thread")]
async fn candidates_are_as_requested_or_as_the_mesh_needs() {
    let server = server().await;
    let mesh = server.mesh(coarse()).await;
    let run = |extra: Value| {
        let mut request = json!({"seed": 3, "generations": 1, "population": 4, "polish": false});
        for (name, value) in extra.as_object().unwrap() {
            request[name] = value.clone();
        }
        let (server, mesh) = (&server, &mesh);
        async move {
            let job = server.job(mesh, request).await;
            server.wait_for(&job, &["succeeded"]).await["result"].clone()
        }
    };
    let default = run(json!({})).await;
    assert_eq!(default["candidates_from"]["kind"], "uniform");
    assert_eq!(default["candidates"], 10_000);
    let because = default["candidates_from"]["because"].as_str().unwrap();
    assert!(because.contains("fewer than 1000"), "{because}");
    let few = run(json!({"candidates": {"kind": "uniform", "count": 300}})).await;
    assert_eq!(
        (&few["candidates"], &few["candidates_from"]["count"]),
        (&json!(300), &json!(300))
    );
    let triangles = run(json!({"candidates": "triangles"})).await;
    assert_eq!(triangles["candidates"], 12);
    let paper = run(json!({"method": "modified_ga", "population": 10})).await;
    assert_eq!(paper["candidates_from"]["kind"], "triangles");
    assert!(default["quality"].as_f64() > triangles["quality"].as_f64());

    // A contact is located by its triangle and the weights of the corners.
    let bytes = coarse();
    for contact in default["contacts"].as_array().unwrap() {
        let triangle = contact["triangle"].as_u64().unwrap() as usize;
        let corner = |k: usize, axis: usize| {
            let at = 84 + 50 * triangle + 12 + 12 * k + 4 * axis;
            f64::from(f32::from_le_bytes(bytes[at..at + 4].try_into().unwrap()))
        };
        for axis in 0..3 {
            let weighed =
                (0..3).map(|k| contact["barycentric"][k].as_f64().unwrap() * corner(k, axis));
            let position = contact["position"][axis].as_f64().unwrap();
            assert!((weighed.sum::<f64>() - position).abs() < 1e-12);
        }
    }
    // Contacts given back by their places are worth the same.
    let places = default["contacts"].as_array().unwrap().iter();
    let grasp: Vec<Value> = places
        .map(|c| json!({"point": c["position"], "normal": c["normal"]}))
        .collect();
    let body = json!({"mesh_id": mesh, "grasps": [grasp]});
    let found = server
        .post("/evaluations")
        .json(&body)
        .send()
        .await
        .unwrap();
    let found: Value = found.json().await.unwrap();
    assert_eq!(found["evaluations"][0]["quality"], default["quality"]);

    for (wrong, pointer) in [
        (json!("squares"), "/candidates"),
        (json!({"kind": "uniform", "count": 0}), "/candidates/count"),
        (
            json!({"kind": "uniform", "count": 200_001}),
            "/candidates/count",
        ),
        (
            json!({"kind": "triangles", "count": 5}),
            "/candidates/count",
        ),
        (json!({"count": 5}), "/candidates/kind"),
        (json!({"kind": "uniform", "seed": 5}), "/candidates/seed"),
        (json!(7), "/candidates"),
    ] {
        let body = json!({"mesh_id": mesh, "candidates": wrong});
        let answer = server.post("/jobs").json(&body).send().await.unwrap();
        assert_eq!(pointers(&problem(answer, 422).await), [pointer], "{wrong}");
    }
}

/// The tetrahedron of the corners of the unit cube at the origin.
const CORNERS: [[f32; 3]; 4] = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
const FACES: [[usize; 3]; 4] = [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]];

fn text(vertex: impl Fn([f32; 3]) -> String, face: impl Fn([usize; 3]) -> String) -> String {
    CORNERS.map(vertex).concat() + &FACES.map(face).concat()
}

#[tokio::test(flavor = "multi_thread")]
async fn every_format_of_a_body_gives_the_same_grasp() {
    let server = server().await;
    let plain = |[x, y, z]: [f32; 3]| format!("{x} {y} {z}\n");
    let three = |[a, b, c]: [usize; 3]| format!("3 {a} {b} {c}\n");
    let obj = text(
        |[x, y, z]| format!("v {x} {y} {z}\n"),
        |f| format!("f {} {} {}\n", f[0] + 1, f[1] + 1, f[2] + 1),
    );
    let ply = "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n\
               element face 4\nproperty list uchar int vertex_indices\nend_header\n";
    let document = r#"{"asset":{"version":"2.0"},"nodes":[{"mesh":0}],
        "meshes":[{"primitives":[{"attributes":{"POSITION":0},"indices":1}]}],
        "accessors":[{"bufferView":0,"componentType":5126,"count":4,"type":"VEC3"},
        {"bufferView":1,"componentType":5121,"count":12,"type":"SCALAR"}],
        "bufferViews":[{"buffer":0,"byteLength":48},{"buffer":0,"byteOffset":48,"byteLength":12}],
        "buffers":[{"byteLength":60}]}  "#;
    let numbers = CORNERS.concat().into_iter().flat_map(f32::to_le_bytes);
    let buffer: Vec<u8> = numbers
        .chain(FACES.concat().into_iter().map(|i| i as u8))
        .collect();
    let chunk = |kind: &[u8; 4], data: &[u8]| {
        assert!(data.len().is_multiple_of(4));
        [&(data.len() as u32).to_le_bytes()[..], kind, data].concat()
    };
    let padding = " ".repeat(document.len().next_multiple_of(4) - document.len());
    let json = chunk(b"JSON", (document.to_owned() + &padding).as_bytes());
    let chunks = [json, chunk(b"BIN\0", &buffer)].concat();
    let length = (chunks.len() as u32 + 12).to_le_bytes();
    let glb = [b"glTF\x02\0\0\0".as_slice(), &length, &chunks].concat();
    let mut results = Vec::new();
    for (format, bytes) in [
        (
            "stl",
            stl(&FACES.map(|face| face.map(|corner| CORNERS[corner]))),
        ),
        ("obj", obj.into_bytes()),
        ("ply", (ply.to_owned() + &text(plain, three)).into_bytes()),
        (
            "off",
            ("OFF\n4 4 6\n".to_owned() + &text(plain, three)).into_bytes(),
        ),
        ("glb", glb),
    ] {
        let mesh = upload(&server, "", bytes.clone()).await;
        assert_eq!(mesh["format"], format);
        assert_eq!(
            upload(&server, &format!("format={format}"), bytes).await["id"],
            mesh["id"]
        );
        let request = json!({"seed": 5, "generations": 1, "population": 4});
        let job = server.job(mesh["id"].as_str().unwrap(), request).await;
        let result = server.wait_for(&job, &["succeeded"]).await["result"].clone();
        results.push((result["quality"].clone(), result["contacts"].clone()));
    }
    assert!(results[0].0.as_f64().unwrap() > 0.1, "{:?}", results[0].0);
    assert!(results.iter().all(|result| *result == results[0]));
}
