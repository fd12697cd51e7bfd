//! A convex polytope that grows by one vertex at a time.
//!
//! It is simplicial: every facet has six vertices and six neighbours. A new vertex replaces the
//! facets that it lies beyond by the cone of itself over their rim. Nothing is solved for: each
//! hyperplane through a ridge of the rim is a combination of those of the two facets that meet
//! there, and each new facet finds its neighbours by walking around the ridges of the old ones.
//!
//! # Why rounding cannot break it
//!
//! The facets always form a closed surface, whatever rounding makes of their planes: which facets
//! are replaced is decided once per facet, and any set of facets has a closed rim. If the surface
//! winds once around the origin before an insertion, and each replaced facet has the origin on its
//! inner and the new vertex on its outer side, then the simplices between old and new surface do not
//! contain the origin and the new surface winds once around it too. A ball around the origin that no
//! facet enters lies then inside the surface, so inside the convex hull of its vertices. The least
//! facet offset is therefore a lower bound on ε even where coplanar facets are not quite convex.

// Lanes of several rows are taken by one number.
#![allow(clippy::needless_range_loop)]

use std::cmp::Ordering;
use std::collections::BinaryHeap;

use nalgebra::Matrix6;

use super::Wrench;
use super::affine::Span;
use super::lanes::Lanes;

/// Error of a plane, relative to the scale, from which on it is solved anew from its vertices. A
/// tenth of [`super::COPLANAR_TOLERANCE`].
const PLANE_ERROR_LIMIT: f64 = 1e-13;

/// What one combination of two planes adds to the error: a few units of 2⁻⁵².
const STEP_ERROR: f64 = 1e-15;

/// Takes the normal of a plane.
const NORMAL: Lanes = Lanes([1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 0.0, 0.0]);
/// Lane of a plane that holds minus its offset.
const OFFSET: usize = 6;
/// Lane of a plane that holds a bound on its error.
const ERROR: usize = 7;

/// A facet but for its plane, in one cache line. Across from the vertex in slot i lies `neighbors[i]`.
#[derive(Debug, Clone, Copy)]
#[repr(align(64))]
struct Facet {
    vertices: [u32; 6],
    /// Number of the neighbour times eight, plus the slot by which it knows this facet. While the
    /// facet is being replaced: number of the new facet over that ridge, and [`RIM`].
    neighbors: [u32; 6],
    /// How far the latest vertex that looked at the facet lies beyond it.
    distance: f64,
    /// The vertex that looked, or [`REPLACED`].
    seen_by: u32,
}

/// Marks, in place of a slot, that a neighbour is the new facet over a ridge of the rim.
const RIM: u32 = 7;

/// Marks a facet that stands no more.
const REPLACED: u32 = u32::MAX;

/// No neighbour yet.
const NONE: u32 = u32::MAX;

/// A ridge between a facet that the new vertex lies beyond and one that it does not.
#[derive(Debug, Clone, Copy)]
struct Ridge {
    visible: u32,
    /// The slot of the other facet in the visible one.
    slot: u32,
    /// The other facet, times eight, and its slot for the visible one.
    hidden: u32,
}

/// A queue entry; the greatest is the facet with the least offset, the older one among equals.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Waiting {
    offset: f64,
    facet: u32,
}

impl Eq for Waiting {}

