//! Meshes, grasps and histories in the formats of other programs.

use reqwest::{Response, StatusCode};
use serde_json::{Value, json};

use crate::common::{Server, cuboid, problem, server, server_with, small_box};
use crate::model_files::{self, Glb, Surface};

/// What is exported of a job.
const OF_A_JOB: [(&str, &str); 5] = [
    ("grasp.glb", "model/gltf-binary"),
    ("grasp.csv", "text/csv; charset=utf-8; header=present"),
    ("convergence.csv", "text/csv; charset=utf-8; header=present"),
    ("grasp.isaac.yaml", "application/yaml"),
    ("grasp.moveit.json", "application/json"),
];

/// A job that has ended, with these settings besides small ones.
pub async fn planned(server: &Server, mesh: &str, settings: Value) -> String {
    let mut request =
        json!({"population": 30, "generations": 5, "seed": 7, "candidates": "triangles"});
    let settings = settings.as_object().unwrap().clone();
    request.as_object_mut().unwrap().extend(settings);
    let job = server.job(mesh, request).await;
    server.wait_for(&job, &["succeeded"]).await;
    job
}

/// Settings that two soft fingers hold the box with.
pub fn pinch() -> Value {
    json!({"contacts": 2, "contact_model": "soft", "units": "cm"})
}

impl Server {
    pub async fn answer(&self, path: &str) -> Response {
        self.get(path).send().await.unwrap()
    }

    pub async fn bytes(&self, path: &str) -> Vec<u8> {
        let answer = self.answer(path).await;
        assert_eq!(answer.status(), StatusCode::OK, "{path}");
        answer.bytes().await.unwrap().to_vec()
    }

    pub async fn text(&self, path: &str) -> String {
        String::from_utf8(self.bytes(path).await).expect("UTF-8")
    }

    async fn surface(&self, path: &str) -> Surface {
        let file = self.bytes(path).await;
        match path.split_once("format=").map(|(_, format)| &format[..3]) {
            Some("stl") => model_files::stl(&file),
            Some("ply") => model_files::ply(&file),
            _ => Glb::new(&file).surface().0,
        }
    }
}

pub fn numbers(value: &Value) -> Vec<f64> {
    let items = value.as_array().expect("a list").iter();
    items.map(|item| item.as_f64().expect("a number")).collect()
}

/// The lines of a table without quotes, as numbers of the columns named; none where a cell is empty.
fn columns(table: &str, names: &[&str]) -> Vec<Vec<Option<f64>>> {
    let mut lines = table.strip_suffix("\r\n").expect("an end").split("\r\n");
    let header: Vec<&str> = lines.next().expect("a header").split(',').collect();
    let place = |name: &&str| header.iter().position(|column| column == name).expect(name);
    let places: Vec<usize> = names.iter().map(place).collect();
    let row = |line: &str| {
        let cells: Vec<&str> = line.split(',').collect();
        assert_eq!(cells.len(), header.len(), "{line}");
        places
            .iter()
            .map(|place| cells[*place].parse().ok())
            .collect()
    };
    lines.map(row).collect()
}

#[tokio::test(flavor = "multi_thread")]
async fn a_mesh_comes_back_in_every_format_with_the_numbers_of_its_triangles() {
    let server = server().await;
    let uploaded = small_box();
    let sent = model_files::stl(&uploaded);
    let id = server.mesh(uploaded).await;
    let path = format!("/meshes/{id}/file");
    for query in ["", "?format=glb", "?format=stl", "?format=ply"] {
        let surface = server.surface(&format!("{path}{query}")).await;
        assert_eq!(surface.triangles.len(), 192, "{query}");
        assert!((surface.volume() - 6.0).abs() < 1e-9, "{query}");
        let Some(numbers) = surface.numbers else {
            assert_eq!(query, "?format=stl");
            continue;
        };
        let mut seen = numbers.clone();
        seen.sort_unstable();
        assert!(seen.into_iter().eq(0..192), "{query}");
        for (triangle, number) in surface.triangles.iter().zip(numbers) {
            // The same corners, from whichever on.
            let known = sent.triangles[number as usize];
            let turns = [0, 1, 2].map(|first| [0, 1, 2].map(|n| known[(first + n) % 3]));
            assert!(turns.contains(triangle), "{triangle:?} is not {known:?}");
        }
    }
}

