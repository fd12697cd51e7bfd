//! The search on bodies made of known candidates.

use std::sync::atomic::{AtomicBool, Ordering};

use nalgebra::{Point3, Unit, Vector3};

use super::*;
use crate::contact::{Cone, ConeEdges, ContactModel, Friction, Torsion};
use crate::interrupt::{Interrupt, Interrupted};
use crate::mesh::Candidate;
use crate::quality::{ACCURACY, Evaluator};
use crate::random::{Purpose, Stream};
use crate::wrench::{EdgeNorm, WrenchModel, WrenchSpace};

/// A grid of candidates on the faces of a box with half edges 1, 0.6 and 0.4.
pub(super) fn block(cells: usize) -> Vec<Candidate> {
    let half = Vector3::new(1.0, 0.6, 0.4);
    let mut candidates = Vec::new();
    for face in 0..6 {
        let (axis, sign) = (face / 2, if face % 2 == 0 { 1.0 } else { -1.0 });
        for i in 0..cells {
            for j in 0..cells {
                let at = |k: usize| 2.0 * (k as f64 + 0.5) / cells as f64 - 1.0;
                let mut local = Vector3::zeros();
                local[axis] = sign;
                local[(axis + 1) % 3] = at(i);
                local[(axis + 2) % 3] = at(j);
                let mut normal = Vector3::zeros();
                normal[axis] = -sign;
                candidates.push(Candidate {
                    position: Point3::from(local.component_mul(&half)),
                    normal: Unit::new_unchecked(normal),
                    triangle: candidates.len() as u32,
                    barycentric: [1.0 / 3.0; 3],
                });
            }
        }
    }
    candidates
}

/// Candidates all over a unit sphere.
pub(super) fn ball(n: usize) -> Vec<Candidate> {
    (0..n)
        .map(|i| {
            let z = 1.0 - 2.0 * (i as f64 + 0.5) / n as f64;
            let angle = 2.399_963_229_728_653 * i as f64;
            let (sin, cos) = angle.sin_cos();
            let r = (1.0 - z * z).sqrt();
            let outward = Vector3::new(r * cos, r * sin, z);
            Candidate {
                position: Point3::from(outward),
                normal: Unit::new_normalize(-outward),
                triangle: i as u32,
                barycentric: [1.0 / 3.0; 3],
            }
        })
        .collect()
}

pub(super) const FRICTIONLESS: ContactModel = ContactModel::Frictionless;

pub(super) fn hard(mu: f64, edges: u32) -> ContactModel {
    ContactModel::Hard {
        friction: Friction::new(mu).unwrap(),
        cone: Cone::Pyramid(ConeEdges::new(edges).unwrap()),
    }
}

pub(super) fn round(mu: f64) -> ContactModel {
    hard(mu, 8).with_cone(Cone::Round)
}

pub(super) fn soft(mu: f64, torsion: f64) -> ContactModel {
    ContactModel::Soft {
        friction: Friction::new(mu).unwrap(),
        torsion: Torsion::new(torsion).unwrap(),
        cone: Cone::Round,
    }
}

pub(super) fn soft_pyramid(mu: f64, torsion: f64, edges: u32) -> ContactModel {
    soft(mu, torsion).with_cone(Cone::Pyramid(ConeEdges::new(edges).unwrap()))
}

pub(super) fn problem(
    candidates: Vec<Candidate>,
    contact_model: ContactModel,
    contacts: usize,
) -> SearchProblem {
    problem_in(WrenchSpace::L1, candidates, contact_model, contacts)
}

pub(super) fn problem_in(
    space: WrenchSpace,
    candidates: Vec<Candidate>,
    contact_model: ContactModel,
    contacts: usize,
) -> SearchProblem {
    let model = WrenchModel {
        contact_model,
        edge_norm: EdgeNorm::UnitEdge,
        space,
        center: Point3::origin(),
        torque_scale: 0.8,
    };
    SearchProblem::new(candidates, model, contacts).unwrap()
}

pub(super) fn settings(population: usize, generations: usize) -> SearchSettings {
    SearchSettings {
        population,
        generations,
        crossover_probability: 0.9,
        mutation_probability: 0.2,
        elitism: 1,
        target_quality: None,
    }
}

pub(super) fn initial(problem: &SearchProblem, mode: InitialMode, seed: u64) -> Initial {
    let mut budget = Budget::new(None);
    let never = Interrupt::never();
    initial_grasp(problem, mode, seed, &mut budget, never, &mut |_| {})
}

/// Runs a method within a limit of evaluations, and returns how many it made.
pub(super) fn search(
    problem: &SearchProblem,
    settings: &SearchSettings,
    seed: u64,
    limit: Option<u64>,
    method: Method,
    first: Option<(Grasp, f64)>,
) -> (Outcome, u64) {
    let mut budget = Budget::new(limit);
    let search = Search {
        problem,
        settings,
        seed,
        budget: &mut budget,
        interrupt: Interrupt::never(),
        observe: &mut |_| {},
    };
    let outcome = search.run(method, first);
    (outcome, budget.spent())
}

