//! Runs with constraints.

use super::*;

/// The upper part of the duck but for the top of its head and a slab at its back.
fn constraints() -> Value {
    json!({
        "include": [{"half_space": {"point": [0, 0, 30], "normal": [0, 0, 1]}}],
        "exclude": [
            {"sphere": {"center": [0, 0, 80], "radius": 12}},
            {"box": {"min": [-100, -100, 29], "max": [0, 100, 33]}},
            {"triangles": [0, 1, 2]}
        ],
        "min_contact_distance": 15,
        "max_contact_distance": 70
    })
}

#[test]
fn constraints_hold_and_the_removed_places_are_counted() {
    let mesh = example("duck.obj");
    let settings = json!({"seed": 2, "generations": 20, "constraints": constraints()});
    let result = plan(&mesh, &settings);
    assert!(result.force_closure, "{:?}", result.explanation);
    for grasp in [&result.contacts, &result.initial.as_ref().unwrap().contacts] {
        assert_eq!(grasp.len(), 4);
        for (i, contact) in grasp.iter().enumerate() {
            let [x, y, z] = contact.position;
            assert!(z >= 30.0 && !(x <= 0.0 && z <= 33.0));
            assert!((x * x + y * y + (z - 80.0).powi(2)).sqrt() > 12.0);
            for other in &grasp[..i] {
                let [a, b, c] = other.position;
                let distance = ((x - a).powi(2) + (y - b).powi(2) + (z - c).powi(2)).sqrt();
                assert!((15.0..=70.0).contains(&distance), "{distance}");
            }
        }
    }
    let report = result.constraints.as_ref().unwrap();
    let rules: Vec<String> = report.iter().map(|rule| rule.rule.to_string()).collect();
    assert_eq!(rules, ["include", "exclude[0]", "exclude[1]", "exclude[2]"]);
    let removed: u64 = report.iter().map(|rule| rule.removed as u64).sum();
    assert_eq!(result.candidates + removed, mesh.report().candidates as u64);
    assert!(report[0].removed > 0 && report[1].removed > 0 && report[2].removed > 0);
    let free = plan(&mesh, &json!({"seed": 2, "generations": 1}));
    assert_eq!(free.constraints, None);
    let on = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
        pool.unwrap().install(|| bytes(&plan(&mesh, &settings)))
    };
    assert_eq!(on(1), bytes(&result));
    assert_eq!(on(3), bytes(&result));
}

#[test]
fn constraints_that_leave_no_grasp_are_explained() {
    let mesh = example("box.stl");
    let nowhere = json!({"constraints": {
        "include": [{"triangles": [5, 6, 7]}],
        "exclude": [{"triangles": [7]}]
    }});
    let result = plan(&mesh, &nowhere);
    assert!(!result.force_closure && result.contacts.is_empty());
    assert_eq!(result.stopped_because, StopReason::Infeasible);
    assert_eq!((result.candidates, result.evaluations), (2, 0));
    let explanation = result.explanation.unwrap();
    assert_eq!(explanation.reason, Reason::Constraints);
    assert!(explanation.proven);
    for expected in ["4 contacts", "2 candidates", "include 1877", "exclude[0] 1"] {
        assert!(
            explanation.detail.contains(expected),
            "{}",
            explanation.detail
        );
    }
    let too_far = json!({"constraints": {"min_contact_distance": 10}});
    let result = plan(&mesh, &too_far);
    let explanation = result.explanation.unwrap();
    assert_eq!(explanation.reason, Reason::Constraints);
    assert_eq!((explanation.proven, result.evaluations), (true, 0));
    assert!(
        explanation
            .detail
            .contains("as far apart as min_contact_distance")
    );
    assert_eq!(result.constraints, Some(Vec::new()));
    // Two places of the box are a diagonal apart, but no four.
    for (spacing, named, not_named) in [
        (json!({"min_contact_distance": 1.1}), "min_", "max_"),
        (json!({"max_contact_distance": 1e-6}), "max_", "min_"),
    ] {
        let result = plan(&mesh, &json!({"seed": 1, "constraints": spacing}));
        let explanation = result.explanation.unwrap();
        assert_eq!(explanation.reason, Reason::Constraints);
        assert!(!explanation.proven);
        let has = |name: &str| explanation.detail.contains(name);
        assert!(has(named) && !has(not_named), "{}", explanation.detail);
    }
    // All that is left is two faces side by side.
    let corner = json!({"constraints": {
        "approach_directions": [[-2, 0, -2]], "max_normal_angle": 50
    }});
    let result = plan(&mesh, &corner);
    let explanation = result.explanation.unwrap();
    assert_eq!(explanation.reason, Reason::OneSided);
    for expected in [
        "at any of the places left by the constraints",
        "max_normal_angle",
    ] {
        assert!(
            explanation.detail.contains(expected),
            "{}",
            explanation.detail
        );
    }
    assert!(!explanation.detail.contains("on this mesh"));
    assert_eq!(result.contacts.len(), 4);
    let allowed = [[-1.0, 0.0, 0.0], [0.0, 0.0, -1.0]];
    assert!(
        result
            .contacts
            .iter()
            .all(|contact| allowed.contains(&contact.normal))
    );
    let unknown = json!({"constraints": {"exclude": [{"triangles": [1, 1880]}],
        "fixed_contacts": [{"triangle": 9999}]}});
    let problem = run::plan(&mesh, &request(&unknown), Interrupt::never(), &mut |_| {});
    let pointers: Vec<String> = problem
        .unwrap_err()
        .errors
        .into_iter()
        .map(|e| e.pointer)
        .collect();
    let expected = [
        "/constraints/fixed_contacts/0/triangle",
        "/constraints/exclude/0/triangles/1",
    ];
    assert_eq!(pointers, expected);
}

