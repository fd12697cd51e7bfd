//! Memetic, local and random search, and the bounds that exchanges rest on.

use super::candidate_scan::{CandidateScan, HalfSpace};
use super::tests::{
    FRICTIONLESS, ball, block, evolve, hard, initial, problem, problem_in, round, search, settings,
    soft, soft_pyramid,
};
use super::*;
use crate::contact::Contact;
use crate::interrupt::Interrupt;
use crate::quality::Evaluator;
use crate::random::{Purpose, Stream};
use crate::wrench::{Wrench, WrenchSpace};

/// A grasp to start from and its ε.
fn start(problem: &SearchProblem, mode: InitialMode, seed: u64) -> (Grasp, f64) {
    let Initial::Found { grasp, quality } = initial(problem, mode, seed) else {
        panic!("no grasp to start from");
    };
    (grasp, quality)
}

fn climb(problem: &SearchProblem, settings: &SearchSettings, seed: u64) -> (Outcome, u64) {
    climb_within(problem, settings, seed, None)
}

fn climb_within(
    problem: &SearchProblem,
    settings: &SearchSettings,
    seed: u64,
    limit: Option<u64>,
) -> (Outcome, u64) {
    let first = start(problem, InitialMode::Weak, seed);
    search(problem, settings, seed, limit, Method::Memetic, Some(first))
}

/// ε of the best grasp that differs in one finger.
fn best_exchange(problem: &SearchProblem, grasp: &[u32]) -> f64 {
    let mut evaluator = Evaluator::new();
    let mut best = 0.0_f64;
    for slot in 0..grasp.len() {
        for candidate in (0..problem.len() as u32).filter(|c| !grasp.contains(c)) {
            let mut other = grasp.to_vec();
            other[slot] = candidate;
            let contacts = problem.grasp_contacts(&other);
            let margin = evaluator.grasp_quality(problem.model(), &contacts, 1e-4);
            best = best.max(margin.map_or(0.0, |margin| margin.value));
        }
    }
    best
}

#[test]
fn no_exchange_improves_what_is_certified() {
    let cases = [
        (WrenchSpace::L1, block(6), FRICTIONLESS, 7, 6),
        (WrenchSpace::L1, block(7), hard(0.3, 8), 3, 8),
        (WrenchSpace::L1, block(7), hard(0.3, 8), 4, 6),
        (WrenchSpace::L1, block(5), hard(0.5, 5), 5, 3),
        (WrenchSpace::L1, ball(300), hard(0.2, 6), 4, 4),
        (WrenchSpace::L1, ball(300), hard(0.4, 7), 3, 4),
        (WrenchSpace::L1, block(4), soft_pyramid(0.4, 0.1, 6), 3, 2),
        (WrenchSpace::L1, block(4), round(0.3), 4, 1),
        (WrenchSpace::Linf, block(4), FRICTIONLESS, 7, 1),
        (WrenchSpace::Linf, block(4), hard(0.4, 8), 3, 1),
    ];
    for (space, candidates, model, contacts, seeds) in cases {
        let problem = problem_in(space, candidates, model, contacts);
        for seed in 0..seeds {
            let (outcome, _) = climb(&problem, &settings(3, 1), seed);
            let (grasp, quality) = outcome.best.expect("a grasp");
            assert!(
                outcome.single_exchange_optimal,
                "{model:?} {contacts} {seed}"
            );
            let tolerance = match problem.model().is_finite_hull() {
                true => EXCHANGE_TOLERANCE,
                false => 2e-3,
            };
            let best = best_exchange(&problem, &grasp);
            assert!(
                best <= quality * (1.0 + tolerance),
                "{model:?} {contacts} {seed}: {quality} but {best} in reach"
            );
        }
    }
}

