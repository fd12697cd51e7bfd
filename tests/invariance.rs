//! ε belongs to the body and the contacts, not to the file they come in.

use graspd_core::contact::{Cone, ConeEdges, Contact, ContactModel, Friction};
use graspd_core::mesh::{Mesh, RawMesh};
use graspd_core::quality::Evaluator;
use graspd_core::wrench::{EdgeNorm, TorqueScale, WrenchModel, WrenchSpace};
use nalgebra::{Isometry3, Point3, Vector3};
use proptest::prelude::*;

/// A closed, bumpy, lopsided body of 8 · 4^3 triangles: an octahedron, refined and displaced.
fn body() -> RawMesh {
    let mut vertices: Vec<Vector3<f64>> = (0..6)
        .map(|i| Vector3::ith(i / 2, if i % 2 == 0 { 1.0 } else { -1.0 }))
        .collect();
    let mut triangles: Vec<[u32; 3]> = Vec::new();
    for octant in 0..8_u32 {
        let corner = |axis: u32| 2 * axis + (octant >> axis & 1);
        let odd = octant.count_ones() % 2 == 1;
        let (b, c) = if odd { (2, 1) } else { (1, 2) };
        triangles.push([corner(0), corner(b), corner(c)]);
    }
    for _ in 0..3 {
        triangles = triangles
            .iter()
            .flat_map(|&[a, b, c]| {
                let mut middle = |i: u32, j: u32| {
                    let m = (vertices[i as usize] + vertices[j as usize]).normalize();
                    vertices.push(m);
                    vertices.len() as u32 - 1
                };
                let (ab, bc, ca) = (middle(a, b), middle(b, c), middle(c, a));
                [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]
            })
            .collect();
    }
    let bump = |v: &Vector3<f64>| {
        let r = 1.0 + 0.2 * (3.0 * v.x + 1.0).sin() + 0.15 * (4.0 * v.y).cos() * v.z + 0.1 * v.x;
        Point3::new(1.5 * r * v.x, r * v.y, 0.8 * r * v.z)
    };
    RawMesh {
        vertices: vertices.iter().map(bump).collect(),
        triangles,
        ..RawMesh::default()
    }
}

/// The margin of the grasp on the given triangles of the file.
fn margin(raw: RawMesh, grasp: &[u32], contact_model: ContactModel) -> f64 {
    margin_with(EdgeNorm::UnitEdge, raw, grasp, contact_model)
}

fn margin_with(
    edge_norm: EdgeNorm,
    raw: RawMesh,
    grasp: &[u32],
    contact_model: ContactModel,
) -> f64 {
    let mesh = Mesh::prepare(raw).unwrap();
    let center = mesh.report().center_of_mass;
    let model = WrenchModel {
        contact_model,
        edge_norm,
        space: WrenchSpace::L1,
        center,
        torque_scale: TorqueScale::MaxRadius.value(&mesh, &center),
    };
    let candidates = mesh.candidates();
    let mut wrenches = Vec::new();
    for triangle in grasp {
        let candidate = candidates.iter().find(|c| c.triangle == *triangle).unwrap();
        let contact = Contact {
            position: candidate.position,
            normal: candidate.normal,
        };
        model.push_wrenches(&contact, &mut wrenches);
    }
    match Evaluator::new().margin(&wrenches) {
        Ok(margin) => margin.value,
        Err(degenerate) => panic!("{degenerate}"),
    }
}

fn models() -> impl Strategy<Value = (ContactModel, usize)> {
    let hard = (0.1..1.5, 3_u32..10).prop_map(|(mu, edges)| ContactModel::Hard {
        friction: Friction::new(mu).unwrap(),
        cone: Cone::Pyramid(ConeEdges::new(edges).unwrap()),
    });
    prop_oneof![Just((ContactModel::Frictionless, 7)), (hard, 3_usize..6),]
}

fn cases() -> impl Strategy<Value = (Vec<u32>, ContactModel)> {
    models().prop_flat_map(|(model, m)| {
        let grasp = proptest::sample::subsequence((0..512_u32).collect::<Vec<_>>(), m);
        (grasp, Just(model))
    })
}

fn vector(size: f64) -> impl Strategy<Value = Vector3<f64>> {
    proptest::array::uniform3(-size..size).prop_map(Vector3::from)
}

fn moved(mut raw: RawMesh, motion: impl Fn(&Point3<f64>) -> Point3<f64>) -> RawMesh {
    raw.vertices.iter_mut().for_each(|v| *v = motion(v));
    raw
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(1000))]

    #[test]
    fn moving_and_turning_the_mesh((grasp, model) in cases(), shift in vector(100.0), turn in vector(4.0)) {
        let motion = Isometry3::new(shift, turn);
        let there = margin(moved(body(), |v| motion * v), &grasp, model);
        prop_assert!((there - margin(body(), &grasp, model)).abs() < 1e-9);
    }

    #[test]
    fn scaling_the_mesh((grasp, model) in cases(), exponent in -4.0..4.0) {
        let factor = 10_f64.powf(exponent);
        let scaled = margin(moved(body(), |v| v * factor), &grasp, model);
        prop_assert!((scaled - margin(body(), &grasp, model)).abs() < 1e-9);
    }

    #[test]
    fn renumbering_triangles_and_contacts((grasp, model) in cases(), order in Just((0..512_u32).collect::<Vec<_>>()).prop_shuffle()) {
        let mut raw = body();
        let triangles = raw.triangles.clone();
        for (old, &new) in order.iter().enumerate() {
            let mut corners = triangles[old];
            corners.rotate_left(new as usize % 3);
            raw.triangles[new as usize] = corners;
        }
        let renumbered: Vec<u32> = grasp.iter().rev().map(|&old| order[old as usize]).collect();
        let there = margin(raw, &renumbered, model);
        prop_assert!((there - margin(body(), &grasp, model)).abs() < 1e-9);
    }

    #[test]
    fn edge_norms_differ_by_the_root_of_one_plus_mu_squared((grasp, model) in cases()) {
        let mu = match model {
            ContactModel::Hard { friction, .. } => friction.get(),
            ContactModel::Frictionless => 0.0,
            ContactModel::Soft { .. } => unreachable!("not drawn"),
        };
        let unit_normal = margin_with(EdgeNorm::UnitNormal, body(), &grasp, model);
        let unit_edge = margin(body(), &grasp, model);
        prop_assert!((unit_normal - mu.hypot(1.0) * unit_edge).abs() < 1e-12);
    }
}
