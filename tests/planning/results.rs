//! What a result says, and of which bodies.

use super::*;

#[test]
fn the_same_seed_gives_the_same_bytes_on_any_number_of_threads() {
    let cases = [
        (
            "box.stl",
            json!({"contact_model": "frictionless", "seed": 5, "generations": 10}),
        ),
        (
            "duck.obj",
            json!({"contacts": 3, "seed": 6, "generations": 4, "population": 60}),
        ),
    ];
    for (name, settings) in cases {
        let mesh = example(name);
        let on = |threads| {
            let pool = rayon::ThreadPoolBuilder::new()
                .num_threads(threads)
                .build()
                .unwrap();
            pool.install(|| bytes(&plan(&mesh, &settings)))
        };
        let one = on(1);
        assert_eq!(one, on(2));
        assert_eq!(one, on(2));
        let other = plan(
            &mesh,
            &json!({"seed": 7, "generations": 4, "population": 60}),
        );
        assert_ne!(one, bytes(&other));
    }
}

#[test]
fn progress_ends_with_what_the_result_says() {
    let mesh = example("box.stl");
    for method in ["memetic", "modified_ga", "local", "random"] {
        for analysis in [json!(null), json!([0.0, 0.0, -1.0])] {
            let mut settings = json!({"method": method, "population": 10, "generations": 2});
            if !analysis.is_null() {
                settings["gravity"] = analysis;
            }
            let mut last = None;
            let result = run::plan(
                &mesh,
                &request(&settings),
                Interrupt::never(),
                &mut |progress| {
                    last = Some(progress.clone());
                },
            )
            .unwrap();
            assert_eq!(last.unwrap().best_quality, result.quality, "{settings}");
        }
    }
}

#[test]
fn progress_reports_every_new_best_grasp() {
    let mesh = example("duck.obj");
    let fixed = json!({"fixed_contacts": [{"triangle": 347}]});
    let sorted = |positions: &mut dyn Iterator<Item = [f64; 3]>| {
        let mut positions: Vec<_> = positions.collect();
        positions.sort_by(|a, b| a.partial_cmp(b).unwrap());
        positions
    };
    for method in ["memetic", "modified_ga", "local", "random"] {
        for constraints in [json!({}), fixed.clone()] {
            let settings = json!({
                "method": method, "polish": false, "population": 10, "generations": 4,
                "seed": 3, "constraints": constraints
            });
            let mut reports: Vec<(Option<f64>, Vec<[f64; 3]>)> = Vec::new();
            let result = run::plan(
                &mesh,
                &request(&settings),
                Interrupt::never(),
                &mut |progress| {
                    if let Some(contacts) = &progress.best_contacts {
                        let mut positions = contacts.iter().map(|contact| contact.position.into());
                        reports.push((progress.best_quality, sorted(&mut positions)));
                    }
                },
            )
            .unwrap();
            let last = sorted(&mut result.contacts.iter().map(|contact| contact.position));
            let (quality, contacts) = reports.last().expect("progress was reported");
            assert_eq!((*quality, contacts), (result.quality, &last), "{settings}");
            reports.dedup_by(|a, b| a.1 == b.1);
            assert!(reports.len() > 1 || method != "memetic", "{settings}");
        }
    }
}

#[test]
fn the_result_carries_the_numbers_it_depends_on() {
    let mesh = example("box.stl");
    let result = plan(
        &mesh,
        &json!({"friction": 0.4, "seed": 3, "generations": 5, "units": "mm", "polish": false}),
    );
    assert!(result.force_closure && result.explanation.is_none());
    assert_eq!(result.quality, result.margin);
    assert_eq!(result.contacts.len(), 4);
    assert_eq!(result.history.len(), 6);
    assert_eq!(result.stopped_because, StopReason::GenerationLimit);
    assert_eq!(result.torque_scale.kind, "max_radius");
    let radius = (0.25_f64 + 0.09 + 0.04).sqrt();
    assert!((result.torque_scale.value * radius - 1.0).abs() < 1e-6);
    assert!(result.quality.unwrap() >= result.initial.unwrap().quality);
    for contact in &result.contacts {
        let corners = mesh.triangles()[contact.triangle.unwrap() as usize]
            .map(|v| mesh.vertices()[v as usize]);
        for axis in 0..3 {
            let centroid: f64 = corners.iter().map(|p| p[axis] / 3.0).sum();
            assert!((contact.position[axis] - centroid).abs() < 1e-12);
            assert_eq!(contact.normal[axis], -contact.approach[axis]);
        }
        // On a convex body every inward normal has the centre on its side.
        let inward: f64 = (0..3)
            .map(|k| contact.normal[k] * (contact.position[k] - result.center_of_mass[k]))
            .sum();
        assert!(inward < 0.0);
    }
}

