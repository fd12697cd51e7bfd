//! The evaluator against the oracle, closed forms and invariances.

use nalgebra::{Matrix6, Rotation3, Vector3};
use rand::{Rng, SeedableRng};
use rand_pcg::Pcg64;

use super::Evaluator;
use super::oracle::{self, scale};
use crate::wrench::Wrench;

fn uniform(rng: &mut Pcg64) -> f64 {
    (rng.next_u64() >> 11) as f64 / (1_u64 << 53) as f64
}

fn below(rng: &mut Pcg64, n: usize) -> usize {
    (rng.next_u64() % n as u64) as usize
}

fn random_wrench(rng: &mut Pcg64) -> Wrench {
    Wrench::from_fn(|_, _| 2.0 * uniform(rng) - 1.0)
}

fn random_set(rng: &mut Pcg64, n: usize) -> Vec<Wrench> {
    (0..n).map(|_| random_wrench(rng)).collect()
}

/// Sets of up to 14 wrenches of many kinds: generic, small integers (coplanar and coincident
/// everywhere), repeated, near one flat, with points inside, with cones, and of lower rank.
fn odd_set(rng: &mut Pcg64, kind: usize) -> Vec<Wrench> {
    let n = 7 + below(rng, 8);
    match kind % 8 {
        0 => random_set(rng, n),
        1 => (0..n)
            .map(|_| Wrench::from_fn(|_, _| below(rng, 3) as f64 - 1.0))
            .collect(),
        2 => {
            let mut set = random_set(rng, n.min(10));
            while set.len() < n {
                set.push(set[below(rng, set.len())]);
            }
            set
        }
        3 => {
            let mut set = random_set(rng, n);
            let flat = n / 2;
            for w in &mut set[..flat + 2] {
                w[5] = 0.25;
            }
            set
        }
        4 => {
            let mut set = random_set(rng, 8);
            while set.len() < n {
                let t = uniform(rng);
                let inner = set[below(rng, 8)] * t + set[below(rng, 8)] * (1.0 - t);
                set.push(inner);
            }
            set
        }
        5 => {
            let cones = 3;
            (0..cones)
                .flat_map(|_| {
                    let axis = random_wrench(rng);
                    let (a, b) = (random_wrench(rng) * 0.3, random_wrench(rng) * 0.3);
                    (0..4).map(move |j| {
                        let (sin, cos) = (std::f64::consts::FRAC_PI_2 * f64::from(j)).sin_cos();
                        axis + a * cos + b * sin
                    })
                })
                .collect()
        }
        6 => {
            let mut set = random_set(rng, n);
            for w in &mut set {
                w[2] = w[0] - 0.5 * w[1];
            }
            set
        }
        _ => {
            let mut set = random_set(rng, n);
            for i in 1..n / 2 {
                let mirrored = -set[i - 1];
                set[i] = mirrored;
            }
            set
        }
    }
}

fn support(set: &[Wrench], direction: &Wrench) -> f64 {
    set.iter()
        .map(|w| w.dot(direction))
        .fold(f64::NEG_INFINITY, f64::max)
}

#[test]
fn agrees_with_the_six_subset_oracle() {
    let mut rng = Pcg64::seed_from_u64(1);
    let mut evaluator = Evaluator::new();
    let (mut inside, mut outside, mut flat) = (0, 0, 0);
    for case in 0..12_000 {
        let mut set = odd_set(&mut rng, case);
        if case % 16 < 8 {
            let mean = set.iter().sum::<Wrench>() / set.len() as f64;
            for w in &mut set {
                *w -= mean;
            }
        }
        match (evaluator.margin(&set), oracle::margin(&set)) {
            (Ok(found), Some(truth)) => {
                let tolerance = 1e-9 * truth.abs().max(1e-3 * scale(&set));
                assert!(
                    (found.value - truth).abs() <= tolerance,
                    "case {case}: {} instead of {truth}: {set:?}",
                    found.value
                );
                assert!(found.exact);
                if truth > 0.0 {
                    inside += 1
                } else {
                    outside += 1
                }
                let quality = evaluator.quality(&set).unwrap();
                if truth > 1e-9 {
                    assert!((quality.value - truth).abs() <= tolerance && quality.exact);
                    assert!(quality.is_force_closure());
                } else if truth < -1e-9 {
                    assert!(!quality.is_force_closure());
                    let support = support(&set, &quality.direction);
                    assert!(support <= 1e-9 && (support - quality.value).abs() < 1e-12);
                }
            }
            (Err(degenerate), _) => {
                flat += 1;
                assert!(degenerate.rank < 6);
            }
            (Ok(found), None) => panic!("case {case}: {found:?} of a set without facets: {set:?}"),
        }
    }
    assert!(
        inside > 2000 && outside > 2000 && flat > 1000,
        "{inside} {outside} {flat}"
    );
}

