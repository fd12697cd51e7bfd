//! A first force-closure grasp: Roa & Suárez, Algorithm 1 (paper, §3.2).
//!
//! Random grasps are seldom force closure, but they can be repaired. Take one contact out. A wrench w closes the hull
//! of the other contacts around the origin when −w lies in the cone that they span. The supporting hyperplanes of
//! that cone bound the region χ of all such w: w·u > 0 for each of their normals u, which point away from the hull.
//! A candidate with a wrench in χ is found in one pass over the surface.
//!
//! ```text
//! if there are too few contacts: impossible
//! up to 100 times
//!     grasp ← a random grasp that keeps the spacing
//!     if it is force closure: found
//!     for each contact, the one nearest to the separating hyperplane first
//!         rest ← the grasp without it
//!         χ ← the region bounded by the supporting normals of the hull of the origin and rest
//!         for up to 8 random candidates with a wrench in χ
//!             if rest and the candidate are force closure: found
//!     after the first failure: look for a proof that no grasp exists
//! ```
//!
//! The contact nearest to the hyperplane that separates the origin from the hull comes first: the others stay on
//! their side when it goes, so its place is the likeliest to be missing. Weak mode asks for one wrench
//! of the new finger in χ, strict mode for all of them (paper, §4.2.1). Where the hull of the rest has no supporting
//! hyperplane at the origin, or could not be finished, some candidates are tried one by one.
//!
//! What is returned was evaluated like any other grasp, so χ only guides the search: rounding in it cannot give a
//! grasp that is not force closure. The search ends after [`STARTS`] starts, or within the budget; each costs m hulls
//! and m passes of O(n) at most. The proof is sought once, as it costs about as much as a start and random
//! starts on a body that cannot be held would otherwise all fail.

use rayon::prelude::*;

use super::evaluator::{GraspEvaluator, SEARCH_FACET_LIMIT};
use super::impossible::{Impossible, separate, too_few_contacts};
use super::problem::{Grasp, SearchProblem};
use super::progress::{Budget, Observer, Phase, SearchProgress, StopReason};
use super::random_grasp::random_grasp;
use crate::interrupt::{Interrupt, Interrupted};
use crate::quality::{Degenerate, Evaluator};
use crate::random::{Purpose, Stream};
use crate::wrench::Wrench;

/// Which candidates may replace a contact.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "snake_case"))]
#[cfg_attr(feature = "schema", derive(utoipa::ToSchema))]
pub enum InitialMode {
    /// One primitive wrench of the new finger in the region χ suffices.
    Weak,
    /// All primitive wrenches of the new finger must lie in χ (paper, §4.2.1).
    Strict,
}

/// Most random starts.
const STARTS: u64 = 100;

/// Candidates of χ that are evaluated before another contact is replaced. One is enough except for
/// grasps within rounding of the border.
const PICKS: usize = 8;

/// Candidates tried one by one where the remaining wrenches leave no region χ to search.
const DIRECT_TRIES: usize = 400;

/// Starts whose margins are compared for the grasp to show when none is force closure.
const SHOWN_STARTS: u64 = 16;

/// What the search for a first grasp led to.
#[derive(Debug, Clone, PartialEq)]
pub enum Initial {
    Found {
        grasp: Grasp,
        quality: f64,
    },
    /// None after all starts, though none is proven not to exist.
    NotFound,
    /// In none of the starts were contacts found that keep the spacing, though that does not prove
    /// that there are none.
    NoneFits,
    Impossible(Impossible),
    Stopped(StopReason),
}

impl From<Interrupted> for Initial {
    fn from(why: Interrupted) -> Self {
        Self::Stopped(why.into())
    }
}

