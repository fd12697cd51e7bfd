//! Regions against evaluations of every candidate, one by one.

use std::collections::HashMap;

use super::*;
use crate::contact::{Cone, ConeEdges, ContactModel, Friction, Torsion};
use crate::mesh::{RawMesh, solids};
use crate::random::{Purpose, Stream};
use crate::wrench::EdgeNorm;

const FLOOR: f64 = 1e-6;

fn prepared(raw: RawMesh) -> Mesh {
    Mesh::prepare(raw).unwrap()
}

fn friction() -> Friction {
    Friction::new(0.5).unwrap()
}

fn pyramid() -> Cone {
    Cone::Pyramid(ConeEdges::new(6).unwrap())
}

fn models() -> [(ContactModel, WrenchSpace, usize); 6] {
    let hard = |cone| ContactModel::Hard {
        friction: friction(),
        cone,
    };
    let soft = ContactModel::Soft {
        friction: friction(),
        torsion: Torsion::new(0.2).unwrap(),
        cone: pyramid(),
    };
    [
        (ContactModel::Frictionless, WrenchSpace::L1, 7),
        (ContactModel::Frictionless, WrenchSpace::Linf, 8),
        (hard(pyramid()), WrenchSpace::L1, 4),
        (hard(pyramid()), WrenchSpace::Linf, 3),
        (hard(Cone::Round), WrenchSpace::L1, 3),
        (soft, WrenchSpace::L1, 3),
    ]
}

fn model(mesh: &Mesh, contact_model: ContactModel, space: WrenchSpace) -> WrenchModel {
    let center = mesh.report().center_of_mass;
    WrenchModel {
        contact_model,
        edge_norm: EdgeNorm::UnitEdge,
        space,
        center,
        torque_scale: mesh.radius_about(&center).recip(),
    }
}

/// A grasp that is force closure, the best of those drawn, with its margin.
fn drawn(mesh: &Mesh, model: &WrenchModel, m: usize) -> (Vec<Site>, Margin) {
    let candidates = mesh.candidates();
    let mut stream = Stream::new(3, Purpose::Population, 0);
    let mut best: Option<(Vec<Site>, Margin)> = None;
    for _ in 0..3000 {
        let grasp = stream.subset(candidates.len(), m);
        let sites: Vec<Site> = grasp
            .iter()
            .map(|&i| (&candidates[i as usize]).into())
            .collect();
        let contacts: Vec<Contact> = sites.iter().map(|site| site.contact).collect();
        let found = Evaluator::new().grasp_quality(model, &contacts, 1e-3);
        let Some(margin) = found.ok().filter(|m| m.value > 0.01) else {
            continue;
        };
        if best
            .as_ref()
            .is_none_or(|(_, best)| margin.value > best.value)
        {
            let exact = Evaluator::new().grasp_margin(model, &contacts, ACCURACY);
            best = Some((sites, exact.unwrap()));
        }
    }
    best.unwrap_or_else(|| panic!("no grasp with {model:?}"))
}

fn regions(
    mesh: &Mesh,
    model: &WrenchModel,
    sites: &[Site],
    margin: &Margin,
    fraction: f64,
) -> Vec<IndependentRegion> {
    let fraction = Fraction::new(fraction).unwrap();
    let never = Interrupt::never();
    let places = Places::new(mesh, never).unwrap();
    independent_regions(&places, model, sites, margin, FLOOR, fraction, never).unwrap()
}

#[test]
fn every_candidate_is_in_or_out_as_its_own_evaluation_says() {
    let (mut inside, mut outside) = (0, 0);
    for raw in [solids::torus(2.0, 0.7, 12, 8), fine_l_shape()] {
        let mesh = prepared(raw);
        for (contact_model, space, m) in models() {
            let model = model(&mesh, contact_model, space);
            let (sites, margin) = drawn(&mesh, &model, m);
            let contacts: Vec<Contact> = sites.iter().map(|site| site.contact).collect();
            for fraction in [0.2, 0.6, 1.0] {
                let found = regions(&mesh, &model, &sites, &margin, fraction);
                assert_eq!(found.len(), m);
                for (finger, region) in found.iter().enumerate() {
                    let own = sites[finger].triangle.unwrap();
                    assert!(region.triangles.contains(&own));
                    assert!(region.triangles.is_sorted());
                    for candidate in mesh.candidates() {
                        let mut moved = contacts.clone();
                        moved[finger] = Contact::from(&candidate);
                        let there = Evaluator::new().grasp_quality(&model, &moved, ACCURACY);
                        let there = there.map_or(0.0, |margin| margin.value);
                        let wanted = (fraction * margin.value).max(FLOOR);
                        if region.triangles.contains(&candidate.triangle) {
                            assert!(there >= wanted - 1e-11, "{there} {wanted}");
                            inside += 1;
                        } else {
                            assert!(there <= wanted + 1e-11, "{there} {wanted}");
                            outside += 1;
                        }
                    }
                }
            }
        }
    }
    assert!(inside > 1000 && outside > 1000, "{inside} {outside}");
}

