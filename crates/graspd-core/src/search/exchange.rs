//! Exchange of one finger with cuts: the best place for it anywhere on the body, proven.
//!
//! All fingers but one stay. Along a direction u they reach some way, and a candidate c reaches h_c(u), so
//! ε of the exchanged grasp is at most the greater of both (in L∞: their sum). Directions along which known
//! grasps are weak, the cuts, bound every candidate so, at once for the whole surface ([`Sites`]); the one
//! with the greatest bound is evaluated, its weakest direction joins the cuts, and so on until no bound
//! exceeds the best ε known. What is left out is proven to be no better.

use super::problem::{GraspEvaluator, Problem, SEARCH_ACCURACY, rounded};
use super::sites::{Cut, Sites, Survivor};
use crate::contact::Contact;
use crate::interrupt::{Interrupt, Interrupted, uninterrupted};
use crate::quality::Degenerate;
use crate::random::Stream;
use crate::wrench::{Wrench, WrenchSpace};

/// Directions remembered from one improvement to the next. Without improvement none is forgotten, so that
/// what has been ruled out stays so.
const MEMORY: usize = 64;

/// The gain, as a share of ε, below which an exchange does not count.
pub const EXCHANGE_TOLERANCE: f64 = 1e-6;

/// Share of ε up to which single precision may be off. Beyond it, where torques are far greater than forces,
/// bounds are taken in double precision.
const COARSE: f64 = 0.05;

/// Candidates that are bounded in double precision between two checks of the interrupt: some milliseconds.
const BOUNDED: usize = 1 << 12;

/// Rounding of a bound in double precision, as a share of it: a candidate must not survive the cut of its
/// own evaluation for that.
const BOUND_ROUNDING: f64 = 1e-9;

/// A grasp that climbs, with what it has learnt of the directions in which it is weak.
#[derive(Debug, Clone)]
pub(super) struct Climber {
    /// Candidates in no order: one a slot.
    pub grasp: Vec<u32>,
    /// ε; `None` while it is not known to be force closure.
    pub quality: Option<f64>,
    /// Weak directions, the latest last.
    directions: Vec<Wrench>,
    /// Slots and candidates that were evaluated since the last improvement and whose bounds say less than
    /// the evaluation did.
    tried: Vec<(usize, u32)>,
    /// Whether one of them may be better than it seems, its hull not having been finished.
    doubtful: bool,
    /// The next slot to exchange.
    slot: usize,
    /// Slots in a row that were proven to have no better candidate.
    proven: usize,
    /// Slots in a row that were tried without success.
    idle: usize,
    /// Evaluations made, for whoever counts them to take.
    pub evaluations: u64,
}

/// What one visit of a slot brought.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Visit {
    /// A better grasp.
    Improved,
    /// Nothing yet, though there may be a better one.
    Undecided,
    /// No candidate in this slot is better by more than the tolerance.
    Proven,
}

