//! What is searched: m of n candidates, beside fixed contacts, under one contact model.

use nalgebra::Point3;

use crate::constraints::Spacing;
use crate::contact::Contact;
use crate::mesh::Candidate;
use crate::quality::{Degenerate, Evaluator, Margin};
use crate::wrench::{STAND_IN_EDGES, Wrench, WrenchModel};

/// Distinct candidate indices, ascending.
pub type Grasp = Vec<u32>;

/// A grasp whose margin is below this, with torques scaled to the size of the body, is not called
/// force closure. Coordinates stored in single precision are rounded by 6·10⁻⁸ of the body's size,
/// and the normals of triangles a hundredth of that size by a hundred times more: a body of
/// revolution then looks as if it could be held by margins up to about 10⁻⁶.
pub const CLOSURE_FLOOR: f64 = 1e-6;

/// [`CLOSURE_FLOOR`] for contacts of a model at places from which those on one body reach no farther.
pub fn closure_floor(model: &WrenchModel, places: impl Iterator<Item = Point3<f64>>) -> f64 {
    let reach = places
        .map(|p| (p - model.center).norm())
        .fold(0.0, f64::max);
    // Torques scaled down by more than that shrink every margin with them.
    CLOSURE_FLOOR * (reach * model.torque_scale).min(1.0)
}

/// Facets after which the search gives a wrench set up and takes the bound it has; some 30 ms.
/// Sets of 2,048 wrenches usually need a tenth.
pub(super) const SEARCH_FACET_LIMIT: usize = 1 << 14;

/// Relative width of the intervals on ε that a search compares. Less than what one generation gains, and
/// a fifth of the time of [`ACCURACY`](crate::quality::ACCURACY), with which the outcome is told.
pub(super) const SEARCH_ACCURACY: f64 = 1e-3;

/// Wrenches looked at between two calls of an observer, in passes over all candidates: some 10 ms
/// on one thread.
const BLOCK: usize = 1 << 18;

/// A grasp-planning problem.
#[derive(Debug, Clone)]
pub struct Problem {
    candidates: Vec<Candidate>,
    model: WrenchModel,
    contacts: usize,
    closure_floor: f64,
    fixed: Vec<Contact>,
    spacing: Spacing,
}

impl Problem {
    /// Grasps of `contacts` fingers on `candidates`. `None` unless there are at least as many
    /// candidates as contacts and at least one contact.
    pub fn new(candidates: Vec<Candidate>, model: WrenchModel, contacts: usize) -> Option<Self> {
        if contacts == 0 || contacts > candidates.len() {
            return None;
        }
        let closure_floor = closure_floor(&model, candidates.iter().map(|c| c.position));
        Some(Self {
            candidates,
            model,
            contacts,
            closure_floor,
            fixed: Vec::new(),
            spacing: Spacing::default(),
        })
    }

    /// The same, with `fixed` contacts in every grasp and distances to keep: between any two planned
    /// contacts, and from each to every fixed one. The fixed ones are taken as they are.
    pub fn beside(self, fixed: Vec<Contact>, spacing: Spacing) -> Self {
        Self {
            fixed,
            spacing,
            ..self
        }
    }

    /// The same with this [`closure_floor()`], where the candidates are only a part of the body.
    pub fn with_closure_floor(self, closure_floor: f64) -> Self {
        Self {
            closure_floor,
            ..self
        }
    }

    /// Margin above which a grasp is called force closure.
    pub fn closure_floor(&self) -> f64 {
        self.closure_floor
    }

    /// Whether a grasp with this margin is force closure, beyond the rounding of the mesh.
    pub fn closes(&self, margin: &Margin) -> bool {
        margin.value > self.closure_floor
    }

    /// Number of candidates n.
    pub fn len(&self) -> usize {
        self.candidates.len()
    }

    /// Never: a problem has at least one candidate.
    pub fn is_empty(&self) -> bool {
        self.candidates.is_empty()
    }

    /// Number of contacts m to plan: the length of a [`Grasp`], the fixed ones not counted.
    pub fn contacts(&self) -> usize {
        self.contacts
    }

    /// The contacts that are part of every grasp besides.
    pub fn fixed(&self) -> &[Contact] {
        &self.fixed
    }

