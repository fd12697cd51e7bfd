//! Continuous improvement of a grasp: its contacts slide over the surface.
//!
//! While no contact leaves its triangle, ε is the least of many smooth functions of the positions, one for
//! each facet of the wrench space. The facets met so far, tracked to where the contacts are now, make a
//! model of ε: the least of their linearisations. Its best step under a quadratic damping is walked over
//! the surface, across edges, and evaluated; if it is no better the facet that binds there is added to the
//! model (a proximal bundle method: Lemaréchal 1975, Kiwiel 1990). Where a triangle ends the normal, and
//! so ε, jumps. So the same step is also taken with every contact kept to its triangle, and single
//! contacts are moved all around, those moves first that the known facets leave the most hope for.

mod cut;
mod moves;
mod program;

#[cfg(test)]
mod tests;

use nalgebra::{DMatrix, Vector3};

use super::evaluator::SEARCH_FACET_LIMIT;
use crate::contact::Contact;
use crate::interrupt::{Interrupt, Interrupted};
use crate::mesh::{Surface, SurfaceContact};
use crate::quality::{ACCURACY, Degenerate, Evaluator, Margin};
use crate::wrench::{Wrench, WrenchModel};
use cut::{Cut, Reaches};

/// Least gain of a step, over ε. What is less is rounding.
const LEAST_GAIN: f64 = 1e-9;

/// Length of the first steps and of the shortest, over the radius of the body.
const FIRST_RADIUS: f64 = 0.05;
const LAST_RADIUS: f64 = 1e-6;

/// Cuts that are kept, those with the least height.
const MAX_CUTS: usize = 16;

/// Steps without gain that each add a cut, before a shorter one is taken.
const NULL_STEPS: usize = 2;

/// How far the weakest directions turn when contacts move by a radius of the body, or more.
const TURN: f64 = 4.0;

/// Cuts whose directions agree to this are one.
const SAME_DIRECTION: f64 = 1e-12;

/// How much effort to spend.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct PolishSettings {
    /// Most evaluations of the quality, that of the start included.
    pub evaluation_limit: u64,
}

impl Default for PolishSettings {
    fn default() -> Self {
        Self {
            evaluation_limit: 300,
        }
    }
}

/// A grasp that no sliding of its contacts improves much, or as far as it came.
#[derive(Debug, Clone, PartialEq)]
pub struct Polished {
    /// The contacts that slid, in the order of the start.
    pub contacts: Vec<SurfaceContact>,
    /// Of all contacts, the fixed ones included: exact, or an interval of relative width [`ACCURACY`].
    pub margin: Margin,
    /// `margin.value` less that of the start; never negative.
    pub gain: f64,
    /// Evaluations of the quality, those that confirm the outcome of unfinished hulls not counted.
    pub evaluations: u64,
    /// Why it was interrupted, when it was.
    pub stopped: Option<Interrupted>,
}

/// Slides the contacts of `start` over the surface to where ε, together with the `fixed` contacts, is
/// greater; each contact has the normal of the triangle that it is in.
///
/// The value of the margin never falls. A grasp that is not force closure is returned as it is. Only
/// contacts that are `allowed` are evaluated, the start excepted. `interrupt` is checked before
/// each evaluation and ends the polish with what it has, or the start where hulls could not be finished. The
/// same input gives the same output to the last bit. Some milliseconds for 4 contacts with 8 edges.
///
/// # Errors
/// When the wrenches of the start do not span the space.
pub fn polish(
    surface: &Surface<'_>,
    model: &WrenchModel,
    fixed: &[Contact],
    start: &[SurfaceContact],
    settings: PolishSettings,
    allowed: &dyn Fn(&[SurfaceContact]) -> bool,
    interrupt: Interrupt<'_>,
) -> Result<Polished, Degenerate> {
    let mut evaluator = Evaluator::with_facet_limit(SEARCH_FACET_LIMIT);
    let contacts = all_contacts(fixed, start);
    let margin = evaluator.grasp_quality(model, &contacts, ACCURACY)?;
    let mut polish = Polish {
        surface,
        model,
        fixed,
        settings,
        allowed,
        interrupt,
        evaluator,
        evaluations: 1,
        places: start.to_vec(),
        contacts,
        margin,
        cuts: Vec::new(),
        radius: FIRST_RADIUS * surface.mesh().report().bounding_radius,
        kept: false,
    };
    let mut stopped = None;
    if margin.is_force_closure()
        && let Err(End::Interrupted(why)) = polish.run()
    {
        stopped = Some(why);
    }
    let mut polished = Polished {
        contacts: polish.places,
        margin: polish.margin,
        gain: polish.margin.value - margin.value,
        evaluations: polish.evaluations,
        stopped,
    };
    if polished.gain > 0.0 && !(margin.exact && polished.margin.exact) {
        if polished.stopped.is_some() {
            (polished.contacts, polished.margin, polished.gain) = (start.to_vec(), margin, 0.0);
            return Ok(polished);
        }
        confirm(&mut polished, model, fixed, start)?;
    }
    Ok(polished)
}

