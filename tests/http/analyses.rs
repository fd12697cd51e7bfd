//! Analyses of a grasp that are made on request: robustness, independent regions, quality for tasks.

use reqwest::StatusCode;
use serde_json::{Value, json};

use crate::common::{Server, file, pointers, problem, server, server_with, small_box};

/// All that can be asked for.
fn asked() -> Value {
    json!({
        "robustness": {"sigma": 0.1, "samples": 50, "seed": 9},
        "independent_regions": {"fraction": 0.6},
        "task_wrenches": [[0, 0, -2, 0, 0, 0], [0, 0, 0, 0.5, 0, 0], [1, 0, 0, 0, 0, 1]],
        "gravity": [0, 0, -9.81]
    })
}

/// Contacts on four sides of the box that hold it with friction.
fn four() -> Value {
    json!([
        {"point": [0.6, 0.1, 0.2]}, {"point": [-0.6, -0.2, 0.1]},
        {"point": [0.1, 1.2, -0.3]}, {"point": [-0.1, -1.2, 0.2]}
    ])
}

async fn evaluate(server: &Server, body: &Value) -> Value {
    let answer = server.post("/evaluations").json(body).send().await.unwrap();
    assert_eq!(answer.status(), StatusCode::OK, "{body}");
    answer.json().await.unwrap()
}

fn number(value: &Value) -> f64 {
    value
        .as_f64()
        .unwrap_or_else(|| panic!("{value} is no number"))
}

#[tokio::test(flavor = "multi_thread")]
async fn an_evaluation_has_the_requested_analyses_and_no_others() {
    let server = server_with(&["--threads-per-job", "3"]).await;
    let mesh = server.mesh(small_box()).await;
    let one_sided = json!([{"triangle": 0}, {"triangle": 1}]);
    let mut free = four();
    free[0] = json!({"point": [0.5, 0.1, 0.2], "normal": [-1, 0, 0]});
    let grasps = json!([four(), one_sided, free]);
    let plain = json!({"mesh_id": mesh, "grasps": grasps});
    let mut body = plain.clone();
    for (name, value) in asked().as_object().unwrap() {
        body[name] = value.clone();
    }
    let found = evaluate(&server, &body).await;
    assert_eq!(found, evaluate(&server, &body).await);
    let [held, pressed, free] = &found["evaluations"].as_array().unwrap()[..] else {
        panic!("{found}");
    };

    let quality = number(&held["quality"]);
    let robustness = &held["robustness"];
    for (name, value) in asked()["robustness"].as_object().unwrap() {
        assert_eq!(&robustness[name], value);
    }
    let share = number(&robustness["force_closure_probability"]);
    assert!(share > 0.5 && share <= 1.0, "{robustness}");
    let (tail, mean) = (
        number(&robustness["percentile_5"]),
        number(&robustness["expected"]),
    );
    assert!(0.0 <= tail && tail < mean && mean < 2.0 * quality);

    let task = &held["task_quality"];
    let each: Vec<f64> = task["per_wrench"]
        .as_array()
        .unwrap()
        .iter()
        .map(number)
        .collect();
    assert_eq!(each.len(), 3);
    assert!(each.iter().all(|s| *s >= quality * (1.0 - 1e-6)));
    let weakest = task["weakest"].as_u64().unwrap() as usize;
    assert_eq!(number(&task["least"]), each[weakest]);
    assert!(each.iter().all(|s| *s >= each[weakest]));
    assert_eq!(number(&held["gravity_quality"]), each[0]);

    let regions = held["independent_regions"].as_array().unwrap();
    assert_eq!(regions.len(), 4);
    let wanted = 0.6 * quality;
    for (finger, region) in regions.iter().enumerate() {
        let triangles: Vec<u64> = serde_json::from_value(region["triangles"].clone()).unwrap();
        assert_eq!(region["count"], triangles.len());
        assert_eq!(region["truncated"], false);
        assert!(number(&region["connected_area"]) <= number(&region["area"]) * (1.0 + 1e-12));
        assert!(region["connected"].as_u64().unwrap() <= triangles.len() as u64);
        // Every triangle of the box, one at a time.
        let mut moved = plain.clone();
        moved["grasps"] = (0..192)
            .map(|triangle| {
                let mut grasp = four();
                grasp[finger] = json!({"triangle": triangle});
                grasp
            })
            .collect();
        let moved = evaluate(&server, &moved).await;
        for (triangle, there) in (0..).zip(moved["evaluations"].as_array().unwrap()) {
            let holds = there["quality"].as_f64().is_some_and(|q| q >= wanted);
            assert_eq!(triangles.contains(&triangle), holds, "{finger} {triangle}");
        }
    }

    assert_eq!(pressed["force_closure"], false);
    assert!(pressed.get("independent_regions").is_none());
    assert_eq!(pressed["robustness"]["force_closure_probability"], 0.0);
    assert_eq!(pressed["robustness"]["expected"], 0.0);
    assert_eq!(pressed["task_quality"]["least"], 0.0);

    let regions = free["independent_regions"].as_array().unwrap();
    assert!(regions[0].get("connected").is_none() && regions[1]["connected"].is_number());
    let same =
        |name: &str| free["independent_regions"][0][name] == held["independent_regions"][0][name];
    assert!(same("triangles") && same("area"));

    let plain = evaluate(&server, &plain).await;
    for name in [
        "robustness",
        "independent_regions",
        "task_quality",
        "gravity_quality",
    ] {
        assert!(plain["evaluations"][0].get(name).is_none(), "{name}");
    }

    // The same from a form.
    let mut form = file(small_box()).text("grasps", grasps.to_string());
    for (name, value) in asked().as_object().unwrap() {
        form = form.text(name.clone(), value.to_string());
    }
    let answer = server.post("/evaluations").multipart(form).send().await;
    assert_eq!(answer.unwrap().json::<Value>().await.unwrap(), found);
}

