//! The state of a polish: where the contacts are, and what bounds ε around them.

use super::cut::{Cut, GraspSupport};
use crate::contact::Contact;
use crate::interrupt::{Interrupt, Interrupted};
use crate::mesh::{Surface, SurfaceContact};
use crate::quality::{ACCURACY, Evaluator, Margin};
use crate::wrench::{Wrench, WrenchModel};

/// Least gain of a step, over ε. What is less is rounding.
const LEAST_GAIN: f64 = 1e-9;

/// Cuts that are kept, those with the least height.
pub(super) const MAX_CUTS: usize = 16;

/// How far the weakest directions turn when contacts move by a radius of the body, or more.
const TURN: f64 = 4.0;

/// Cuts whose directions agree to this are one.
const SAME_DIRECTION: f64 = 1e-12;

/// Why nothing more is evaluated.
pub(super) enum End {
    EvaluationLimit,
    Interrupted(Interrupted),
}

impl From<Interrupted> for End {
    fn from(why: Interrupted) -> Self {
        Self::Interrupted(why)
    }
}

/// What a trial led to.
pub(super) enum Trial {
    Better,
    /// No better, with the direction in which it is weakest.
    Worse(Wrench),
    /// Not allowed, or without a quality.
    Unfit,
}

/// Contacts that slide, and the cuts that bound ε around them.
pub(super) struct Sliding<'a> {
    pub surface: &'a Surface<'a>,
    pub model: &'a WrenchModel,
    pub fixed: &'a [Contact],
    pub evaluation_limit: u64,
    pub allowed: &'a dyn Fn(&[SurfaceContact]) -> bool,
    pub interrupt: Interrupt<'a>,
    pub evaluator: Evaluator,
    pub evaluations: u64,
    /// Where the sliding contacts are.
    pub places: Vec<SurfaceContact>,
    /// The fixed contacts, then the sliding ones.
    pub contacts: Vec<Contact>,
    pub margin: Margin,
    /// Weak directions at the present contacts, the weakest first.
    pub cuts: Vec<Cut>,
    /// Length of the present steps.
    pub radius: f64,
}

impl Sliding<'_> {
    /// Returns what ε of a trial has to exceed.
    pub fn enough(&self) -> f64 {
        self.margin.value * (1.0 + LEAST_GAIN)
    }

    /// Returns an upper bound on ε of other contacts: the support of their wrench space along the present cuts.
    pub fn bound(&self, trial: &[SurfaceContact]) -> f64 {
        let contacts = all_contacts(self.fixed, trial);
        let support = GraspSupport::new(self.model, &contacts);
        let heights = self.cuts.iter().map(|cut| support.height(&cut.direction));
        heights.fold(f64::INFINITY, f64::min)
    }

    /// Evaluates contacts and takes them when they are better.
    pub fn evaluate(&mut self, trial: Vec<SurfaceContact>) -> Result<Trial, End> {
        if trial == self.places || !(self.allowed)(&trial) {
            return Ok(Trial::Unfit);
        }
        if self.evaluations >= self.evaluation_limit {
            return Err(End::EvaluationLimit);
        }
        self.interrupt.check()?;
        self.evaluations += 1;
        let contacts = all_contacts(self.fixed, &trial);
        let enough = self.enough();
        let found = self
            .evaluator
            .grasp_quality_above(self.model, &contacts, ACCURACY, enough);
        let Ok(margin) = found else {
            return Ok(Trial::Unfit);
        };
        if margin.value <= enough {
            return Ok(Trial::Worse(margin.direction));
        }
        (self.places, self.contacts, self.margin) = (trial, contacts, margin);
        self.track(margin.direction);
        Ok(Trial::Better)
    }

    /// Brings all cuts, and a new one, to the present contacts.
    pub fn track(&mut self, direction: Wrench) {
        let support = GraspSupport::new(self.model, &self.contacts);
        let reach = self.reach();
        let known = std::mem::take(&mut self.cuts);
        let directions = std::iter::once(direction).chain(known.iter().map(|cut| cut.direction));
        for direction in directions {
            insert(&mut self.cuts, support.cut(&direction, reach));
        }
        self.cuts.truncate(MAX_CUTS);
    }

    /// Returns how far the direction of a cut may have turned since the last step.
    fn reach(&self) -> f64 {
        let size = self.surface.mesh().report().bounding_radius;
        (TURN * self.radius / size).min(1.0)
    }

    /// Adds the cut next to a direction. Returns `false` when it is known.
    pub fn add_cut(&mut self, direction: Wrench) -> bool {
        let cut = GraspSupport::new(self.model, &self.contacts).cut(&direction, self.reach());
        let new = insert(&mut self.cuts, cut);
        self.cuts.truncate(MAX_CUTS);
        new
    }
}

/// Inserts a cut by height, unless there is one in its direction.
fn insert(cuts: &mut Vec<Cut>, cut: Cut) -> bool {
    let known = |other: &Cut| 1.0 - other.direction.dot(&cut.direction) < SAME_DIRECTION;
    if !cut.height.is_finite() || cuts.iter().any(known) {
        return false;
    }
    let place = cuts.partition_point(|other| other.height <= cut.height);
    cuts.insert(place, cut);
    true
}

/// Returns the fixed contacts, then the sliding ones.
pub(super) fn all_contacts(fixed: &[Contact], sliding: &[SurfaceContact]) -> Vec<Contact> {
    let sliding = sliding.iter().map(Contact::from);
    fixed.iter().copied().chain(sliding).collect()
}
