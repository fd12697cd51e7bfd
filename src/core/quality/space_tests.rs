//! Intervals of round cones, soft fingers and L∞ spaces against support values told another way, explicit
//! polygons and Minkowski sums, and invariances.

use std::f64::consts::{PI, TAU};

use nalgebra::{Point3, Rotation3, Unit, UnitVector3, Vector3};
use rand::{Rng, SeedableRng};
use rand_pcg::Pcg64;

use super::{ACCURACY, Degenerate, Evaluator, Margin, Wrench};
use crate::core::contact::{Cone, ConeEdges, Contact, ContactModel, Friction, Torsion};
use crate::core::wrench::{EdgeNorm, WrenchModel, WrenchSpace};

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

#[test]
fn polygons_converge_to_the_round_cone_from_below() {
    let mut rng = Pcg64::seed_from_u64(1);
    let mut evaluator = Evaluator::new();
    for (mu, m) in [(0.2, 5), (0.5, 4), (0.9, 3)] {
        let model = model(hard(mu, Cone::Round), WrenchSpace::L1);
        for (grasp, round) in closed(&mut rng, &mut evaluator, &model, m, 15) {
            let reach = grasp.iter().map(|c| (c.position - model.center).norm());
            let reach = model.torque_scale * reach.fold(0.0, f64::max);
            let mut last = 0.0;
            for edges in [8, 16, 64, 256] {
                let wrenches = polygons(&model, &grasp, mu, edges);
                let inscribed = evaluator.quality(&wrenches).unwrap().value.max(0.0);
                assert!(inscribed >= last - ROUNDING && inscribed <= round.upper);
                // A circle is this far from its polygon, times what a unit direction makes of it.
                let sagitta =
                    mu * model.edge_length(friction(mu)) * (1.0 - (PI / edges as f64).cos());
                let farthest = inscribed + sagitta * reach.hypot(1.0);
                assert!(
                    round.value <= farthest + ROUNDING,
                    "{edges}: {inscribed} {round:?}"
                );
                last = inscribed;
            }
        }
    }
}

#[test]
fn the_l_infinity_space_is_the_minkowski_sum() {
    let mut rng = Pcg64::seed_from_u64(2);
    let mut evaluator = Evaluator::new();
    let cases = [
        (ContactModel::Frictionless, 7),
        (ContactModel::Frictionless, 8),
        (hard(0.8, pyramid(4)), 3),
        (hard(0.6, pyramid(3)), 4),
        (soft(0.6, 0.3, pyramid(3)), 3),
    ];
    for (contact_model, m) in cases {
        let model = model(contact_model, WrenchSpace::Linf);
        for (grasp, _) in closed(&mut rng, &mut evaluator, &model, m, 20) {
            let mut sums = vec![Wrench::zeros()];
            for contact in &grasp {
                let mut own = Vec::new();
                model.push_wrenches(contact, &mut own);
                let added: Vec<Wrench> = own
                    .iter()
                    .flat_map(|w| sums.iter().map(move |sum| sum + w))
                    .collect();
                sums.extend(added);
            }
            let truth = evaluator.quality(&sums).unwrap();
            assert!(truth.exact);
            let found = evaluator.grasp_quality(&model, &grasp, 1e-10).unwrap();
            assert!(
                (found.value - truth.value).abs() < 1e-9 && found.exact,
                "{found:?} {truth:?}"
            );
            assert!(found.value <= truth.value && truth.value <= found.upper);
        }
    }
}

#[test]
fn no_interval_is_ever_a_false_claim() {
    let mut rng = Pcg64::seed_from_u64(3);
    let mut evaluator = Evaluator::new();
    for (model, m) in cases() {
        for (grasp, margin) in closed(&mut rng, &mut evaluator, &model, m, 12) {
            let Margin {
                value,
                upper,
                direction,
                exact,
                ..
            } = margin;
            assert!(
                exact && value <= upper && upper - value <= ACCURACY * upper + ROUNDING,
                "{margin:?} {model:?}"
            );
            assert!((direction.norm() - 1.0).abs() < ROUNDING);
            let reach = support(&model, &grasp, &direction);
            assert!(
                reach <= upper && upper - reach < ROUNDING,
                "{reach} {margin:?}"
            );
            let mut starts: Vec<Wrench> = (0..8).map(|_| random_direction(&mut rng)).collect();
            starts.push(direction);
            let least = least_support(&mut rng, &model, &grasp, &starts);
            assert!(least >= value, "{least} below {margin:?} of {model:?}");
            for _ in 0..2000 {
                assert!(support(&model, &grasp, &random_direction(&mut rng)) >= value);
            }
        }
        let mut open = 0;
        for _ in 0..300 {
            let grasp = contacts(&mut rng, m);
            for margin in [
                evaluator.grasp_quality(&model, &grasp, 1e-2),
                evaluator.grasp_margin(&model, &grasp, 1e-3),
            ] {
                match margin {
                    Ok(margin) if margin.is_force_closure() => {
                        let u = random_direction(&mut rng);
                        assert!(support(&model, &grasp, &u) >= margin.value);
                    }
                    Ok(Margin {
                        direction, upper, ..
                    }) => {
                        open += 1;
                        let reach = support(&model, &grasp, &direction);
                        assert!(reach <= 1e-9 && (reach - upper).abs() < ROUNDING);
                    }
                    Err(Degenerate { direction, .. }) => {
                        assert!(support(&model, &grasp, &direction) <= 1e-9);
                    }
                }
            }
        }
        assert!(open > 10, "{open} of {model:?}");
    }
}

