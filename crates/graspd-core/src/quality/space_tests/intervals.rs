//! Intervals hold the truth, and no more than they may.

use super::*;

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
