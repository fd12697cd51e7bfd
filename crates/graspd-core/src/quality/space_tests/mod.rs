//! Intervals of round cones, soft fingers and L∞ spaces against support values told another way, explicit
//! polygons and Minkowski sums, and invariances.

use std::f64::consts::{PI, TAU};

use nalgebra::{Point3, Rotation3, Unit, UnitVector3, Vector3};
use rand::{Rng, SeedableRng};
use rand_pcg::Pcg64;

use super::{ACCURACY, Degenerate, Evaluator, Margin};
use crate::contact::{Cone, ConeEdges, Contact, ContactModel, Friction, Torsion};
use crate::wrench::Wrench;
use crate::wrench::{EdgeNorm, WrenchModel, WrenchSpace};

mod intervals;
mod relations;

const SPACES: [WrenchSpace; 2] = [WrenchSpace::L1, WrenchSpace::Linf];

/// Rounding of ends of intervals, which are of the order of one.
const ROUNDING: f64 = 1e-10;

fn signed(rng: &mut Pcg64) -> f64 {
    (rng.next_u64() >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
}

fn unit(rng: &mut Pcg64) -> UnitVector3<f64> {
    loop {
        let v = Vector3::from_fn(|_, _| signed(rng));
        if v.norm() < 1.0 && v.norm() > 0.1 {
            return Unit::new_normalize(v);
        }
    }
}

/// Places on an ellipsoid with dented normals.
fn contacts(rng: &mut Pcg64, m: usize) -> Vec<Contact> {
    let radii = Vector3::new(1.0, 0.7, 0.5);
    (0..m)
        .map(|_| {
            let v = unit(rng).into_inner();
            let dent = unit(rng).into_inner() * 0.2;
            Contact {
                position: v.component_mul(&radii).into(),
                normal: Unit::new_normalize(dent - v.component_div(&radii)),
            }
        })
        .collect()
}

fn friction(mu: f64) -> Friction {
    Friction::new(mu).unwrap()
}

fn pyramid(edges: u32) -> Cone {
    Cone::Pyramid(ConeEdges::new(edges).unwrap())
}

fn hard(mu: f64, cone: Cone) -> ContactModel {
    let friction = friction(mu);
    ContactModel::Hard { friction, cone }
}

fn soft(mu: f64, torsion: f64, cone: Cone) -> ContactModel {
    ContactModel::Soft {
        friction: friction(mu),
        torsion: Torsion::new(torsion).unwrap(),
        cone,
    }
}

fn model(contact_model: ContactModel, space: WrenchSpace) -> WrenchModel {
    WrenchModel {
        contact_model,
        edge_norm: EdgeNorm::UnitEdge,
        space,
        center: Point3::new(0.03, -0.02, 0.01),
        torque_scale: 0.9,
    }
}

/// All that goes through intervals, with a number of contacts.
fn cases() -> Vec<(WrenchModel, usize)> {
    let mut cases = Vec::new();
    for space in SPACES {
        cases.push((model(hard(0.5, Cone::Round), space), 4));
        cases.push((model(hard(0.8, Cone::Round), space), 3));
        cases.push((model(hard(0.2, Cone::Round), space), 6));
        cases.push((model(soft(0.5, 0.2, Cone::Round), space), 3));
    }
    let sum = |contact_model| model(contact_model, WrenchSpace::Linf);
    cases.push((sum(ContactModel::Frictionless), 8));
    cases.push((sum(ContactModel::Frictionless), 10));
    cases.push((sum(hard(0.5, pyramid(5))), 4));
    cases.push((sum(soft(0.5, 0.2, pyramid(6))), 9));
    cases
}

/// Random grasps that are force closure, with their margin.
fn closed(
    rng: &mut Pcg64,
    evaluator: &mut Evaluator,
    model: &WrenchModel,
    m: usize,
    count: usize,
) -> Vec<(Vec<Contact>, Margin)> {
    let mut found = Vec::new();
    for _ in 0..200_000 {
        let grasp = contacts(rng, m);
        if let Ok(margin) = evaluator.grasp_quality(model, &grasp, ACCURACY)
            && margin.value > 1e-4
        {
            found.push((grasp, margin));
        }
        if found.len() == count {
            return found;
        }
    }
    panic!("only {} of {count} for {model:?}", found.len());
}

/// How far the wrench space reaches along u = (a; b), through the velocity v = a + λ·b×(p−c) that u
/// is dual to at a contact: a force f has the product f·v with it.
fn support(model: &WrenchModel, grasp: &[Contact], u: &Wrench) -> f64 {
    let (a, b) = (
        u.fixed_rows::<3>(0).into_owned(),
        u.fixed_rows::<3>(3) * model.torque_scale,
    );
    let reaches = grasp.iter().map(|contact| {
        let n = contact.normal.into_inner();
        let v = a + b.cross(&(contact.position - model.center));
        let along = v.dot(&n);
        let (slide, twist) = ((v - n * along).norm(), b.dot(&n));
        let (mu, torsion, cone) = match model.contact_model {
            ContactModel::Frictionless => return along,
            ContactModel::Hard { friction, cone } => (friction, 0.0, cone),
            ContactModel::Soft {
                friction,
                torsion,
                cone,
            } => (friction, torsion.get(), cone),
        };
        let length = model.edge_length(mu);
        let tangential = match cone {
            Cone::Round => (mu.get() * slide).hypot(torsion * twist),
            Cone::Pyramid(edges) => {
                let (t1, t2) = model.tangents(contact);
                let edge = |i: u32| {
                    let (sin, cos) = (TAU * f64::from(i) / f64::from(edges.get())).sin_cos();
                    mu.get() * v.dot(&(t1 * cos + t2 * sin))
                };
                let slide = (0..edges.get()).map(edge).fold(f64::MIN, f64::max);
                slide.max(if torsion > 0.0 {
                    torsion * twist.abs()
                } else {
                    f64::MIN
                })
            }
        };
        length * (along + tangential)
    });
    match model.space {
        WrenchSpace::L1 => reaches.fold(f64::MIN, f64::max),
        WrenchSpace::Linf => reaches.map(|reach| reach.max(0.0)).sum(),
    }
}

fn random_direction(rng: &mut Pcg64) -> Wrench {
    Wrench::from_fn(|_, _| signed(rng)).normalize()
}

/// The least support value that sampling finds, by ever smaller steps from each of some starts.
fn least_support(
    rng: &mut Pcg64,
    model: &WrenchModel,
    grasp: &[Contact],
    starts: &[Wrench],
) -> f64 {
    let descend = |start: &Wrench, rng: &mut Pcg64| {
        let (mut u, mut height) = (*start, support(model, grasp, start));
        let mut step = 0.3;
        while step > 1e-6 {
            let next = (u + random_direction(rng) * step).normalize();
            let reach = support(model, grasp, &next);
            if reach < height {
                (u, height) = (next, reach);
            } else {
                step *= 0.97;
            }
        }
        height
    };
    starts
        .iter()
        .map(|start| descend(start, rng))
        .fold(f64::MAX, f64::min)
}

/// The wrenches of a regular polygon in place of each round cone; μ_t of a soft one is left out.
fn polygons(model: &WrenchModel, grasp: &[Contact], mu: f64, edges: usize) -> Vec<Wrench> {
    let length = model.edge_length(friction(mu));
    let mut wrenches = Vec::new();
    for contact in grasp {
        let t1 = contact
            .normal
            .cross(&Vector3::new(0.6, -0.5, 0.3))
            .normalize();
        let t2 = contact.normal.cross(&t1);
        for i in 0..edges {
            let (sin, cos) = (TAU * i as f64 / edges as f64).sin_cos();
            let force = (contact.normal.into_inner() + (t1 * cos + t2 * sin) * mu) * length;
            wrenches.push(model.wrench(&contact.position, &force));
        }
    }
    wrenches
}

fn overlap(a: &Margin, b: &Margin) -> bool {
    a.value <= b.upper + ROUNDING && b.value <= a.upper + ROUNDING
}
