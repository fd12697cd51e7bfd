//! Bounds on all candidates of a body at once, a few billion bounds a second.
//!
//! An [exchange](super::exchange) asks again and again which candidates reach far enough along some directions. Three
//! things make the answer cheap.
//!
//! - *Three components instead of six.* Along u = (a, b) the wrench of a force f at a candidate p reaches f·v, where
//!   v = a + b × λ(p − c) is a force too. So the cone of a candidate reaches l·(n·v + max t·v), over the tangential
//!   parts t of its edges, with l the normal component of an edge and n the normal.
//! - *Single precision, sixteen candidates side by side.* Everything that is kept of a candidate is an upper bound:
//!   it is raised by the greatest error that rounding may cause, the [slack](CandidateScan::slack).
//! - *Blocks and clusters.* Candidates are sorted along a space-filling curve, so sixteen in a row, a block, are
//!   neighbours with similar normals. One bound for a whole block, sixteen of them side by side in a cluster, spares
//!   most blocks.
//!
//! ```text
//! for each cluster
//!     bounds of its sixteen blocks under all half-spaces
//!     for each block whose least bound exceeds the threshold
//!         bounds of its sixteen candidates under all half-spaces
//!         keep the candidates whose least bound exceeds the threshold
//! ```
//!
//! No bound is below the reach of its candidate, so no candidate that is good enough is lost. The layout costs
//! O(n log n), some 100 ns a candidate, and 64 bytes; a pass reads all clusters, a sixteenth of that, and the blocks
//! that survive.

// Lanes of several rows share one index.
#![allow(clippy::needless_range_loop)]

mod block;
mod lanes;
mod reach;

use rayon::prelude::*;

use super::problem::SearchProblem;
use crate::interrupt::{Interrupt, Interrupted};
use crate::mesh::along_curve;
use crate::quality::lanes::{NullaryFnOnce, vectorized};
use crate::wrench::Wrench;
use block::{Block, Bounded, Cluster, Direction};
use lanes::{Singles, WIDTH};
use reach::ReachModel;

/// Blocks made between two checks of the interrupt: some milliseconds.
const BUILT: usize = 1 << 11;

/// A bound on the grasps that have one finger missing: ε with a candidate in its place is at most `base` and the reach
/// of the candidate along the direction.
#[derive(Debug, Clone, Copy)]
pub(super) struct HalfSpace {
    pub direction: Wrench,
    /// The reach of the other fingers in L∞, where reaches are added; zero in L1.
    pub base: f64,
}

/// A candidate that may be good enough, and a bound on ε with it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Survivor {
    pub candidate: u32,
    /// Its place in the order of the scan.
    index: u32,
    pub bound: f64,
    /// Whether the bound is in double precision.
    pub exact: bool,
}

/// All candidates of a problem, laid out for scans.
#[derive(Debug)]
pub(super) struct CandidateScan {
    clusters: Vec<Cluster>,
    blocks: Vec<Block>,
    /// The candidates in the order of the scan.
    candidates: Vec<u32>,
    model: ReachModel,
}

impl CandidateScan {
    /// Lays out the candidates on the current rayon pool; `interrupt` is checked every few milliseconds.
    pub fn new(problem: &SearchProblem, interrupt: Interrupt<'_>) -> Result<Self, Interrupted> {
        let model = problem.model();
        let position = |i: usize| problem.candidates()[i].position;
        let candidates = along_curve(problem.len(), position, interrupt)?;
        let mut blocks: Vec<Block> = Vec::with_capacity(problem.len().div_ceil(WIDTH));
        for part in candidates.chunks(BUILT * WIDTH) {
            interrupt.check()?;
            let part = part.par_chunks(WIDTH);
            blocks.par_extend(part.map(|chunk| Block::new(problem, chunk)));
        }
        interrupt.check()?;
        let clusters = blocks.par_chunks(WIDTH).map(Cluster::new).collect();
        let longest_lever = problem
            .candidates()
            .iter()
            .map(|c| (c.position - model.center).norm() * model.torque_scale)
            .fold(0.0, f64::max);
        Ok(Self {
            clusters,
            blocks,
            candidates,
            model: ReachModel::new(model, longest_lever, problem.contacts()),
        })
    }

    /// Returns the greatest error of a reach. No bound is below the reach of its candidate, and none above it by more
    /// than twice this.
    pub fn slack(&self) -> f64 {
        self.model.slack
    }

