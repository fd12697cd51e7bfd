//! Runs that are cancelled, and such as cannot find anything.

use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};

use super::*;
use crate::interrupt::Interrupted;
use crate::robustness::Scatter;
use crate::search::SearchProgress;

#[test]
fn the_interrupt_is_checked_every_few_evaluations_of_many_wrenches() {
    let mesh = &bodies()[1];
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build();
    let pool = pool.unwrap();
    for method in 0..4 {
        for space in [WrenchSpace::L1, WrenchSpace::Linf] {
            let mut settings = settings(40, Constraints::default(), method);
            settings.wrench.space = space;
            settings.wrench.contact = ContactSettings::Known(ContactModel::Soft {
                friction: Friction::new(0.5).unwrap(),
                torsion: Torsion::new(0.1).unwrap(),
                cone: Cone::Pyramid(ConeEdges::new(32).unwrap()),
            });
            settings.top = 1;
            let scatter = Scatter {
                sigma: 0.01,
                samples: 12,
                seed: 0,
            };
            settings.analysis.robustness = Some(scatter);
            let analysing = AtomicBool::new(false);
            let checks = [const { AtomicU64::new(0) }; 2];
            let ask = || {
                let phase = usize::from(analysing.load(Ordering::Relaxed));
                checks[phase].fetch_add(1, Ordering::Relaxed);
                None
            };
            let mut observe = |progress: &SearchProgress| {
                analysing.store(progress.phase == Phase::Analysis, Ordering::Relaxed);
            };
            let plan = pool.install(|| plan(mesh, &settings, Interrupt::new(&ask), &mut observe));
            let evaluations = plan.unwrap().evaluations;
            let checks = checks.map(AtomicU64::into_inner);
            // Two climbers, or individuals, or samples, at a time, each of three evaluations at most.
            assert!(6 * checks[0] >= evaluations, "{checks:?} {evaluations}");
            assert!(checks[1] >= 6, "{checks:?}");
        }
    }
}

#[test]
fn a_cancelled_run_keeps_its_grasp_and_evaluates_it_where_that_is_soon_done() {
    let mesh = &bodies()[1];
    for (contacts, told) in [(4, true), (60, false)] {
        let settings = settings(contacts, Constraints::default(), 0);
        let found = AtomicBool::new(false);
        let ask = || {
            found
                .load(Ordering::Relaxed)
                .then_some(Interrupted::Cancelled)
        };
        let mut observe = |progress: &SearchProgress| {
            let now = progress.phase == Phase::Search && progress.best.is_some();
            found.store(now, Ordering::Relaxed);
        };
        let plan = plan(mesh, &settings, Interrupt::new(&ask), &mut observe).unwrap();
        assert_eq!(plan.stop, StopReason::Cancelled);
        assert!(plan.best.is_some_and(|best| best.force_closure));
        assert_eq!(plan.evaluation.is_some(), told);
    }
}

#[test]
fn contacts_farther_apart_than_the_body_is_wide_are_proven_not_to_be_there() {
    for mesh in &bodies() {
        let places: Vec<Point3<f64>> = mesh.candidates().iter().map(|c| c.position).collect();
        let pairs = places
            .iter()
            .flat_map(|p| places.iter().map(move |q| (p - q).norm()));
        let widest = pairs.fold(0.0, f64::max);
        for seed in 0..4 {
            for (share, proven) in [(1.0 + 1e-9, true), (1.0, false)] {
                let spacing = Spacing {
                    min: Some(widest * share),
                    max: None,
                };
                let apart = Constraints {
                    spacing,
                    ..Constraints::default()
                };
                let plan = planned(mesh, &settings(3, apart, seed));
                let told = plan.infeasible == Some(Infeasible::NoneApart);
                assert_eq!(told, proven, "{:?}", plan.infeasible);
                assert!(!proven || plan.stop == StopReason::Infeasible);
            }
        }
    }
}