/// An L shape with more places than its twenty-odd triangles.
fn fine_l_shape() -> RawMesh {
    let mut raw = solids::l_shape();
    for _ in 0..2 {
        raw.triangles = raw
            .triangles
            .clone()
            .into_iter()
            .flat_map(|[a, b, c]| {
                let middle = |i: u32, j: u32, raw: &mut RawMesh| {
                    let (p, q) = (raw.vertices[i as usize], raw.vertices[j as usize]);
                    raw.vertices.push(nalgebra::center(&p, &q));
                    raw.vertices.len() as u32 - 1
                };
                let ab = middle(a, b, &mut raw);
                let (bc, ca) = (middle(b, c, &mut raw), middle(c, a, &mut raw));
                [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]
            })
            .collect();
    }
    raw
}

#[test]
fn regions_shrink_as_more_is_to_be_kept_and_areas_add_up() {
    let mesh = prepared(solids::sphere(1.0, 10, 20));
    let (contact_model, space, m) = models()[2];
    let model = model(&mesh, contact_model, space);
    let (sites, margin) = drawn(&mesh, &model, m);
    let found = [0.01, 0.3, 0.7, 0.95].map(|f| regions(&mesh, &model, &sites, &margin, f));
    for pair in found.windows(2) {
        for (wide, narrow) in pair[0].iter().zip(&pair[1]) {
            assert!(narrow.triangles.iter().all(|t| wide.triangles.contains(t)));
            assert!(narrow.area <= wide.area && narrow.area > 0.0);
        }
    }
    let areas: HashMap<u32, f64> = mesh.source().iter().copied().zip(mesh.areas()).collect();
    for region in found.iter().flatten() {
        assert_eq!(region.count, region.triangles.len() as u64);
        assert!((1..=region.count).contains(&region.connected.unwrap()));
        assert!(region.connected_area.unwrap() <= region.area * (1.0 + 1e-12));
        let area: f64 = region.triangles.iter().map(|t| areas[t]).sum();
        assert_eq!(region.area, area);
    }
    // On so round a body a finger may be a little aside, and not everywhere.
    assert!(
        found[1]
            .iter()
            .all(|r| (3..390).contains(&r.triangles.len()))
    );
}

#[test]
fn threads_and_free_contacts_change_nothing() {
    let mesh = prepared(solids::torus(2.0, 0.7, 16, 8));
    let (contact_model, space, m) = models()[2];
    let model = model(&mesh, contact_model, space);
    let (mut sites, margin) = drawn(&mesh, &model, m);
    let on = |threads, sites: &[Site]| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
        pool.unwrap()
            .install(|| regions(&mesh, &model, sites, &margin, 0.5))
    };
    let one = on(1, &sites);
    assert_eq!(one, on(3, &sites));
    sites[0].triangle = None;
    let free = on(2, &sites);
    assert_eq!((free[0].connected, free[0].connected_area), (None, None));
    assert_eq!(free[0].triangles, one[0].triangles);
    assert_eq!(free[1..], one[1..]);
}

#[test]
fn where_the_others_hold_the_body_a_finger_may_be_anywhere() {
    let mesh = prepared(solids::torus(2.0, 0.7, 12, 8));
    let (contact_model, space, _) = models()[2];
    let model = model(&mesh, contact_model, space);
    let (mut sites, margin) = drawn(&mesh, &model, 4);
    sites.push(sites[0]);
    let found = regions(&mesh, &model, &sites, &margin, 1.0);
    assert_eq!(found[4].triangles.len(), mesh.candidates().len());
    assert_eq!(found[4].connected, Some(found[4].count));
}

#[test]
fn it_can_be_interrupted() {
    let mesh = prepared(solids::torus(2.0, 0.7, 12, 8));
    let (contact_model, space, m) = models()[2];
    let model = model(&mesh, contact_model, space);
    let (sites, margin) = drawn(&mesh, &model, m);
    let cancelled = || Some(Interrupted::Cancelled);
    let stop = Interrupt::new(&cancelled);
    let fraction = Fraction::new(0.5).unwrap();
    let places = Places::new(&mesh, Interrupt::never()).unwrap();
    let found = independent_regions(&places, &model, &sites, &margin, FLOOR, fraction, stop);
    assert_eq!(found, Err(Interrupted::Cancelled));
}

#[test]
fn every_number_is_visited_once() {
    for n in [0, 1, 2, 7, 100, 1001] {
        let mut visited = spread(n);
        visited.sort_unstable();
        assert!(visited.iter().copied().eq(0..n as u32));
    }
}