#[test]
fn a_climb_that_is_cut_short_certifies_nothing() {
    let problem = problem(block(10), hard(0.3, 8), 4);
    for limit in [8, 20, 50, 111] {
        let (outcome, evaluations) = climb_within(&problem, &settings(4, 50), 1, Some(limit));
        assert_eq!(outcome.stop, StopReason::EvaluationLimit);
        assert!(
            evaluations <= limit && evaluations + 4 > limit,
            "{evaluations}"
        );
        if let (true, Some((grasp, quality))) = (outcome.single_exchange_optimal, outcome.best) {
            assert!(best_exchange(&problem, &grasp) <= quality * (1.0 + EXCHANGE_TOLERANCE));
        }
    }
}

#[test]
fn memetic_search_is_the_same_on_any_number_of_threads() {
    for (space, model) in [
        (WrenchSpace::L1, hard(0.3, 6)),
        (WrenchSpace::Linf, round(0.3)),
    ] {
        let problem = problem_in(space, block(8), model, 4);
        let on = |threads| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads);
            pool.build()
                .unwrap()
                .install(|| climb(&problem, &settings(40, 2), 9))
        };
        let one = on(1);
        assert_eq!(one, on(2));
        assert_eq!(one, on(5));
    }
}

#[test]
fn memetic_search_is_better_than_the_rivals_for_fewer_evaluations() {
    for (model, contacts) in [(FRICTIONLESS, 7), (hard(0.2, 8), 4)] {
        let problem = problem(block(12), model, contacts);
        let mut means = [0.0; 4];
        let mut spent = [0; 4];
        for seed in 0..4 {
            let first = Some(start(&problem, InitialMode::Weak, seed));
            let (few, many) = (settings(2, 1), settings(100, 40));
            let outcomes = [
                climb(&problem, &settings(4, 3), seed),
                evolve(&problem, &many, seed),
                search(&problem, &few, seed, None, Method::Local, first),
                search(&problem, &many, seed, None, Method::Random, None),
            ];
            for (i, (outcome, evaluations)) in outcomes.iter().enumerate() {
                means[i] += outcome.best.as_ref().map_or(0.0, |best| best.1) / 4.0;
                spent[i] += evaluations;
            }
        }
        let [memetic, genetic, local, random] = means;
        assert!(memetic > 1.2 * genetic && memetic > local, "{means:?}");
        assert!(genetic > random, "{means:?}");
        assert!(spent[0] < spent[1], "{spent:?}");
    }
}

#[test]
fn local_search_only_improves_and_says_when_it_is_stuck() {
    let problem = problem(block(10), hard(0.3, 8), 4);
    for seed in 0..6 {
        let first = start(&problem, InitialMode::Strict, seed);
        let quality = first.1;
        let run = |limit| {
            let first = Some(first.clone());
            search(&problem, &settings(2, 1), seed, limit, Method::Local, first)
        };
        let (outcome, evaluations) = run(None);
        assert_eq!(outcome.stop, StopReason::LocalOptimum);
        let best: Vec<f64> = outcome.history.iter().filter_map(|g| g.best).collect();
        assert!(best.windows(2).all(|w| w[1] > w[0]) && best[0] == quality);
        let (grasp, found) = outcome.best.unwrap();
        let margin = Evaluator::new().margin(&problem.wrenches(&grasp)).unwrap();
        assert!((margin.value - found).abs() < 1e-12 && best.last() == Some(&found));
        let (cut_short, spent) = run(Some(evaluations / 2));
        assert_eq!(
            (cut_short.stop, spent),
            (StopReason::EvaluationLimit, evaluations / 2)
        );
    }
}

#[test]
fn random_search_counts_what_it_was_asked_for() {
    let problem = problem(block(8), hard(0.5, 8), 4);
    let (outcome, evaluations) = search(&problem, &settings(50, 5), 1, None, Method::Random, None);
    assert_eq!((evaluations, outcome.history.len()), (300, 6));
    assert_eq!(outcome.stop, StopReason::GenerationLimit);
    assert!(outcome.best.is_some());
}