#[test]
fn the_cross_polytope_has_quality_one_over_root_six() {
    let set: Vec<Wrench> = (0..12)
        .map(|i| Wrench::ith(i / 2, if i % 2 == 0 { 1.0 } else { -1.0 }))
        .collect();
    let margin = Evaluator::new().quality(&set).unwrap();
    assert!((margin.value - 6.0_f64.sqrt().recip()).abs() < 1e-15);
}

#[test]
fn the_cube_has_quality_one() {
    let set: Vec<Wrench> = (0..64)
        .map(|i| Wrench::from_fn(|axis, _| if i >> axis & 1 == 0 { 1.0 } else { -1.0 }))
        .collect();
    let margin = Evaluator::new().margin(&set).unwrap();
    assert!((margin.value - 1.0).abs() < 1e-15, "{margin:?}");
}

#[test]
fn too_few_or_flat_sets_are_degenerate_with_their_rank() {
    let mut rng = Pcg64::seed_from_u64(4);
    let mut evaluator = Evaluator::new();
    for n in 0..7 {
        let set = random_set(&mut rng, n);
        let degenerate = evaluator.quality(&set).unwrap_err();
        assert_eq!(degenerate.rank, n.saturating_sub(1));
        let components: Vec<f64> = set.iter().map(|w| w.dot(&degenerate.direction)).collect();
        assert!((degenerate.direction.norm() - 1.0).abs() < 1e-12);
        assert!(
            components
                .iter()
                .all(|c| (c - components[0]).abs() < 1e-12 && *c < 1e-12)
        );
    }
    let same = vec![random_wrench(&mut rng); 30];
    for flat in [&same[..], &[Wrench::zeros(); 9]] {
        assert_eq!(evaluator.margin(flat).unwrap_err().rank, 0);
        assert!(!evaluator.quality(flat).is_ok_and(|m| m.is_force_closure()));
    }
}

#[test]
fn supporting_normals_tell_exactly_which_wrenches_close_the_set() {
    let mut rng = Pcg64::seed_from_u64(5);
    let mut evaluator = Evaluator::new();
    let (mut closing, mut not) = (0, 0);
    for case in 0..400 {
        let n = 6 + case % 8;
        let mut rest = random_set(&mut rng, n);
        for w in &mut rest {
            w[0] = w[0].abs() - 0.1;
            w[1] += 0.2;
        }
        let normals = evaluator.supporting_normals(&rest).unwrap().unwrap();
        for _ in 0..40 {
            let w = random_wrench(&mut rng) * 3.0 - rest.iter().sum::<Wrench>() * 0.5;
            let predicted = normals
                .iter()
                .map(|u| u.dot(&w))
                .fold(f64::INFINITY, f64::min);
            if predicted.abs() < 1e-6 {
                continue;
            }
            rest.push(w);
            let truth = evaluator.quality(&rest).unwrap().value > 0.0;
            rest.pop();
            assert_eq!(predicted > 0.0, truth, "{predicted}");
            if truth { closing += 1 } else { not += 1 }
        }
    }
    assert!(closing > 500 && not > 500, "{closing} {not}");
}

/// 1,000 random sets of 7 to 40 wrenches with the margin of each.
fn each_set(seed: u64, mut check: impl FnMut(&mut Pcg64, &mut Evaluator, Vec<Wrench>, f64)) {
    let mut rng = Pcg64::seed_from_u64(seed);
    let mut evaluator = Evaluator::new();
    for case in 0..1000 {
        let n = 7 + case % 14;
        let mut set = random_set(&mut rng, n);
        if case % 3 > 0 {
            let mean = set.iter().sum::<Wrench>() / n as f64;
            set.iter_mut().for_each(|w| *w -= mean);
        }
        let margin = evaluator.margin(&set).unwrap().value;
        check(&mut rng, &mut evaluator, set, margin);
    }
}

