//! Exchange of one finger: the best candidate for it anywhere on the body, proven.
//!
//! All fingers but one stay. Along a direction u they reach as far as h(u), and a candidate c reaches h_c(u). ε of the
//! exchanged grasp is the least reach over all directions, so for each single u it is at most max(h(u), h_c(u)) in L1,
//! and at most h(u) + h_c(u) in L∞. Each direction in which a known grasp is weak is a half-space that contains the
//! whole wrench space of that grasp, and bounds every candidate on the body at once. Few candidates pass all
//! half-spaces; only those are evaluated.
//!
//! ```text
//! target ← ε of the grasp, and a little more
//! half-spaces ← the weak directions that the climber remembers
//! survivors ← candidates whose bound exceeds the target under all half-spaces      one pass, CandidateScan
//! while there are survivors, and evaluations are allowed
//!     c ← the survivor with the greatest bound                        (local search: a random one)
//!     evaluate the grasp with c
//!     if it is better: take it, raise the target
//!     add its weakest direction to the half-spaces; drop the survivors that it rules out
//! ```
//!
//! Invariant: a candidate that is neither evaluated nor among the survivors has a bound of at most the target, so it is
//! no better than the grasp by more than the tolerance. When no survivor is left, that is proven of every candidate in
//! this slot ([`Visit::Proven`]); proven for all slots in a row, the grasp is optimal under exchanges of one finger.
//! Two things weaken the proof, and both are remembered: a hull that could not be finished, and an interval on ε that
//! reaches above the target.
//!
//! It ends because each round takes one candidate out of finitely many. The evaluated candidate itself is ruled out by
//! its own half-space, up to rounding. A visit costs one pass over the candidates, O(n) for each half-space that is
//! not already beaten, and a few evaluations: a facet near the optimum rules out large parts of the surface.
//!
//! The bounds of a pass are in single precision and rounded up. Which survivor is next must not depend on that, nor on
//! the order of the candidates in memory: the bounds that matter are computed again in double precision, and of equal
//! ones the least candidate is taken. So a moved or turned body gives the same search.

use super::candidate_scan::{CandidateScan, HalfSpace, Survivor};
use super::evaluator::{GraspEvaluator, SEARCH_ACCURACY, rounded};
use super::problem::SearchProblem;
use crate::contact::Contact;
use crate::interrupt::{Interrupt, Interrupted, uninterrupted};
use crate::quality::Degenerate;
use crate::random::Stream;
use crate::wrench::{Wrench, WrenchSpace};

/// Directions remembered from one improvement to the next. Without an improvement none is forgotten, so that
/// what has been ruled out stays so.
const MEMORY: usize = 64;

/// The gain, as a share of ε, below which an exchange does not count.
pub const EXCHANGE_TOLERANCE: f64 = 1e-6;

/// Greatest error of bounds in single precision, as a share of ε, with which they are used. Beyond it, where torques
/// are far greater than forces, bounds are computed in double precision.
const COARSE: f64 = 0.05;

/// Candidates that are bounded in double precision between two checks of the interrupt: some milliseconds.
const BOUNDED: usize = 1 << 12;

/// Rounding of a bound in double precision, as a share of it. A candidate must not survive the half-space of its
/// own evaluation because of it.
const BOUND_ROUNDING: f64 = 1e-9;

/// A grasp that is improved step by step, and the directions in which it and its neighbours were found to be weak.
#[derive(Debug, Clone)]
pub(super) struct Climber {
    /// One candidate for each slot, in no order.
    pub grasp: Vec<u32>,
    /// ε; `None` while it is not known to be force closure.
    pub quality: Option<f64>,
    /// Weak directions, the latest last.
    directions: Vec<Wrench>,
    /// Slots and candidates that were evaluated since the last improvement and whose bounds are weaker than
    /// their evaluation.
    tried: Vec<(usize, u32)>,
    /// Whether one of them may be better than its evaluation says, because its hull was not finished.
    doubtful: bool,
    /// The next slot to exchange.
    slot: usize,
    /// Slots in a row that were proven to have no better candidate.
    proven: usize,
    /// Slots in a row that were tried without success.
    idle: usize,
    /// Evaluations made since they were last taken.
    evaluations: u64,
}

/// What one visit of a slot led to.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Visit {
    /// A better grasp.
    Improved,
    /// Nothing yet, though there may be a better one.
    Undecided,
    /// No candidate in this slot is better by more than the tolerance.
    Proven,
}

/// Exchanges fingers of grasps of one problem; the working memory of one thread.
pub(super) struct Exchange<'a> {
    problem: &'a SearchProblem,
    scan: &'a CandidateScan,
    evaluator: GraspEvaluator<'a>,
    half_spaces: Vec<HalfSpace>,
    survivors: Vec<Survivor>,
    others: Vec<u32>,
    trial: Vec<u32>,
}