pub(super) fn evolve(
    problem: &SearchProblem,
    settings: &SearchSettings,
    seed: u64,
) -> (Outcome, u64) {
    search(problem, settings, seed, None, Method::ModifiedGa, None)
}

#[test]
fn algorithm_1_closes_a_block_without_and_with_friction() {
    let cases = [
        (FRICTIONLESS, 7),
        (FRICTIONLESS, 9),
        (hard(0.3, 8), 3),
        (hard(0.2, 8), 4),
        (hard(0.5, 5), 5),
    ];
    for (model, contacts) in cases {
        let problem = problem(block(10), model, contacts);
        for mode in [InitialMode::Weak, InitialMode::Strict] {
            for seed in 0..10 {
                let Initial::Found { grasp, quality } = initial(&problem, mode, seed) else {
                    panic!("no grasp for {model:?} {contacts} {mode:?} {seed}");
                };
                assert_eq!(grasp.len(), contacts);
                assert!(grasp.windows(2).all(|w| w[0] < w[1]));
                let margin = Evaluator::new().margin(&problem.wrenches(&grasp)).unwrap();
                assert!(margin.is_force_closure() && margin.value == quality);
            }
        }
    }
}

#[test]
fn bodies_that_cannot_be_held_are_proven_so() {
    let sphere = problem(ball(500), FRICTIONLESS, 7);
    match initial(&sphere, InitialMode::Weak, 1) {
        Initial::Impossible(Impossible::Deficient { rank, direction }) => {
            assert_eq!(rank, 3);
            // A torque about the centre, told about the centroid of the candidates, 10⁻⁵ off it.
            assert!(direction.fixed_rows::<3>(0).norm() < 1e-4, "{direction}");
        }
        other => panic!("{other:?}"),
    }
    for (model, contacts, least) in [(FRICTIONLESS, 6, 7), (hard(0.5, 8), 2, 3)] {
        let block = problem(block(4), model, contacts);
        let proof = Initial::Impossible(Impossible::TooFewContacts { least });
        assert_eq!(initial(&block, InitialMode::Weak, 1), proof);
    }
    let mut upper = block(6);
    upper.retain(|c| c.normal.z > -0.5);
    let upper = problem(upper, FRICTIONLESS, 7);
    match initial(&upper, InitialMode::Weak, 1) {
        Initial::Impossible(Impossible::OneSided { direction }) => {
            assert!(direction[2] < -1e-3, "{direction}");
        }
        other => panic!("{other:?}"),
    }
}

#[test]
fn the_genetic_algorithm_improves_generation_by_generation() {
    let problem = problem(block(10), hard(0.3, 8), 4);
    let (outcome, evaluations) = evolve(&problem, &settings(60, 15), 3);
    assert_eq!(outcome.stop, StopReason::GenerationLimit);
    assert_eq!(outcome.history.len(), 16);
    assert_eq!(evaluations, 60 + 15 * 59);
    let best: Vec<f64> = outcome.history.iter().filter_map(|g| g.best).collect();
    assert!(best.windows(2).all(|w| w[1] >= w[0]));
    assert!(best[best.len() - 1] > 1.3 * best[0], "{best:?}");
    let (grasp, quality) = outcome.best.unwrap();
    let margin = Evaluator::new().margin(&problem.wrenches(&grasp)).unwrap();
    assert_eq!(margin.value, quality);
}

#[test]
fn the_outcome_does_not_depend_on_the_number_of_threads() {
    let problem = problem(block(8), hard(0.3, 6), 4);
    let on = |threads| {
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .unwrap();
        pool.install(|| {
            (
                initial(&problem, InitialMode::Weak, 9),
                evolve(&problem, &settings(50, 8), 9),
            )
        })
    };
    let one = on(1);
    assert_eq!(one, on(2));
    assert_eq!(one, on(5));
}

#[test]
fn limits_targets_and_the_observer_stop_the_search() {
    let problem = problem(block(8), hard(0.5, 8), 4);
    let (method, limit) = (Method::ModifiedGa, Some(333));
    let (outcome, evaluations) = search(&problem, &settings(100, 50), 1, limit, method, None);
    assert_eq!(
        (outcome.stop, evaluations),
        (StopReason::EvaluationLimit, 333)
    );
    let easy = SearchSettings {
        target_quality: Some(1e-3),
        ..settings(100, 50)
    };
    let (outcome, _) = evolve(&problem, &easy, 1);
    assert_eq!(outcome.stop, StopReason::TargetQuality);
    assert!(outcome.best.unwrap().1 >= 1e-3);
    let mut budget = Budget::new(None);
    let enough = AtomicBool::new(false);
    let ask = || {
        enough
            .load(Ordering::Relaxed)
            .then_some(Interrupted::Cancelled)
    };
    let search = Search {
        problem: &problem,
        settings: &settings(100, 50),
        seed: 1,
        budget: &mut budget,
        interrupt: Interrupt::new(&ask),
        observe: &mut |progress| {
            enough.store(progress.evaluations >= 500, Ordering::Relaxed);
        },
    };
    let outcome = search.run(Method::ModifiedGa, None);
    assert_eq!(outcome.stop, StopReason::Cancelled);
    assert!(outcome.best.is_some() && budget.spent() < 1000);
}

