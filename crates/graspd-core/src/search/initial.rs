//! A first force-closure grasp: Roa & Suárez, Algorithm 1 (paper, §3.2).

use rayon::prelude::*;

use super::fitting::random_grasp;
use super::impossible::{Impossible, prove_impossible, too_few_contacts};
use super::problem::{Grasp, GraspEvaluator, Problem, SEARCH_FACET_LIMIT};
use super::progress::{Observer, Phase, Progress, Stop};
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

/// Random starts before the search for a first grasp is given up.
const STARTS: u64 = 100;

/// Candidates of χ that are evaluated before another contact is tried. One is enough but for
/// grasps within rounding of the border.
const PICKS: usize = 8;

/// Candidates tried one by one where the remaining wrenches leave no region χ to search.
const DIRECT_TRIES: usize = 400;

/// Starts whose margins are compared when there is no force closure to show.
const SHOWN_STARTS: u64 = 16;

/// What became of the search for a first grasp.
#[derive(Debug, Clone, PartialEq)]
pub enum Initial {
    Found {
        grasp: Grasp,
        quality: f64,
    },
    /// None after all starts, though none is proven not to exist.
    NotFound,
    /// In none of the starts were contacts found that keep their distances, though that does not prove
    /// that there are none.
    NoneFits,
    Impossible(Impossible),
    Stopped(Stop),
}

impl From<Interrupted> for Initial {
    fn from(why: Interrupted) -> Self {
        Self::Stopped(why.into())
    }
}

/// Finds a force-closure grasp, and adds the quality evaluations made to `evaluations`.
///
/// A random grasp that is not force closure has one contact replaced: the supporting hyperplanes,
/// at the origin, of the hull of the origin and the other contacts' wrenches bound a region χ on
/// their far side, and any candidate with a wrench in χ closes the grasp. Contacts nearest to the
/// facet that separates the origin from the hull are replaced first; when χ is empty for all of
/// them the search starts over, a hundred times at most. After the first failure it is checked
/// whether any grasp can exist at all. Only grasps that [fit](Problem::fits) are tried. Each region costs one
/// hull and one pass over the candidates. `observe` is called and
/// `interrupt` checked before each hull and between blocks of candidates.
pub fn initial_grasp(
    problem: &Problem,
    mode: InitialMode,
    seed: u64,
    evaluation_limit: Option<u64>,
    evaluations: &mut u64,
    interrupt: Interrupt<'_>,
    observe: Observer<'_>,
) -> Initial {
    if let Some(proof) = too_few_contacts(problem) {
        return Initial::Impossible(proof);
    }
    let mut search = Search {
        problem,
        mode,
        evaluator: GraspEvaluator::new(problem),
        hull: Evaluator::with_facet_limit(SEARCH_FACET_LIMIT),
        evaluation_limit: evaluation_limit.unwrap_or(u64::MAX),
        evaluations,
        interrupt,
        observe,
        any_fits: false,
    };
    for start in 0..STARTS {
        let mut stream = Stream::new(seed, Purpose::InitialGrasp, start);
        if let Err(end) = search.start(&mut stream) {
            return end;
        }
        if start == 0 {
            match prove_impossible(problem, interrupt) {
                Err(why) => return Initial::Stopped(why.into()),
                Ok(Some(proof)) => return Initial::Impossible(proof),
                Ok(None) => {}
            }
        }
    }
    if search.any_fits {
        Initial::NotFound
    } else {
        Initial::NoneFits
    }
}

struct Search<'a, 'o> {
    problem: &'a Problem,
    mode: InitialMode,
    evaluator: GraspEvaluator<'a>,
    hull: Evaluator,
    evaluation_limit: u64,
    evaluations: &'a mut u64,
    interrupt: Interrupt<'o>,
    observe: Observer<'o>,
    /// Whether any start had a grasp to try.
    any_fits: bool,
}

impl Search<'_, '_> {
    /// One random grasp and its repair; continues when it cannot be repaired.
    fn start(&mut self, stream: &mut Stream) -> Result<(), Initial> {
        let problem = self.problem;
        let Some(grasp) = random_grasp(problem, stream, self.interrupt)? else {
            return Ok(());
        };
        self.any_fits = true;
        self.accept(&grasp)?;
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
                Ok(None) | Err(_) => self.others(&rest, stream)?,
            };
            for candidate in chosen {
                let mut repaired = rest.clone();
                let place = repaired.partition_point(|&c| c < candidate);
                repaired.insert(place, candidate);
                self.accept(&repaired)?;
            }
        }
        Ok(())
    }

    /// Reports progress and checks the interrupt.
    fn report(&mut self) -> Result<(), Interrupted> {
        (self.observe)(&Progress {
            phase: Phase::Initial,
            generation: 0,
            evaluations: *self.evaluations,
            best: None,
            grasp: None,
            generation_ended: false,
        });
        self.interrupt.check()
    }

    /// Breaks with the grasp when it is force closure.
    fn accept(&mut self, grasp: &[u32]) -> Result<(), Initial> {
        self.report()?;
        if *self.evaluations >= self.evaluation_limit {
            return Err(Initial::Stopped(Stop::EvaluationLimit));
        }
        *self.evaluations += 1;
        match self.evaluator.epsilon(grasp) {
            Some(quality) => Err(Initial::Found {
                grasp: grasp.to_vec(),
                quality,
            }),
            None => Ok(()),
        }
    }

    /// Slots of the grasp, the contact nearest to the separating hyperplane first; ties at random.
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

    /// The candidates in the region χ that `normals` bound and that fit beside `rest`, ascending.
    /// Without normals there is no region. Most candidates fail on one of the first normals.
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

    /// The candidates that are accepted and fit beside `rest`, ascending, none of them in it. O(n) on the
    /// current rayon pool.
    fn scan(
        &mut self,
        rest: &[u32],
        accepts: impl Fn(&mut Vec<Wrench>, u32) -> bool + Sync,
    ) -> Result<Vec<u32>, Initial> {
        let (n, block) = (self.problem.len(), self.problem.block());
        let problem = self.problem;
        let fits = |wrenches: &mut Vec<Wrench>, candidate: u32| {
            let fits = accepts(wrenches, candidate)
                && rest.binary_search(&candidate).is_err()
                && problem.fits_beside(rest, candidate);
            fits.then_some(candidate)
        };
        let mut found: Vec<u32> = Vec::new();
        for from in (0..n).step_by(block) {
            self.report()?;
            let to = n.min(from + block);
            found.par_extend(
                (from as u32..to as u32)
                    .into_par_iter()
                    .with_min_len(512)
                    .map_init(Vec::new, &fits)
                    .flatten(),
            );
        }
        Ok(found)
    }

    /// Up to [`DIRECT_TRIES`] random candidates that fit beside `rest`, none of them in it.
    fn others(&mut self, rest: &[u32], stream: &mut Stream) -> Result<Vec<u32>, Initial> {
        let n = self.problem.len();
        let mut candidates = if self.problem.is_spaced() {
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

/// Of the first random grasps that [`initial_grasp`] tried, the one with the greatest margin: what
/// to show when there is no force closure. `None` when none of them fits or all are degenerate, or when
/// `interrupt`, which is checked before each of sixteen hulls, comes.
pub fn nearest_start(problem: &Problem, seed: u64, interrupt: Interrupt<'_>) -> Option<Grasp> {
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
