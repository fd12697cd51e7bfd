//! Sixteen sites side by side, sixteen blocks of them, and bounds on how far they reach.

// Lanes of several rows are taken by one number.
#![allow(clippy::needless_range_loop)]

use super::{CENTRE_ROUNDING, Problem, Sites, Spread};
use crate::contact::Contact;

/// How many sites are looked at side by side.
pub(super) const WIDTH: usize = 16;

#[derive(Debug, Clone, Copy)]
#[repr(align(64))]
pub(super) struct Singles(pub [f32; WIDTH]);

impl Singles {
    #[inline(always)]
    pub fn splat(value: f32) -> Self {
        Self([value; WIDTH])
    }

    #[inline(always)]
    pub fn zip(mut self, other: &Self, f: impl Fn(f32, f32) -> f32) -> Self {
        for lane in 0..WIDTH {
            self.0[lane] = f(self.0[lane], other.0[lane]);
        }
        self
    }

    #[inline(always)]
    pub fn map(mut self, f: impl Fn(f32) -> f32) -> Self {
        for lane in 0..WIDTH {
            self.0[lane] = f(self.0[lane]);
        }
        self
    }

    #[inline(always)]
    pub fn plus(self, other: &Self) -> Self {
        self.zip(other, |a, b| a + b)
    }

    #[inline(always)]
    pub fn greater(self, other: &Self) -> Self {
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
pub(super) struct Block {
    /// λ(p − c).
    lever: [Singles; 3],
    normal: [Singles; 3],
    /// The first two edges of the cone lie over these, from the normal.
    tangents: [[Singles; 3]; 2],
}

/// Sixteen blocks, by a ball around the levers of each and one around its normals.
#[derive(Debug, Clone, Copy)]
pub(super) struct Cluster {
    lever: [Singles; 3],
    normal: [Singles; 3],
    lever_radius: Singles,
    normal_radius: Singles,
}

/// A cut in single precision: the force part, then the torque part.
pub(super) struct Direction {
    pub parts: [[f32; 3]; 2],
    /// Length of the torque part.
    pub torque: f32,
    pub base: f32,
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

impl Block {
    pub fn new(problem: &Problem, candidates: &[u32]) -> Self {
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

/// Sixteen things side by side whose reach has a bound.
pub(super) trait Bounded {
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
