//! Evaluation of grasps as far as a search needs it.

use super::problem::SearchProblem;
use crate::contact::Contact;
use crate::quality::{Degenerate, Evaluator, Margin};

/// Facets after which the search stops with a wrench set and takes the bound it has; some 30 ms.
/// Sets of 2,048 wrenches usually need a tenth.
pub(super) const SEARCH_FACET_LIMIT: usize = 1 << 14;

/// Relative width of the intervals on ε that a search compares. Less than what one generation gains, and
/// a fifth of the time of [`ACCURACY`](crate::quality::ACCURACY), which the result has.
pub(super) const SEARCH_ACCURACY: f64 = 1e-3;

/// Evaluates grasps of one problem; the working memory of one thread.
pub(super) struct GraspEvaluator<'a> {
    problem: &'a SearchProblem,
    evaluator: Evaluator,
    contacts: Vec<Contact>,
}

impl<'a> GraspEvaluator<'a> {
    pub(super) fn new(problem: &'a SearchProblem) -> Self {
        Self {
            problem,
            evaluator: Evaluator::with_facet_limit(SEARCH_FACET_LIMIT),
            contacts: Vec::new(),
        }
    }

    /// See [`Evaluator::grasp_quality`].
    pub(super) fn quality(&mut self, grasp: &[u32]) -> Result<Margin, Degenerate> {
        self.quality_above(grasp, f64::NEG_INFINITY)
    }

    /// See [`Evaluator::grasp_quality_above`].
    pub(super) fn quality_above(
        &mut self,
        grasp: &[u32],
        threshold: f64,
    ) -> Result<Margin, Degenerate> {
        self.contacts.clear();
        self.contacts.extend(self.problem.contacts_of(grasp));
        let model = self.problem.model();
        self.evaluator
            .grasp_quality_above(model, &self.contacts, SEARCH_ACCURACY, threshold)
    }

    /// Returns ε when the grasp is force closure. It is a lower bound: by [`SEARCH_ACCURACY`] where cones are round
    /// or the space is L∞, by more when the hull grows too large. `None` also when the contacts do not
    /// [keep the spacing](SearchProblem::keeps_spacing).
    pub(super) fn epsilon(&mut self, grasp: &[u32]) -> Option<f64> {
        if !self.problem.keeps_spacing(grasp) {
            return None;
        }
        let margin = self.quality(grasp).ok()?;
        self.problem
            .passes_closure_floor(&margin)
            .then_some(margin.value)
    }
}

/// Rounds a quality to 30 bits, one part in 10⁹. Grasps that share their weakest facet have the same ε up
/// to rounding errors. Compared in this way, a body gives the same search when it is moved or turned.
pub(super) fn rounded(quality: f64) -> f64 {
    const DROPPED: u32 = f64::MANTISSA_DIGITS - 30;
    let half = 1_u64 << (DROPPED - 1);
    f64::from_bits((quality.to_bits() + half) >> DROPPED << DROPPED)
}
