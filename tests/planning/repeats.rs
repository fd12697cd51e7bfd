//! Runs that are repeated, and several grasps of one.

use super::*;

#[test]
fn trials_are_the_runs_of_the_seeds_that_follow() {
    let mesh = example("box.stl");
    let common =
        json!({"friction": 0.3, "generations": 2, "method": "modified_ga", "population": 30});
    let with = |more: Value| {
        let mut settings = common.clone();
        for (name, value) in more.as_object().unwrap() {
            settings[name] = value.clone();
        }
        plan(&mesh, &settings)
    };
    let all = with(json!({"seed": 11, "trials": 5}));
    let singles: Vec<PlanResult> = (11..16).map(|seed| with(json!({ "seed": seed }))).collect();
    let trials = all.trials.as_ref().unwrap();
    assert_eq!(
        (trials.count, trials.runs.len(), trials.force_closures),
        (5, 5, 5)
    );
    for (run, single) in trials.runs.iter().zip(&singles) {
        assert_eq!((run.seed, run.last), (single.seed, single.quality));
        assert_eq!(
            run.initial,
            single.initial.as_ref().map(|grasp| grasp.quality)
        );
        assert_eq!(run.evaluations, single.evaluations);
    }
    let qualities: Vec<f64> = singles.iter().filter_map(|single| single.quality).collect();
    let mean = qualities.iter().sum::<f64>() / 5.0;
    let last = trials.last.unwrap();
    assert!((last.mean - mean).abs() < 1e-15 && last.max == all.quality.unwrap());
    let best = singles
        .iter()
        .find(|single| single.quality == all.quality)
        .unwrap();
    assert_eq!((all.seed, &all.contacts), (best.seed, &best.contacts));
    assert_eq!(
        all.evaluations,
        singles.iter().map(|single| single.evaluations).sum::<u64>()
    );
    assert!(singles[0].trials.is_none() && all.reproducible);
}

#[test]
fn the_progress_of_trials_is_that_of_all_together() {
    let mesh = example("box.stl");
    let settings = json!({
        "friction": 0.3, "generations": 3, "method": "modified_ga", "population": 10, "trials": 4, "polish": false,
        "seed": 2,
    });
    let mut reports = Vec::new();
    let result = run::plan(
        &mesh,
        &request(&settings),
        Interrupt::never(),
        &mut |progress| {
            reports.push(progress.clone());
        },
    );
    let result = result.unwrap();
    let spread = result.trials.as_ref().unwrap().last.unwrap();
    assert!(spread.min < spread.max);
    for pair in reports.windows(2) {
        let [before, after] = pair else {
            unreachable!()
        };
        assert!(before.generation <= after.generation && before.evaluations <= after.evaluations);
        // Nothing is less than any quality.
        assert!(before.best_quality <= after.best_quality);
    }
    let last = reports.last().unwrap();
    assert_eq!((last.generation, last.generations), (12, 12));
    assert_eq!(last.evaluations, result.evaluations);
    assert_eq!(last.best_quality, result.quality);
    let best = last.best_contacts.as_ref().unwrap();
    for contact in &result.contacts {
        let same = |other: &&Contact| other.position == contact.position.into();
        assert_eq!(best.iter().filter(same).count(), 1);
    }
}

#[test]
fn the_top_grasps_differ_and_are_sorted() {
    let mesh = example("duck.obj");
    for method in ["memetic", "modified_ga"] {
        let result = plan(
            &mesh,
            &json!({"seed": 5, "top": 4, "method": method, "generations": 6}),
        );
        let top = result.top.as_ref().unwrap();
        assert!(top.len() > 1 && top.len() <= 4, "{method} {}", top.len());
        assert_eq!(Some(top[0].quality), result.quality);
        assert_eq!(top[0].distance_to_best, 0.0);
        assert!(
            top.windows(2)
                .all(|pair| pair[0].quality >= pair[1].quality)
        );
        let least = 0.05 * mesh.report().bounding_radius;
        let far = |from: &[ContactPoint], to: &[ContactPoint]| {
            let apart = |a: &ContactPoint, b: &ContactPoint| {
                Point3::from(a.position) - Point3::from(b.position)
            };
            let nearest = |a: &ContactPoint| {
                to.iter()
                    .map(|b| apart(a, b).norm())
                    .fold(f64::INFINITY, f64::min)
            };
            from.iter().map(nearest).fold(0.0, f64::max)
        };
        for (i, a) in top.iter().enumerate() {
            for b in &top[..i] {
                assert!(far(&a.contacts, &b.contacts).max(far(&b.contacts, &a.contacts)) >= least);
            }
        }
    }
}
