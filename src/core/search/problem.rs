//! What is searched: m of n candidates, under one contact model.

use crate::core::contact::Contact;
use crate::core::mesh::Candidate;
use crate::core::quality::{Degenerate, Evaluator, Margin};
use crate::core::wrench::{Wrench, WrenchModel};

/// Distinct candidate indices, ascending.
pub type Grasp = Vec<u32>;

/// A grasp-planning problem.
#[derive(Debug, Clone)]
pub struct Problem {
    candidates: Vec<Candidate>,
    model: WrenchModel,
    contacts: usize,
}

impl Problem {
    /// Grasps of `contacts` fingers on `candidates`. `None` unless there are at least as many
    /// candidates as contacts and at least one contact.
    pub fn new(candidates: Vec<Candidate>, model: WrenchModel, contacts: usize) -> Option<Self> {
        (contacts > 0 && contacts <= candidates.len()).then_some(Self {
            candidates,
            model,
            contacts,
        })
    }

    /// Number of candidates n.
    pub fn len(&self) -> usize {
        self.candidates.len()
    }

    /// Never: a problem has at least one candidate.
    pub fn is_empty(&self) -> bool {
        self.candidates.is_empty()
    }

    /// Number of contacts m of a grasp.
    pub fn contacts(&self) -> usize {
        self.contacts
    }

    pub fn candidate(&self, index: u32) -> &Candidate {
        &self.candidates[index as usize]
    }

    pub fn model(&self) -> &WrenchModel {
        &self.model
    }

    /// Number of primitive wrenches of a grasp.
    pub fn wrenches_per_grasp(&self) -> usize {
        self.contacts * self.model.contact_model.wrenches_per_contact()
    }

    /// Appends the primitive wrenches of one candidate.
    pub fn push_wrenches(&self, index: u32, out: &mut Vec<Wrench>) {
        let candidate = self.candidate(index);
        let contact = Contact {
            position: candidate.position,
            normal: candidate.normal,
        };
        self.model.push_wrenches(&contact, out);
    }

    /// The primitive wrenches of some candidates, in their order.
    pub fn wrenches(&self, grasp: &[u32]) -> Vec<Wrench> {
        let mut wrenches = Vec::new();
        for &index in grasp {
            self.push_wrenches(index, &mut wrenches);
        }
        wrenches
    }
}

/// Evaluates grasps of one problem; the working memory of one thread.
pub(super) struct GraspEvaluator<'a> {
    problem: &'a Problem,
    evaluator: Evaluator,
    wrenches: Vec<Wrench>,
}

impl<'a> GraspEvaluator<'a> {
    pub(super) fn new(problem: &'a Problem) -> Self {
        Self {
            problem,
            evaluator: Evaluator::new(),
            wrenches: Vec::new(),
        }
    }

    /// See [`Evaluator::quality`].
    pub(super) fn quality(&mut self, grasp: &[u32]) -> Result<Margin, Degenerate> {
        self.wrenches.clear();
        for &index in grasp {
            self.problem.push_wrenches(index, &mut self.wrenches);
        }
        self.evaluator.quality(&self.wrenches)
    }

    /// ε when the grasp is force closure.
    pub(super) fn epsilon(&mut self, grasp: &[u32]) -> Option<f64> {
        let margin = self.quality(grasp).ok()?;
        margin.is_force_closure().then_some(margin.value)
    }
}
