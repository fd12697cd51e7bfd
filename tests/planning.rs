//! A planning run from mesh bytes to result, without a server.

use std::ops::ControlFlow;

use graspd::core::mesh::{Limits, Mesh, RawMesh, read};
use graspd::run;
use graspd::wire::{
    ContactPoint, EvaluationRequest, PlanRequest, PlanResult, Reason, StoppedBecause,
};
use nalgebra::{Point3, Rotation3, Vector3};
use serde_json::{Value, json};

const LIMITS: Limits = Limits {
    triangles: 100_000,
    vertices: 100_000,
    ..Limits::NONE
};

fn example(name: &str) -> Mesh {
    let path = format!("{}/examples/meshes/{name}", env!("CARGO_MANIFEST_DIR"));
    let (format, raw) = read(&std::fs::read(path).unwrap(), None, &LIMITS).unwrap();
    Mesh::prepare(raw, format).unwrap()
}

/// A regular icosahedron: every normal passes through the centre.
fn icosahedron() -> Mesh {
    let phi = 1.618_033_988_749_895;
    let mut vertices = Vec::new();
    for axis in 0..3 {
        for (a, b) in [(1.0, phi), (-1.0, phi), (1.0, -phi), (-1.0, -phi)] {
            let mut v = Vector3::zeros();
            v[(axis + 1) % 3] = a;
            v[(axis + 2) % 3] = b;
            vertices.push(Point3::from(v));
        }
    }
    let mut triangles = Vec::new();
    let near = |i: u32, j: u32| (vertices[i as usize] - vertices[j as usize]).norm() < 2.1;
    for a in 0..12 {
        for b in a + 1..12 {
            for c in b + 1..12 {
                if near(a, b) && near(b, c) && near(c, a) {
                    triangles.push([a, b, c]);
                }
            }
        }
    }
    let raw = RawMesh {
        vertices,
        triangles,
    };
    Mesh::prepare(raw, None).unwrap()
}

fn request(settings: &Value) -> PlanRequest {
    PlanRequest::from_json(settings, 1).unwrap()
}

fn plan(mesh: &Mesh, settings: &Value) -> PlanResult {
    run::plan(mesh, &request(settings), &mut |_| ControlFlow::Continue(())).unwrap()
}

/// The result without the times, which alone may differ between two runs.
fn bytes(result: &PlanResult) -> String {
    let mut value = serde_json::to_value(result).unwrap();
    value["elapsed_s"].take();
    for entry in value["history"].as_array_mut().unwrap() {
        entry["elapsed_s"].take();
    }
    value.to_string()
}

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
    assert_eq!(result.stopped_because, StoppedBecause::GenerationLimit);
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
    assert_eq!(result.stopped_because, StoppedBecause::Impossible);
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
fn time_and_observer_stop_a_run_and_what_was_found_is_kept() {
    let mesh = example("duck.obj");
    let limited = json!({"seed": 1, "generations": 100_000, "time_limit_s": 0.3});
    let result = plan(&mesh, &limited);
    assert_eq!(result.stopped_because, StoppedBecause::TimeLimit);
    assert!(result.force_closure);

    let endless = json!({"seed": 1, "generations": 100_000});
    let mut polls = 0;
    let result = run::plan(&mesh, &request(&endless), &mut |_| {
        polls += 1;
        if polls == 20 {
            ControlFlow::Break(())
        } else {
            ControlFlow::Continue(())
        }
    });
    let result = result.unwrap();
    assert_eq!(result.stopped_because, StoppedBecause::Cancelled);
    assert!(result.force_closure);
}

#[test]
fn more_contacts_than_candidates_is_a_problem_that_names_both() {
    let problem = run::plan(
        &icosahedron(),
        &request(&json!({"contacts": 21, "candidates": "triangles"})),
        &mut |_| ControlFlow::Continue(()),
    )
    .unwrap_err();
    assert_eq!(problem.status, 422);
    assert!(problem.detail.contains("21 contacts") && problem.detail.contains("20 candidates"));
}

#[test]
fn limits_hold_from_the_first_evaluation_on() {
    let mesh = example("duck.obj");
    for limit in [1, 2, 100, 333] {
        let settings = json!({"seed": 1, "friction": 0.2, "evaluation_limit": limit});
        let result = plan(&mesh, &settings);
        assert_eq!(result.evaluations, limit);
        assert_eq!(result.stopped_because, StoppedBecause::EvaluationLimit);
    }
    let easy = plan(
        &mesh,
        &json!({"seed": 1, "target_quality": 1e-5, "polish": false}),
    );
    assert_eq!(easy.stopped_because, StoppedBecause::TargetQuality);
    assert_eq!(easy.quality, easy.initial.map(|grasp| grasp.quality));
    let hard = plan(
        &mesh,
        &json!({"seed": 1, "target_quality": 0.1, "polish": false}),
    );
    let last = hard.history.last().unwrap();
    assert_eq!(hard.stopped_because, StoppedBecause::TargetQuality);
    assert_eq!(
        (last.best, last.evaluations),
        (hard.quality, hard.evaluations)
    );
}