#[test]
fn fixed_contacts_come_first_and_count_for_the_quality() {
    let mesh = example("duck.obj");
    for (space, edges) in [("l1", 8), ("linf", 0)] {
        let measured = json!({"wrench_space": space, "cone_edges": edges});
        let mut settings = measured.clone();
        for (name, value) in [
            ("contacts", json!(5)),
            ("seed", json!(3)),
            ("population", json!(40)),
            ("generations", json!(5)),
            (
                "constraints",
                json!({
                    "fixed_contacts": [
                        {"triangle": 347},
                        {"point": [27.7, 10.7, 69.9]},
                        {"point": [0, 0, 0], "normal": [0, 0, 3]}
                    ],
                    "min_contact_distance": 10
                }),
            ),
        ] {
            settings[name] = value;
        }
        let result = plan(&mesh, &settings);
        assert!(result.force_closure);
        let fixed: Vec<bool> = result
            .contacts
            .iter()
            .map(|contact| contact.fixed)
            .collect();
        assert_eq!(fixed, [true, true, true, false, false]);
        let [first, second, third] = &result.contacts[..3] else {
            panic!("three of them");
        };
        assert_eq!((first.triangle, second.triangle), (Some(347), Some(6242)));
        assert_eq!((third.triangle, third.barycentric), (None, None));
        assert_eq!((third.position, third.normal), ([0.0; 3], [0.0, 0.0, 1.0]));
        let written = serde_json::to_value(&result.contacts).unwrap();
        assert!(written[4].get("fixed").is_none() && written[2].get("triangle").is_none());
        assert!(
            result
                .contacts
                .iter()
                .all(|contact| contact.forces.is_some())
        );
        for (grasp, quality) in [
            (&result.contacts, result.quality),
            (
                &result.initial.as_ref().unwrap().contacts,
                result.initial.as_ref().map(|initial| initial.quality),
            ),
        ] {
            let given: Vec<Value> = grasp
                .iter()
                .map(|c| json!({"point": c.position, "normal": c.normal}))
                .collect();
            let mut asked = measured.clone();
            asked["grasps"] = json!([given]);
            let asked = EvaluationRequest::from_json(&asked).unwrap();
            let found = run::evaluate(&mesh, &asked, Interrupt::never());
            let found = found.unwrap().evaluations.remove(0);
            let difference = found.quality.unwrap() - quality.unwrap();
            assert!(difference.abs() < 1e-12, "{difference}");
        }
    }
}