#[test]
fn outside_the_margin_is_minus_the_distance() {
    let mut rng = Pcg64::seed_from_u64(4);
    let mut evaluator = Evaluator::new();
    let mut far = 0;
    for contact_model in [hard(0.3, Cone::Round), soft(0.3, 0.2, Cone::Round)] {
        let model = model(contact_model, WrenchSpace::L1);
        for _ in 0..400 {
            let grasp = contacts(&mut rng, 3);
            let Ok(margin) = evaluator.grasp_margin(&model, &grasp, ACCURACY) else {
                continue;
            };
            if margin.is_force_closure() || margin.value > -1e-3 {
                continue;
            }
            far += 1;
            assert!(margin.upper - margin.value < 1e-6, "{margin:?}");
            let reach = support(&model, &grasp, &margin.direction);
            assert!((reach - margin.upper).abs() < ROUNDING);
            let least = least_support(&mut rng, &model, &grasp, &[margin.direction]);
            assert!(least >= margin.value, "{least} {margin:?}");
        }
    }
    assert!(far > 100, "{far}");
}

#[test]
fn the_norm_of_edges_scales_the_interval() {
    let mut rng = Pcg64::seed_from_u64(5);
    let mut evaluator = Evaluator::new();
    for (model, m) in cases() {
        let factor = match model.contact_model {
            ContactModel::Frictionless => 1.0,
            ContactModel::Hard { friction, .. } | ContactModel::Soft { friction, .. } => {
                friction.get().hypot(1.0)
            }
        };
        let normal = WrenchModel {
            edge_norm: EdgeNorm::UnitNormal,
            ..model
        };
        for (grasp, edge) in closed(&mut rng, &mut evaluator, &model, m, 10) {
            let mut scaled = evaluator.grasp_quality(&normal, &grasp, ACCURACY).unwrap();
            scaled.value /= factor;
            scaled.upper /= factor;
            assert!(overlap(&scaled, &edge), "{scaled:?} {edge:?}");
        }
    }
}

#[test]
fn moving_turning_resizing_and_renumbering_leave_the_interval() {
    let mut rng = Pcg64::seed_from_u64(6);
    let mut evaluator = Evaluator::new();
    for (model, m) in cases() {
        for (mut grasp, before) in closed(&mut rng, &mut evaluator, &model, m, 8) {
            let turn = Rotation3::from_scaled_axis(unit(&mut rng).into_inner() * 2.0);
            let shift = unit(&mut rng).into_inner() * 3.0;
            let size = 10.0_f64.powf(5.0 * signed(&mut rng));
            let place = |p: Point3<f64>| (turn * p + shift) * size;
            for contact in &mut grasp {
                contact.position = place(contact.position);
                contact.normal = turn * contact.normal;
            }
            grasp.rotate_left(1);
            let contact_model = match model.contact_model {
                ContactModel::Soft {
                    friction,
                    torsion,
                    cone,
                } => soft(friction.get(), torsion.get() * size, cone),
                other => other,
            };
            let moved = WrenchModel {
                contact_model,
                center: place(model.center),
                torque_scale: model.torque_scale / size,
                ..model
            };
            let after = evaluator.grasp_quality(&moved, &grasp, ACCURACY).unwrap();
            // Positions lose digits to the shift.
            assert!((after.value - before.value).abs() <= 2.0 * ACCURACY * before.upper);
        }
    }
}

#[test]
fn greater_spaces_have_greater_quality() {
    let mut rng = Pcg64::seed_from_u64(7);
    let mut evaluator = Evaluator::new();
    for (mu, m) in [(0.3, 5), (0.6, 4), (0.9, 3)] {
        let l1 = model(hard(mu, pyramid(8)), WrenchSpace::L1);
        for (grasp, least) in closed(&mut rng, &mut evaluator, &l1, m, 15) {
            let mut of = |contact_model, space| {
                let model = model(contact_model, space);
                evaluator.grasp_quality(&model, &grasp, ACCURACY).unwrap()
            };
            for cone in [pyramid(8), Cone::Round] {
                let hull = of(hard(mu, cone), WrenchSpace::L1);
                let sum = of(hard(mu, cone), WrenchSpace::Linf);
                assert!(hull.value <= sum.upper && sum.value <= m as f64 * hull.upper);
            }
            for space in SPACES {
                let edged = of(hard(mu, pyramid(8)), space);
                let round = of(hard(mu, Cone::Round), space);
                let twisting = of(soft(mu, 0.1, Cone::Round), space);
                let more = of(soft(mu, 0.4, Cone::Round), space);
                let hardly = of(soft(mu, 1e-9, Cone::Round), space);
                assert!(edged.value <= round.upper && round.value <= twisting.upper);
                assert!(twisting.value <= more.upper);
                assert!((hardly.value - round.value).abs() < 2.0 * ACCURACY);
            }
            assert!(least.value <= of(hard(mu, Cone::Round), WrenchSpace::L1).upper);
        }
    }
}