#[test]
fn a_long_history_is_thinned() {
    let settings = json!({"contact_model": "frictionless", "method": "random",
        "population": 2, "generations": 5000});
    let result = plan(&example("box.stl"), &settings);
    let history = &result.history;
    assert_eq!(history.len(), 1000);
    assert_eq!((history[0].generation, history[999].generation), (0, 5000));
    assert!(
        history
            .windows(2)
            .all(|w| w[0].generation < w[1].generation)
    );
}

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
fn constraints_hold_and_what_they_removed_is_told() {
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
    let rules: Vec<&str> = report.iter().map(|rule| rule.rule.as_str()).collect();
    assert_eq!(rules, ["include", "exclude[0]", "exclude[1]", "exclude[2]"]);
    let removed: u64 = report.iter().map(|rule| rule.removed).sum();
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
    assert_eq!(result.stopped_because, StoppedBecause::Infeasible);
    assert_eq!((result.candidates, result.evaluations), (2, 0));
    let explanation = result.explanation.unwrap();
    assert_eq!(explanation.reason, Reason::Constraints);
    assert!(explanation.proven);
    for told in ["4 contacts", "2 candidates", "include 1877", "exclude[0] 1"] {
        assert!(explanation.detail.contains(told), "{}", explanation.detail);
    }
    let too_far = json!({"constraints": {"min_contact_distance": 10}});
    let result = plan(&mesh, &too_far);
    let explanation = result.explanation.unwrap();
    assert_eq!(explanation.reason, Reason::Constraints);
    assert_eq!((explanation.proven, result.evaluations), (false, 0));
    assert!(explanation.detail.contains("min_contact_distance"));
    assert_eq!(result.constraints, Some(Vec::new()));
    // All that is left is two faces side by side.
    let corner = json!({"constraints": {
        "approach_directions": [[-2, 0, -2]], "max_normal_angle": 50
    }});
    let result = plan(&mesh, &corner);
    let explanation = result.explanation.unwrap();
    assert_eq!(explanation.reason, Reason::OneSided);
    assert!(explanation.detail.contains("max_normal_angle"));
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
    let problem = run::plan(
        &mesh,
        &request(&unknown),
        &mut |_| ControlFlow::Continue(()),
    );
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
            let found = run::evaluate(&mesh, &asked, &|| ControlFlow::Continue(()));
            let found = found.unwrap().unwrap().evaluations.remove(0);
            let difference = found.quality.unwrap() - quality.unwrap();
            assert!(difference.abs() < 1e-12, "{difference}");
        }
    }
}

/// Whether a grasp is force closure does not depend on where torques are taken about nor on their
/// scale; what cannot be told in such numbers is refused, and never proven impossible.
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
        let problem = run::plan(&mesh, &request(&settings), &mut |_| {
            ControlFlow::Continue(())
        });
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
    };
    let mesh = Mesh::prepare(rounded, None).unwrap();
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
        };
        assert_eq!(triangles(&Mesh::prepare(moved, None).unwrap()), expected);
    }
}

#[test]
fn trials_are_the_runs_of_the_seeds_that_follow() {
    let mesh = example("box.stl");
    let common =
        json!({"friction": 0.3, "generations": 2, "method": "modified_ga", "population": 30});
    let with = |more: Value| {
        let mut settings = common.clone();
        for (name, value) in more.as_object().unwrap() {
            settings[name] = value.clone();
        }
        plan(&mesh, &settings)
    };
    let all = with(json!({"seed": 11, "trials": 5}));
    let singles: Vec<PlanResult> = (11..16).map(|seed| with(json!({ "seed": seed }))).collect();
    let trials = all.trials.as_ref().unwrap();
    assert_eq!(
        (trials.count, trials.runs.len(), trials.force_closures),
        (5, 5, 5)
    );
    for (run, single) in trials.runs.iter().zip(&singles) {
        assert_eq!((run.seed, run.last), (single.seed, single.quality));
        assert_eq!(
            run.initial,
            single.initial.as_ref().map(|grasp| grasp.quality)
        );
        assert_eq!(run.evaluations, single.evaluations);
    }
    let qualities: Vec<f64> = singles.iter().filter_map(|single| single.quality).collect();
    let mean = qualities.iter().sum::<f64>() / 5.0;
    let last = trials.last.unwrap();
    assert!((last.mean - mean).abs() < 1e-15 && last.max == all.quality.unwrap());
    let best = singles
        .iter()
        .find(|single| single.quality == all.quality)
        .unwrap();
    assert_eq!((all.seed, &all.contacts), (best.seed, &best.contacts));
    assert_eq!(
        all.evaluations,
        singles.iter().map(|single| single.evaluations).sum::<u64>()
    );
    assert!(singles[0].trials.is_none() && all.reproducible);
}

#[test]
fn the_top_grasps_differ_and_are_sorted() {
    let mesh = example("duck.obj");
    for method in ["memetic", "modified_ga"] {
        let result = plan(
            &mesh,
            &json!({"seed": 5, "top": 4, "method": method, "generations": 6}),
        );
        let top = result.top.as_ref().unwrap();
        assert!(top.len() > 1 && top.len() <= 4, "{method} {}", top.len());
        assert_eq!(Some(top[0].quality), result.quality);
        assert_eq!(top[0].distance_to_best, 0.0);
        assert!(
            top.windows(2)
                .all(|pair| pair[0].quality >= pair[1].quality)
        );
        let least = 0.05 * mesh.report().bounding_radius;
        let far = |from: &[ContactPoint], to: &[ContactPoint]| {
            let apart = |a: &ContactPoint, b: &ContactPoint| {
                Point3::from(a.position) - Point3::from(b.position)
            };
            let nearest = |a: &ContactPoint| {
                to.iter()
                    .map(|b| apart(a, b).norm())
                    .fold(f64::INFINITY, f64::min)
            };
            from.iter().map(nearest).fold(0.0, f64::max)
        };
        for (i, a) in top.iter().enumerate() {
            for b in &top[..i] {
                assert!(far(&a.contacts, &b.contacts).max(far(&b.contacts, &a.contacts)) >= least);
            }
        }
    }
}
