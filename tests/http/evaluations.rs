//! Given grasps, evaluated at once: over HTTP, and the same from the command line.

use std::io::Write as _;
use std::process::{Command, Output, Stdio};
use std::time::Duration;

use reqwest::StatusCode;
use reqwest::multipart::{Form, Part};
use serde_json::{Value, json};

use crate::common::{Server, cuboid, file, pointers, problem, server, server_with, small_box, stl};

/// Triangles of [`small_box`].
const TRIANGLES: usize = 6 * 4 * 4 * 2;

async fn evaluate(server: &Server, body: &Value) -> Vec<u8> {
    let answer = server.post("/evaluations").json(body).send().await.unwrap();
    let status = answer.status();
    let bytes = answer.bytes().await.unwrap().to_vec();
    assert_eq!(
        status,
        StatusCode::OK,
        "{}",
        String::from_utf8_lossy(&bytes)
    );
    bytes
}

async fn evaluations(server: &Server, body: &Value) -> Value {
    serde_json::from_slice(&evaluate(server, body).await).unwrap()
}

async fn refused(server: &Server, body: &Value, status: u16) -> Value {
    let answer = server.post("/evaluations").json(body).send().await.unwrap();
    problem(answer, status).await
}

/// `graspd evaluate` on a mesh file, grasps on its standard input.
fn command(mesh: &std::path::Path, grasps: &str, flags: &[&str]) -> Output {
    let mut child = Command::new(env!("CARGO_BIN_EXE_graspd"))
        .arg("evaluate")
        .arg(mesh)
        .arg("-")
        .args(flags)
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let mut input = child.stdin.take().unwrap();
    // A command that refuses its flags reads nothing.
    let _ = input.write_all(grasps.as_bytes());
    drop(input);
    child.wait_with_output().unwrap()
}

/// Seven triangles of the box that differ with `n`, the seventh of them with all of its digits.
fn seven(n: usize) -> Vec<Value> {
    (0..7)
        .map(|finger| json!({"triangle": (n * 31 + finger * 29 + finger * finger) % TRIANGLES}))
        .collect()
}

/// Contacts on four sides of the box that hold it with friction.
fn four() -> Value {
    json!([
        {"point": [0.6, 0.1, 0.2]}, {"point": [-0.6, -0.2, 0.1]},
        {"point": [0.1, 1.2, -0.3]}, {"point": [-0.1, -1.2, 0.2]}
    ])
}

fn number(value: &Value) -> f64 {
    value
        .as_f64()
        .unwrap_or_else(|| panic!("{value} is no number"))
}

fn vector(value: &Value) -> [f64; 3] {
    serde_json::from_value(value.clone()).unwrap_or_else(|_| panic!("{value} is no vector"))
}

fn distance(a: [f64; 3], b: [f64; 3]) -> f64 {
    a.iter()
        .zip(b)
        .map(|(a, b)| (a - b).powi(2))
        .sum::<f64>()
        .sqrt()
}

fn close(a: &Value, b: &Value) -> bool {
    (number(a) - number(b)).abs() <= 1e-9 * number(a).abs()
}