#[tokio::test(flavor = "multi_thread")]
async fn a_large_mesh_is_coarsened_on_request() {
    let server = server().await;
    let id = server.mesh(cuboid([1.0, 2.0, 3.0], 30)).await;
    let path = format!("/meshes/{id}/file");
    for (query, coarse) in [
        ("?max_triangles=1000", true),
        ("?max_triangles=5000", true),
        ("?max_triangles=10799", true),
        ("?max_triangles=10800", false),
        ("?max_triangles=2000000", false),
        ("", false),
    ] {
        let file = Glb::new(&server.bytes(&format!("{path}{query}")).await);
        let (surface, extras) = file.surface();
        assert_eq!(extras["coarse"], coarse, "{query}");
        assert_eq!(extras["triangles_of_the_mesh"], 10_800);
        let count = surface.triangles.len();
        match coarse {
            true => {
                let budget: usize = query.split('=').nth(1).unwrap().parse().unwrap();
                assert!((budget / 4..=budget).contains(&count), "{query}: {count}");
            }
            false => assert_eq!(count, 10_800, "{query}"),
        }
        let numbers = surface.numbers.as_ref().unwrap();
        assert_eq!(numbers.len(), count);
        assert!(numbers.iter().all(|number| *number < 10_800));
        let volume = surface.volume();
        assert!((4.5..6.001).contains(&volume), "{query}: {volume}");
    }
    for format in ["stl", "ply"] {
        let query = format!("{path}?format={format}&max_triangles=1000");
        let count = server.surface(&query).await.triangles.len();
        assert!((250..=1000).contains(&count), "{format}: {count}");
    }
}

#[tokio::test(flavor = "multi_thread")]
async fn files_say_what_they_are_and_are_sent_once() {
    let server = server().await;
    let mesh = server.mesh(small_box()).await;
    let job = planned(&server, &mesh, pinch()).await;
    let of_a_job = OF_A_JOB.map(|(name, kind)| (format!("/jobs/{job}/{name}"), kind));
    let of_a_mesh = [
        ("", "model/gltf-binary"),
        ("?max_triangles=1000", "model/gltf-binary"),
        ("?format=stl", "model/stl"),
        ("?format=ply", "model/ply"),
    ]
    .map(|(query, kind)| (format!("/meshes/{mesh}/file{query}"), kind));
    let variants = ["grasp.glb?grasp=initial", "grasp.csv?grasp=initial"]
        .map(|name| (format!("/jobs/{job}/{name}"), ""));
    let mut tags = Vec::new();
    for (path, kind) in of_a_job.into_iter().chain(of_a_mesh).chain(variants) {
        let answer = server.answer(&path).await;
        assert_eq!(answer.status(), StatusCode::OK, "{path}");
        let headers = answer.headers().clone();
        if !kind.is_empty() {
            assert_eq!(headers["content-type"], kind, "{path}");
        }
        let name = headers["content-disposition"].to_str().unwrap();
        let name = name.strip_prefix("attachment; filename=\"").unwrap();
        let name = name.strip_suffix('"').unwrap();
        let is_plain = |byte: u8| byte.is_ascii_alphanumeric() || b".-".contains(&byte);
        assert!(name.bytes().all(is_plain), "{name}");
        let bytes = answer.bytes().await.unwrap();
        let tag = headers["etag"].clone();
        let again = server.get(&path).header("if-none-match", &tag);
        let again = again.send().await.unwrap();
        assert_eq!(again.status(), StatusCode::NOT_MODIFIED, "{path}");
        assert_eq!(again.headers()["etag"], tag);
        assert!(again.bytes().await.unwrap().is_empty());
        let other = server.get(&path).header("if-none-match", "\"x\"");
        let other = other.send().await.unwrap();
        assert_eq!(other.bytes().await.unwrap(), bytes, "{path}");
        assert!(!tags.contains(&tag), "{path}: {tag:?}");
        tags.push(tag);
    }
}

