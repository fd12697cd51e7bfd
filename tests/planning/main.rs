//! A planning run from mesh bytes to result, without a server.

use graspd::run;
use graspd::wire::{ContactPoint, EvaluationRequest, PlanRequest, PlanResult, Reason};
use graspd_core::Interrupt;
use graspd_core::contact::Contact;
use graspd_core::mesh::{Mesh, RawMesh};
use graspd_core::search::StopReason;
use graspd_mesh_io::{Limits, read};
use nalgebra::{Point3, Rotation3, Vector3};
use serde_json::{Value, json};

mod constraints;
mod limits;
mod repeats;
mod results;

const LIMITS: Limits = Limits {
    triangles: 100_000,
    vertices: 100_000,
    ..Limits::NONE
};

fn example(name: &str) -> Mesh {
    let path = format!("{}/examples/meshes/{name}", env!("CARGO_MANIFEST_DIR"));
    let (_, raw) = read(&std::fs::read(path).unwrap(), None, &LIMITS).unwrap();
    Mesh::prepare(raw).unwrap()
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
        ..RawMesh::default()
    };
    Mesh::prepare(raw).unwrap()
}

fn request(settings: &Value) -> PlanRequest {
    PlanRequest::from_json(settings, 1).unwrap()
}

fn plan(mesh: &Mesh, settings: &Value) -> PlanResult {
    run::plan(mesh, &request(settings), Interrupt::never(), &mut |_| {}).unwrap()
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