#[tokio::test(flavor = "multi_thread")]
async fn a_planned_grasp_is_worth_the_same_however_its_contacts_are_given() {
    let server = server().await;
    let mesh = server.mesh(small_box()).await;
    for settings in [
        json!({}),
        json!({"friction": 0, "edge_norm": "unit_normal"}),
        json!({"contact_model": "soft", "torque_scale": "none"}),
        json!({"cone_edges": 0, "wrench_space": "linf", "center_of_mass": [0.1, 0, 0]}),
    ] {
        let mut plan = json!({
            "population": 8, "generations": 2, "seed": 7, "polish": false,
            "candidates": "triangles"
        });
        for (name, value) in settings.as_object().unwrap() {
            plan[name] = value.clone();
        }
        let job = server.job(&mesh, plan).await;
        let result = server.wait_for(&job, &["succeeded"]).await["result"].clone();
        assert_eq!(result["force_closure"], true, "{settings}");
        let contacts = result["contacts"].as_array().unwrap();
        let each = |members: &[&str]| -> Vec<Value> {
            let pick = |contact: &Value| {
                members
                    .iter()
                    .map(|name| {
                        let from = if *name == "point" { "position" } else { *name };
                        ((*name).to_owned(), contact[from].clone())
                    })
                    .collect()
            };
            contacts.iter().map(pick).map(Value::Object).collect()
        };
        let mut body = settings.clone();
        body["mesh_id"] = mesh.as_str().into();
        body["grasps"] = json!([
            each(&["triangle"]),
            each(&["point"]),
            each(&["point", "normal"])
        ]);
        let found = evaluations(&server, &body).await;
        for name in [
            "torque_scale",
            "center_of_mass",
            "contact_model",
            "edge_norm",
            "wrench_space",
            "cone_edges",
            "friction",
            "torsional_friction",
            "frame",
            "version",
        ] {
            assert_eq!(found[name], result[name], "{name} with {settings}");
        }
        let [triangles, points, free] = &found["evaluations"].as_array().unwrap()[..] else {
            panic!("{found}");
        };
        // The same places to the bit are worth the same to the bit.
        for name in [
            "force_closure",
            "quality",
            "margin",
            "exact",
            "bounds",
            "weakest_wrench",
            "measures",
        ] {
            assert_eq!(triangles[name], result[name], "{name} with {settings}");
        }
        for (given, planned) in triangles["contacts"]
            .as_array()
            .unwrap()
            .iter()
            .zip(contacts)
        {
            assert_eq!(given, planned, "{settings}");
        }
        for (index, planned) in contacts.iter().enumerate() {
            let (projected, free) = (&points["contacts"][index], &free["contacts"][index]);
            assert_eq!(projected["triangle"], planned["triangle"]);
            assert!(number(&projected["distance"]) < 1e-9);
            assert_eq!(free["position"], planned["position"]);
            assert!(free.get("triangle").is_none() && free.get("distance").is_none());
        }
        for other in [points, free] {
            assert!(close(&other["quality"], &result["quality"]), "{other}");
            assert_eq!(other["explanation"], Value::Null);
        }
    }
}

#[tokio::test(flavor = "multi_thread")]
async fn thousands_of_grasps_are_answered_in_their_order_and_as_if_each_were_alone() {
    let server = server().await;
    let mesh = server.mesh(small_box()).await;
    let grasps: Vec<_> = (0..2000).map(seven).collect();
    let body = |grasps: &[Vec<Value>]| json!({"mesh_id": mesh, "friction": 0, "grasps": grasps});
    let all = evaluations(&server, &body(&grasps)).await;
    let all = all["evaluations"].as_array().unwrap();
    assert_eq!(all.len(), grasps.len());
    for (found, asked) in all.iter().zip(&grasps) {
        let contacts = found["contacts"].as_array().unwrap();
        let triangles: Vec<_> = contacts.iter().map(|c| &c["triangle"]).collect();
        let wanted: Vec<_> = asked.iter().map(|c| &c["triangle"]).collect();
        assert_eq!(triangles, wanted);
    }
    for index in [0, 1, 999, 1999] {
        let alone = evaluations(&server, &body(&grasps[index..=index])).await;
        assert_eq!(alone["evaluations"][0], all[index]);
    }
}