#[test]
fn a_looser_accuracy_or_fewer_facets_only_widen_the_interval() {
    let mut rng = Pcg64::seed_from_u64(8);
    let mut evaluator = Evaluator::new();
    let mut given_up = 0;
    for (model, m) in cases() {
        for (grasp, fine) in closed(&mut rng, &mut evaluator, &model, m, 8) {
            for accuracy in [0.3, 1e-2, 1e-3] {
                let loose = evaluator.grasp_quality(&model, &grasp, accuracy).unwrap();
                assert!(loose.exact && overlap(&loose, &fine));
                assert!(
                    loose.upper - loose.value <= accuracy * loose.upper + ROUNDING,
                    "{loose:?}"
                );
            }
            for limit in [7, 20, 60, 200] {
                let mut small = Evaluator::with_facet_limit(limit);
                let wide = small.grasp_quality(&model, &grasp, ACCURACY).unwrap();
                assert!(wide.value <= fine.upper && wide.upper >= fine.value);
                assert!(wide.facets <= limit);
                given_up += usize::from(!wide.exact);
            }
        }
    }
    assert!(given_up > 100, "{given_up}");
}

#[test]
fn grasps_that_can_never_close_do_not() {
    let mut rng = Pcg64::seed_from_u64(9);
    let mut evaluator = Evaluator::new();
    let mut open = |model: &WrenchModel, grasp: &[Contact]| {
        for margin in [
            evaluator.grasp_quality(model, grasp, ACCURACY),
            evaluator.grasp_margin(model, grasp, ACCURACY),
        ] {
            let direction = match margin {
                Ok(margin) => {
                    assert!(!margin.is_force_closure(), "{margin:?} of {model:?}");
                    margin.direction
                }
                Err(Degenerate { rank, direction }) => {
                    assert!(rank < 6);
                    direction
                }
            };
            assert!(support(model, grasp, &direction) < 1e-9);
        }
    };
    for space in SPACES {
        for _ in 0..200 {
            let pair = contacts(&mut rng, 2);
            open(&model(hard(1.5, Cone::Round), space), &pair);
            let one = &pair[..1];
            open(&model(soft(1.5, 1.0, Cone::Round), space), one);
            open(&model(soft(1.5, 1.0, Cone::Round), space), &[one[0]; 5]);
            let ball: Vec<Contact> = (0..12)
                .map(|_| {
                    let normal = unit(&mut rng);
                    let position = (-normal.into_inner()).into();
                    Contact { position, normal }
                })
                .collect();
            let centred = WrenchModel {
                center: Point3::origin(),
                ..model(ContactModel::Frictionless, space)
            };
            open(&centred, &ball);
        }
    }
}

#[test]
fn opposite_soft_fingers_close() {
    let mut evaluator = Evaluator::new();
    let finger = |x: f64| Contact {
        position: Point3::new(x, 0.0, 0.0),
        normal: Unit::new_normalize(Vector3::new(-x, 0.0, 0.0)),
    };
    let (mu, torsion) = (0.5_f64, 0.3);
    for space in SPACES {
        let model = WrenchModel {
            edge_norm: EdgeNorm::UnitNormal,
            center: Point3::origin(),
            torque_scale: 1.0,
            ..model(soft(mu, torsion, Cone::Round), space)
        };
        let margin = evaluator
            .grasp_quality(&model, &[finger(1.0), finger(-1.0)], ACCURACY)
            .unwrap();
        // About the line through both nothing but torsion resists; along any u = (a; b) each
        // finger reaches ∓a_x + √(μ²·‖a_t ± x×b_t‖² + μ_t²·b_x²), and μ_t is the least.
        let times = if space == WrenchSpace::L1 { 1.0 } else { 2.0 };
        assert!(margin.is_force_closure(), "{margin:?}");
        // The least support is reached all around the line, which takes more facets than allowed.
        assert!(
            margin.upper - margin.value < 1e-2 * margin.upper,
            "{margin:?}"
        );
        assert!(margin.value <= times * torsion, "{margin:?}");
    }
}

#[test]
fn what_is_no_number_is_refused() {
    let mut rng = Pcg64::seed_from_u64(10);
    let mut evaluator = Evaluator::new();
    for (model, m) in cases() {
        let mut grasp = contacts(&mut rng, m);
        grasp[1].position.y = f64::NAN;
        assert_eq!(
            evaluator
                .grasp_quality(&model, &grasp, ACCURACY)
                .unwrap_err()
                .rank,
            0
        );
        grasp[1].position.y = f64::INFINITY;
        assert_eq!(
            evaluator
                .grasp_margin(&model, &grasp, ACCURACY)
                .unwrap_err()
                .rank,
            0
        );
        assert_eq!(
            evaluator
                .grasp_quality(&model, &[], ACCURACY)
                .unwrap_err()
                .rank,
            0
        );
    }
}