#[test]
fn a_body_that_cannot_be_held_is_explained() {
    let mesh = icosahedron();
    let result = plan(&mesh, &json!({"contact_model": "frictionless"}));
    assert!(!result.force_closure && result.quality.is_none());
    assert_eq!(result.stopped_because, StopReason::Impossible);
    let explanation = result.explanation.unwrap();
    assert!(explanation.proven);
    assert_eq!(explanation.reason, Reason::RankDeficient);
    assert!(explanation.detail.contains("3 of 6") && explanation.detail.contains("torque"));
    assert!(plan(&mesh, &json!({"friction": 0.5})).force_closure);

    let explanation = plan(&example("box.stl"), &json!({"contacts": 2}))
        .explanation
        .unwrap();
    assert_eq!(explanation.reason, Reason::TooFewContacts);
}

#[test]
fn more_contacts_than_candidates_is_a_problem_that_names_both() {
    let problem = run::plan(
        &icosahedron(),
        &request(&json!({"contacts": 21, "candidates": "triangles"})),
        Interrupt::never(),
        &mut |_| {},
    )
    .unwrap_err();
    assert_eq!(problem.status, 422);
    assert!(problem.detail.contains("21 contacts") && problem.detail.contains("20 candidates"));
}

/// Whether a grasp is force closure does not depend on where torques are taken about nor on their
/// scale; what such numbers cannot express is refused, and never proven impossible.
#[test]
fn far_centres_and_odd_torque_scales_are_held_or_refused() {
    let mesh = example("duck.obj");
    let radius = mesh.report().bounding_radius;
    for (center, scale) in [(50.0, 1.0), (0.0, 1e-5), (0.0, 1e5), (90.0, 1e-3)] {
        let settings = json!({"seed": 1, "friction": 0.5, "generations": 3,
            "center_of_mass": [center * radius, 0.0, 0.0], "torque_scale": scale / radius});
        assert!(plan(&mesh, &settings).force_closure, "{center} {scale}");
    }
    for (field, value) in [
        ("center_of_mass", json!([1e6, 0.0, 0.0])),
        ("torque_scale", json!(1e-9)),
        ("torque_scale", json!(1e9)),
    ] {
        let settings = json!({ (field): value });
        let problem = run::plan(&mesh, &request(&settings), Interrupt::never(), &mut |_| {});
        let problem = problem.unwrap_err();
        assert_eq!(problem.status, 422);
        assert_eq!(problem.errors[0].pointer, format!("/{field}"));
    }
}

/// A body of revolution whose coordinates have been through single precision, as in STL.
#[test]
fn rounding_of_the_file_does_not_feign_force_closure() {
    let exact = icosahedron();
    let rounded = RawMesh {
        vertices: exact
            .vertices()
            .iter()
            .map(|v| v.map(|x| f64::from((x * 0.7) as f32)))
            .collect(),
        triangles: exact.triangles().to_vec(),
        ..RawMesh::default()
    };
    let mesh = Mesh::prepare(rounded).unwrap();
    let result = plan(&mesh, &json!({"contact_model": "frictionless", "seed": 1}));
    assert!(!result.force_closure);
    assert_eq!(result.explanation.unwrap().reason, Reason::RankDeficient);
}

#[test]
fn a_body_that_is_moved_turned_or_scaled_gets_the_same_grasp() {
    let mesh = example("duck.obj");
    let settings = json!({"seed": 4, "method": "modified_ga", "generations": 10, "population": 60});
    let triangles = |mesh: &Mesh| -> Vec<u32> {
        let contacts = plan(mesh, &settings).contacts;
        contacts.iter().filter_map(|c| c.triangle).collect()
    };
    let expected = triangles(&mesh);
    let turn = Rotation3::from_scaled_axis(Vector3::new(0.3, -1.1, 0.7));
    let motions: [&dyn Fn(Point3<f64>) -> Point3<f64>; 3] = [
        &|v| v + Vector3::new(1000.0, -3.0, 64.5),
        &|v| turn * v,
        &|v| v * 0.001,
    ];
    for motion in motions {
        let moved = RawMesh {
            vertices: mesh.vertices().iter().map(|v| motion(*v)).collect(),
            triangles: mesh.triangles().to_vec(),
            ..RawMesh::default()
        };
        assert_eq!(triangles(&Mesh::prepare(moved).unwrap()), expected);
    }
}