#[tokio::test(flavor = "multi_thread")]
async fn form_json_and_command_line_answer_the_same_bytes_on_any_number_of_threads() {
    let server = server_with(&["--threads-per-job", "3"]).await;
    let mesh = server.mesh(small_box()).await;
    let grasps = json!([seven(1), four(), seven(2), [{"triangle": 5}], seven(3)]);
    let wrenches = json!([{"force": [0, 0, -9.81]}, {"torque": [0.1, 0, 0], "force": [1, 0, 0]}]);
    let settings = json!({"contact_model": "soft", "cone_edges": 5, "units": "mm"});
    let mut document = settings.clone();
    document["grasps"] = grasps.clone();
    document["external_wrenches"] = wrenches.clone();
    let mut body = document.clone();
    body["mesh_id"] = mesh.as_str().into();
    let expected = evaluate(&server, &body).await;
    assert_eq!(evaluate(&server, &body).await, expected);

    let fields = file(small_box())
        .text("grasps", grasps.to_string())
        .text("external_wrenches", wrenches.to_string())
        .text("contact_model", "soft")
        .text("cone_edges", "5")
        .text("units", "mm");
    let whole = file(small_box()).part("request", Part::text(document.to_string()));
    for form in [fields, whole] {
        let answer = server.post("/evaluations").multipart(form).send().await;
        assert_eq!(answer.unwrap().bytes().await.unwrap(), expected);
    }

    let path = server.folder.path().join("box.stl");
    std::fs::write(&path, small_box()).unwrap();
    for threads in ["1", "2"] {
        let output = command(
            &path,
            &document.to_string(),
            &["--json", "--threads", threads],
        );
        assert_eq!(output.stdout, expected);
    }
    let own = json!({"grasps": grasps, "external_wrenches": wrenches}).to_string();
    let flags = [
        "--json",
        "--contact-model",
        "soft",
        "--cone-edges",
        "5",
        "--units",
        "mm",
    ];
    assert_eq!(command(&path, &own, &flags).stdout, expected);
}

#[tokio::test(flavor = "multi_thread")]
async fn of_a_mesh_in_a_form_nothing_stays() {
    let server = server().await;
    for grasps in ["[[{\"triangle\": 0}]]", "[[{\"triangle\": 100000}]]"] {
        let form = file(small_box()).text("grasps", grasps);
        let answer = server
            .post("/evaluations")
            .multipart(form)
            .send()
            .await
            .unwrap();
        let fine = answer.status() == StatusCode::OK;
        assert_eq!(fine, grasps.len() < 20, "{grasps}");
    }
    assert_eq!(server.json("/meshes").await["meshes"], json!([]));
    assert_eq!(server.kept_files(), [""; 0]);
}

#[tokio::test(flavor = "multi_thread")]
async fn settings_change_the_quality_as_they_must() {
    let server = server().await;
    let mesh = server.mesh(small_box()).await;
    let with = async |settings: Value| {
        let mut body = settings;
        body["mesh_id"] = mesh.as_str().into();
        body["grasps"] = json!([four()]);
        let found = evaluations(&server, &body).await;
        assert_eq!(found["evaluations"][0]["force_closure"], true, "{found}");
        found
    };
    let quality = |found: &Value| number(&found["evaluations"][0]["quality"]);
    let bounds = |found: &Value| -> [f64; 2] {
        serde_json::from_value(found["evaluations"][0]["bounds"].clone()).unwrap()
    };
    let hard = with(json!({})).await;
    let [lower, upper] = bounds(&hard);
    assert!(
        quality(&hard) <= lower && upper <= lower * (1.0 + 2e-6),
        "{lower} {upper}"
    );
    let fine = with(json!({"cone_edges": 32})).await;
    assert!(quality(&hard) < quality(&fine) && quality(&fine) <= upper);
    let round = with(json!({"cone_edges": 0})).await;
    assert_eq!(round["cone_edges"], 0);
    assert_eq!([quality(&round), upper], [lower, bounds(&round)[1]]);

    let normal = with(json!({"edge_norm": "unit_normal"})).await;
    assert!((quality(&normal) / quality(&hard) - 1.25f64.sqrt()).abs() < 1e-9);
    let sum = with(json!({"wrench_space": "linf"})).await;
    assert!(quality(&sum) > quality(&hard) && quality(&sum) <= 4.0 * quality(&hard));
    let measures = &hard["evaluations"][0]["measures"];
    assert_eq!(number(&measures["epsilon_l1"]), quality(&hard));
    assert!((number(&measures["epsilon_linf"]) / quality(&sum) - 1.0).abs() < 1e-5);

    let soft = with(json!({"contact_model": "soft"})).await;
    assert!(quality(&soft) >= quality(&hard));
    // Half the diagonal of 1 by 2 by 3, over twenty.
    assert!((number(&soft["torsional_friction"]) - 3.5f64.sqrt() / 20.0).abs() < 1e-6);
    let stiff = with(json!({"contact_model": "soft", "torsional_friction": 1.5})).await;
    assert_eq!(stiff["torsional_friction"], 1.5);
    assert!(quality(&stiff) > quality(&soft));
}