#[tokio::test(flavor = "multi_thread")]
async fn a_plan_has_the_same_analyses_as_an_evaluation_of_its_grasp() {
    let server = server().await;
    let mesh = server.mesh(small_box()).await;
    for settings in [
        json!({}),
        json!({"friction": 0, "wrench_space": "linf"}),
        json!({"contact_model": "soft", "cone_edges": 0}),
    ] {
        let mut body = settings.clone();
        for (name, value) in asked().as_object().unwrap() {
            body[name] = value.clone();
        }
        let mut plan = body.clone();
        plan["population"] = 8.into();
        plan["generations"] = 2.into();
        plan["seed"] = 7.into();
        plan["polish"] = false.into();
        plan["candidates"] = "triangles".into();
        let job = server.job(&mesh, plan).await;
        let job = server.wait_for(&job, &["succeeded"]).await;
        for (name, value) in asked().as_object().unwrap() {
            let echoed = &job["request"][name];
            let same = match (echoed.as_array(), value.as_array()) {
                (Some(a), Some(b)) => a.len() == b.len(),
                _ => echoed == value,
            };
            assert!(same, "{name}");
        }
        let result = &job["result"];
        assert_eq!(result["force_closure"], true);
        let triangles: Vec<Value> = result["contacts"]
            .as_array()
            .unwrap()
            .iter()
            .map(|contact| json!({"triangle": contact["triangle"]}))
            .collect();
        body["mesh_id"] = mesh.as_str().into();
        body["grasps"] = json!([triangles]);
        let found = evaluate(&server, &body).await;
        for name in [
            "robustness",
            "independent_regions",
            "task_quality",
            "gravity_quality",
        ] {
            assert!(!result[name].is_null(), "{name} with {settings}");
            assert_eq!(
                result[name], found["evaluations"][0][name],
                "{name} with {settings}"
            );
        }
    }
}

#[tokio::test(flavor = "multi_thread")]
async fn analyses_that_cannot_be_made_are_refused() {
    let server = server().await;
    let mesh = server.mesh(small_box()).await;
    for (name, value, pointer) in [
        ("robustness", json!({}), "/robustness/sigma"),
        ("robustness", json!({"sigma": -1}), "/robustness/sigma"),
        // The box is two units from its middle to its corners.
        ("robustness", json!({"sigma": 2}), "/robustness/sigma"),
        (
            "robustness",
            json!({"sigma": 1, "samples": 1e5}),
            "/robustness/samples",
        ),
        (
            "robustness",
            json!({"sigma": 1, "count": 5}),
            "/robustness/count",
        ),
        (
            "independent_regions",
            json!({"fraction": 0}),
            "/independent_regions/fraction",
        ),
        ("independent_regions", json!(0.5), "/independent_regions"),
        ("task_wrenches", json!([]), "/task_wrenches"),
        (
            "task_wrenches",
            json!([[0, 0, 0, 0, 0, 0]]),
            "/task_wrenches/0",
        ),
        ("gravity", json!([0, 0, 0]), "/gravity"),
    ] {
        let body = json!({"mesh_id": mesh, "grasps": [four()], name: value});
        let answer = server
            .post("/evaluations")
            .json(&body)
            .send()
            .await
            .unwrap();
        assert_eq!(pointers(&problem(answer, 422).await), [pointer], "{body}");
        if value == json!({"sigma": 2}) {
            // Known only when the mesh is.
            let job = server.job(&mesh, json!({name: value})).await;
            let job = server.wait_for(&job, &["failed"]).await;
            assert_eq!(job["problem"]["errors"][0]["pointer"], pointer, "{job}");
            continue;
        }
        let body = json!({"mesh_id": mesh, name: value});
        let answer = server.post("/jobs").json(&body).send().await.unwrap();
        assert_eq!(pointers(&problem(answer, 422).await), [pointer], "{body}");
    }
}
