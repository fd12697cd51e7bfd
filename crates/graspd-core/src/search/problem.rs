//! The problem that is searched: m of n candidates, together with fixed contacts, under one contact model.

use nalgebra::Point3;

use crate::constraints::Spacing;
use crate::contact::Contact;
use crate::mesh::Candidate;
use crate::quality::Margin;
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

/// Wrenches computed between two calls of an observer, in passes over all candidates: some 10 ms
/// on one thread.
const BLOCK: usize = 1 << 18;

/// Grasps to choose from: candidates, the number of contacts to plan, and what holds for all of them.
#[derive(Debug, Clone)]
pub struct SearchProblem {
    candidates: Vec<Candidate>,
    model: WrenchModel,
    contacts: usize,
    closure_floor: f64,
    fixed: Vec<Contact>,
    spacing: Spacing,
}

impl SearchProblem {
    /// The problem of grasps of `contacts` fingers on `candidates`. `None` unless there are at least as many
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

    /// Adds contacts that are part of every grasp, and distances to keep: between any two planned
    /// contacts, and from each to every fixed one. The fixed ones are taken as they are.
    pub fn with_fixed(self, fixed: Vec<Contact>, spacing: Spacing) -> Self {
        Self {
            fixed,
            spacing,
            ..self
        }
    }

    /// Sets the [`closure_floor()`], where the candidates are only a part of the body.
    pub fn with_closure_floor(self, closure_floor: f64) -> Self {
        Self {
            closure_floor,
            ..self
        }
    }

    /// Returns the margin above which a grasp is called force closure.
    pub fn closure_floor(&self) -> f64 {
        self.closure_floor
    }

    /// Whether a grasp with this margin is force closure, beyond the rounding of the mesh.
    pub fn passes_closure_floor(&self, margin: &Margin) -> bool {
        margin.value > self.closure_floor
    }

    /// Returns the number of candidates n.
    pub fn len(&self) -> usize {
        self.candidates.len()
    }

    /// Whether there are no candidates. Never: a problem has at least one.
    pub fn is_empty(&self) -> bool {
        self.candidates.is_empty()
    }

    /// Returns the number of contacts m to plan: the length of a [`Grasp`], the fixed ones not counted.
    pub fn contacts(&self) -> usize {
        self.contacts
    }

    /// Returns the contacts that are part of every grasp.
    pub fn fixed(&self) -> &[Contact] {
        &self.fixed
    }

    /// Whether there is any distance to keep.
    pub fn has_spacing(&self) -> bool {
        self.spacing.is_bounded()
    }

    /// Whether every two contacts of a grasp keep their distance, fixed ones included. O(m²).
    pub fn keeps_spacing(&self, grasp: &[u32]) -> bool {
        !self.has_spacing()
            || (0..grasp.len()).all(|slot| self.keeps_spacing_with(&grasp[..slot], grasp[slot]))
    }

    /// Whether a candidate keeps its distance from some others and from the fixed contacts. O(m).
    pub fn keeps_spacing_with(&self, others: &[u32], candidate: u32) -> bool {
        if !self.has_spacing() {
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

    /// Candidates of one block of a pass over all of them, between two calls of an observer.
    pub(super) fn block_size(&self) -> usize {
        BLOCK / self.wrenches_per_contact()
    }

    /// Returns the cost of an evaluation, in wrenches of a finite hull.
    pub fn evaluation_cost(&self) -> usize {
        self.model.effort(self.fixed.len() + self.contacts)
    }

    /// Returns the number of primitive wrenches of a grasp, those of the fixed contacts included.
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

    /// Returns the fixed contacts and those of some candidates, in their order.
    pub fn grasp_contacts(&self, grasp: &[u32]) -> Vec<Contact> {
        self.contacts_of(grasp).collect()
    }

    /// Returns the primitive wrenches of the fixed contacts and of some candidates, in their order.
    pub fn wrenches(&self, grasp: &[u32]) -> Vec<Wrench> {
        let mut wrenches = Vec::new();
        for contact in self.contacts_of(grasp) {
            self.model.push_wrenches(&contact, &mut wrenches);
        }
        wrenches
    }

    pub(super) fn contacts_of(&self, grasp: &[u32]) -> impl Iterator<Item = Contact> {
        let planned = grasp.iter().map(|&i| Contact::from(self.candidate(i)));
        self.fixed.iter().copied().chain(planned)
    }
}