/// The memory of one thread.
pub(super) struct Exchange<'a> {
    problem: &'a Problem,
    sites: &'a Sites,
    evaluator: GraspEvaluator<'a>,
    cuts: Vec<Cut>,
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
    pub fn has_arrived(&self) -> bool {
        self.quality.is_some() && self.proven >= self.grasp.len()
    }

    /// Whether no exchange of one finger improves it by more than [`EXCHANGE_TOLERANCE`], or by what the
    /// intervals are wide where ε is known as such.
    pub fn is_optimal(&self) -> bool {
        self.has_arrived() && !self.doubtful
    }

    /// Slots in a row without success.
    pub fn idle(&self) -> usize {
        self.idle
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
    pub fn new(problem: &'a Problem, sites: &'a Sites) -> Self {
        Self {
            problem,
            sites,
            evaluator: GraspEvaluator::new(problem),
            cuts: Vec::new(),
            survivors: Vec::new(),
            others: Vec::new(),
            trial: Vec::new(),
        }
    }

    /// Visits the next slot of a climber with at most `allowed` evaluations.
    pub fn visit(&mut self, climber: &mut Climber, allowed: u64) -> Visit {
        let slot = climber.slot;
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
        visit
    }

    /// Looks for a better candidate in one slot, with at most `allowed` evaluations: the best there is, those
    /// with the greatest bounds first, or with a stream the first that is better, in random order. `interrupt` is
    /// checked before each evaluation and every few thousand candidates.
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
        let wanted = |quality: f64| (quality * (1.0 + EXCHANGE_TOLERANCE)).max(floor);
        let mut target = climber.quality.map_or(floor, wanted);

        self.cuts.clear();
        for direction in climber.directions.iter().rev() {
            if let Some(cut) = self.cut(direction, target) {
                self.cuts.push(cut);
            }
        }
        let mut survivors = std::mem::take(&mut self.survivors);
        self.sites.survivors(&self.cuts, target, &mut survivors);
        let own = climber.grasp[slot];
        survivors.retain(|s| {
            let candidate = s.candidate;
            candidate != own
                && !self.others.contains(&candidate)
                && (!problem.is_spaced() || problem.fits_beside(&self.others, candidate))
                && !climber.tried.contains(&(slot, candidate))
        });

        let mut visit = Visit::Proven;
        let mut left = allowed;
        let coarse = climber.quality.is_none() || self.sites.slack() <= COARSE * target;
        // What a stream picks must not depend on the order of the sites or on single precision.
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
                // In single precision it seemed better. All that are known to be like it go at once: there are
                // very many where a face is flat.
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
                    target = wanted(margin.value);
                    visit = Visit::Improved;
                }
                _ if upper > target * (1.0 + BOUND_ROUNDING) => {
                    climber.tried.push((slot, candidate));
                    climber.doubtful |= upper > target * (1.0 + 2.0 * SEARCH_ACCURACY);
                }
                _ => {}
            }
            climber.directions.push(direction);
            match self.cut(&direction, target) {
                Some(cut) => {
                    if coarse {
                        self.sites.narrow(&cut, target, &mut survivors);
                    } else {
                        survivors.retain_mut(|s| {
                            s.bound = s.bound.min(self.bound_under(&cut, s.candidate));
                            s.bound > target
                        });
                    }
                    self.cuts.push(cut);
                }
                None => survivors.retain(|s| s.bound > target),
            }
        }
        self.survivors = survivors;
        Ok(visit)
    }

    /// The survivor with the greatest bound in double precision, the least candidate among equals: which one
    /// it is does not change when the body is moved or turned.
    fn greatest(&self, survivors: &mut [Survivor]) -> usize {
        let bounds = survivors.iter().map(|s| s.bound);
        let near = bounds.fold(f64::NEG_INFINITY, f64::max) - 2.0 * self.sites.slack();
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

    /// The least bound of a candidate under all cuts, in double precision.
    fn bound(&self, candidate: u32) -> f64 {
        let bounds = self.cuts.iter();
        let bounds = bounds.map(|cut| self.bound_under(cut, candidate));
        bounds.fold(f64::INFINITY, f64::min)
    }

    fn bound_under(&self, cut: &Cut, candidate: u32) -> f64 {
        let contact = Contact::from(self.problem.candidate(candidate));
        let model = self.problem.model();
        let reach = model.reach(&contact, &cut.direction);
        match model.space {
            WrenchSpace::L1 => reach,
            WrenchSpace::Linf => cut.base + reach.max(0.0),
        }
    }

    /// A direction as a bound on the finger that is missing beside [`Self::others`]; `None` when they
    /// reach the target alone.
    fn cut(&self, direction: &Wrench, target: f64) -> Option<Cut> {
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
                return (base < target).then_some(Cut {
                    direction: *direction,
                    base: 0.0,
                });
            }
            WrenchSpace::Linf => reaches.map(|reach| reach.max(0.0)).sum::<f64>(),
        };
        (base < target).then_some(Cut {
            direction: *direction,
            base,
        })
    }
}
