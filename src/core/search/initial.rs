//! A first force-closure grasp: Roa & Suárez, Algorithm 1 (paper, §3.2).

use std::ops::ControlFlow;

use rayon::prelude::*;

use super::impossible::{Impossible, prove_impossible, too_few_contacts};
use super::problem::{Grasp, GraspEvaluator, Problem};
use super::progress::{Observer, Phase, Progress, Stop};
use super::random::{Purpose, Stream};
use crate::core::quality::{Degenerate, Evaluator, Margin};
use crate::core::wrench::Wrench;

/// Which candidates may replace a contact.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
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
    Impossible(Impossible),
    Stopped(Stop),
}

/// Finds a force-closure grasp, and adds the quality evaluations made to `evaluations`.
///
/// A random grasp that is not force closure has one contact replaced: the supporting hyperplanes,
/// at the origin, of the hull of the origin and the other contacts' wrenches bound a region χ on
/// their far side, and any candidate with a wrench in χ closes the grasp. Contacts nearest to the
/// facet that separates the origin from the hull are replaced first; when χ is empty for all of
/// them the search starts over, a hundred times at most. After the first failure it is checked
/// whether any grasp can exist at all. Each region costs one hull and one pass over the candidates.
pub fn initial_grasp(
    problem: &Problem,
    mode: InitialMode,
    seed: u64,
    evaluations: &mut u64,
    observe: Observer<'_>,
) -> Initial {
    if let Some(proof) = too_few_contacts(problem) {
        return Initial::Impossible(proof);
    }
    let mut search = Search {
        problem,
        mode,
        evaluator: GraspEvaluator::new(problem),
        hull: Evaluator::new(),
        evaluations,
        observe,
    };
    for start in 0..STARTS {
        let mut stream = Stream::new(seed, Purpose::InitialGrasp, start);
        match search.start(&mut stream) {
            ControlFlow::Break(end) => return end,
            ControlFlow::Continue(()) => {}
        }
        if start == 0
            && let Some(proof) = prove_impossible(problem, seed)
        {
            return Initial::Impossible(proof);
        }
    }
    Initial::NotFound
}

struct Search<'a, 'o> {
    problem: &'a Problem,
    mode: InitialMode,
    evaluator: GraspEvaluator<'a>,
    hull: Evaluator,
    evaluations: &'a mut u64,
    observe: Observer<'o>,
}

impl Search<'_, '_> {
    /// One random grasp and its repair; continues when it cannot be repaired.
    fn start(&mut self, stream: &mut Stream) -> ControlFlow<Initial> {
        let problem = self.problem;
        let grasp = stream.subset(problem.len(), problem.contacts());
        self.poll()?;
        self.accept(&grasp)?;
        let separating = match self.evaluator.quality(&grasp) {
            Ok(margin) => margin.direction,
            Err(Degenerate { direction, .. }) => direction,
        };
        for slot in self.replacement_order(&grasp, &separating, stream) {
            self.poll()?;
            let mut rest = grasp.clone();
            rest.remove(slot);
            let wrenches = problem.wrenches(&rest);
            let chosen = match self.hull.supporting_normals(&wrenches) {
                Ok(normals) => {
                    let mut region = region(problem, self.mode, &normals, &rest);
                    stream.shuffle(&mut region);
                    region.truncate(PICKS);
                    region
                }
                Err(_) => self.others(&rest, stream, DIRECT_TRIES),
            };
            for candidate in chosen {
                let mut repaired = rest.clone();
                let place = repaired.partition_point(|&c| c < candidate);
                repaired.insert(place, candidate);
                self.accept(&repaired)?;
            }
        }
        ControlFlow::Continue(())
    }

    fn poll(&mut self) -> ControlFlow<Initial> {
        let progress = Progress {
            phase: Phase::Initial,
            generation: 0,
            evaluations: *self.evaluations,
            best: None,
            generation_ended: false,
        };
        (self.observe)(&progress).map_break(Initial::Stopped)
    }

    /// Breaks with the grasp when it is force closure.
    fn accept(&mut self, grasp: &[u32]) -> ControlFlow<Initial> {
        *self.evaluations += 1;
        match self.evaluator.epsilon(grasp) {
            Some(quality) => ControlFlow::Break(Initial::Found {
                grasp: grasp.to_vec(),
                quality,
            }),
            None => ControlFlow::Continue(()),
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
            let wrenches = self.problem.wrenches(&grasp[slot..=slot]);
            wrenches
                .iter()
                .map(|w| w.dot(separating))
                .fold(f64::NEG_INFINITY, f64::max)
        };
        let heights: Vec<f64> = (0..grasp.len()).map(height).collect();
        order.sort_by(|&a, &b| heights[b].total_cmp(&heights[a]));
        order
    }

    /// Up to `most` random candidates that are not in `rest`.
    fn others(&self, rest: &[u32], stream: &mut Stream, most: usize) -> Vec<u32> {
        let n = self.problem.len();
        let mut candidates = stream.subset(n, most.min(n));
        candidates.retain(|c| rest.binary_search(c).is_err());
        stream.shuffle(&mut candidates);
        candidates
    }
}

/// The candidates in the region χ that `normals` bound, ascending, none of them in `rest`. Without
/// normals there is no region. O(n) on the current rayon pool; most candidates fail on one of the
/// first normals.
fn region(problem: &Problem, mode: InitialMode, normals: &[Wrench], rest: &[u32]) -> Vec<u32> {
    if normals.is_empty() {
        return Vec::new();
    }
    let in_region = |w: &Wrench| normals.iter().all(|normal| normal.dot(w) > 0.0);
    (0..problem.len() as u32)
        .into_par_iter()
        .with_min_len(512)
        .map_init(Vec::new, |wrenches, candidate| {
            wrenches.clear();
            problem.push_wrenches(candidate, wrenches);
            let fits = match mode {
                InitialMode::Weak => wrenches.iter().any(in_region),
                InitialMode::Strict => wrenches.iter().all(in_region),
            };
            (fits && rest.binary_search(&candidate).is_err()).then_some(candidate)
        })
        .flatten()
        .collect()
}

/// Of the first random starts that [`initial_grasp`] made, the grasp with the greatest margin: what
/// to show when there is no force closure. `None` when all of them are degenerate. Builds
/// sixteen whole hulls.
pub fn nearest_start(problem: &Problem, seed: u64) -> Option<(Grasp, Margin)> {
    (0..SHOWN_STARTS)
        .into_par_iter()
        .filter_map(|start| {
            let mut stream = Stream::new(seed, Purpose::InitialGrasp, start);
            let grasp = stream.subset(problem.len(), problem.contacts());
            let margin = Evaluator::new().margin(&problem.wrenches(&grasp)).ok()?;
            Some((grasp, margin))
        })
        .collect::<Vec<_>>()
        .into_iter()
        .rev()
        .max_by(|(_, a), (_, b)| a.value.total_cmp(&b.value))
}
