//! How intervals of one grasp, of the same moved or of another space stand to each other, and odd grasps.

use super::*;

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