#[tokio::test(flavor = "multi_thread")]
async fn exports_that_are_impossible_are_problems() {
    let server = server().await;
    let mesh = server.mesh(small_box()).await;
    let job = planned(&server, &mesh, pinch()).await;
    let of_a_job = OF_A_JOB.map(|(name, _)| (format!("/jobs/{job}/{name}"), name));
    let of_a_mesh = [(format!("/meshes/{mesh}/file"), "file")];
    for (path, name) in of_a_job.into_iter().chain(of_a_mesh) {
        let refused: &[&str] = match name {
            "file" => &[
                "format=obj",
                "format=",
                "format=GLB",
                "format=stl&format=stl",
                "max_triangles=999",
                "max_triangles=2000001",
                "max_triangles=-1",
                "max_triangles=many",
                "grasp=best",
            ],
            "convergence.csv" => &["grasp=best", "width=100"],
            "grasp.isaac.yaml" | "grasp.moveit.json" => &[
                "grasp=0",
                "units=ly",
                "units=",
                "units=cm&units=cm",
                "units=mm",
                "theme=dark",
            ],
            _ => &[
                "grasp=0",
                "grasp=-1",
                "grasp=worst",
                "grasp=",
                "grasp=1001",
                "grasp=1&grasp=2",
                "units=cm",
            ],
        };
        for query in refused {
            let problem = problem(server.answer(&format!("{path}?{query}")).await, 400).await;
            let pointer = format!("/{}", query.split('=').next().unwrap());
            assert_eq!(problem["errors"][0]["pointer"], pointer, "{path}?{query}");
        }
        for accept in ["image/gif", "text/html", "*/*;q=0"] {
            let answer = server.get(&path).header("accept", accept).send().await;
            problem(answer.unwrap(), 406).await;
        }
        let any = server.get(&path).header("accept", "text/html, */*;q=0.1");
        assert_eq!(any.send().await.unwrap().status(), StatusCode::OK);
        problem(server.delete(&path).send().await.unwrap(), 405).await;
        for unknown in ["0".repeat(64), uuid(), "x".to_owned()] {
            let path = path.replace(&job, &unknown).replace(&mesh, &unknown);
            problem(server.answer(&path).await, 404).await;
        }
    }
}

fn uuid() -> String {
    "01a20203-4fd6-77c7-b546-6eed63910d31".to_owned()
}

#[tokio::test(flavor = "multi_thread")]
async fn without_a_result_there_is_nothing_to_export() {
    let server = server_with(&["--workers", "1"]).await;
    let mesh = server.mesh(small_box()).await;
    let endless = json!({"population": 10_000, "generations": 90_000, "seed": 7});
    let running = server.job(&mesh, endless.clone()).await;
    let waiting = server.job(&mesh, endless).await;
    server.wait_for(&running, &["running"]).await;
    for job in [&running, &waiting] {
        for (name, _) in OF_A_JOB {
            let early = server.answer(&format!("/jobs/{job}/{name}")).await;
            assert!(early.headers().contains_key("retry-after"), "{name}");
            problem(early, 409).await;
        }
    }
    let cancel = server.post(&format!("/jobs/{waiting}/cancel"));
    cancel.send().await.unwrap();
    server.wait_for(&waiting, &["cancelled"]).await;
    for (name, _) in OF_A_JOB {
        let never = server.answer(&format!("/jobs/{waiting}/{name}")).await;
        assert!(!never.headers().contains_key("retry-after"), "{name}");
        let problem = problem(never, 409).await;
        assert!(problem["detail"].as_str().unwrap().contains("cancelled"));
    }
    server.stop().await;

    let (server, mesh) = crate::scripted::server(&[]).await;
    let failed = server.job(&mesh, json!({"label": "panic"})).await;
    server.wait_for(&failed, &["failed"]).await;
    for (name, _) in OF_A_JOB {
        let never = server.answer(&format!("/jobs/{failed}/{name}")).await;
        assert!(!never.headers().contains_key("retry-after"), "{name}");
        let problem = problem(never, 409).await;
        assert!(problem["detail"].as_str().unwrap().contains("failed"));
    }
}

#[tokio::test(flavor = "multi_thread")]
async fn tables_outlive_the_mesh_and_a_scene_does_not() {
    let server = server().await;
    let mesh = server.mesh(small_box()).await;
    let job = planned(&server, &mesh, pinch()).await;
    let gone = server.delete(&format!("/meshes/{mesh}")).send().await;
    assert_eq!(gone.unwrap().status(), StatusCode::NO_CONTENT);
    for (name, _) in OF_A_JOB {
        let answer = server.answer(&format!("/jobs/{job}/{name}")).await;
        match name {
            "grasp.glb" => drop(problem(answer, 410).await),
            _ => assert_eq!(answer.status(), StatusCode::OK, "{name}"),
        }
    }
    let file = server.answer(&format!("/meshes/{mesh}/file")).await;
    problem(file, 404).await;
}

