//! What is told at the end of a run of the grasps that it found.

use super::{Plan, PlannedGrasp, evaluated, progress};
use crate::analysis::Analyst;
use crate::contact::{Contact, Site};
use crate::evaluation::{FACET_LIMIT, evaluate_with};
use crate::interrupt::Interrupt;
use crate::quality::Evaluator;
use crate::search::{Grasp, Observer, Phase, Problem, Stop};
use crate::top::differs;

/// Effort of an evaluation, in wrenches, up to which a cancelled run still tells everything of its best grasp:
/// some milliseconds.
const AFTER_CANCELLATION: usize = 256;

/// Tells up to `count` grasps, the best first, each at least `least` from the others: the best of the plan and
/// those of `others`, which come the best first, that differ. Only as many as are told are evaluated.
pub(super) fn choose(
    plan: &mut Plan,
    problem: &Problem,
    others: &[(Grasp, f64)],
    count: usize,
    least: f64,
    interrupt: Interrupt<'_>,
) {
    let Some(best) = plan.best.as_ref().filter(|best| best.force_closure) else {
        return;
    };
    plan.top = vec![best.clone()];
    for (grasp, _) in others {
        if plan.top.len() >= count {
            break;
        }
        let contacts: Vec<_> = grasp.iter().map(|&i| *problem.candidate(i)).collect();
        let known = plan.top.iter().map(|grasp| grasp.contacts.as_slice());
        if !differs(&contacts, known, least) {
            continue;
        }
        if let Err(why) = interrupt.ignoring_time_limit().check() {
            plan.stop = why.into();
            break;
        }
        let grasp = evaluated(problem, grasp);
        if grasp.force_closure {
            plan.top.push(grasp);
        }
    }
    let quality = |grasp: &PlannedGrasp| grasp.margin.map_or(0.0, |margin| margin.value);
    // They came by what the search knew of their quality.
    plan.top[1..].sort_by(|a, b| quality(b).total_cmp(&quality(a)));
}

/// Evaluates the best grasp in all respects.
pub(super) fn evaluate(
    plan: &mut Plan,
    problem: &Problem,
    interrupt: Interrupt<'_>,
    observe: Observer<'_>,
) {
    let Some(best) = &plan.best else {
        return;
    };
    let interrupt = if plan.stop == Stop::Cancelled {
        if problem.effort() > AFTER_CANCELLATION {
            return;
        }
        Interrupt::never()
    } else {
        observe(&progress(plan, Phase::Search));
        interrupt.ignoring_time_limit()
    };
    let planned = best.contacts.iter().map(Contact::from);
    let contacts: Vec<Contact> = problem.fixed().iter().copied().chain(planned).collect();
    let evaluation = evaluate_with(
        &mut Evaluator::with_facet_limit(FACET_LIMIT),
        problem.model(),
        &contacts,
        problem.closure_floor(),
        &[],
        interrupt,
    );
    match evaluation {
        Ok(evaluation) => plan.evaluation = Some(evaluation),
        Err(why) => plan.stop = why.into(),
    }
}

/// Looks closer at the best grasp; when that is interrupted, it is why the run ended.
pub(super) fn analyse(
    plan: &mut Plan,
    fixed: &[Contact],
    analyst: &Analyst,
    interrupt: Interrupt<'_>,
    observe: Observer<'_>,
) {
    let Some(best) = &plan.best else {
        return;
    };
    let closed = best.margin.as_ref().ok().filter(|_| best.force_closure);
    if analyst.has_work(closed.is_some()) {
        observe(&progress(plan, Phase::Analysis));
    }
    let fixed = fixed.iter().map(|&contact| Site {
        contact,
        triangle: None,
    });
    let sites: Vec<Site> = fixed.chain(best.contacts.iter().map(Site::from)).collect();
    match analyst.analyse(&sites, closed, interrupt) {
        Ok(analysis) => plan.analysis = Some(analysis),
        Err(why) => plan.stop = why.into(),
    }
}
