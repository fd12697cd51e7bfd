//! A planning run from mesh bytes to result, without a server.

use std::ops::ControlFlow;

use graspd::core::mesh::{Limits, Mesh, RawMesh, read};
use graspd::run;
use graspd::wire::{PlanRequest, PlanResult, Reason, StoppedBecause};
use nalgebra::{Point3, Rotation3, Vector3};
use serde_json::{Value, json};

const LIMITS: Limits = Limits {
    triangles: 100_000,
    vertices: 100_000,
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
        &json!({"friction": 0.4, "seed": 3, "generations": 5, "units": "mm"}),
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
        let corners =
            mesh.triangles()[contact.triangle as usize].map(|v| mesh.vertices()[v as usize]);
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
        &request(&json!({"contacts": 21})),
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
    let easy = plan(&mesh, &json!({"seed": 1, "target_quality": 1e-5}));
    assert_eq!(easy.stopped_because, StoppedBecause::TargetQuality);
    assert_eq!(easy.quality, easy.initial.map(|grasp| grasp.quality));
    let hard = plan(&mesh, &json!({"seed": 1, "target_quality": 0.1}));
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
    let settings = json!({"seed": 4, "generations": 10, "population": 60});
    let triangles = |mesh: &Mesh| -> Vec<u32> {
        let contacts = plan(mesh, &settings).contacts;
        contacts.iter().map(|contact| contact.triangle).collect()
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