#[tokio::test(flavor = "multi_thread")]
async fn tables_and_scenes_contain_the_chosen_grasp() {
    let server = server().await;
    let mesh = server.mesh(small_box()).await;
    let job = planned(&server, &mesh, json!({"top": 3, "units": "cm"})).await;
    let result = server.json(&format!("/jobs/{job}/result")).await;
    let top = result["top"].as_array().expect("several").clone();
    assert_eq!(top.len(), 3, "{result}");
    let grasps = [
        ("", &result["contacts"]),
        ("?grasp=best", &result["contacts"]),
        ("?grasp=initial", &result["initial"]["contacts"]),
        ("?grasp=1", &result["contacts"]),
        ("?grasp=2", &top[1]["contacts"]),
        ("?grasp=3", &top[2]["contacts"]),
    ];
    for (query, contacts) in grasps {
        let table = server.text(&format!("/jobs/{job}/grasp.csv{query}")).await;
        let scene = Glb::new(&server.bytes(&format!("/jobs/{job}/grasp.glb{query}")).await);
        let nodes = scene.nodes();
        let contacts = contacts.as_array().expect("contacts");
        let places = columns(&table, &["x", "y", "z", "normal_x", "normal_y", "normal_z"]);
        let triangles = columns(&table, &["contact", "triangle"]);
        let forces = columns(&table, &["force_x", "force_y", "force_z"]);
        assert_eq!(places.len(), contacts.len(), "{query}");
        for (index, contact) in contacts.iter().enumerate() {
            let wanted = [numbers(&contact["position"]), numbers(&contact["normal"])].concat();
            let found: Vec<f64> = places[index].iter().flatten().copied().collect();
            assert_eq!(found, wanted, "{query}");
            let number = (index + 1) as f64;
            assert_eq!(
                triangles[index],
                [Some(number), contact["triangle"].as_f64()]
            );
            let known = contact.get("forces").map(numbers);
            let exported = forces[index].iter().copied().collect::<Option<Vec<f64>>>();
            assert_eq!(exported, known, "{query}");
            let node = nodes[format!("contact {}", index + 1).as_str()];
            assert_eq!(node["translation"], contact["position"], "{query}");
        }
        let is_known = contacts[0].get("forces").is_some();
        assert_eq!(
            is_known,
            ["", "?grasp=best", "?grasp=1"].contains(&query),
            "{query}"
        );
        let (surface, extras) = scene.surface();
        assert!((surface.volume() - 6.0).abs() < 1e-9);
        assert_eq!(nodes["graspd"]["scale"], json!([0.01, 0.01, 0.01]));
        assert_eq!(extras["units"], "cm");
    }
    for query in ["?grasp=4", "?grasp=1000"] {
        let refused = server
            .answer(&format!("/jobs/{job}/grasp.csv{query}"))
            .await;
        let problem = problem(refused, 409).await;
        assert!(problem["detail"].as_str().unwrap().contains("3 grasps"));
    }
    let table = server.text(&format!("/jobs/{job}/convergence.csv")).await;
    let found = columns(&table, &["generation", "best", "mean", "evaluations"]);
    let history = result["history"].as_array().unwrap();
    assert_eq!(found.len(), history.len());
    for (row, entry) in found.iter().zip(history) {
        let wanted = ["generation", "best", "mean", "evaluations"].map(|name| entry[name].as_f64());
        assert_eq!(row[..], wanted);
    }
}

#[tokio::test(flavor = "multi_thread")]
async fn names_and_labels_of_senders_are_in_no_file() {
    let server = server().await;
    let evil = "<img src=x onerror=alert(1)>\"; filename=\"=cmd|'x'!A1";
    let part = reqwest::multipart::Part::bytes(small_box()).file_name(format!("{evil}.stl"));
    let mut settings = pinch();
    settings["label"] = evil.into();
    settings["population"] = 30.into();
    settings["generations"] = 5.into();
    let form = reqwest::multipart::Form::new()
        .part("mesh", part)
        .text("request", settings.to_string());
    let answer = server.post("/jobs").multipart(form).send().await.unwrap();
    assert_eq!(answer.status(), StatusCode::ACCEPTED);
    let job: Value = answer.json().await.unwrap();
    let (mesh, id) = (&job["mesh_id"], job["id"].as_str().unwrap());
    server.wait_for(id, &["succeeded"]).await;
    let mesh = mesh.as_str().unwrap();
    let of_a_job = OF_A_JOB.map(|(name, _)| format!("/jobs/{id}/{name}"));
    let of_a_mesh =
        ["glb", "stl", "ply"].map(|format| format!("/meshes/{mesh}/file?format={format}"));
    for path in of_a_job.iter().chain(&of_a_mesh) {
        let answer = server.answer(path).await;
        assert_eq!(answer.status(), StatusCode::OK, "{path}");
        assert_eq!(answer.headers()["x-content-type-options"], "nosniff");
        let name = answer.headers()["content-disposition"].clone();
        assert_eq!(name.to_str().unwrap().matches("filename").count(), 1);
        let bytes = answer.bytes().await.unwrap();
        for part in ["onerror", "cmd|"] {
            let found = bytes.windows(part.len()).any(|at| at == part.as_bytes());
            assert!(!found, "{path}");
        }
    }
}