/// Finds a force-closure grasp. The evaluations are taken from `budget`. Only grasps that
/// [keep the spacing](SearchProblem::keeps_spacing) are tried. `observe` is called and `interrupt` checked before each
/// hull and between blocks of candidates.
pub fn initial_grasp(
    problem: &SearchProblem,
    mode: InitialMode,
    seed: u64,
    budget: &mut Budget,
    interrupt: Interrupt<'_>,
    observe: Observer<'_>,
) -> Initial {
    if let Some(proof) = too_few_contacts(problem) {
        return Initial::Impossible(proof);
    }
    let mut repair = Repair {
        problem,
        mode,
        evaluator: GraspEvaluator::new(problem),
        hull: Evaluator::with_facet_limit(SEARCH_FACET_LIMIT),
        budget,
        interrupt,
        observe,
        has_tried: false,
    };
    for start in 0..STARTS {
        let mut stream = Stream::new(seed, Purpose::InitialGrasp, start);
        if let Err(end) = repair.start(&mut stream) {
            return end;
        }
        if start == 0 {
            match separate(problem, interrupt) {
                Err(why) => return Initial::Stopped(why.into()),
                Ok(Some(proof)) => return Initial::Impossible(proof),
                Ok(None) => {}
            }
        }
    }
    if repair.has_tried {
        Initial::NotFound
    } else {
        Initial::NoneFits
    }
}

struct Repair<'a> {
    problem: &'a SearchProblem,
    mode: InitialMode,
    evaluator: GraspEvaluator<'a>,
    hull: Evaluator,
    budget: &'a mut Budget,
    interrupt: Interrupt<'a>,
    observe: Observer<'a>,
    /// Whether any start had a grasp to try.
    has_tried: bool,
}