/// Where a hull was given up after few facets, compares start and end by what many tell.
fn confirm(
    polished: &mut Polished,
    model: &WrenchModel,
    fixed: &[Contact],
    start: &[SurfaceContact],
) -> Result<(), Degenerate> {
    let mut evaluator = Evaluator::new();
    let mut evaluate =
        |places| evaluator.grasp_quality(model, &all_contacts(fixed, places), ACCURACY);
    let before = evaluate(start)?;
    match evaluate(&polished.contacts) {
        Ok(after) if after.value > before.value => {
            (polished.margin, polished.gain) = (after, after.value - before.value);
        }
        _ => {
            polished.contacts = start.to_vec();
            (polished.margin, polished.gain) = (before, 0.0);
        }
    }
    Ok(())
}

/// Why nothing more is evaluated.
enum End {
    EvaluationLimit,
    Interrupted(Interrupted),
}

impl From<Interrupted> for End {
    fn from(why: Interrupted) -> Self {
        Self::Interrupted(why)
    }
}

/// What became of a trial.
enum Trial {
    Better,
    /// No better, with the direction in which it is weakest.
    Worse(Wrench),
    /// Not allowed, or without a quality.
    Unfit,
}

struct Polish<'a> {
    surface: &'a Surface<'a>,
    model: &'a WrenchModel,
    fixed: &'a [Contact],
    settings: PolishSettings,
    allowed: &'a dyn Fn(&[SurfaceContact]) -> bool,
    interrupt: Interrupt<'a>,
    evaluator: Evaluator,
    evaluations: u64,
    /// Where the sliding contacts are.
    places: Vec<SurfaceContact>,
    /// The fixed contacts, then the sliding ones.
    contacts: Vec<Contact>,
    margin: Margin,
    /// All of the present contacts.
    cuts: Vec<Cut>,
    /// Length of the present steps.
    radius: f64,
    /// Whether the last good step kept contacts to their triangles.
    kept: bool,
}

