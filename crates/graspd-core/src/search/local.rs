//! Local optimum search of Roa & Suárez (2009), the rival in the paper.
//!
//! ε is the distance from the origin to the nearest facet of the hull, so only a contact on that facet can raise it.
//! The search exchanges one such contact at a time.
//!
//! ```text
//! grasp ← first grasp of Algorithm 1
//! repeat
//!     facet ← the weakest facet of the hull
//!     for each contact on it
//!         candidates ← those that leave the ball of radius ε inside the hull when they replace it
//!         take the first of them, in random order, that makes the ball greater
//! until no contact on the facet can be improved
//! ```
//!
//! Which candidates leave the ball inside follows from the facets of the hull of the other contacts, as
//! [`exchange`](super::exchange) explains; one that cuts it off need not be evaluated.
//!
//! Invariant: the grasp is force closure and its ε grows with every exchange. So no grasp comes twice, and as there
//! are finitely many the search ends, at a grasp that no exchange of a contact on its weakest facet improves. One
//! generation of the history is one exchange. A round over the facet costs one pass over the candidates for each
//! contact on it, and the evaluations of the candidates that no facet rules out.

use super::candidate_scan::CandidateScan;
use super::driver::{Driver, SearchMethod, Step};
use super::evaluator::GraspEvaluator;
use super::exchange::{Climber, Exchange, Visit};
use super::problem::{Grasp, SearchProblem};
use super::progress::StopReason;
use crate::contact::Contact;
use crate::random::{Purpose, Stream};
use crate::wrench::WrenchSpace;

/// Evaluations between two reports of progress.
const EVALUATED_AT_ONCE: u64 = 16;

/// A contact whose wrenches come this near to the weakest facet, as a share of ε, lies on it. Intervals on ε are
/// wider than that, and the upper end is what a contact reaches.
const ON_FACET: f64 = 1e-6;

/// The local search between two exchanges.
pub(super) struct Local {
    /// The grasp; `None` when there is none to start from.
    climber: Option<Climber>,
    /// The candidates, laid out before the first exchange.
    scan: Option<CandidateScan>,
    stream: Stream,
}

impl Local {
    pub fn new(first: Option<(Grasp, f64)>, seed: u64) -> Self {
        Self {
            climber: first.map(|(grasp, quality)| Climber::new(grasp, quality)),
            scan: None,
            stream: Stream::new(seed, Purpose::Local, 0),
        }
    }
}

impl SearchMethod for Local {
    fn step(&mut self, driver: &mut Driver<'_>) -> Result<Step, StopReason> {
        let Some(climber) = &mut self.climber else {
            return Ok(Step::Ended(StopReason::LocalOptimum));
        };
        if driver.best().is_none() {
            offer(climber, driver);
            return Ok(Step::GenerationEnded);
        }
        let problem = driver.problem;
        let scan = match &mut self.scan {
            Some(scan) => scan,
            none => none.insert(CandidateScan::new(problem, driver.interrupt)?),
        };
        let mut exchange = Exchange::new(problem, scan);
        for slot in slots_on_facet(problem, &climber.grasp) {
            if improve(&mut exchange, climber, slot, &mut self.stream, driver)? {
                offer(climber, driver);
                return Ok(Step::GenerationEnded);
            }
        }
        Ok(Step::Ended(StopReason::LocalOptimum))
    }

    fn qualities(&self) -> impl Iterator<Item = f64> {
        self.climber.iter().filter_map(|climber| climber.quality)
    }

    /// Evaluations without an improvement are no generation.
    fn records_unfinished_generation(&self) -> bool {
        false
    }

    fn into_others(self) -> Vec<(Grasp, f64)> {
        Vec::new()
    }
}

fn offer(climber: &Climber, driver: &mut Driver<'_>) {
    let mut grasp = climber.grasp.clone();
    grasp.sort_unstable();
    if let Some(quality) = climber.quality {
        driver.offer(&grasp, quality);
    }
}

/// The contacts that reach the weakest facet.
fn slots_on_facet(problem: &SearchProblem, grasp: &[u32]) -> Vec<usize> {
    let Ok(margin) = GraspEvaluator::new(problem).quality(grasp) else {
        return Vec::new();
    };
    let reach = |slot: usize| {
        let contact = Contact::from(problem.candidate(grasp[slot]));
        problem.model().reach(&contact, &margin.direction)
    };
    // In L∞ every contact that reaches beyond zero holds the facet up.
    let near = match problem.model().space {
        WrenchSpace::L1 => margin.upper * (1.0 - ON_FACET),
        WrenchSpace::Linf => ON_FACET * margin.upper,
    };
    (0..grasp.len())
        .filter(|&slot| reach(slot) >= near)
        .collect()
}

/// Looks for a better candidate in one slot, and returns whether there is one.
fn improve(
    exchange: &mut Exchange<'_>,
    climber: &mut Climber,
    slot: usize,
    stream: &mut Stream,
    driver: &mut Driver<'_>,
) -> Result<bool, StopReason> {
    loop {
        let most = driver.budget().left_or_stop()?.min(EVALUATED_AT_ONCE);
        let visit = exchange.exchange(climber, slot, most, Some(stream), driver.interrupt);
        driver.budget().spend(climber.take_evaluations());
        match visit? {
            Visit::Improved => return Ok(true),
            Visit::Proven => return Ok(false),
            Visit::Undecided => driver.checkpoint()?,
        }
    }
}