#[tokio::test(flavor = "multi_thread")]
async fn forces_balance_what_they_resist() {
    let server = server().await;
    let mesh = server.mesh(small_box()).await;
    let wrench = json!({"force": [1, -2, 3], "torque": [0.3, 0.2, -0.1]});
    let body = json!({
        "mesh_id": mesh, "external_wrench": wrench,
        "grasps": [four(), [{"point": [0, 0, 2]}]]
    });
    let found = evaluations(&server, &body).await;
    let center = vector(&found["center_of_mass"]);
    let total = |grasp: &Value, forces: Vec<[f64; 3]>| {
        let (mut force, mut torque, mut pushed) = ([0.0; 3], [0.0; 3], 0.0);
        for (contact, f) in grasp["contacts"].as_array().unwrap().iter().zip(forces) {
            let (at, normal) = (vector(&contact["position"]), vector(&contact["normal"]));
            let arm: Vec<f64> = at.iter().zip(center).map(|(p, c)| p - c).collect();
            for k in 0..3 {
                force[k] += f[k];
                let (i, j) = ((k + 1) % 3, (k + 2) % 3);
                torque[k] += arm[i] * f[j] - arm[j] * f[i];
                pushed += f[k] * normal[k];
            }
        }
        (force, torque, pushed)
    };
    let grasp = &found["evaluations"][0];
    let forces = serde_json::from_value(grasp["resisted"][0]["forces"].clone()).unwrap();
    let (force, torque, pushed) = total(grasp, forces);
    assert!(distance(force, [-1.0, 2.0, -3.0]) < 1e-6, "{force:?}");
    assert!(distance(torque, [-0.3, -0.2, 0.1]) < 1e-6, "{torque:?}");
    assert!((pushed - number(&grasp["resisted"][0]["effort"])).abs() < 1e-6);

    let shown = grasp["contacts"].as_array().unwrap();
    let forces = shown
        .iter()
        .map(|contact| vector(&contact["forces"]))
        .collect();
    let (force, torque, pushed) = total(grasp, forces);
    let scale = number(&found["torque_scale"]["value"]);
    let weakest = &grasp["weakest_wrench"];
    assert!(distance(force, vector(&weakest["force"])) < 1e-6);
    assert!(distance(torque.map(|t| t * scale), vector(&weakest["torque"])) < 1e-6);
    // Edges of unit length that sum to one exert ε in that direction.
    let least = (1.25f64.sqrt() * number(&grasp["quality"])).recip();
    assert!((pushed / least - 1.0).abs() < 1e-6, "{pushed} {least}");

    let alone = &found["evaluations"][1]["resisted"][0];
    assert_eq!(
        alone,
        &json!({"resisted": false, "effort": null, "forces": null})
    );
}

#[tokio::test(flavor = "multi_thread")]
async fn what_keeps_a_grasp_from_force_closure_is_told() {
    let server = server().await;
    let mesh = server.mesh(small_box()).await;
    let pinch = json!([
        {"point": [0.1, 0.2, 1.5], "normal": [0, 0, -2]},
        {"point": [0.1, 0.2, -1.5], "normal": [0, 0, 1]}
    ]);
    let corner =
        json!([{"point": [0.6, 0.1, 0.2]}, {"point": [0.1, 1.2, -0.3]}, {"point": [0.2, 0.3, 2]}]);
    let body = |settings: Value, grasps: &[&Value]| {
        let mut body = settings;
        body["mesh_id"] = mesh.as_str().into();
        body["grasps"] = json!(grasps);
        body
    };
    let found = evaluations(&server, &body(json!({}), &[&pinch, &corner])).await;
    let [pinched, pressed] = &found["evaluations"].as_array().unwrap()[..] else {
        panic!("{found}");
    };
    for grasp in [pinched, pressed] {
        assert_eq!(grasp["force_closure"], false);
        assert_eq!([&grasp["quality"], &grasp["bounds"]], [&Value::Null; 2]);
        let words = grasp["explanation"]["detail"].as_str().unwrap();
        assert!(words.contains("Nothing hinders a "), "{words}");
        assert!(grasp["contacts"][0].get("forces").is_none());
    }
    let motion = &pinched["explanation"]["motion"];
    assert_eq!(pinched["explanation"]["reason"], "rank_deficient");
    assert_eq!(pinched["explanation"]["rank"], 5);
    assert_eq!(motion["kind"], "rotation");
    assert!((vector(&motion["axis"])[2].abs() - 1.0).abs() < 1e-9);
    let [x, y, _] = vector(&motion["point"]);
    assert!(distance([x, y, 0.0], [0.1, 0.2, 0.0]) < 1e-6, "{motion}");

    assert_eq!(pressed["explanation"]["reason"], "origin_outside");
    let outside = number(&pressed["explanation"]["distance"]);
    assert!(outside > 0.1);
    assert_eq!(number(&pressed["margin"]), -outside);

    let soft = body(json!({"contact_model": "soft"}), &[&pinch]);
    let soft = evaluations(&server, &soft).await;
    assert_eq!(soft["evaluations"][0]["force_closure"], true);
    assert!(soft["evaluations"][0]["contacts"][0]["torsion"].is_number());
}

