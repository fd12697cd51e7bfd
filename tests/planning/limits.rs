//! Runs that are stopped, and long ones.

use std::sync::atomic::{AtomicU32, Ordering};

use super::*;
use graspd_core::Interrupted;

#[test]
fn time_and_cancellation_stop_a_run_and_what_was_found_is_kept() {
    let mesh = example("duck.obj");
    let limited = json!({"seed": 1, "generations": 100_000, "time_limit_s": 0.3});
    let result = plan(&mesh, &limited);
    assert_eq!(result.stopped_because, StopReason::TimeLimit);
    assert!(result.force_closure);

    let endless = json!({"seed": 1, "generations": 100_000});
    let reports = AtomicU32::new(0);
    let ask = || (reports.load(Ordering::Relaxed) >= 20).then_some(Interrupted::Cancelled);
    let result = run::plan(&mesh, &request(&endless), Interrupt::new(&ask), &mut |_| {
        reports.fetch_add(1, Ordering::Relaxed);
    });
    let result = result.unwrap();
    assert_eq!(result.stopped_because, StopReason::Cancelled);
    assert!(result.force_closure);
}

#[test]
fn limits_hold_from_the_first_evaluation_on() {
    let mesh = example("duck.obj");
    for limit in [1, 2, 100, 333] {
        let settings = json!({"seed": 1, "friction": 0.2, "evaluation_limit": limit});
        let result = plan(&mesh, &settings);
        assert_eq!(result.evaluations, limit);
        assert_eq!(result.stopped_because, StopReason::EvaluationLimit);
    }
    let easy = plan(
        &mesh,
        &json!({"seed": 1, "target_quality": 1e-5, "polish": false}),
    );
    assert_eq!(easy.stopped_because, StopReason::TargetQuality);
    assert_eq!(easy.quality, easy.initial.map(|grasp| grasp.quality));
    let hard = plan(
        &mesh,
        &json!({"seed": 1, "target_quality": 0.1, "polish": false}),
    );
    let last = hard.history.last().unwrap();
    assert_eq!(hard.stopped_because, StopReason::TargetQuality);
    assert_eq!(
        (last.best, last.evaluations),
        (hard.quality, hard.evaluations)
    );
}

#[test]
fn a_long_history_is_thinned() {
    let settings = json!({"contact_model": "frictionless", "method": "random",
        "population": 2, "generations": 5000});
    let result = plan(&example("box.stl"), &settings);
    let history = &result.history;
    assert_eq!(history.len(), 1000);
    assert_eq!((history[0].generation, history[999].generation), (0, 5000));
    assert!(
        history
            .windows(2)
            .all(|w| w[0].generation < w[1].generation)
    );
}