    /// Whether there is any distance to keep.
    pub fn is_spaced(&self) -> bool {
        self.spacing.is_bounded()
    }

    /// Whether every two contacts of a grasp keep their distance, fixed ones included. O(m²).
    pub fn fits(&self, grasp: &[u32]) -> bool {
        !self.is_spaced()
            || (0..grasp.len()).all(|slot| self.fits_beside(&grasp[..slot], grasp[slot]))
    }

    /// Whether a candidate keeps its distance from some others and from the fixed contacts. O(m).
    pub fn fits_beside(&self, others: &[u32], candidate: u32) -> bool {
        if !self.is_spaced() {
            return true;
        }
        let position = |index: u32| &self.candidate(index).position;
        let fixed = self.fixed.iter().map(|contact| &contact.position);
        fixed
            .chain(others.iter().map(|&other| position(other)))
            .all(|other| self.spacing.allows(position(candidate), other))
    }

    pub fn candidate(&self, index: u32) -> &Candidate {
        &self.candidates[index as usize]
    }

    pub fn model(&self) -> &WrenchModel {
        &self.model
    }

    /// Candidates to look at between two calls of an observer.
    pub(super) fn block(&self) -> usize {
        BLOCK / self.wrenches_per_contact()
    }

    /// What an evaluation costs, in wrenches of a finite hull.
    pub fn effort(&self) -> usize {
        self.model.effort(self.fixed.len() + self.contacts)
    }

    /// Number of primitive wrenches of a grasp, those of the fixed contacts included.
    pub fn wrenches_per_grasp(&self) -> usize {
        (self.fixed.len() + self.contacts) * self.wrenches_per_contact()
    }

    fn wrenches_per_contact(&self) -> usize {
        let finite = self.model.contact_model.wrenches_per_contact();
        finite.unwrap_or(STAND_IN_EDGES)
    }

    pub fn candidates(&self) -> &[Candidate] {
        &self.candidates
    }

    /// Appends the primitive wrenches of one candidate.
    pub fn push_wrenches(&self, index: u32, out: &mut Vec<Wrench>) {
        self.model.push_wrenches(&self.candidate(index).into(), out);
    }

    /// The fixed contacts and those of some candidates, in their order.
    pub fn grasp_contacts(&self, grasp: &[u32]) -> Vec<Contact> {
        self.contacts_of(grasp).collect()
    }

    /// The primitive wrenches of the fixed contacts and of some candidates, in their order.
    pub fn wrenches(&self, grasp: &[u32]) -> Vec<Wrench> {
        let mut wrenches = Vec::new();
        for contact in self.contacts_of(grasp) {
            self.model.push_wrenches(&contact, &mut wrenches);
        }
        wrenches
    }

    fn contacts_of(&self, grasp: &[u32]) -> impl Iterator<Item = Contact> {
        let planned = grasp.iter().map(|&i| Contact::from(self.candidate(i)));
        self.fixed.iter().copied().chain(planned)
    }
}

/// Evaluates grasps of one problem; the working memory of one thread.
pub(super) struct GraspEvaluator<'a> {
    problem: &'a Problem,
    evaluator: Evaluator,
    contacts: Vec<Contact>,
}

impl<'a> GraspEvaluator<'a> {
    pub(super) fn new(problem: &'a Problem) -> Self {
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

    /// ε when the grasp is force closure, or a lower bound: by [`SEARCH_ACCURACY`] where cones are round or
    /// the space is L∞, by more when the hull grows too large. `None` also when the contacts do not
    /// [fit](Problem::fits).
    pub(super) fn epsilon(&mut self, grasp: &[u32]) -> Option<f64> {
        if !self.problem.fits(grasp) {
            return None;
        }
        let margin = self.quality(grasp).ok()?;
        self.problem.closes(&margin).then_some(margin.value)
    }
}

/// A quality to 30 bits, one part in 10⁹. Grasps that share their weakest facet have the same ε up
/// to rounding; comparing so, the same body gives the same search when it is moved or turned.
pub(super) fn rounded(quality: f64) -> f64 {
    const DROPPED: u32 = f64::MANTISSA_DIGITS - 30;
    let half = 1_u64 << (DROPPED - 1);
    f64::from_bits((quality.to_bits() + half) >> DROPPED << DROPPED)
}