#[tokio::test(flavor = "multi_thread")]
async fn what_cannot_be_used_is_named() {
    let server = server().await;
    let mesh = server.mesh(small_box()).await;
    let contact = |contact: Value| json!({"grasps": [[{"triangle": 1}], [contact]]});
    let with = |name: &str, value: Value| json!({"grasps": [[{"triangle": 1}]], name: value});
    for (mut body, pointer) in [
        (json!({}), "/grasps"),
        (json!({"grasps": []}), "/grasps"),
        (json!({"grasps": {"0": []}}), "/grasps"),
        (
            json!({"grasps": vec![[json!({"triangle": 1})]; 10_001]}),
            "/grasps",
        ),
        (json!({"grasps": [[{"triangle": 1}], []]}), "/grasps/1"),
        (
            json!({"grasps": [vec![json!({"triangle": 1}); 65]]}),
            "/grasps/0",
        ),
        (contact(json!(17)), "/grasps/1/0"),
        (contact(json!({})), "/grasps/1/0"),
        (
            contact(json!({"triangle": TRIANGLES})),
            "/grasps/1/0/triangle",
        ),
        (contact(json!({"triangle": -1})), "/grasps/1/0/triangle"),
        (contact(json!({"triangle": "1"})), "/grasps/1/0/triangle"),
        (
            contact(json!({"triangle": 1, "point": [0, 0, 0]})),
            "/grasps/1/0/triangle",
        ),
        (contact(json!({"point": [0, 0]})), "/grasps/1/0/point"),
        (contact(json!({"point": [0, 0, null]})), "/grasps/1/0/point"),
        (contact(json!({"point": [0, 0, 1e13]})), "/grasps/1/0/point"),
        (
            contact(json!({"point": [0, 0, 1], "normal": [0, 0, 0]})),
            "/grasps/1/0/normal",
        ),
        (
            contact(json!({"point": [0, 0, 1e6], "normal": [0, 0, 1]})),
            "/grasps/1/0/point",
        ),
        (contact(json!({"normal": [0, 0, 1]})), "/grasps/1/0"),
        (
            contact(json!({"triangle": 1, "finger": "thumb"})),
            "/grasps/1/0/finger",
        ),
        (
            with("external_wrench", json!([1, 2, 3])),
            "/external_wrench",
        ),
        (
            with("external_wrench", json!({"force": [1, 2]})),
            "/external_wrench/force",
        ),
        (with("external_wrenches", json!({})), "/external_wrenches"),
        (
            with("external_wrenches", json!([{}])),
            "/external_wrenches/0",
        ),
        (with("contacts", json!(4)), "/contacts"),
        (with("seed", json!(4)), "/seed"),
        (with("friction", json!(-1)), "/friction"),
        (with("cone_edges", json!(2)), "/cone_edges"),
        (with("wrench_space", json!("l2")), "/wrench_space"),
        (with("torsional_friction", json!(1)), "/torsional_friction"),
        (with("torque_scale", json!(1e9)), "/torque_scale"),
        (
            with("center_of_mass", json!([0, 0, 1e9])),
            "/center_of_mass",
        ),
    ] {
        let text = body.to_string();
        body["mesh_id"] = mesh.as_str().into();
        let found = refused(&server, &body, 422).await;
        let shown = &text[..text.len().min(200)];
        assert_eq!(pointers(&found), [pointer], "{shown}");
        let form = file(small_box()).part("request", Part::text(text.clone()));
        let answer = server.post("/evaluations").multipart(form).send().await;
        assert_eq!(problem(answer.unwrap(), 422).await, found, "{shown}");
    }
    for mesh_id in [Value::Null, json!(7), json!("nope"), json!("0".repeat(64))] {
        let body = json!({"mesh_id": mesh_id, "grasps": [[{"triangle": 1}]]});
        assert_eq!(pointers(&refused(&server, &body, 422).await), ["/mesh_id"]);
    }
    let many = json!({"mesh_id": mesh, "grasps": vec![[json!({"triangle": 99_999})]; 50]});
    assert_eq!(pointers(&refused(&server, &many, 422).await).len(), 20);
}