/// Faces that share normals, edges of cones on circles, opposite contacts: the most degenerate
/// wrench sets there are must still have an exact margin.
#[test]
fn every_grasp_of_a_block_has_an_exact_margin() {
    for (model, contacts) in [
        (FRICTIONLESS, 7),
        (hard(0.2, 8), 4),
        (hard(1.0, 4), 6),
        (hard(0.5, 16), 9),
    ] {
        let problem = problem(block(4), model, contacts);
        let mut evaluator = Evaluator::new();
        for index in 0..300 {
            let mut stream = Stream::new(1, Purpose::Population, index);
            let grasp = stream.subset(problem.len(), contacts);
            let wrenches = problem.wrenches(&grasp);
            let (Ok(quality), Ok(margin)) =
                (evaluator.quality(&wrenches), evaluator.margin(&wrenches))
            else {
                continue;
            };
            assert_eq!(quality.is_force_closure(), margin.is_force_closure());
            if margin.is_force_closure() {
                assert!(quality.exact && margin.exact);
                assert_eq!(quality.value, margin.value);
            }
            let support = wrenches
                .iter()
                .map(|w| w.dot(&margin.direction))
                .fold(f64::MIN, f64::max);
            assert!((support - margin.value).abs() < 1e-12);
        }
    }
}

#[test]
fn round_cones_and_sums_are_searched_as_well() {
    let cases = [
        (WrenchSpace::L1, round(0.3), 4),
        (WrenchSpace::L1, soft(0.4, 0.1), 3),
        (WrenchSpace::Linf, FRICTIONLESS, 8),
        (WrenchSpace::Linf, hard(0.4, 8), 3),
        (WrenchSpace::Linf, round(0.4), 4),
    ];
    for (space, contact_model, contacts) in cases {
        let problem = problem_in(space, block(8), contact_model, contacts);
        let Initial::Found { grasp, quality } = initial(&problem, InitialMode::Weak, 2) else {
            panic!("no grasp for {contact_model:?} in {space:?}");
        };
        let mut evaluator = Evaluator::new();
        let mut fine = |grasp: &[u32]| {
            let contacts = problem.grasp_contacts(grasp);
            let margin = evaluator.grasp_quality(problem.model(), &contacts, ACCURACY);
            margin.unwrap()
        };
        assert!(quality <= fine(&grasp).upper);
        let on = |threads| {
            let pool = rayon::ThreadPoolBuilder::new();
            let pool = pool.num_threads(threads).build().unwrap();
            pool.install(|| evolve(&problem, &settings(40, 8), 3))
        };
        let (outcome, evaluations) = on(1);
        assert_eq!((outcome.clone(), evaluations), on(3));
        let (best, value) = outcome.best.unwrap();
        let margin = fine(&best);
        assert!(value <= margin.upper && value >= (1.0 - 2e-3) * margin.value);
        assert!(Some(value) > outcome.history[0].best);
    }
}

#[test]
fn a_search_with_large_spaces_looks_up_between_few_grasps() {
    let problem = problem_in(WrenchSpace::Linf, block(6), round(0.5), 64);
    let mut last = 0;
    let mut budget = Budget::new(None);
    let search = Search {
        problem: &problem,
        settings: &settings(9, 0),
        seed: 1,
        budget: &mut budget,
        interrupt: Interrupt::never(),
        observe: &mut |progress| {
            assert!(progress.evaluations <= last + 4);
            last = progress.evaluations;
        },
    };
    let outcome = search.run(Method::ModifiedGa, None);
    assert!(outcome.best.is_some() && budget.spent() == 9);
}

#[test]
fn a_body_that_round_cones_cannot_hold_is_proven_so() {
    let mut top = ball(400);
    top.retain(|c| c.normal.z < -0.7);
    for space in [WrenchSpace::L1, WrenchSpace::Linf] {
        for contact_model in [round(0.3), soft(0.3, 0.2)] {
            let problem = problem_in(space, top.clone(), contact_model, 5);
            match initial(&problem, InitialMode::Weak, 1) {
                Initial::Impossible(Impossible::OneSided { direction }) => {
                    assert!(direction[2] > 0.1, "{direction}");
                }
                other => panic!("{other:?}"),
            }
        }
    }
    let pair = problem(block(4), round(0.5), 2);
    let proof = Initial::Impossible(Impossible::TooFewContacts { least: 3 });
    assert_eq!(initial(&pair, InitialMode::Weak, 1), proof);
}
