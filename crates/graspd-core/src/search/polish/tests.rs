//! The polish on bodies made by code.

use nalgebra::{Point3, Vector3};
use rand::{Rng, SeedableRng};
use rand_pcg::Pcg64;

use super::*;
use crate::contact::{Cone, ConeEdges, ContactModel, Friction, Torsion};
use crate::interrupt::at_check;
use crate::mesh::{Mesh, RawMesh, solids};
use crate::wrench::{EdgeNorm, TorqueScale, WrenchSpace};

fn uniform(rng: &mut Pcg64) -> f64 {
    (rng.next_u64() >> 11) as f64 / (1_u64 << 53) as f64
}

fn mesh(raw: RawMesh) -> Mesh {
    Mesh::prepare(raw).unwrap()
}

fn hard(friction: f64) -> ContactModel {
    ContactModel::Hard {
        friction: Friction::new(friction).unwrap(),
        cone: Cone::Pyramid(ConeEdges::new(8).unwrap()),
    }
}

fn soft(mesh: &Mesh) -> ContactModel {
    ContactModel::Soft {
        friction: Friction::new(0.5).unwrap(),
        torsion: Torsion::new(0.2 * mesh.report().bounding_radius).unwrap(),
        cone: Cone::Round,
    }
}

fn model(mesh: &Mesh, contact_model: ContactModel, space: WrenchSpace) -> WrenchModel {
    let center = mesh.report().center_of_mass;
    WrenchModel {
        contact_model,
        edge_norm: EdgeNorm::UnitEdge,
        space,
        center,
        torque_scale: TorqueScale::MaxRadius.value(mesh, &center),
    }
}

/// Centroids of random triangles.
fn random_start(surface: &Surface<'_>, m: usize, rng: &mut Pcg64) -> Vec<SurfaceContact> {
    let n = surface.mesh().triangles().len();
    std::iter::repeat_with(|| surface.centroid((uniform(rng) * n as f64) as usize))
        .flatten()
        .take(m)
        .collect()
}

fn run(
    surface: &Surface<'_>,
    model: &WrenchModel,
    fixed: &[Contact],
    start: &[SurfaceContact],
    limit: u64,
    allowed: &dyn Fn(&[SurfaceContact]) -> bool,
) -> Result<Polished, Degenerate> {
    let settings = PolishSettings {
        evaluation_limit: limit,
    };
    let never = Interrupt::never();
    polish(surface, model, fixed, start, settings, allowed, never)
}

fn epsilon(model: &WrenchModel, fixed: &[Contact], places: &[SurfaceContact]) -> f64 {
    let contacts = all_contacts(fixed, places);
    let margin = Evaluator::new().grasp_quality(model, &contacts, ACCURACY);
    margin.map_or(f64::NEG_INFINITY, |margin| margin.value)
}

fn check_places(surface: &Surface<'_>, places: &[SurfaceContact]) {
    for place in places {
        let weights = place.barycentric;
        assert!(weights.iter().all(|w| (0.0..=1.0).contains(w)));
        assert!((weights.iter().sum::<f64>() - 1.0).abs() < 1e-14);
        assert_eq!(
            surface.place(place.triangle, weights).as_ref(),
            Some(place),
            "position, normal and number follow from triangle and weights"
        );
    }
}

