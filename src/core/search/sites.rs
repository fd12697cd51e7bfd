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

use rayon::prelude::*;

use super::problem::Problem;
use crate::core::contact::{Cone, Contact, ContactModel};
use crate::core::mesh::Candidate;
use crate::core::quality::lanes::{NullaryFnOnce, vectorized};
use crate::core::wrench::{STAND_IN_EDGES, Wrench, WrenchModel, WrenchSpace};

/// How many sites are looked at side by side.
const WIDTH: usize = 16;

/// Rounding of a reach in single precision over the longest wrench: some twelve roundings of 2⁻²⁴ in three
/// components, twice that for safety.
const ROUNDING: f64 = 3e-6;

#[derive(Debug, Clone, Copy)]
#[repr(align(64))]
struct Singles([f32; WIDTH]);

impl Singles {
    #[inline(always)]
    fn splat(value: f32) -> Self {
        Self([value; WIDTH])
    }

    #[inline(always)]
    fn zip(mut self, other: &Self, f: impl Fn(f32, f32) -> f32) -> Self {
        for lane in 0..WIDTH {
            self.0[lane] = f(self.0[lane], other.0[lane]);
        }
        self
    }

    #[inline(always)]
    fn map(mut self, f: impl Fn(f32) -> f32) -> Self {
        for lane in 0..WIDTH {
            self.0[lane] = f(self.0[lane]);
        }
        self
    }

    #[inline(always)]
    fn plus(self, other: &Self) -> Self {
        self.zip(other, |a, b| a + b)
    }

    #[inline(always)]
    fn greater(self, other: &Self) -> Self {
        self.zip(other, |a, b| if a > b { a } else { b })
    }
}

#[inline(always)]
fn dot(a: &[Singles; 3], b: &[Singles; 3]) -> Singles {
    let product = |axis: usize| a[axis].zip(&b[axis], |x, y| x * y);
    product(0).plus(&product(1)).plus(&product(2))
}

/// Sixteen sites.
#[derive(Debug, Clone, Copy)]
struct Block {
    /// λ(p − c).
    lever: [Singles; 3],
    normal: [Singles; 3],
    /// The first two edges of the cone lie over these, from the normal.
    tangents: [[Singles; 3]; 2],
}