impl PartialOrd for Waiting {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for Waiting {
    #[inline(always)]
    fn cmp(&self, other: &Self) -> Ordering {
        other
            .offset
            .total_cmp(&self.offset)
            .then(other.facet.cmp(&self.facet))
    }
}

/// The polytope cannot grow: the facet limit is reached.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Unfinished;

/// A standing facet: its number, outward unit normal (six lanes, then zeros) and signed distance from
/// the origin.
#[derive(Debug, Clone, Copy)]
pub(super) struct Nearest {
    pub facet: u32,
    pub normal: Lanes,
    pub offset: f64,
}

/// The polytope and the memory to grow it, kept from one to the next.
#[derive(Debug, Default)]
pub(super) struct Polytope {
    facets: Vec<Facet>,
    /// n·x = offset of each facet, n its outward unit normal: the normal, minus the offset, and a bound on
    /// the error of the product with a vertex.
    planes: Vec<Lanes>,
    /// Six components, one, and zero.
    vertices: Vec<Lanes>,
    queue: BinaryHeap<Waiting>,
    /// Facets farther from the origin than this are never asked for.
    bound: f64,
    /// A vertex this little beyond a facet counts as lying in it.
    tolerance: f64,
    facet_limit: usize,
    visible: Vec<u32>,
    rim: Vec<Ridge>,
}

impl Polytope {
    /// Starts over with a simplex. `planes[i]`, outward unit normal and minus the offset, is opposite
    /// corner i. At most `facet_limit` facets will be built, those replaced on the way included.
    #[inline(always)]
    pub fn start(
        &mut self,
        corners: &[Lanes; 7],
        planes: &[Lanes; 7],
        tolerance: f64,
        facet_limit: usize,
    ) {
        self.facets.clear();
        self.planes.clear();
        self.vertices.clear();
        self.queue.clear();
        self.vertices.extend_from_slice(corners);
        self.bound = f64::INFINITY;
        self.tolerance = tolerance;
        self.facet_limit = facet_limit.min((u32::MAX >> 3) as usize);
        for opposite in 0..7_u32 {
            let mut vertices = [0; 6];
            let mut neighbors = [0; 6];
            for slot in 0..6 {
                let other = slot + u32::from(slot >= opposite);
                vertices[slot as usize] = other;
                // The facet opposite `other` lacks that corner, so this one's opposite corner is in
                // its slot of the same number, or one less.
                neighbors[slot as usize] = other << 3 | (opposite - u32::from(opposite > other));
            }
            let mut plane = planes[opposite as usize];
            plane.0[ERROR] = STEP_ERROR;
            let offset = -plane.0[OFFSET];
            self.planes.push(plane);
            self.facets.push(Facet {
                vertices,
                neighbors,
                distance: 0.0,
                seen_by: 0,
            });
            let facet = opposite;
            self.queue.push(Waiting { offset, facet });
        }
    }

    /// Facets built so far.
    pub fn facet_count(&self) -> usize {
        self.facets.len()
    }

    /// Facets at least as far from the origin as this need not be given by [`Self::nearest`].
    #[inline(always)]
    pub fn set_bound(&mut self, bound: f64) {
        self.bound = bound;
    }

    /// The nearest standing facet, each given once.
    #[inline(always)]
    pub fn nearest(&mut self) -> Option<Nearest> {
        loop {
            let next = self.queue.pop()?;
            if self.facets[next.facet as usize].seen_by != REPLACED {
                let plane = &self.planes[next.facet as usize];
                return Some(Nearest {
                    facet: next.facet,
                    normal: plane.zip(&NORMAL, |x, one| x * one),
                    offset: next.offset,
                });
            }
        }
    }

    /// Every standing facet: its vertices and outward unit normal.
    fn standing(&self) -> impl Iterator<Item = ([&Lanes; 6], Wrench)> {
        let facets = self.facets.iter().zip(&self.planes);
        let standing = facets.filter(|(facet, _)| facet.seen_by != REPLACED);
        standing.map(|(facet, plane)| {
            let corners = facet.vertices.map(|v| &self.vertices[v as usize]);
            (corners, plane.wrench())
        })
    }

    /// The volume inside, in the sixth power of the unit of the vertices.
    pub fn volume(&self) -> f64 {
        // From a corner, so that nothing cancels when the origin is far outside.
        let Some(base) = self.vertices.first() else {
            return 0.0;
        };
        let factorial = 720.0;
        let pieces = self.standing().map(|(corners, normal)| {
            let edges = Matrix6::from_fn(|row, column| corners[column].0[row] - base.0[row]);
            let facing = normal.dot(&(corners[0].wrench() - base.wrench()));
            edges.determinant().abs().copysign(facing)
        });
        pieces.sum::<f64>() / factorial
    }