impl Climber {
    /// A force-closure grasp.
    pub fn new(grasp: Vec<u32>, quality: f64) -> Self {
        Self {
            quality: Some(quality),
            ..Self::unknown(grasp)
        }
    }

    /// A grasp that was not evaluated and may not be force closure.
    pub fn unknown(grasp: Vec<u32>) -> Self {
        Self {
            grasp,
            quality: None,
            directions: Vec::new(),
            tried: Vec::new(),
            doubtful: false,
            slot: 0,
            proven: 0,
            idle: 0,
            evaluations: 0,
        }
    }

    /// Whether every slot was visited and nothing better found.
    pub fn is_local_optimum(&self) -> bool {
        self.quality.is_some() && self.proven >= self.grasp.len()
    }

    /// Whether it is proven that no exchange of one finger improves it by more than [`EXCHANGE_TOLERANCE`], or by
    /// more than the width of the interval where ε is known as one.
    pub fn is_proven_optimal(&self) -> bool {
        self.is_local_optimum() && !self.doubtful
    }

    /// Returns the number of slots in a row without success.
    pub fn idle(&self) -> usize {
        self.idle
    }

    /// Returns the evaluations made since the last call.
    pub fn take_evaluations(&mut self) -> u64 {
        std::mem::take(&mut self.evaluations)
    }

    fn improve(&mut self, slot: usize, candidate: u32, quality: f64) {
        self.grasp[slot] = candidate;
        self.quality = Some(quality);
        let old = self.directions.len().saturating_sub(MEMORY);
        self.directions.drain(..old);
        self.tried.clear();
        self.doubtful = false;
    }
}

impl<'a> Exchange<'a> {
    pub fn new(problem: &'a SearchProblem, scan: &'a CandidateScan) -> Self {
        Self {
            problem,
            scan,
            evaluator: GraspEvaluator::new(problem),
            half_spaces: Vec::new(),
            survivors: Vec::new(),
            others: Vec::new(),
            trial: Vec::new(),
        }
    }

    /// Visits the next slot of a climber with at most `allowed` evaluations, and returns how many were made.
    pub fn visit(&mut self, climber: &mut Climber, allowed: u64) -> u64 {
        let (slot, before) = (climber.slot, climber.evaluations);
        // A visit takes a few milliseconds at most.
        let visit = uninterrupted(|never| self.exchange(climber, slot, allowed, None, never));
        match visit {
            Visit::Improved => (climber.proven, climber.idle) = (0, 0),
            Visit::Undecided => (climber.proven, climber.idle) = (0, climber.idle + 1),
            Visit::Proven => {
                climber.proven += 1;
                climber.idle += 1;
            }
        }
        climber.slot = (slot + 1) % climber.grasp.len();
        climber.evaluations - before
    }

    /// Looks for a better candidate in one slot, with at most `allowed` evaluations. Without a stream it looks for the
    /// best, the candidates with the greatest bounds first; with a stream it takes the first that is better, in random
    /// order. `interrupt` is checked before each evaluation and every few thousand candidates.
    pub fn exchange(
        &mut self,
        climber: &mut Climber,
        slot: usize,
        allowed: u64,
        mut stream: Option<&mut Stream>,
        interrupt: Interrupt<'_>,
    ) -> Result<Visit, Interrupted> {
        let problem = self.problem;
        self.others.clear();
        self.others.extend_from_slice(&climber.grasp);
        self.others.remove(slot);
        let floor = problem.closure_floor();
        let beyond = |quality: f64| (quality * (1.0 + EXCHANGE_TOLERANCE)).max(floor);
        let mut target = climber.quality.map_or(floor, beyond);

        self.half_spaces.clear();
        for direction in climber.directions.iter().rev() {
            if let Some(half_space) = self.half_space(direction, target) {
                self.half_spaces.push(half_space);
            }
        }
        let mut survivors = std::mem::take(&mut self.survivors);
        self.scan
            .survivors(&self.half_spaces, target, &mut survivors);
        let own = climber.grasp[slot];
        survivors.retain(|s| {
            let candidate = s.candidate;
            candidate != own
                && !self.others.contains(&candidate)
                && (!problem.has_spacing() || problem.keeps_spacing_with(&self.others, candidate))
                && !climber.tried.contains(&(slot, candidate))
        });

        let mut visit = Visit::Proven;
        let mut left = allowed;
        let coarse = climber.quality.is_none() || self.scan.slack() <= COARSE * target;
        // What a stream picks must not depend on the order of the scan or on single precision, so all bounds are
        // computed in double precision at once.
        if !coarse || stream.is_some() {
            for block in survivors.chunks_mut(BOUNDED) {
                interrupt.check()?;
                for s in block {
                    (s.bound, s.exact) = (self.bound(s.candidate), true);
                }
            }
            survivors.retain(|s| s.bound > target);
            survivors.sort_unstable_by_key(|s| s.candidate);
        }
        while !(survivors.is_empty() || stream.is_some() && visit == Visit::Improved) {
            let next = match &mut stream {
                Some(stream) => stream.below(survivors.len()),
                None => self.greatest(&mut survivors),
            };
            let useless = target * (1.0 + BOUND_ROUNDING);
            if survivors[next].bound <= useless {
                // In single precision it seemed better. All that are known to be no better go at once: on a flat face
                // there are very many.
                match stream {
                    Some(_) => _ = survivors.swap_remove(next),
                    None => survivors.retain(|s| !s.exact || s.bound > useless),
                }
                continue;
            }
            if left == 0 {
                if visit == Visit::Proven {
                    visit = Visit::Undecided;
                }
                break;
            }
            interrupt.check()?;
            let candidate = survivors.swap_remove(next).candidate;
            left -= 1;
            climber.evaluations += 1;
            self.trial.clear();
            self.trial.extend_from_slice(&self.others);
            self.trial.push(candidate);
            let evaluated = self.evaluator.quality_above(&self.trial, target);
            let (direction, upper) = match evaluated {
                Ok(margin) => (margin.direction, margin.upper),
                Err(Degenerate { direction, .. }) => (direction, 0.0),
            };
            match evaluated {
                Ok(margin) if margin.value > target => {
                    climber.improve(slot, candidate, margin.value);
                    target = beyond(margin.value);
                    visit = Visit::Improved;
                }
                // The upper end of its interval does not rule it out: it must not be evaluated again.
                _ if upper > target * (1.0 + BOUND_ROUNDING) => {
                    climber.tried.push((slot, candidate));
                    climber.doubtful |= upper > target * (1.0 + 2.0 * SEARCH_ACCURACY);
                }
                _ => {}
            }
            climber.directions.push(direction);
            match self.half_space(&direction, target) {
                Some(half_space) => {
                    if coarse {
                        self.scan.narrow(&half_space, target, &mut survivors);
                    } else {
                        survivors.retain_mut(|s| {
                            s.bound = s.bound.min(self.bound_by(&half_space, s.candidate));
                            s.bound > target
                        });
                    }
                    self.half_spaces.push(half_space);
                }
                None => survivors.retain(|s| s.bound > target),
            }
        }
        self.survivors = survivors;
        Ok(visit)
    }