fn assert_same(found: f64, expected: f64) {
    assert!(
        (found - expected).abs() < 1e-12,
        "{found} instead of {expected}"
    );
}

#[test]
fn scaling_the_wrenches_scales_the_margin() {
    each_set(10, |rng, evaluator, set, margin| {
        let factor = 10.0_f64.powf(12.0 * uniform(rng) - 6.0);
        let scaled: Vec<Wrench> = set.iter().map(|w| w * factor).collect();
        assert_same(evaluator.margin(&scaled).unwrap().value / factor, margin);
    });
}

#[test]
fn rotating_forces_and_torques_leaves_the_margin() {
    each_set(11, |rng, evaluator, set, margin| {
        let axis = Vector3::from_fn(|_, _| uniform(rng) - 0.5);
        let rotation = Rotation3::from_scaled_axis(axis * 6.0);
        let mut both = Matrix6::zeros();
        both.fixed_view_mut::<3, 3>(0, 0)
            .copy_from(rotation.matrix());
        both.fixed_view_mut::<3, 3>(3, 3)
            .copy_from(rotation.matrix());
        let turned: Vec<Wrench> = set.iter().map(|w| both * w).collect();
        assert_same(evaluator.margin(&turned).unwrap().value, margin);
    });
}

#[test]
fn order_and_repetition_leave_the_margin() {
    each_set(12, |rng, evaluator, mut set, margin| {
        for i in (1..set.len()).rev() {
            set.swap(i, below(rng, i + 1));
        }
        for _ in 0..5 {
            set.push(set[below(rng, set.len())]);
        }
        assert_same(evaluator.margin(&set).unwrap().value, margin);
    });
}

#[test]
fn interior_wrenches_leave_the_margin() {
    each_set(13, |rng, evaluator, mut set, margin| {
        for _ in 0..6 {
            let weights: Vec<f64> = set.iter().map(|_| uniform(rng)).collect();
            let sum: f64 = weights.iter().sum();
            set.push(set.iter().zip(&weights).map(|(w, t)| w * (t / sum)).sum());
        }
        assert_same(evaluator.margin(&set).unwrap().value, margin);
    });
}

#[test]
fn more_wrenches_never_lower_the_quality() {
    each_set(14, |rng, evaluator, mut set, margin| {
        set.push(random_wrench(rng));
        let grown = evaluator.quality(&set).unwrap().value;
        assert!(margin <= 0.0 || grown >= margin - 1e-12);
    });
}

#[test]
fn seven_wrenches_never_beat_a_sixth_of_the_longest() {
    let mut rng = Pcg64::seed_from_u64(15);
    let mut evaluator = Evaluator::new();
    let mut closed = 0;
    for _ in 0..20_000 {
        let set = random_set(&mut rng, 7);
        let margin = evaluator.quality(&set).unwrap();
        closed += usize::from(margin.is_force_closure());
        assert!(margin.value <= scale(&set) / 6.0 + 1e-15);
    }
    assert!(closed > 50, "{closed}");
}

#[test]
fn simplex_form_and_polytope_agree() {
    let mut rng = Pcg64::seed_from_u64(16);
    let mut polytope = super::hull::Hull::new(super::FACET_LIMIT);
    for _ in 0..5000 {
        let set = random_set(&mut rng, 7);
        let Some(simplex) = super::evaluator::simplex_margin(&set) else {
            continue;
        };
        let hull = polytope.margin(&set).unwrap();
        assert!((hull.value - simplex.value).abs() < 1e-10 * simplex.scale);
    }
}

#[test]
fn a_hull_that_cannot_be_finished_claims_nothing_beyond_its_proof() {
    let mut rng = Pcg64::seed_from_u64(17);
    let (mut outside, mut inside) = (0, 0);
    for case in 0..600 {
        let mut set = random_set(&mut rng, 30 + case % 40);
        if case % 2 == 0 {
            for w in &mut set {
                w[3] += 1.5;
            }
        }
        let truth = Evaluator::new().quality(&set).unwrap();
        let found = Evaluator::with_facet_limit(60).margin(&set).unwrap();
        if truth.is_force_closure() {
            inside += 1;
            assert!(found.value <= truth.value + 1e-12 && found.upper >= truth.value - 1e-12);
        } else {
            outside += 1;
            assert!(found.value <= 1e-9 && support(&set, &found.direction) <= 1e-9);
        }
    }
    assert!(outside > 100 && inside > 100, "{outside} {inside}");
}