/// The bound of every candidate is at least what the candidate reaches, and close to it.
#[test]
fn bounds_of_candidates_hold_and_are_tight() {
    let models = [
        (WrenchSpace::L1, FRICTIONLESS),
        (WrenchSpace::L1, hard(0.7, 8)),
        (WrenchSpace::L1, hard(0.7, 5)),
        (WrenchSpace::L1, hard(0.2, 6)),
        (WrenchSpace::L1, hard(0.2, 3)),
        (WrenchSpace::L1, round(0.4)),
        (WrenchSpace::L1, soft(0.4, 0.2)),
        (WrenchSpace::L1, soft_pyramid(0.4, 0.2, 8)),
        (WrenchSpace::Linf, round(1.3)),
    ];
    for (space, model) in models {
        for candidates in [ball(700), block(9)] {
            let problem = problem_in(space, candidates, model, 4);
            let scan = CandidateScan::new(&problem, Interrupt::never()).unwrap();
            let mut stream = Stream::new(8, Purpose::Population, 0);
            for round in 0..40 {
                let mut half_space = || HalfSpace {
                    direction: Wrench::from_fn(|_, _| stream.below(2001) as f64 - 1000.0)
                        .normalize(),
                    base: if space == WrenchSpace::Linf { 0.3 } else { 0.0 },
                };
                let half_spaces: Vec<HalfSpace> =
                    (0..1 + round % 3).map(|_| half_space()).collect();
                let reach = |candidate: u32| {
                    let contact = Contact::from(problem.candidate(candidate));
                    let reaches = half_spaces.iter().map(|half_space| {
                        let own: f64 = problem
                            .wrenches(&[candidate])
                            .iter()
                            .map(|w| w.dot(&half_space.direction))
                            .fold(f64::NEG_INFINITY, f64::max);
                        let reach = problem.model().reach(&contact, &half_space.direction);
                        if problem.model().contact_model.is_round() {
                            // The pyramid that stands in for the cone is inside it.
                            assert!(reach >= own - 1e-12);
                        } else {
                            assert!((reach - own).abs() < 1e-12, "{reach} {own}");
                        }
                        half_space.base
                            + if space == WrenchSpace::Linf {
                                reach.max(0.0)
                            } else {
                                reach
                            }
                    });
                    reaches.fold(f64::INFINITY, f64::min)
                };
                let threshold = 0.2;
                let mut found = Vec::new();
                scan.survivors(&half_spaces[..1], threshold, &mut found);
                for half_space in &half_spaces[1..] {
                    scan.narrow(half_space, threshold, &mut found);
                }
                let mut at_once = Vec::new();
                scan.survivors(&half_spaces, threshold, &mut at_once);
                assert_eq!(found, at_once);
                for candidate in 0..problem.len() as u32 {
                    let exact = reach(candidate);
                    match found.iter().find(|s| s.candidate == candidate) {
                        Some(survivor) => {
                            let bound = survivor.bound;
                            assert!(bound >= exact && bound <= exact + 1e-4, "{bound} {exact}");
                        }
                        None => assert!(exact <= threshold),
                    }
                }
            }
        }
    }
}

#[test]
fn a_small_problem_is_searched_to_the_end() {
    let never = Interrupt::never();
    let mut budget = Budget::new(None);
    let cube = problem(block(1), hard(0.5, 8), 4);
    let found = exhaustive_search(&cube, &mut budget, never);
    let Ok(Some(AllGrasps {
        grasps: 15,
        best: Some((grasp, quality)),
    })) = found
    else {
        panic!("{found:?}");
    };
    assert_eq!(budget.spent(), 15);
    assert!(best_exchange(&cube, &grasp) <= quality);
    let none = problem(block(1), FRICTIONLESS, 5);
    let nothing = AllGrasps {
        grasps: 6,
        best: None,
    };
    let found = exhaustive_search(&none, &mut budget, never);
    assert_eq!(found, Ok(Some(nothing)));
    for (candidates, contacts) in [(block(9), 4), (block(2), 12), (block(9), 64)] {
        let large = problem(candidates, FRICTIONLESS, contacts);
        assert_eq!(exhaustive_search(&large, &mut budget, never), Ok(None));
    }
}
