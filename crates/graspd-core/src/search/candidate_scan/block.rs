//! Sixteen candidates side by side, sixteen blocks of them, and bounds on how far they reach.

// Lanes of several rows share one index.
#![allow(clippy::needless_range_loop)]

use super::lanes::{Singles, WIDTH, dot};
use super::reach::{ReachModel, Tangential};
use crate::contact::Contact;
use crate::search::problem::SearchProblem;

/// Error of a distance from a centre in single precision, over the reach of a unit wrench.
const CENTRE_ROUNDING: f32 = 1e-5;

/// Sixteen candidates.
#[derive(Debug, Clone, Copy)]
pub(super) struct Block {
    /// λ(p − c).
    lever: [Singles; 3],
    normal: [Singles; 3],
    /// The first edge of the cone leans towards the first of these; the second is across it.
    tangents: [[Singles; 3]; 2],
}

/// Sixteen blocks: for each a ball around its levers and one around its normals.
#[derive(Debug, Clone, Copy)]
pub(super) struct Cluster {
    lever: [Singles; 3],
    normal: [Singles; 3],
    lever_radius: Singles,
    normal_radius: Singles,
}

/// A half-space in single precision.
pub(super) struct Direction {
    /// The force part of the direction, then the torque part.
    pub parts: [[f32; 3]; 2],
    /// Length of the torque part.
    pub torque: f32,
    /// What is added to the reach of a candidate.
    pub base: f32,
}

/// Returns v = a + b × λ(p − c), the direction of a force at p that has the reach of (a, b).
#[inline(always)]
fn force(lever: &[Singles; 3], direction: &Direction) -> [Singles; 3] {
    let [a, b] = &direction.parts;
    let product = |i: usize, j: usize| lever[j].map(|x| x * b[i]);
    let cross = |i: usize, j: usize| product(i, j).zip(&product(j, i), |x, y| x - y);
    let force = [cross(1, 2), cross(2, 0), cross(0, 1)];
    std::array::from_fn(|axis| force[axis].map(|x| x + a[axis]))
}

impl Block {
    pub fn new(problem: &SearchProblem, candidates: &[u32]) -> Self {
        let model = problem.model();
        let mut block = Self {
            lever: [Singles::splat(0.0); 3],
            normal: [Singles::splat(0.0); 3],
            tangents: [[Singles::splat(0.0); 3]; 2],
        };
        for lane in 0..WIDTH {
            // The last block is filled up with its first candidate.
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
    pub fn new(blocks: &[Block]) -> Self {
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

/// Returns the mean of sixteen points.
fn middle(points: &[Singles; 3]) -> [f32; 3] {
    std::array::from_fn(|axis| points[axis].0.iter().sum::<f32>() / WIDTH as f32)
}

/// Returns the greatest distance of sixteen points from one.
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

/// Sixteen things side by side whose reach has a bound.
pub(super) trait Bounded {
    /// Returns upper bounds on the reach along one direction.
    fn bounds(&self, model: &ReachModel, direction: &Direction) -> Singles;
}

impl Bounded for Block {
    /// Bounds sixteen candidates.
    #[inline(always)]
    fn bounds(&self, model: &ReachModel, direction: &Direction) -> Singles {
        let b = &direction.parts[1];
        let force = force(&self.lever, direction);
        let along = dot(&self.normal, &force);
        let reach = match &model.tangential {
            Tangential::None => along,
            Tangential::Edges {
                edges,
                even,
                torsion,
            } => {
                let mut x = dot(&self.tangents[0], &force);
                let y = dot(&self.tangents[1], &force).map(f32::abs);
                // Of an even pyramid one quarter is enough, of an odd one half.
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
            Tangential::Round { friction, torsion } => {
                let x = dot(&self.tangents[0], &force);
                let y = dot(&self.tangents[1], &force);
                let mut squared = x.zip(&y, |x, y| (x * x + y * y) * (friction * friction));
                if *torsion > 0.0 {
                    squared = squared.zip(&self.twist(b, *torsion), |s, t| s + t * t);
                }
                along.plus(&squared.map(f32::sqrt))
            }
        };
        model.raised(reach, direction.base)
    }
}

impl Block {
    /// Returns the reach of the greatest torques about the normals.
    #[inline(always)]
    fn twist(&self, b: &[f32; 3], torsion: f32) -> Singles {
        let b = b.map(|x| Singles::splat(x * torsion));
        dot(&self.normal, &b)
    }
}

impl Bounded for Cluster {
    /// Bounds all candidates of each of sixteen blocks. n·v + μ·|v across n| changes by no more than √(1 + μ²) times
    /// the change of v, and √(1 + μ²)·|v| times the change of n. Within a block v differs from that of the centre by
    /// at most the radius of the levers times |b|, and n by the radius of the normals.
    #[inline(always)]
    fn bounds(&self, model: &ReachModel, direction: &Direction) -> Singles {
        let force = force(&self.lever, direction);
        let along = dot(&self.normal, &force);
        let squared = dot(&force, &force);
        let across = squared.zip(&along, |s, a| {
            let rest = s - a * a;
            if rest > 0.0 { rest.sqrt() } else { 0.0 }
        });
        let steep = (1.0 + model.friction * model.friction).sqrt();
        let lever = self.lever_radius.map(|radius| radius * direction.torque);
        let normal = squared.zip(&self.normal_radius, |s, radius| s.sqrt() * radius);
        let reach = along.zip(&across, |along, across| along + model.friction * across);
        let twist = model.torsion * direction.torque + CENTRE_ROUNDING;
        let wide = lever.plus(&normal).map(|x| x * steep + twist);
        model.raised(reach.plus(&wide), direction.base)
    }
}