impl Repair<'_> {
    /// Tries one random grasp and its repairs. `Err` ends the search; `Ok` means that none is force closure.
    fn start(&mut self, stream: &mut Stream) -> Result<(), Initial> {
        let problem = self.problem;
        let Some(grasp) = random_grasp(problem, stream, self.interrupt)? else {
            return Ok(());
        };
        self.has_tried = true;
        self.try_grasp(&grasp)?;
        self.report()?;
        let separating = match self.evaluator.quality(&grasp) {
            Ok(margin) => margin.direction,
            Err(Degenerate { direction, .. }) => direction,
        };
        for slot in self.replacement_order(&grasp, &separating, stream) {
            let mut rest = grasp.clone();
            rest.remove(slot);
            let wrenches = problem.wrenches(&rest);
            self.report()?;
            let chosen = match self.hull.supporting_normals(&wrenches) {
                Ok(Some(normals)) => {
                    let mut region = self.region(&normals, &rest)?;
                    stream.shuffle(&mut region);
                    region.truncate(PICKS);
                    region
                }
                // The rest span too little to bound a region, or too much to finish their hull.
                Ok(None) | Err(_) => self.random_candidates(&rest, stream)?,
            };
            for candidate in chosen {
                let mut repaired = rest.clone();
                let place = repaired.partition_point(|&c| c < candidate);
                repaired.insert(place, candidate);
                self.try_grasp(&repaired)?;
            }
        }
        Ok(())
    }

    /// Reports progress and checks the interrupt.
    fn report(&mut self) -> Result<(), Interrupted> {
        (self.observe)(&SearchProgress {
            phase: Phase::Initial,
            generation: 0,
            evaluations: self.budget.spent(),
            best: None,
            grasp: None,
            generation_ended: false,
        });
        self.interrupt.check()
    }

    /// Evaluates a grasp and ends the search with it when it is force closure.
    fn try_grasp(&mut self, grasp: &[u32]) -> Result<(), Initial> {
        self.report()?;
        self.budget.left_or_stop().map_err(Initial::Stopped)?;
        self.budget.spend(1);
        match self.evaluator.epsilon(grasp) {
            Some(quality) => Err(Initial::Found {
                grasp: grasp.to_vec(),
                quality,
            }),
            None => Ok(()),
        }
    }

    /// Returns the slots of the grasp, the contact nearest to the separating hyperplane first; ties at random.
    fn replacement_order(
        &self,
        grasp: &[u32],
        separating: &Wrench,
        stream: &mut Stream,
    ) -> Vec<usize> {
        let mut order: Vec<usize> = (0..grasp.len()).collect();
        stream.shuffle(&mut order);
        let height = |slot: usize| {
            let mut wrenches = Vec::new();
            self.problem.push_wrenches(grasp[slot], &mut wrenches);
            wrenches
                .iter()
                .map(|w| w.dot(separating))
                .fold(f64::NEG_INFINITY, f64::max)
        };
        let heights: Vec<f64> = (0..grasp.len()).map(height).collect();
        order.sort_by(|&a, &b| heights[b].total_cmp(&heights[a]));
        order
    }

    /// Returns the candidates in the region χ that `normals` bound and that keep the spacing with `rest`, ascending.
    /// Without normals there is no region. Most candidates fail on one of the first normals, so a candidate costs
    /// little more than its wrenches.
    fn region(&mut self, normals: &[Wrench], rest: &[u32]) -> Result<Vec<u32>, Initial> {
        if normals.is_empty() {
            return Ok(Vec::new());
        }
        let (problem, mode) = (self.problem, self.mode);
        let in_region = |w: &Wrench| normals.iter().all(|normal| normal.dot(w) > 0.0);
        self.scan(rest, |wrenches, candidate| {
            wrenches.clear();
            problem.push_wrenches(candidate, wrenches);
            match mode {
                InitialMode::Weak => wrenches.iter().any(in_region),
                InitialMode::Strict => wrenches.iter().all(in_region),
            }
        })
    }

    /// Returns the candidates that are accepted and keep the spacing with `rest`, ascending, none of them in it. O(n)
    /// on the current rayon pool.
    fn scan(
        &mut self,
        rest: &[u32],
        accepts: impl Fn(&mut Vec<Wrench>, u32) -> bool + Sync,
    ) -> Result<Vec<u32>, Initial> {
        let (n, block) = (self.problem.len(), self.problem.block_size());
        let problem = self.problem;
        let accepted = |wrenches: &mut Vec<Wrench>, candidate: u32| {
            let is_accepted = accepts(wrenches, candidate)
                && rest.binary_search(&candidate).is_err()
                && problem.keeps_spacing_with(rest, candidate);
            is_accepted.then_some(candidate)
        };
        let mut found: Vec<u32> = Vec::new();
        for from in (0..n).step_by(block) {
            self.report()?;
            let to = n.min(from + block);
            found.par_extend(
                (from as u32..to as u32)
                    .into_par_iter()
                    .with_min_len(512)
                    .map_init(Vec::new, &accepted)
                    .flatten(),
            );
        }
        Ok(found)
    }

    /// Returns up to [`DIRECT_TRIES`] random candidates that keep the spacing with `rest`, none of them in it.
    fn random_candidates(
        &mut self,
        rest: &[u32],
        stream: &mut Stream,
    ) -> Result<Vec<u32>, Initial> {
        let n = self.problem.len();
        let mut candidates = if self.problem.has_spacing() {
            let all = self.scan(rest, |_, _| true)?;
            let picks = stream.subset(all.len(), DIRECT_TRIES.min(all.len()));
            picks.into_iter().map(|pick| all[pick as usize]).collect()
        } else {
            stream.subset(n, DIRECT_TRIES.min(n))
        };
        candidates.retain(|c| rest.binary_search(c).is_err());
        stream.shuffle(&mut candidates);
        Ok(candidates)
    }
}

/// Returns the grasp with the greatest margin of the first sixteen random grasps that [`initial_grasp`] tries: a grasp
/// to show when none is force closure. `None` when none of them keeps the spacing, all are degenerate, or the
/// interrupt, which is checked before each of the hulls, comes.
pub fn nearest_start(
    problem: &SearchProblem,
    seed: u64,
    interrupt: Interrupt<'_>,
) -> Option<Grasp> {
    let mut evaluator = Evaluator::with_facet_limit(SEARCH_FACET_LIMIT);
    let mut nearest: Option<(Grasp, f64)> = None;
    for start in 0..SHOWN_STARTS {
        interrupt.check().ok()?;
        let mut stream = Stream::new(seed, Purpose::InitialGrasp, start);
        let Some(grasp) = random_grasp(problem, &mut stream, interrupt).ok()? else {
            continue;
        };
        if let Ok(margin) = evaluator.margin(&problem.wrenches(&grasp))
            && nearest
                .as_ref()
                .is_none_or(|(_, best)| margin.value > *best)
        {
            nearest = Some((grasp, margin.value));
        }
    }
    nearest.map(|(grasp, _)| grasp)
}