    /// Returns the place of the survivor with the greatest bound in double precision, the least candidate among equals.
    /// Which one it is does not change when the body is moved or turned.
    fn greatest(&self, survivors: &mut [Survivor]) -> usize {
        let bounds = survivors.iter().map(|s| s.bound);
        // Only those within the error of single precision of the greatest can be the greatest.
        let near = bounds.fold(f64::NEG_INFINITY, f64::max) - 2.0 * self.scan.slack();
        let mut best = (0, f64::NEG_INFINITY, u32::MAX);
        for (i, survivor) in survivors.iter_mut().enumerate() {
            if survivor.bound < near {
                continue;
            }
            if !survivor.exact {
                (survivor.bound, survivor.exact) = (self.bound(survivor.candidate), true);
            }
            let (bound, candidate) = (rounded(survivor.bound), survivor.candidate);
            if bound > best.1 || (bound == best.1 && candidate < best.2) {
                best = (i, bound, candidate);
            }
        }
        best.0
    }

    /// Returns the least bound of a candidate under all half-spaces, in double precision.
    fn bound(&self, candidate: u32) -> f64 {
        let bounds = self.half_spaces.iter();
        let bounds = bounds.map(|half_space| self.bound_by(half_space, candidate));
        bounds.fold(f64::INFINITY, f64::min)
    }

    fn bound_by(&self, half_space: &HalfSpace, candidate: u32) -> f64 {
        let contact = Contact::from(self.problem.candidate(candidate));
        let model = self.problem.model();
        let reach = model.reach(&contact, &half_space.direction);
        match model.space {
            WrenchSpace::L1 => reach,
            WrenchSpace::Linf => half_space.base + reach.max(0.0),
        }
    }

    /// Returns the half-space of a direction for the finger that is missing among [`Self::others`]. `None` when the
    /// others reach the target by themselves, as it rules out nothing then.
    fn half_space(&self, direction: &Wrench, target: f64) -> Option<HalfSpace> {
        let problem = self.problem;
        let others = self
            .others
            .iter()
            .map(|&i| Contact::from(problem.candidate(i)));
        let others = others.chain(problem.fixed().iter().copied());
        let reaches = others.map(|contact| problem.model().reach(&contact, direction));
        let base = match problem.model().space {
            WrenchSpace::L1 => {
                let base = reaches.fold(f64::NEG_INFINITY, f64::max);
                return (base < target).then_some(HalfSpace {
                    direction: *direction,
                    base: 0.0,
                });
            }
            WrenchSpace::Linf => reaches.map(|reach| reach.max(0.0)).sum::<f64>(),
        };
        (base < target).then_some(HalfSpace {
            direction: *direction,
            base,
        })
    }
}