/// Sixteen blocks, by a ball around the levers of each and one around its normals.
#[derive(Debug, Clone, Copy)]
struct Cluster {
    lever: [Singles; 3],
    normal: [Singles; 3],
    lever_radius: Singles,
    normal_radius: Singles,
}

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
    /// O(n log n), some 100 ns a candidate, on the current rayon pool.
    pub fn new(problem: &Problem) -> Self {
        let model = problem.model();
        let candidates = along_curve(problem.candidates());
        let blocks: Vec<Block> = candidates
            .par_chunks(WIDTH)
            .map(|chunk| Block::new(problem, chunk))
            .collect();
        let clusters = blocks.par_chunks(WIDTH).map(Cluster::new).collect();
        let greatest = problem
            .candidates()
            .iter()
            .map(|c| (c.position - model.center).norm() * model.torque_scale)
            .fold(0.0, f64::max);
        let (spread, length, friction, torsion) = spread(model);
        // The others' reach is rounded too where it is added.
        let added = 1.0 + problem.contacts() as f64 / 32.0;
        Self {
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
        }
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

/// Sixteen things side by side whose reach has a bound.
trait Bounded {
    /// The bounds under one cut.
    fn bounds(&self, sites: &Sites, cut: &Direction) -> Singles;
}

impl Bounded for Block {
    /// Of sixteen sites.
    #[inline(always)]
    fn bounds(&self, sites: &Sites, cut: &Direction) -> Singles {
        let b = &cut.parts[1];
        let force = force(&self.lever, cut);
        let along = dot(&self.normal, &force);
        let reach = match &sites.spread {
            Spread::None => along,
            Spread::Edges {
                edges,
                even,
                torsion,
            } => {
                let mut x = dot(&self.tangents[0], &force);
                let y = dot(&self.tangents[1], &force).map(f32::abs);
                if *even {
                    x = x.map(f32::abs);
                }
                let mut most = Singles::splat(f32::NEG_INFINITY);
                for &[cos, sin] in edges {
                    most = most.greater(&x.zip(&y, |x, y| x * cos + y * sin));
                }
                if *torsion > 0.0 {
                    most = most.greater(&self.twist(b, *torsion).map(f32::abs));
                }
                along.plus(&most)
            }
            Spread::Round { friction, torsion } => {
                let x = dot(&self.tangents[0], &force);
                let y = dot(&self.tangents[1], &force);
                let mut squared = x.zip(&y, |x, y| (x * x + y * y) * (friction * friction));
                if *torsion > 0.0 {
                    squared = squared.zip(&self.twist(b, *torsion), |s, t| s + t * t);
                }
                along.plus(&squared.map(f32::sqrt))
            }
        };
        sites.raised(reach, cut)
    }
}

impl Block {
    /// What the greatest torques about the normals reach.
    #[inline(always)]
    fn twist(&self, b: &[f32; 3], torsion: f32) -> Singles {
        let b = b.map(|x| Singles::splat(x * torsion));
        dot(&self.normal, &b)
    }
}

impl Bounded for Cluster {
    /// Of all sites of each of sixteen blocks. n·v + μ·|v across n| changes by no more than √(1 + μ²) times
    /// what v changes by, and |v| times what n changes by.
    #[inline(always)]
    fn bounds(&self, sites: &Sites, cut: &Direction) -> Singles {
        let force = force(&self.lever, cut);
        let along = dot(&self.normal, &force);
        let squared = dot(&force, &force);
        let across = squared.zip(&along, |s, a| {
            let rest = s - a * a;
            if rest > 0.0 { rest.sqrt() } else { 0.0 }
        });
        let steep = (1.0 + sites.friction * sites.friction).sqrt();
        let lever = self.lever_radius.map(|radius| radius * cut.torque);
        let normal = squared.zip(&self.normal_radius, |s, radius| s.sqrt() * radius);
        let reach = along.zip(&across, |along, across| along + sites.friction * across);
        let twist = sites.torsion * cut.torque + CENTRE_ROUNDING;
        let wide = lever.plus(&normal).map(|x| x * steep + twist);
        sites.raised(reach.plus(&wide), cut)
    }
}

/// A cut in single precision: the force part, then the torque part.
struct Direction {
    parts: [[f32; 3]; 2],
    /// Length of the torque part.
    torque: f32,
    base: f32,
}

/// v = a + b × λ(p − c).
#[inline(always)]
fn force(lever: &[Singles; 3], cut: &Direction) -> [Singles; 3] {
    let [a, b] = &cut.parts;
    let product = |i: usize, j: usize| lever[j].map(|x| x * b[i]);
    let cross = |i: usize, j: usize| product(i, j).zip(&product(j, i), |x, y| x - y);
    let force = [cross(1, 2), cross(2, 0), cross(0, 1)];
    std::array::from_fn(|axis| force[axis].map(|x| x + a[axis]))
}

/// The candidates in the order of their positions along a Z-order curve (Morton 1966) with 2¹⁰ steps an axis.
fn along_curve(candidates: &[Candidate]) -> Vec<u32> {
    const STEPS: f64 = 1023.0;
    let mut low = [f64::INFINITY; 3];
    let mut high = [f64::NEG_INFINITY; 3];
    for candidate in candidates {
        for axis in 0..3 {
            low[axis] = low[axis].min(candidate.position[axis]);
            high[axis] = high[axis].max(candidate.position[axis]);
        }
    }
    let code = |candidate: &Candidate| {
        (0..3).fold(0_u64, |code, axis| {
            let share = (candidate.position[axis] - low[axis]) / (high[axis] - low[axis]);
            // The cast takes no number for zero.
            code | spaced((share * STEPS) as u64) << axis
        })
    };
    let mut order: Vec<(u64, u32)> = candidates
        .par_iter()
        .zip(0..candidates.len() as u32)
        .map(|(candidate, i)| (code(candidate), i))
        .collect();
    order.par_sort_unstable();
    order.into_iter().map(|(_, i)| i).collect()
}

/// Ten bits with two zeros after each.
fn spaced(bits: u64) -> u64 {
    (0..10).fold(0, |spaced, bit| spaced | (bits >> bit & 1) << (3 * bit))
}

impl Block {
    fn new(problem: &Problem, candidates: &[u32]) -> Self {
        let model = problem.model();
        let mut block = Self {
            lever: [Singles::splat(0.0); 3],
            normal: [Singles::splat(0.0); 3],
            tangents: [[Singles::splat(0.0); 3]; 2],
        };
        for lane in 0..WIDTH {
            // The last block is filled up with its first site.
            let candidate = candidates.get(lane).unwrap_or(&candidates[0]);
            let contact = Contact::from(problem.candidate(*candidate));
            let lever = (contact.position - model.center) * model.torque_scale;
            let (t1, t2) = model.tangents(&contact);
            for axis in 0..3 {
                block.lever[axis].0[lane] = lever[axis] as f32;
                block.normal[axis].0[lane] = contact.normal[axis] as f32;
                block.tangents[0][axis].0[lane] = t1[axis] as f32;
                block.tangents[1][axis].0[lane] = t2[axis] as f32;
            }
        }
        block
    }
}

impl Cluster {
    fn new(blocks: &[Block]) -> Self {
        let mut cluster = Self {
            lever: [Singles::splat(0.0); 3],
            normal: [Singles::splat(0.0); 3],
            lever_radius: Singles::splat(0.0),
            normal_radius: Singles::splat(0.0),
        };
        for (lane, block) in blocks.iter().enumerate() {
            let lever = middle(&block.lever);
            let mut normal = middle(&block.normal);
            let length = normal.iter().map(|x| x * x).sum::<f32>().sqrt();
            if length > 0.0 {
                normal = normal.map(|x| x / length);
            }
            for axis in 0..3 {
                cluster.lever[axis].0[lane] = lever[axis];
                cluster.normal[axis].0[lane] = normal[axis];
            }
            cluster.lever_radius.0[lane] = radius(&block.lever, &lever);
            cluster.normal_radius.0[lane] = radius(&block.normal, &normal);
        }
        cluster
    }
}

/// The mean of sixteen points.
fn middle(points: &[Singles; 3]) -> [f32; 3] {
    std::array::from_fn(|axis| points[axis].0.iter().sum::<f32>() / WIDTH as f32)
}

/// Greatest distance of sixteen points from one.
fn radius(points: &[Singles; 3], center: &[f32; 3]) -> f32 {
    (0..WIDTH)
        .map(|lane| {
            (0..3)
                .map(|axis| (points[axis].0[lane] - center[axis]).powi(2))
                .sum::<f32>()
        })
        .fold(0.0, f32::max)
        .sqrt()
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