#[test]
fn epsilon_never_falls_and_the_margin_is_that_of_the_contacts() {
    let mut rng = Pcg64::seed_from_u64(1);
    let (mut closed, mut better) = (0, 0);
    for raw in [
        solids::torus(2.0, 0.7, 24, 12),
        solids::sphere(1.0, 12, 18),
        solids::l_shape(),
        solids::cuboid([0.0; 3], [3.0, 2.0, 1.0]),
    ] {
        let mesh = mesh(raw);
        let surface = Surface::new(&mesh);
        let (l1, linf) = (WrenchSpace::L1, WrenchSpace::Linf);
        for (contact_model, space, m, starts) in [
            (ContactModel::Frictionless, l1, 7, 60),
            (hard(0.5), l1, 4, 60),
            (hard(0.5).with_cone(Cone::Round), l1, 4, 8),
            (hard(0.5), linf, 3, 8),
            (soft(&mesh), l1, 3, 4),
        ] {
            let model = model(&mesh, contact_model, space);
            for _ in 0..starts {
                let start = random_start(&surface, m, &mut rng);
                let limit = 1 + (uniform(&mut rng) * 100.0) as u64;
                let Ok(found) = run(&surface, &model, &[], &start, limit, &|_| true) else {
                    continue;
                };
                let before = epsilon(&model, &[], &start);
                // Hulls that are given up at the limit of a search are told so when nothing was gained.
                if found.gain > 0.0 || found.margin.exact {
                    assert_eq!(found.margin.value, epsilon(&model, &[], &found.contacts));
                    assert_eq!(found.gain, found.margin.value - before);
                }
                assert!(found.gain >= 0.0);
                assert!((1..=limit).contains(&found.evaluations));
                assert_eq!(found.contacts.len(), m);
                assert_eq!(found.stopped, None);
                if !found.margin.is_force_closure() {
                    assert_eq!(found.contacts, start);
                    assert_eq!(found.evaluations, 1);
                } else if limit > 20 {
                    closed += 1;
                    better += usize::from(found.gain > 0.0);
                }
                if found.gain > 0.0 {
                    check_places(&surface, &found.contacts);
                } else {
                    assert_eq!(found.contacts, start);
                }
            }
        }
    }
    assert!(
        closed > 100 && better * 10 > closed * 9,
        "{better} of {closed}"
    );
}

/// Two soft fingers on opposite faces hold a cube best at the middle of the faces: any other place adds a
/// lever arm to torques that pushing exerts, and takes nothing off.
#[test]
fn two_soft_fingers_find_the_middle_of_the_faces() {
    let mesh = mesh(solids::cube(1.0));
    let surface = Surface::new(&mesh);
    let model = model(&mesh, soft(&mesh), WrenchSpace::L1);
    let on = |x: f64| {
        let side = move |place: &SurfaceContact| (place.position.x - x).abs() < 1e-12;
        (0..mesh.triangles().len())
            .filter_map(|index| surface.centroid(index))
            .filter(side)
            .collect::<Vec<_>>()
    };
    let middle = |x: f64| Contact {
        position: Point3::new(x, 0.5, 0.5),
        normal: nalgebra::Unit::new_unchecked(Vector3::new(1.0 - 2.0 * x, 0.0, 0.0)),
    };
    let best = epsilon(&model, &[middle(0.0), middle(1.0)], &[]);
    assert!(best > 0.0);
    for a in on(0.0) {
        for b in on(1.0) {
            let found = run(&surface, &model, &[], &[a, b], 1000, &|_| true).unwrap();
            // As near as hulls that are given up at the limit of a search tell.
            assert!(
                found.margin.value > best * (1.0 - 1e-3),
                "{:?} of {best} after {}",
                found.margin,
                found.evaluations
            );
            for place in &found.contacts {
                let aside = place.position - Point3::new(place.position.x, 0.5, 0.5);
                assert!(aside.norm() < 2e-2, "{place:?}");
            }
        }
    }
}

