//! How far every site of a body reaches along some directions, at a few billion sites a second.
//!
//! Along u = (a, b) the wrench of a force f at a site p reaches f·v, where v = a + b × λ(p − c) is a force
//! too. So the cone of a site reaches l·(n·v + max t·v), t over what its edges have beside the normal n,
//! and nothing of six components is needed. Numbers are in single precision, sixteen sites side by side,
//! and everything that is kept of a site is an upper bound by what rounding may have taken.
//!
//! Sites are sorted along a space-filling curve, so that sixteen in a row are neighbours with similar normals:
//! one bound for all of them, again sixteen such bounds side by side, spares the look at most.

// Lanes of several rows are taken by one number.
#![allow(clippy::needless_range_loop)]

mod block;

use rayon::prelude::*;

use super::problem::Problem;
use crate::contact::{Cone, ContactModel};
use crate::interrupt::{Interrupt, Interrupted};
use crate::mesh::along_curve;
use crate::quality::lanes::{NullaryFnOnce, vectorized};
use crate::wrench::{STAND_IN_EDGES, Wrench, WrenchModel, WrenchSpace};
use block::{Block, Bounded, Cluster, Direction, Singles, WIDTH};

/// Rounding of a reach in single precision over the longest wrench: some twelve roundings of 2⁻²⁴ in three
/// components, twice that for safety.
const ROUNDING: f64 = 3e-6;

/// What the cone of a site has beside the normal.
#[derive(Debug, Clone)]
enum Spread {
    None,
    /// Pyramid and torsion: the greater of both. Edges are at the angles whose cosine and sine, times μ,
    /// are given; the others mirror them.
    Edges {
        edges: Vec<[f32; 2]>,
        /// Whether the mirror image of an edge across the second tangent is an edge too.
        even: bool,
        torsion: f32,
    },
    /// Circle or ellipsoid: μ and torsion.
    Round {
        friction: f32,
        torsion: f32,
    },
}

/// Blocks made between two checks of the interrupt: some milliseconds.
const BUILT: usize = 1 << 11;

/// Error of a distance from a centre in single precision, over the reach of a unit wrench.
const CENTRE_ROUNDING: f32 = 1e-5;

/// A direction that no grasp may lack: what the other fingers reach along it, and the wanted one has to.
#[derive(Debug, Clone, Copy)]
pub(super) struct Cut {
    pub direction: Wrench,
    /// What is added to the reach of a site: that of the others where the space is a sum, else zero.
    pub base: f64,
}

/// A site that may be good enough: its candidate, and a bound on what it allows.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Survivor {
    pub candidate: u32,
    /// Where it lies among the sites.
    place: u32,
    pub bound: f64,
    /// Whether the bound is in double precision.
    pub exact: bool,
}

/// All candidates of a problem, laid out for scans.
#[derive(Debug)]
pub(super) struct Sites {
    clusters: Vec<Cluster>,
    blocks: Vec<Block>,
    /// The candidate at each place.
    candidates: Vec<u32>,
    spread: Spread,
    /// μ, and μ_t λ: what bounds the spread of a whole block.
    friction: f32,
    torsion: f32,
    length: f32,
    /// Lowest reach that counts: zero where a finger may push with no force at all.
    floor: f32,
    /// Greatest error of a reach; bounds are raised by it.
    slack: f64,
}

impl Sites {
    /// O(n log n), some 100 ns a candidate, on the current rayon pool; `interrupt` is checked every few
    /// milliseconds.
    pub fn new(problem: &Problem, interrupt: Interrupt<'_>) -> Result<Self, Interrupted> {
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
        let greatest = problem
            .candidates()
            .iter()
            .map(|c| (c.position - model.center).norm() * model.torque_scale)
            .fold(0.0, f64::max);
        let (spread, length, friction, torsion) = spread(model);
        // The others' reach is rounded too where it is added.
        let added = 1.0 + problem.contacts() as f64 / 32.0;
        Ok(Self {
            clusters,
            blocks,
            candidates,
            spread,
            friction: friction as f32,
            torsion: torsion as f32,
            length: length as f32,
            floor: match model.space {
                WrenchSpace::L1 => f32::NEG_INFINITY,
                WrenchSpace::Linf => 0.0,
            },
            slack: ROUNDING * (1.0 + greatest) * length * (1.0 + friction + torsion) * added,
        })
    }

    /// No bound is below what the site reaches, and none above it by more than twice this.
    pub fn slack(&self) -> f64 {
        self.slack
    }

    /// The sites whose every bound exceeds `threshold`, by candidate.
    pub fn survivors(&self, cuts: &[Cut], threshold: f64, found: &mut Vec<Survivor>) {
        found.clear();
        vectorized(Scan {
            sites: self,
            cuts,
            threshold: threshold as f32,
            found,
        });
    }