    /// Adds a vertex (six components, one, and zero) that lies beyond the standing facet `seed` by
    /// more than the tolerance.
    #[inline(always)]
    pub fn insert(&mut self, point: &Lanes, seed: u32) -> Result<(), Unfinished> {
        let apex = self.vertices.len() as u32;
        self.vertices.push(*point);
        self.look(point, apex, seed);
        if self.facets.len() + self.rim.len() > self.facet_limit {
            return Err(Unfinished);
        }
        self.raise_cone(apex);
        self.join_cone();
        for &facet in &self.visible {
            self.facets[facet as usize].seen_by = REPLACED;
        }
        Ok(())
    }

    /// Walks from `seed` over the facets that `point` lies beyond, and notes their rim. A point in
    /// the plane of a facet is not beyond it, which keeps coplanar facets as they are.
    #[inline(always)]
    fn look(&mut self, point: &Lanes, apex: u32, seed: u32) {
        self.visible.clear();
        self.rim.clear();
        self.visible.push(seed);
        let start = &mut self.facets[seed as usize];
        start.seen_by = apex;
        start.distance = self.planes[seed as usize].dot(point);
        let mut at = 0;
        while let Some(&visible) = self.visible.get(at) {
            at += 1;
            let neighbors = self.facets[visible as usize].neighbors;
            for slot in 0..6 {
                let hidden = neighbors[slot];
                let number = hidden >> 3;
                let next = &mut self.facets[number as usize];
                if next.seen_by != apex {
                    next.seen_by = apex;
                    next.distance = self.planes[number as usize].dot(point);
                    if next.distance > self.tolerance {
                        self.visible.push(number);
                        continue;
                    }
                }
                if next.distance <= self.tolerance {
                    self.rim.push(Ridge {
                        visible,
                        slot: slot as u32,
                        hidden,
                    });
                }
            }
        }
    }

    /// Makes the facets over the ridges of the rim. A new facet has the vertices of the visible facet
    /// below it, in the same slots, with the apex in the slot of the vertex that it lacks.
    #[inline(always)]
    fn raise_cone(&mut self, apex: u32) {
        for i in 0..self.rim.len() {
            let Ridge {
                visible,
                slot,
                hidden,
            } = self.rim[i];
            let new = self.facets.len() as u32;
            let below = &mut self.facets[visible as usize];
            below.neighbors[slot as usize] = new << 3 | RIM;
            let (mut vertices, beyond) = (below.vertices, below.distance);
            vertices[slot as usize] = apex;
            let behind = &mut self.facets[(hidden >> 3) as usize];
            behind.neighbors[(hidden & 7) as usize] = new << 3 | slot;
            let mut plane = combination(
                &self.planes[visible as usize],
                beyond,
                &self.planes[(hidden >> 3) as usize],
                behind.distance,
            );
            // Also when the error is no number.
            if plane.0[ERROR] >= PLANE_ERROR_LIMIT || plane.0[ERROR].is_nan() {
                plane = self.solved(&vertices, visible, hidden >> 3);
            }
            let mut neighbors = [NONE; 6];
            neighbors[slot as usize] = hidden;
            let offset = -plane.0[OFFSET];
            self.planes.push(plane);
            self.facets.push(Facet {
                vertices,
                neighbors,
                distance: 0.0,
                seen_by: apex,
            });
            if offset < self.bound {
                self.queue.push(Waiting { offset, facet: new });
            }
        }
    }