/// Against a grid of the face that the finger may slide on, refined around its best.
#[test]
fn a_finger_finds_the_best_place_of_a_face() {
    let mesh = mesh(solids::cuboid([0.0; 3], [3.0, 2.0, 1.0]));
    let surface = Surface::new(&mesh);
    let mut rng = Pcg64::seed_from_u64(4);
    let mut runs = 0;
    while runs < 10 {
        let model = model(&mesh, hard(0.6), WrenchSpace::L1);
        let top: Vec<SurfaceContact> = (0..mesh.triangles().len())
            .filter_map(|index| surface.centroid(index))
            .filter(|place| place.position.z == 1.0)
            .collect();
        let others = random_start(&surface, 3, &mut rng);
        let fixed = all_contacts(&[], &others);
        let at = |x: f64, y: f64| {
            let step = Point3::new(x, y, 1.0) - top[0].position;
            surface.walk(&top[0], &step)
        };
        let value = |x: f64, y: f64| epsilon(&model, &fixed, &[at(x, y)]);
        let (mut x, mut y, mut width) = (1.5, 1.0, 3.0);
        let mut best = f64::NEG_INFINITY;
        for _ in 0..30 {
            let (mut next_x, mut next_y) = (x, y);
            for i in -12..=12 {
                for j in -12..=12 {
                    let there = |c: f64, k: i32| c + width * f64::from(k) / 24.0;
                    let (x, y) = (
                        there(x, i).clamp(1e-9, 3.0 - 1e-9),
                        there(y, j).clamp(1e-9, 2.0 - 1e-9),
                    );
                    let there = value(x, y);
                    if there > best {
                        (best, next_x, next_y) = (there, x, y);
                    }
                }
            }
            (x, y, width) = (next_x, next_y, 0.6 * width);
        }
        if best < 0.04 {
            continue;
        }
        runs += 1;
        let keep_top = |places: &[SurfaceContact]| places[0].normal == top[0].normal;
        let mut reached = f64::NEG_INFINITY;
        for i in 1..8 {
            for j in 1..8 {
                let start = at(3.0 * f64::from(i) / 8.0, 2.0 * f64::from(j) / 8.0);
                let Ok(found) = run(&surface, &model, &fixed, &[start], 1000, &keep_top) else {
                    continue;
                };
                reached = reached.max(found.margin.value);
                let place = found.contacts[0].position;
                for k in 0..if found.gain > 0.0 { 200 } else { 0 } {
                    let length = 0.02 / f64::from(k / 20 + 1).powi(2);
                    let (sin, cos) = f64::from(k).sin_cos();
                    let near = value(
                        (place.x + length * cos).clamp(1e-9, 3.0 - 1e-9),
                        (place.y + length * sin).clamp(1e-9, 2.0 - 1e-9),
                    );
                    assert!(
                        near < found.margin.value * (1.0 + 1e-4),
                        "{near} is near {found:?}"
                    );
                }
            }
        }
        assert!(reached > best * (1.0 - 1e-4), "{reached} of {best}");
    }
}

#[test]
fn only_what_is_allowed_is_evaluated_or_returned() {
    let mesh = mesh(solids::torus(2.0, 0.7, 24, 12));
    let surface = Surface::new(&mesh);
    let model = model(&mesh, hard(0.5), WrenchSpace::L1);
    let mut rng = Pcg64::seed_from_u64(2);
    let mut better = 0;
    for _ in 0..100 {
        let start = random_start(&surface, 4, &mut rng);
        let low = start
            .iter()
            .map(|p| p.position.z)
            .fold(f64::INFINITY, f64::min);
        let granted = std::cell::Cell::new(0);
        let allowed = |places: &[SurfaceContact]| {
            let apart = places.iter().enumerate().all(|(i, a)| {
                let others = &places[..i];
                others
                    .iter()
                    .all(|b| (a.position - b.position).norm() > 0.5)
            });
            let granting = apart && places.iter().all(|p| p.position.z >= low);
            granted.set(granted.get() + u64::from(granting));
            granting
        };
        let Ok(found) = run(&surface, &model, &[], &start, 200, &allowed) else {
            continue;
        };
        assert!(found.evaluations - 1 <= granted.get());
        assert!(found.contacts == start || allowed(&found.contacts));
        better += usize::from(found.gain > 0.0);
        let refused = run(&surface, &model, &[], &start, 200, &|_| false).unwrap();
        assert_eq!((refused.contacts, refused.evaluations), (start, 1));
    }
    assert!(better > 20, "{better}");
}

#[test]
fn the_same_input_gives_the_same_bits() {
    let mesh = mesh(solids::torus(2.0, 0.7, 24, 12));
    let mut rng = Pcg64::seed_from_u64(3);
    for contact_model in [hard(0.5), hard(0.5).with_cone(Cone::Round)] {
        let model = model(&mesh, contact_model, WrenchSpace::L1);
        for _ in 0..10 {
            let start = random_start(&Surface::new(&mesh), 4, &mut rng);
            let bits = || {
                let found = run(&Surface::new(&mesh), &model, &[], &start, 100, &|_| true);
                format!("{found:?}")
            };
            assert_eq!(bits(), bits());
        }
    }
}

