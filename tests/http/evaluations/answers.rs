//! The same grasps get the same answers.

use super::*;

#[tokio::test(flavor = "multi_thread")]
async fn a_planned_grasp_evaluates_alike_however_its_contacts_are_given() {
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
async fn a_mesh_in_a_form_is_not_kept() {
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