    /// Joins the new facets to each other. Two of them share the ridge of the apex and four vertices
    /// of the rim; the visible facets around those four lead from one to the other.
    #[inline(always)]
    fn join_cone(&mut self) {
        let first = self.facets.len() - self.rim.len();
        for (i, ridge) in self.rim.iter().enumerate() {
            let new = first + i;
            let below = self.facets[ridge.visible as usize];
            for across in 0..6 {
                if self.facets[new].neighbors[across] != NONE {
                    continue;
                }
                let mut step = below.neighbors[across];
                // The vertex to leave behind next, and the slot by which the ridge was entered.
                let mut behind = below.vertices[ridge.slot as usize];
                let mut entry = ridge.slot;
                while step & 7 != RIM {
                    let facet = &self.facets[(step >> 3) as usize];
                    entry = step & 7;
                    let exit = position(&facet.vertices, behind);
                    behind = facet.vertices[entry as usize];
                    step = facet.neighbors[exit];
                }
                let other = step >> 3;
                self.facets[new].neighbors[across] = other << 3 | entry;
                self.facets[other as usize].neighbors[entry as usize] =
                    (new as u32) << 3 | across as u32;
            }
        }
    }

    /// The plane through six vertices, nearest to the direction between two others.
    #[cold]
    #[inline(never)]
    fn solved(&self, vertices: &[u32; 6], visible: u32, hidden: u32) -> Lanes {
        let points = vertices.map(|v| self.vertices[v as usize].wrench());
        let between = [visible, hidden].map(|facet| self.planes[facet as usize].wrench());
        plane_through(&points, &(between[0] + between[1]))
    }
}

/// The plane through the ridge between two facets and a vertex that lies `beyond` the visible one and
/// at `below`, not beyond, the hidden one.
#[inline(always)]
fn combination(visible: &Lanes, beyond: f64, hidden: &Lanes, below: f64) -> Lanes {
    /// Takes the error.
    const ONLY_ERROR: Lanes = Lanes([0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0]);
    // A vertex in the plane of the hidden facet makes a facet in that plane.
    let below = if below < 0.0 { below } else { 0.0 };
    let plane = hidden.zip(visible, |h, v| h * beyond - v * below);
    let normal = plane.zip(&NORMAL, |x, one| x * one);
    let shrink = 1.0 / normal.dot(&normal).sqrt();
    let error = STEP_ERROR * (1.0 + (beyond - below) * shrink);
    plane.zip(&ONLY_ERROR, |x, one| x * shrink + one * error)
}

/// Where `vertex` is among six.
#[inline(always)]
fn position(vertices: &[u32; 6], vertex: u32) -> usize {
    let mut found = 0;
    for slot in 1..6 {
        found = if vertices[slot] == vertex {
            slot
        } else {
            found
        };
    }
    found
}

/// The plane through six points that faces `guess`, with the greatest distance of a point from it as
/// its error. Where the points do not define one, some plane that holds them.
pub(super) fn plane_through(points: &[Wrench; 6], guess: &Wrench) -> Lanes {
    let mut rests = points.map(|p| p - points[0]);
    let mut span = Span::new();
    for _ in 0..5 {
        let farthest = rests
            .iter()
            .max_by(|a, b| a.norm_squared().total_cmp(&b.norm_squared()));
        let direction = farthest.and_then(|rest| rest.try_normalize(f64::MIN_POSITIVE));
        let Some(direction) = direction else {
            break;
        };
        let direction = span.reject(&direction).normalize();
        span.push(direction);
        for rest in &mut rests {
            *rest -= direction * direction.dot(rest);
        }
    }
    let facing = span.reject(guess);
    let normal = facing
        .try_normalize(1e-6 * guess.norm())
        .map_or_else(|| span.orthogonal(), |n| span.reject(&n).normalize());
    let normal = if normal.dot(guess) < 0.0 {
        -normal
    } else {
        normal
    };
    let heights = points.map(|p| p.dot(&normal));
    let offset = heights.iter().fold(f64::INFINITY, |a, b| a.min(*b));
    let top = heights.iter().fold(f64::NEG_INFINITY, |a, b| a.max(*b));
    let mut plane = Lanes::of(&normal, -offset);
    plane.0[ERROR] = STEP_ERROR + (top - offset);
    plane
}