#[tokio::test(flavor = "multi_thread")]
async fn triangles_without_a_normal_are_refused() {
    let server = server().await;
    let mut bytes = small_box();
    let sliver = stl(&[[[0.0, 0.0, 1.5], [0.25, 0.0, 1.5], [0.125, 0.0, 1.5]]]);
    bytes.extend(&sliver[84..]);
    bytes[80..84].copy_from_slice(&(TRIANGLES as u32 + 1).to_le_bytes());
    let mesh = server.mesh(bytes).await;
    let body = json!({"mesh_id": mesh, "grasps": [[{"triangle": TRIANGLES}]]});
    let found = refused(&server, &body, 422).await;
    assert_eq!(pointers(&found), ["/grasps/0/0/triangle"]);
    assert!(
        found["errors"][0]["detail"]
            .as_str()
            .unwrap()
            .contains("degenerate")
    );
}

#[tokio::test(flavor = "multi_thread")]
async fn what_is_no_such_request_is_refused_before_it_is_looked_at() {
    let server = server().await;
    let mesh = server.mesh(small_box()).await;
    let send = async |kind: &str, body: Vec<u8>| {
        let request = server.post("/evaluations").header("content-type", kind);
        request.body(body).send().await.unwrap()
    };
    let deep = format!("{{\"grasps\":{}{}}}", "[".repeat(200), "]".repeat(200));
    for body in [
        "",
        "{",
        "{} {}",
        "{\"friction\":1,\"friction\":1}",
        "{\"grasps\":[[{\"triangle\":1,\"triangle\":1}]]}",
        &deep,
    ] {
        problem(send("application/json", body.into()).await, 400).await;
    }
    problem(send("text/plain", b"{}".to_vec()).await, 415).await;
    problem(
        send("application/json; charset=utf-16", b"{}".to_vec()).await,
        415,
    )
    .await;
    let long = vec![b' '; (8 << 20) + 1];
    problem(send("application/json", long.clone()).await, 413).await;
    let form = file(small_box()).text("grasps", String::from_utf8(long).unwrap());
    let answer = server.post("/evaluations").multipart(form).send().await;
    problem(answer.unwrap(), 413).await;
    let no_mesh = Part::bytes(b"%PDF-1.7, and no mesh".to_vec()).file_name("box.stl");
    for (form, status) in [
        (Form::new().text("grasps", "[[{\"triangle\":1}]]"), 400),
        (
            file(small_box()).part("mesh", Part::bytes(small_box()).file_name("b.stl")),
            400,
        ),
        (
            file(small_box())
                .text("friction", "1")
                .text("request", "{}"),
            400,
        ),
        (
            Form::new()
                .part("mesh", no_mesh)
                .text("grasps", "[[{\"triangle\":1}]]"),
            415,
        ),
        (file(small_box()).text("grasps", "[[{"), 422),
    ] {
        let answer = server.post("/evaluations").multipart(form).send().await;
        problem(answer.unwrap(), status).await;
    }

    let body = json!({"mesh_id": mesh, "grasps": [[{"triangle": 1}]]});
    let html = server
        .post("/evaluations")
        .header("accept", "text/html")
        .json(&body);
    problem(html.send().await.unwrap(), 406).await;
    let query = server.post("/evaluations?format=stl").json(&body);
    problem(query.send().await.unwrap(), 400).await;
    let answer = server.get("/evaluations").send().await.unwrap();
    assert_eq!(answer.headers()["allow"], "POST");
    problem(answer, 405).await;

    // Much more than a planning request may have.
    let mut padded = body.to_string().into_bytes();
    padded.resize(1 << 20, b' ');
    assert_eq!(
        send("application/json", padded).await.status(),
        StatusCode::OK
    );
    server.service.begin_drain();
    refused(&server, &body, 503).await;
    let form = file(small_box()).text("grasps", "[[{\"triangle\":1}]]");
    let answer = server.post("/evaluations").multipart(form).send().await;
    problem(answer.unwrap(), 503).await;
}

