//! A planning run in progress: what its stages share.

use super::outcome::{Infeasible, Plan};
use super::settings::Settings;
use crate::interrupt::Interrupt;
use crate::mesh::Mesh;
use crate::search::{Budget, Observer, Phase, SearchProgress, StopReason};
use crate::wrench::WrenchModel;

/// The input of a run, and what it has found and spent so far.
pub(super) struct Run<'a> {
    pub mesh: &'a Mesh,
    pub settings: &'a Settings,
    pub budget: Budget,
    pub interrupt: Interrupt<'a>,
    pub observe: Observer<'a>,
    pub plan: Plan,
}

impl<'a> Run<'a> {
    pub fn new(
        mesh: &'a Mesh,
        settings: &'a Settings,
        model: WrenchModel,
        interrupt: Interrupt<'a>,
        observe: Observer<'a>,
    ) -> Self {
        Self {
            mesh,
            settings,
            budget: Budget::new(settings.evaluation_limit),
            interrupt,
            observe,
            plan: Plan::empty(model),
        }
    }

    /// Reports where the run stands outside its search.
    pub fn report(&mut self, phase: Phase) {
        (self.observe)(&SearchProgress {
            phase,
            generation: self.plan.history.len().saturating_sub(1),
            evaluations: self.budget.spent(),
            best: self.plan.best.as_ref().and_then(|best| best.quality()),
            grasp: None,
            generation_ended: false,
        });
    }

    /// Notes that the constraints leave nothing to try.
    pub fn set_infeasible(&mut self, why: Infeasible) {
        self.plan.stop = StopReason::Infeasible;
        self.plan.infeasible = Some(why);
    }

    /// Returns what was found.
    pub fn finish(self) -> Plan {
        Plan {
            evaluations: self.budget.spent(),
            ..self.plan
        }
    }
}