impl Polish<'_> {
    fn run(&mut self) -> Result<(), End> {
        let size = self.surface.mesh().report().bounding_radius;
        self.track(self.margin.direction);
        while self.radius > LAST_RADIUS * size {
            let better =
                self.slide(self.kept)? || self.slide(!self.kept)? || self.move_one(self.radius)?;
            self.radius = if better {
                (2.0 * self.radius).min(size)
            } else {
                0.5 * self.radius
            };
        }
        Ok(())
    }

    /// Steps of all contacts together, until one is better or none promises to be.
    fn slide(&mut self, keep: bool) -> Result<bool, End> {
        for _ in 0..NULL_STEPS {
            let Some(steps) = self.best_steps(self.radius, keep) else {
                break;
            };
            let trial: Vec<SurfaceContact> = self
                .places
                .iter()
                .zip(&steps)
                .map(|(place, step)| self.surface.walk(place, step))
                .collect();
            if self.bound(&trial) <= self.enough() {
                break;
            }
            match self.try_out(trial)? {
                Trial::Better => {
                    self.kept = keep;
                    return Ok(true);
                }
                Trial::Worse(direction) => {
                    if !self.add_cut(direction) {
                        break;
                    }
                }
                Trial::Unfit => break,
            }
        }
        Ok(false)
    }

    /// The steps of the sliding contacts, none longer than `radius`, that raise the least linearised cut
    /// the most, less a damping; `keep` keeps the contacts to their triangles. `None` when that gains
    /// nothing.
    fn best_steps(&self, radius: f64, keep: bool) -> Option<Vec<Vector3<f64>>> {
        let first = self.fixed.len();
        let sliding = self.places.len();
        let mut rows: Vec<Vec<Vector3<f64>>> = self
            .cuts
            .iter()
            .map(|cut| cut.gradient[first..].to_vec())
            .collect();
        let steepest = rows.iter().flatten().map(Vector3::norm).fold(0.0, f64::max);
        if steepest == 0.0 || !steepest.is_finite() {
            return None;
        }
        let damping = radius / steepest;
        let mut costs: Vec<f64> = self.cuts.iter().map(|cut| cut.height).collect();
        if keep {
            for (contact, place) in self.places.iter().enumerate() {
                for (distance, away) in self.surface.sides(place).into_iter().flatten() {
                    if distance < radius {
                        let mut row = vec![Vector3::zeros(); sliding];
                        row[contact] = away;
                        rows.push(row);
                        costs.push(distance);
                    }
                }
            }
        }
        let n = rows.len();
        let product = |a: &[Vector3<f64>], b: &[Vector3<f64>]| -> f64 {
            a.iter().zip(b).map(|(a, b)| a.dot(b)).sum()
        };
        let products = DMatrix::from_fn(n, n, |i, j| damping * product(&rows[i], &rows[j]));
        let mut weights = Vec::new();
        program::minimize(&products, &costs, self.cuts.len(), &mut weights);
        let mut steps = vec![Vector3::zeros(); sliding];
        for (row, weight) in rows.iter().zip(&weights) {
            for (step, slope) in steps.iter_mut().zip(row) {
                *step += slope * (damping * weight);
            }
        }
        let hoped = self
            .cuts
            .iter()
            .zip(&rows)
            .map(|(cut, row)| cut.height + product(row, &steps))
            .fold(f64::INFINITY, f64::min);
        (hoped > self.enough()).then_some(steps)
    }

    /// What ε has to exceed.
    fn enough(&self) -> f64 {
        self.margin.value * (1.0 + LEAST_GAIN)
    }

    /// What ε of other contacts does not exceed, by the present cuts.
    fn bound(&self, trial: &[SurfaceContact]) -> f64 {
        let contacts = all_contacts(self.fixed, trial);
        let reaches = Reaches::new(self.model, &contacts);
        let heights = self.cuts.iter().map(|cut| reaches.height(&cut.direction));
        heights.fold(f64::INFINITY, f64::min)
    }

    /// Evaluates contacts and takes them when they are better.
    fn try_out(&mut self, trial: Vec<SurfaceContact>) -> Result<Trial, End> {
        if trial == self.places || !(self.allowed)(&trial) {
            return Ok(Trial::Unfit);
        }
        if self.evaluations >= self.settings.evaluation_limit {
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
    fn track(&mut self, direction: Wrench) {
        let reaches = Reaches::new(self.model, &self.contacts);
        let reach = self.reach();
        let known = std::mem::take(&mut self.cuts);
        let directions = std::iter::once(direction).chain(known.iter().map(|cut| cut.direction));
        for direction in directions {
            insert(&mut self.cuts, reaches.cut(&direction, reach));
        }
        self.cuts.truncate(MAX_CUTS);
    }

    /// How far the direction of a cut may have turned.
    fn reach(&self) -> f64 {
        let size = self.surface.mesh().report().bounding_radius;
        (TURN * self.radius / size).min(1.0)
    }

    /// Adds the cut next to a direction; `false` when it is known.
    fn add_cut(&mut self, direction: Wrench) -> bool {
        let cut = Reaches::new(self.model, &self.contacts).cut(&direction, self.reach());
        let new = insert(&mut self.cuts, cut);
        self.cuts.truncate(MAX_CUTS);
        new
    }
}

/// Puts a cut in its place by height, unless there is one in its direction.
fn insert(cuts: &mut Vec<Cut>, cut: Cut) -> bool {
    let known = |other: &Cut| 1.0 - other.direction.dot(&cut.direction) < SAME_DIRECTION;
    if !cut.height.is_finite() || cuts.iter().any(known) {
        return false;
    }
    let place = cuts.partition_point(|other| other.height <= cut.height);
    cuts.insert(place, cut);
    true
}

fn all_contacts(fixed: &[Contact], sliding: &[SurfaceContact]) -> Vec<Contact> {
    let sliding = sliding.iter().map(Contact::from);
    fixed.iter().copied().chain(sliding).collect()
}