#[test]
fn an_interrupt_ends_it_with_what_it_has() {
    let mesh = mesh(solids::sphere(1.0, 12, 18));
    let surface = Surface::new(&mesh);
    let model = model(&mesh, hard(0.5), WrenchSpace::L1);
    let mut rng = Pcg64::seed_from_u64(5);
    let mut ended = 0;
    for _ in 0..40 {
        let start = random_start(&surface, 4, &mut rng);
        let ask = at_check(10);
        let found = polish(
            &surface,
            &model,
            &[],
            &start,
            PolishSettings::default(),
            &|_| true,
            Interrupt::new(&ask),
        );
        let Ok(found) = found else { continue };
        if found.margin.is_force_closure() {
            assert_eq!(found.stopped, Some(Interrupted::Cancelled));
            assert_eq!(found.evaluations, 10);
            ended += usize::from(found.gain > 0.0);
        }
    }
    assert!(ended > 5, "{ended}");
}

/// Needles, slivers, borders and edges of three triangles at random.
#[test]
fn no_mesh_keeps_it_going() {
    let mut rng = Pcg64::seed_from_u64(6);
    let mut polished = 0;
    for round in 0..60 {
        let mut raw = solids::sphere(1.0, 6, 8);
        let n = raw.vertices.len() as f64;
        for triangle in &mut raw.triangles {
            if uniform(&mut rng) < 0.1 {
                triangle[0] = (uniform(&mut rng) * n) as u32;
            }
        }
        for vertex in &mut raw.vertices {
            if uniform(&mut rng) < 0.3 {
                vertex.z = 1e-6 * uniform(&mut rng);
            }
            if uniform(&mut rng) < 0.1 {
                *vertex = Point3::new(1e-3, 0.0, 1e-6 * uniform(&mut rng));
            }
        }
        let Ok(mesh) = Mesh::prepare(raw) else {
            continue;
        };
        let surface = Surface::new(&mesh);
        let model = model(&mesh, hard(0.5), WrenchSpace::L1);
        for _ in 0..10 {
            let start = random_start(&surface, 4, &mut rng);
            let Ok(found) = run(&surface, &model, &[], &start, 100, &|_| true) else {
                continue;
            };
            assert!(found.gain >= 0.0 && found.evaluations <= 100, "{round}");
            if found.gain > 0.0 {
                polished += 1;
                check_places(&surface, &found.contacts);
            }
        }
    }
    assert!(polished > 20, "{polished}");
}

#[test]
fn without_sliding_contacts_or_rank_there_is_nothing_to_polish() {
    let mesh = mesh(solids::cube(1.0));
    let surface = Surface::new(&mesh);
    let model = model(&mesh, hard(0.5), WrenchSpace::L1);
    let mut rng = Pcg64::seed_from_u64(7);
    let fixed = all_contacts(&[], &random_start(&surface, 8, &mut rng));
    let found = run(&surface, &model, &fixed, &[], 100, &|_| true).unwrap();
    assert_eq!((found.gain, found.evaluations), (0.0, 1));
    assert!(run(&surface, &model, &[], &[], 100, &|_| true).is_err());
    let one = surface.centroid(0).unwrap();
    assert!(
        run(&surface, &model, &[], &[one; 3], 100, &|_| true).is_ok_and(|f| f.gain == 0.0) || {
            run(&surface, &model, &[], &[one; 3], 100, &|_| true).is_err()
        }
    );
    // A place that is nowhere stays where it is.
    let mut start = random_start(&surface, 6, &mut rng);
    start[0].triangle = 99;
    if let Ok(found) = run(&surface, &model, &[], &start, 100, &|_| true) {
        assert_eq!(found.contacts[0], start[0]);
    }
}
