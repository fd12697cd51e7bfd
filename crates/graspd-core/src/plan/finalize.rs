//! The last stages of a planning run: other grasps that differ, the full evaluation and the analyses of the best.

use super::outcome::PlannedGrasp;
use super::run::Run;
use crate::analysis::Analyst;
use crate::contact::{Contact, Site};
use crate::diverse::{DISTINCT, differs};
use crate::evaluation::{FACET_LIMIT, evaluate_with};
use crate::interrupt::Interrupt;
use crate::quality::Evaluator;
use crate::search::{Grasp, Phase, SearchProblem, StopReason};

/// Cost of an evaluation, in wrenches, up to which the best grasp of a cancelled run is still evaluated in full:
/// some milliseconds.
const AFTER_CANCELLATION: usize = 256;

/// Chooses the grasps to return, the best first: the best of the plan, and those of `others` that differ from it and
/// each other. `others` come the best first. Only those that are returned are evaluated.
pub(super) fn choose_diverse(run: &mut Run<'_>, problem: &SearchProblem, others: &[(Grasp, f64)]) {
    let count = run.settings.top;
    let least = DISTINCT * run.mesh.report().bounding_radius;
    let Some(best) = run.plan.best.as_ref().filter(|best| best.force_closure) else {
        return;
    };
    let fixed: Vec<_> = problem.fixed().iter().map(|c| c.position).collect();
    let mut top = vec![best.clone()];
    for (grasp, _) in others {
        if top.len() >= count {
            break;
        }
        let contacts: Vec<_> = grasp.iter().map(|&i| *problem.candidate(i)).collect();
        let chosen = top.iter().map(|grasp| grasp.contacts.as_slice());
        if !differs(&contacts, chosen, &fixed, least) {
            continue;
        }
        if let Err(why) = run.interrupt.ignoring_time_limit().check() {
            run.plan.stop = why.into();
            break;
        }
        let grasp = PlannedGrasp::new(problem, grasp);
        if grasp.force_closure {
            top.push(grasp);
        }
    }
    let quality = |grasp: &PlannedGrasp| grasp.margin.map_or(0.0, |margin| margin.value);
    // The search had ordered them by bounds on their quality.
    top[1..].sort_by(|a, b| quality(b).total_cmp(&quality(a)));
    run.plan.top = top;
}

/// Evaluates the best grasp in all respects.
pub(super) fn evaluate(run: &mut Run<'_>, problem: &SearchProblem) {
    let Some(best) = &run.plan.best else {
        return;
    };
    let planned = best.contacts.iter().map(Contact::from);
    let contacts: Vec<Contact> = problem.fixed().iter().copied().chain(planned).collect();
    let interrupt = if run.plan.stop == StopReason::Cancelled {
        if problem.evaluation_cost() > AFTER_CANCELLATION {
            return;
        }
        Interrupt::never()
    } else {
        run.report(Phase::Search);
        run.interrupt.ignoring_time_limit()
    };
    let evaluation = evaluate_with(
        &mut Evaluator::with_facet_limit(FACET_LIMIT),
        problem.model(),
        &contacts,
        problem.closure_floor(),
        &[],
        interrupt,
    );
    match evaluation {
        Ok(evaluation) => run.plan.evaluation = Some(evaluation),
        Err(why) => run.plan.stop = why.into(),
    }
}

/// Analyses the best grasp; when that is interrupted, it is why the run ended.
pub(super) fn analyse(run: &mut Run<'_>, analyst: &Analyst) {
    let Some(best) = &run.plan.best else {
        return;
    };
    let margin = best.margin.ok().filter(|_| best.force_closure);
    let fixed = run.settings.constraints.fixed.iter();
    let fixed = fixed.map(|&contact| Site {
        contact,
        triangle: None,
    });
    let sites: Vec<Site> = fixed.chain(best.contacts.iter().map(Site::from)).collect();
    if analyst.has_work(margin.is_some()) {
        run.report(Phase::Analysis);
    }
    match analyst.analyse(&sites, margin.as_ref(), run.interrupt) {
        Ok(analysis) => run.plan.analysis = Some(analysis),
        Err(why) => run.plan.stop = why.into(),
    }
}