    /// Lowers the bounds of some sites by one more cut and drops those that no longer exceed `threshold`.
    pub fn narrow(&self, cut: &Cut, threshold: f64, survivors: &mut Vec<Survivor>) {
        vectorized(Narrow {
            sites: self,
            cut,
            threshold: threshold as f32,
            survivors,
        });
    }

    #[inline(always)]
    fn raised(&self, reach: Singles, cut: &Direction) -> Singles {
        let (length, floor) = (self.length, self.floor);
        reach.map(|reach| {
            let reach = reach * length;
            cut.base + if reach > floor { reach } else { floor }
        })
    }

    fn direction(&self, cut: &Cut) -> Direction {
        let u = &cut.direction;
        Direction {
            parts: [
                [u[0] as f32, u[1] as f32, u[2] as f32],
                [u[3] as f32, u[4] as f32, u[5] as f32],
            ],
            torque: u.fixed_rows::<3>(3).norm() as f32,
            base: (cut.base + self.slack) as f32,
        }
    }
}

/// What the edges have beside the normal, their normal component, μ, and μ_t λ.
fn spread(model: &WrenchModel) -> (Spread, f64, f64, f64) {
    let (friction, torsion, cone) = match model.contact_model {
        ContactModel::Frictionless => return (Spread::None, 1.0, 0.0, 0.0),
        ContactModel::Hard { friction, cone } => (friction, 0.0, cone),
        ContactModel::Soft {
            friction,
            torsion,
            cone,
        } => (friction, torsion.get() * model.torque_scale, cone),
    };
    let length = model.edge_length(friction);
    let mu = friction.get();
    let spread = match cone {
        Cone::Round => Spread::Round {
            friction: mu as f32,
            torsion: torsion as f32,
        },
        Cone::Pyramid(_) => {
            let count = cone.edges().unwrap_or(STAND_IN_EDGES);
            let even = count.is_multiple_of(2);
            let last = if even { count / 4 } else { count / 2 };
            let edges = (0..=last).map(|j| {
                let (sin, cos) = (std::f64::consts::TAU * j as f64 / count as f64).sin_cos();
                [(mu * cos) as f32, (mu * sin) as f32]
            });
            Spread::Edges {
                edges: edges.collect(),
                even,
                torsion: torsion as f32,
            }
        }
    };
    (spread, length, mu, torsion)
}

struct Scan<'a> {
    sites: &'a Sites,
    cuts: &'a [Cut],
    threshold: f32,
    found: &'a mut Vec<Survivor>,
}

impl NullaryFnOnce for Scan<'_> {
    type Output = ();

    #[inline(always)]
    fn call(mut self) {
        let sites = self.sites;
        let cuts: Vec<Direction> = self.cuts.iter().map(|cut| sites.direction(cut)).collect();
        for (number, cluster) in sites.clusters.iter().enumerate() {
            let first = number * WIDTH;
            let least = least(sites, cluster, &cuts, self.threshold);
            for lane in 0..WIDTH.min(sites.blocks.len() - first) {
                if least.0[lane] > self.threshold {
                    self.look(first + lane, &cuts);
                }
            }
        }
    }
}

impl Scan<'_> {
    #[inline(always)]
    fn look(&mut self, number: usize, cuts: &[Direction]) {
        let sites = self.sites;
        let block = &sites.blocks[number];
        let least = least(sites, block, cuts, self.threshold);
        let first = number * WIDTH;
        for lane in 0..WIDTH.min(sites.candidates.len() - first) {
            if least.0[lane] > self.threshold {
                self.found.push(Survivor {
                    candidate: sites.candidates[first + lane],
                    place: (first + lane) as u32,
                    bound: f64::from(least.0[lane]),
                    exact: false,
                });
            }
        }
    }
}

/// The least of sixteen bounds each under all cuts, or under those until none exceeds the threshold.
#[inline(always)]
fn least(sites: &Sites, bounded: &impl Bounded, cuts: &[Direction], threshold: f32) -> Singles {
    let mut least = Singles::splat(f32::INFINITY);
    for cut in cuts {
        least = least.zip(
            &bounded.bounds(sites, cut),
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

struct Narrow<'a> {
    sites: &'a Sites,
    cut: &'a Cut,
    threshold: f32,
    survivors: &'a mut Vec<Survivor>,
}

impl NullaryFnOnce for Narrow<'_> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let sites = self.sites;
        let cut = sites.direction(self.cut);
        let mut kept = 0;
        let mut next = 0;
        while next < self.survivors.len() {
            let number = self.survivors[next].place as usize / WIDTH;
            let bounds = sites.blocks[number].bounds(sites, &cut);
            while let Some(&survivor) = self.survivors.get(next)
                && survivor.place as usize / WIDTH == number
            {
                next += 1;
                let bound =
                    f64::from(bounds.0[survivor.place as usize % WIDTH]).min(survivor.bound);
                self.survivors[kept] = Survivor { bound, ..survivor };
                kept += usize::from(bound > f64::from(self.threshold));
            }
        }
        self.survivors.truncate(kept);
    }
}
