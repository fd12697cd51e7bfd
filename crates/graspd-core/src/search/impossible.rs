//! Proof that a body cannot be held, whatever candidates are chosen.
//!
//! A grasp is force closure when the wrenches of its contacts surround the origin. If all wrenches of all candidates
//! and fixed contacts lie on one side of a hyperplane through the origin, no choice of them does. The search for such
//! a hyperplane looks at all candidates a dozen times, far fewer than there are grasps.
//!
//! ```text
//! kept ← the longest wrench
//! up to six times                                                 how many dimensions are there?
//!     w ← the wrench farthest from the flat through kept
//!     if it lies in the flat: proven, all have one component in common
//!     add w to kept
//! up to 200 times                                                 cutting planes
//!     if kept surround the origin: nothing is proven, stop
//!     u ← the direction in which kept reach least
//!     w ← the wrench of the whole surface that reaches farthest along u
//!     if w does not pass the floor: proven, no wrench has a component along u
//!     add w to kept
//! ```
//!
//! What holds in each round: `kept` are wrenches of the problem, so when they surround the origin no hyperplane has
//! all wrenches on one side; and u is the best normal that separates `kept` from the origin, so only a wrench that
//! contradicts it can change the answer.
//!
//! Force closure depends neither on the point torques are taken about nor on their scale, nor on whether the wrenches
//! of several fingers are added (L∞) or mixed (L1). So the point and scale are chosen to suit the candidates, and one
//! proof serves both spaces.
//!
//! It ends after [`ROUNDS`] passes at the latest, without a proof; a dozen are usual. A pass costs O(n) products,
//! in parallel, and each round one small hull. In a round cone the farthest wrench is computed exactly, not among the
//! edges of a pyramid, so the proof holds for the cone.

use nalgebra::{Point3, Vector3};
use rayon::prelude::*;

use super::problem::{CLOSURE_FLOOR, SearchProblem};
use crate::contact::{Contact, ContactModel};
use crate::interrupt::{Interrupt, Interrupted};
use crate::mesh::Candidate;
use crate::quality::{Evaluator, Span};
use crate::wrench::{Wrench, WrenchModel};

/// The reason why no force-closure grasp exists. Directions are unit wrenches about the centroid of the
/// candidates and fixed contacts, torques scaled by the distance of the farthest from it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Impossible {
    /// All grasps were evaluated.
    Exhausted { grasps: u64 },
    /// So few contacts of this model never hold a body.
    TooFewContacts { least: usize },
    /// The wrenches of all candidates lie in a flat of `rank` dimensions, so that all have the same
    /// component in this direction: zero when the body is symmetric about an axis and there is no
    /// friction.
    Deficient { rank: usize, direction: Wrench },
    /// No wrench of any candidate has a positive component in this direction.
    OneSided { direction: Wrench },
}

/// Rounds of adding the wrench that contradicts the present hyperplane. Each takes one pass over
/// the candidates; a dozen are usual.
const ROUNDS: usize = 200;

/// Returns the least number of contacts of the problem's model that can hold a body when the problem has fewer, fixed
/// ones included: less than 7 frictionless contacts span too few dimensions, and two hard ones resist no torque
/// about the line through them (Markenscoff et al. 1990).
pub(super) fn too_few_contacts(problem: &SearchProblem) -> Option<Impossible> {
    let least = match problem.model().contact_model {
        ContactModel::Frictionless => 7,
        ContactModel::Hard { .. } => 3,
        ContactModel::Soft { .. } => 2,
    };
    let count = problem.fixed().len() + problem.contacts();
    (count < least).then_some(Impossible::TooFewContacts { least })
}

/// Looks for a proof that no grasp of this problem is force closure: too few contacts, or a hyperplane with all
/// wrenches on one side. `None` when there is no such proof, though there may still be no grasp. `interrupt` is
/// checked between blocks of candidates.
pub fn prove_impossible(
    problem: &SearchProblem,
    interrupt: Interrupt<'_>,
) -> Result<Option<Impossible>, Interrupted> {
    match too_few_contacts(problem) {
        Some(proof) => Ok(Some(proof)),
        None => separate(problem, interrupt),
    }
}

/// Looks for a proof that no set of candidates, of any number, has a margin above
/// [`CLOSURE_FLOOR`] together with the fixed contacts. `interrupt` is checked between blocks of candidates.
pub(super) fn separate(
    problem: &SearchProblem,
    interrupt: Interrupt<'_>,
) -> Result<Option<Impossible>, Interrupted> {
    let surface = Surface::new(problem);
    let (_, base) = surface.farthest(interrupt, Wrench::norm_squared)?;
    let mut kept = vec![base];
    let mut span = Span::new();
    for rank in 0..6 {
        let (squared, farthest) =
            surface.farthest(interrupt, |w| span.reject(&(w - base)).norm_squared())?;
        if squared.sqrt() <= CLOSURE_FLOOR {
            // The flat need not contain the origin: the direction points to the side away from the wrenches.
            let direction = span.orthogonal();
            let direction = if base.dot(&direction) > 0.0 {
                -direction
            } else {
                direction
            };
            return Ok(Some(Impossible::Deficient { rank, direction }));
        }
        span.push(span.reject(&(farthest - base)).normalize());
        kept.push(farthest);
    }
    let mut evaluator = Evaluator::new();
    for _ in 0..ROUNDS {
        let direction = match evaluator.quality(&kept) {
            Ok(margin) if margin.value <= CLOSURE_FLOOR => margin.direction,
            _ => return Ok(None),
        };
        let (height, highest) = surface.highest(interrupt, &direction)?;
        if height <= CLOSURE_FLOOR {
            return Ok(Some(Impossible::OneSided { direction }));
        }
        kept.push(highest);
    }
    Ok(None)
}