#[tokio::test(flavor = "multi_thread")]
async fn a_client_that_hangs_up_leaves_no_work_behind() {
    let server = server().await;
    let mesh = server.mesh(cuboid([1.0, 2.0, 3.0], 8)).await;
    // Far more than the time that one call may take.
    let crowd: Vec<_> = (0..64).map(|n| json!({"triangle": n * 11})).collect();
    let heavy = json!({"mesh_id": mesh, "cone_edges": 32, "grasps": vec![crowd; 5_000]});
    for _ in 0..3 {
        let request = server.post("/evaluations").json(&heavy);
        let call = request.timeout(Duration::from_millis(1500)).send();
        assert!(call.await.is_err_and(|fault| fault.is_timeout()));
    }
    // As long as one of them ran, its threads and then the places would be taken.
    let light = json!({"mesh_id": mesh, "friction": 0, "grasps": [[{"triangle": 1}]]});
    let answer = server.post("/evaluations").json(&light);
    let answer = answer.timeout(Duration::from_secs(20)).send().await;
    assert_eq!(answer.unwrap().status(), StatusCode::OK);
}

#[test]
fn the_command_says_by_its_exit_code_how_it_went() {
    let folder = tempfile::tempdir().unwrap();
    let mesh = folder.path().join("box.stl");
    std::fs::write(&mesh, small_box()).unwrap();
    let held = json!([four()]).to_string();
    let both = json!([four(), [{"triangle": 1}]]).to_string();
    let planned = json!({"quality": 0.1, "contacts": [{"triangle": 1, "position": [0, 0, 0]}]});
    for (grasps, flags, code, said) in [
        (held.as_str(), &[][..], 0, ""),
        (&both, &[], 3, ""),
        (&planned.to_string(), &[], 3, ""),
        (&held, &["--friction", "0"], 3, ""),
        (
            &held,
            &["--friction", "much"],
            2,
            "--friction: must be a number",
        ),
        (&held, &["--seed", "1"], 2, "--seed"),
        (
            "[[{\"triangle\": 1000}]]",
            &[],
            1,
            "/grasps/0/0/triangle: the mesh has no triangle",
        ),
        ("[[{\"face\": 1}]]", &[], 1, "/grasps/0/0/face: unknown"),
        ("[[", &[], 1, "Malformed JSON"),
        ("7", &[], 1, "must be a JSON object"),
        (
            &held,
            &["--center-of-mass", "0,0,1e9"],
            1,
            "/center_of_mass",
        ),
    ] {
        let output = command(&mesh, grasps, flags);
        let error = String::from_utf8(output.stderr).unwrap();
        assert_eq!(
            output.status.code(),
            Some(code),
            "{grasps} {flags:?}: {error}"
        );
        assert!(error.contains(said), "{error}");
    }
    let output = command(&mesh, &both, &[]);
    let shown = String::from_utf8(output.stdout).unwrap();
    for words in [
        "grasp 0: force closure, quality 0.",
        "grasp 1: no force closure: ",
        "Nothing hinders a ",
        "isotropy",
    ] {
        assert!(shown.contains(words), "{shown}");
    }
    let output = command(&folder.path().join("none.stl"), &held, &[]);
    assert_eq!(output.status.code(), Some(1));
}