    /// Finds the candidates whose every bound exceeds `threshold`.
    pub fn survivors(&self, half_spaces: &[HalfSpace], threshold: f64, found: &mut Vec<Survivor>) {
        found.clear();
        vectorized(FindSurvivors {
            scan: self,
            half_spaces,
            threshold: threshold as f32,
            found,
        });
    }

    /// Lowers the bounds of survivors by one more half-space, and drops those that no longer exceed `threshold`.
    pub fn narrow(&self, half_space: &HalfSpace, threshold: f64, survivors: &mut Vec<Survivor>) {
        vectorized(Narrow {
            scan: self,
            half_space,
            threshold: threshold as f32,
            survivors,
        });
    }

    /// Rounds a half-space to single precision, raised by the slack.
    fn direction(&self, half_space: &HalfSpace) -> Direction {
        let u = &half_space.direction;
        Direction {
            parts: [
                [u[0] as f32, u[1] as f32, u[2] as f32],
                [u[3] as f32, u[4] as f32, u[5] as f32],
            ],
            torque: u.fixed_rows::<3>(3).norm() as f32,
            base: (half_space.base + self.slack()) as f32,
        }
    }
}

/// A pass over all candidates.
struct FindSurvivors<'a> {
    scan: &'a CandidateScan,
    half_spaces: &'a [HalfSpace],
    threshold: f32,
    found: &'a mut Vec<Survivor>,
}

impl NullaryFnOnce for FindSurvivors<'_> {
    type Output = ();

    #[inline(always)]
    fn call(mut self) {
        let scan = self.scan;
        let half_spaces = self.half_spaces.iter();
        let directions: Vec<Direction> = half_spaces.map(|h| scan.direction(h)).collect();
        for (number, cluster) in scan.clusters.iter().enumerate() {
            let first = number * WIDTH;
            let least = least(&scan.model, cluster, &directions, self.threshold);
            for lane in 0..WIDTH.min(scan.blocks.len() - first) {
                if least.0[lane] > self.threshold {
                    self.look_into(first + lane, &directions);
                }
            }
        }
    }
}

impl FindSurvivors<'_> {
    /// Looks for survivors in one block.
    #[inline(always)]
    fn look_into(&mut self, number: usize, directions: &[Direction]) {
        let scan = self.scan;
        let block = &scan.blocks[number];
        let least = least(&scan.model, block, directions, self.threshold);
        let first = number * WIDTH;
        for lane in 0..WIDTH.min(scan.candidates.len() - first) {
            if least.0[lane] > self.threshold {
                self.found.push(Survivor {
                    candidate: scan.candidates[first + lane],
                    index: (first + lane) as u32,
                    bound: f64::from(least.0[lane]),
                    exact: false,
                });
            }
        }
    }
}

/// Returns the least of sixteen bounds each along all directions, or along the first so many that none exceeds the
/// threshold any more.
#[inline(always)]
fn least(
    model: &ReachModel,
    bounded: &impl Bounded,
    directions: &[Direction],
    threshold: f32,
) -> Singles {
    let mut least = Singles::splat(f32::INFINITY);
    for direction in directions {
        least = least.zip(
            &bounded.bounds(model, direction),
            |a, b| if b < a { b } else { a },
        );
        let mut alive = false;
        for lane in 0..WIDTH {
            alive |= least.0[lane] > threshold;
        }
        if !alive {
            break;
        }
    }
    least
}

/// A pass over some survivors.
struct Narrow<'a> {
    scan: &'a CandidateScan,
    half_space: &'a HalfSpace,
    threshold: f32,
    survivors: &'a mut Vec<Survivor>,
}

impl NullaryFnOnce for Narrow<'_> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let scan = self.scan;
        let direction = scan.direction(self.half_space);
        let mut kept = 0;
        let mut next = 0;
        // Survivors are in the order of the scan, so those of one block follow each other.
        while next < self.survivors.len() {
            let number = self.survivors[next].index as usize / WIDTH;
            let bounds = scan.blocks[number].bounds(&scan.model, &direction);
            while let Some(&survivor) = self.survivors.get(next)
                && survivor.index as usize / WIDTH == number
            {
                next += 1;
                let bound =
                    f64::from(bounds.0[survivor.index as usize % WIDTH]).min(survivor.bound);
                self.survivors[kept] = Survivor { bound, ..survivor };
                kept += usize::from(bound > f64::from(self.threshold));
            }
        }
        self.survivors.truncate(kept);
    }
}