/// All contacts of the problem, with torques about their centroid and scaled by their extent.
struct Surface<'a> {
    fixed: &'a [Contact],
    candidates: &'a [Candidate],
    block: usize,
    model: WrenchModel,
}

impl<'a> Surface<'a> {
    fn new(problem: &'a SearchProblem) -> Self {
        let (fixed, candidates) = (problem.fixed(), problem.candidates());
        let count = (fixed.len() + candidates.len()) as f64;
        let places = || {
            let fixed = fixed.iter().map(|c| c.position);
            fixed.chain(candidates.iter().map(|c| c.position))
        };
        let center = places().fold(Vector3::zeros(), |sum, p| sum + p.coords / count);
        let center = Point3::from(center);
        let reach = places().map(|p| (p - center).norm()).fold(0.0, f64::max);
        let model = WrenchModel {
            center,
            // All in one place have no torque to scale.
            torque_scale: if reach > 0.0 { reach.recip() } else { 1.0 },
            ..*problem.model()
        };
        Self {
            fixed,
            candidates,
            block: problem.block_size(),
            model,
        }
    }

    /// Returns the greatest score of a primitive wrench, and that wrench.
    fn farthest(
        &self,
        interrupt: Interrupt<'_>,
        score: impl Fn(&Wrench) -> f64 + Sync,
    ) -> Result<(f64, Wrench), Interrupted> {
        let wrenches =
            |contact: &Contact, out: &mut Vec<Wrench>| self.model.push_wrenches(contact, out);
        self.best(interrupt, wrenches, score)
    }

    /// Returns how far the wrenches reach along `direction`, and the wrench that reaches farthest. In a round cone
    /// that is the farthest of the cone itself, not of a pyramid, so that the proof holds for the cone.
    fn highest(
        &self,
        interrupt: Interrupt<'_>,
        direction: &Wrench,
    ) -> Result<(f64, Wrench), Interrupted> {
        let wrenches = |contact: &Contact, out: &mut Vec<Wrench>| {
            if !self.model.contact_model.is_round() {
                return self.model.push_wrenches(contact, out);
            }
            self.model.push_slice(contact, out);
            let farthest = farthest_of_slice(out, direction);
            out.clear();
            out.push(farthest);
        };
        self.best(interrupt, wrenches, |w| w.dot(direction))
    }

    /// Returns the greatest score of the wrenches of all contacts, and the first wrench that has it. Blocks are
    /// compared in their order, so the answer does not depend on the number of threads.
    fn best(
        &self,
        interrupt: Interrupt<'_>,
        wrenches_of: impl Fn(&Contact, &mut Vec<Wrench>) + Sync,
        score: impl Fn(&Wrench) -> f64 + Sync,
    ) -> Result<(f64, Wrench), Interrupted> {
        let mut best = best_of(self.fixed.iter().copied(), &wrenches_of, &score);
        for block in self.candidates.chunks(self.block) {
            interrupt.check()?;
            let parts: Vec<(f64, Wrench)> = block
                .par_chunks(1024)
                .map(|part| best_of(part.iter().map(Contact::from), &wrenches_of, &score))
                .collect();
            for part in parts {
                if part.0 > best.0 {
                    best = part;
                }
            }
        }
        Ok(best)
    }
}

/// Returns the greatest score of the wrenches of some contacts, and the first wrench that has it.
fn best_of(
    contacts: impl Iterator<Item = Contact>,
    wrenches_of: &impl Fn(&Contact, &mut Vec<Wrench>),
    score: &impl Fn(&Wrench) -> f64,
) -> (f64, Wrench) {
    let mut best = (f64::NEG_INFINITY, Wrench::zeros());
    let mut wrenches = Vec::new();
    for contact in contacts {
        wrenches.clear();
        wrenches_of(&contact, &mut wrenches);
        for w in &wrenches {
            let scored = score(w);
            if scored > best.0 {
                best = (scored, *w);
            }
        }
    }
    best
}

/// Returns the point of c + A·z, ‖z‖ ≤ 1, that reaches farthest along `direction`: z = Aᵀu/‖Aᵀu‖. In `slice` c comes
/// first, then the columns of A.
fn farthest_of_slice(slice: &[Wrench], direction: &Wrench) -> Wrench {
    let Some((center, columns)) = slice.split_first() else {
        return Wrench::zeros();
    };
    let along: Wrench = columns.iter().map(|a| a * a.dot(direction)).sum();
    let squares: f64 = columns.iter().map(|a| a.dot(direction).powi(2)).sum();
    let length = squares.sqrt();
    if length > 0.0 {
        center + along / length
    } else {
        *center
    }
}
