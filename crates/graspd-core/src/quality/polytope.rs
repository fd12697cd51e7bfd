//! A convex polytope that grows by one vertex at a time.
//!
//! The polytope is simplicial: every facet has six vertices and six neighbours.
//!
//! ```text
//! insert(p):
//!     visible ← the facets with p on their outer side            one product each
//!     rim ← the ridges between visible facets and others
//!     for each ridge of the rim, between the visible facet F and the hidden facet G:
//!         the new facet is the ridge and p, with the plane  s_F·G − s_G·F,  normalised
//!     remove the visible facets; make new facets neighbours of each other (pairing.rs)
//! ```
//!
//! s_F > 0 ≥ s_G are the signed distances of p from F and G. Every hyperplane through the ridge is a combination of those
//! two; this one contains p. So no linear system is solved: a dozen multiplications a facet. Each combination adds a few
//! units of rounding, which is accounted for in the plane; a plane whose account exceeds [`PLANE_ERROR_LIMIT`] is solved
//! anew from its vertices.
//!
//! An insertion costs one product per facet plus the work for the new facets. Facets are at most `facet_limit`, so every
//! loop is bounded.
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

use nalgebra::Matrix6;

use super::affine::Span;
use super::facet::{Facet, NONE, PARITY, Ridge};
use super::growth::{Growing, Nearest, Unfinished};
use super::lanes::{LANES, Lanes};
use super::pairing::{Pairing, name};
use crate::wrench::Wrench;

/// Error of a plane, relative to the scale, from which on it is solved anew from its vertices. A
/// tenth of [`super::COPLANAR_TOLERANCE`].
const PLANE_ERROR_LIMIT: f64 = 1e-13;

/// What one combination of two planes adds to the error: a few units of 2⁻⁵².
const STEP_ERROR: f64 = 1e-15;

/// Mask of the normal of a plane.
const NORMAL: Lanes = Lanes([1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 0.0, 0.0]);
/// Lane of a plane that holds minus its offset.
const OFFSET: usize = 6;
/// Lane of a plane that holds a bound on its error.
const ERROR: usize = 7;

/// The plane of a facet that was replaced: no point lies beyond it.
const REPLACED: Lanes = Lanes([0.0, 0.0, 0.0, 0.0, 0.0, 0.0, -1.0, -1.0]);

/// The polytope and the memory to grow it, kept from one to the next.
///
/// An insertion looks at every facet once, without a branch: for the few hundred facets of a usual
/// evaluation that is faster than a walk over the visible ones.
#[derive(Debug, Default)]
pub(super) struct Polytope {
    facets: Vec<Facet>,
    /// n·x = offset of each facet, n its outward unit normal: the normal, minus the offset, and a bound on
    /// the error of the product with a vertex.
    planes: Vec<Lanes>,
    /// Offset of each facet that [`Self::nearest`] has not returned yet, else infinity; padded with infinity to a multiple
    /// of eight.
    waiting: Vec<f64>,
    /// Six components, one, and zero.
    vertices: Vec<Lanes>,
    vertex_names: Vec<u64>,
    /// A vertex beyond a facet by no more than this counts as lying in it.
    tolerance: f64,
    facet_limit: usize,
    /// How far the latest vertex lies beyond each facet.
    distances: Vec<f64>,
    visible: Vec<u32>,
    rim: Vec<Ridge>,
    /// Number of the first facet whose neighbours are not all known yet: those of the latest cone.
    unjoined: usize,
    pairing: Pairing,
}

impl Growing for Polytope {
    #[inline(always)]
    fn start(
        &mut self,
        corners: &[Lanes; 7],
        planes: &[Lanes; 7],
        tolerance: f64,
        facet_limit: usize,
    ) {
        self.facets.clear();
        self.planes.clear();
        self.waiting.clear();
        self.vertices.clear();
        self.vertices.extend_from_slice(corners);
        self.vertex_names.clear();
        self.vertex_names.extend((0..7).map(name));
        self.tolerance = tolerance;
        self.facet_limit = facet_limit.min((u32::MAX >> 4) as usize);
        for opposite in 0..7_u32 {
            let mut vertices = [NONE; 8];
            vertices[PARITY] = opposite & 1;
            let mut neighbors = [NONE; 8];
            for slot in 0..6 {
                let other = slot + u32::from(slot >= opposite);
                vertices[slot as usize] = other;
                // The facet opposite `other` lacks that corner, so this one's opposite corner is in
                // its slot of the same number, or one less.
                neighbors[slot as usize] = other << 3 | (opposite - u32::from(opposite > other));
            }
            let mut plane = planes[opposite as usize];
            plane.0[ERROR] = STEP_ERROR;
            self.waiting.push(-plane.0[OFFSET]);
            self.planes.push(plane);
            self.facets.push(Facet {
                vertices,
                neighbors,
            });
        }
        self.waiting.push(f64::INFINITY);
        self.unjoined = self.facets.len();
    }

    fn facet_count(&self) -> usize {
        self.facets.len()
    }

    #[inline(always)]
    fn nearest(&mut self) -> Option<Nearest> {
        let mut least = Lanes::splat(f64::INFINITY);
        let mut block = [0_u64; LANES];
        for (number, offsets) in self.waiting.chunks_exact(LANES).enumerate() {
            for lane in 0..LANES {
                let nearer = offsets[lane] < least.0[lane];
                least.0[lane] = if nearer { offsets[lane] } else { least.0[lane] };
                block[lane] = if nearer { number as u64 } else { block[lane] };
            }
        }
        let mut found = (f64::INFINITY, usize::MAX);
        for lane in 0..LANES {
            let facet = block[lane] as usize * LANES + lane;
            if least.0[lane] < found.0 || (least.0[lane] == found.0 && facet < found.1) {
                found = (least.0[lane], facet);
            }
        }
        (found.0 < f64::INFINITY).then(|| self.take(found.1))
    }

    /// Amortised constant time.
    fn any(&mut self, from: &mut usize) -> Option<Nearest> {
        let mut rest = self.waiting.get(*from..)?.iter();
        *from += rest.position(|offset| *offset < f64::INFINITY)?;
        Some(self.take(*from))
    }

    /// Where rounding has folded coplanar facets over each other, the overlap counts once.
    fn volume(&self) -> f64 {
        // From a corner, so that nothing cancels when the origin is far outside.
        let Some(base) = self.vertices.first() else {
            return 0.0;
        };
        let factorial = 720.0;
        let facets = self.facets.iter().zip(&self.planes);
        let standing = facets.filter(|(_, plane)| **plane != REPLACED);
        let pieces = standing.map(|(facet, _)| {
            let edges = Matrix6::from_fn(|row, slot| {
                self.vertices[facet.vertices[slot] as usize].0[row] - base.0[row]
            });
            match facet.vertices[PARITY] {
                0 => edges.determinant(),
                _ => -edges.determinant(),
            }
        });
        pieces.sum::<f64>().abs() / factorial
    }

    #[inline(always)]
    fn insert(&mut self, point: &Lanes) -> Result<bool, Unfinished> {
        self.join_cone();
        let apex = self.vertices.len() as u32;
        self.look(point);
        if self.visible.is_empty() {
            return Ok(false);
        }
        if self.rim.is_empty() {
            // Rounding would have all facets replaced.
            return Err(Unfinished::Folded);
        }
        if self.facets.len() + self.rim.len() > self.facet_limit {
            return Err(Unfinished::Limit);
        }
        self.vertices.push(*point);
        self.vertex_names.push(name(apex));
        self.unjoined = self.facets.len();
        self.raise_cone(apex);
        for &facet in &self.visible {
            self.planes[facet as usize] = REPLACED;
            self.waiting[facet as usize] = f64::INFINITY;
        }
        Ok(true)
    }
}

impl Polytope {
    #[inline(always)]
    fn take(&mut self, facet: usize) -> Nearest {
        let offset = std::mem::replace(&mut self.waiting[facet], f64::INFINITY);
        Nearest {
            normal: self.planes[facet].zip(&NORMAL, |x, one| x * one),
            offset,
        }
    }

    /// Makes the facets of the latest cone neighbours of each other. Deferred to the next insertion, because only that needs
    /// it: the last insertion saves the work.
    #[inline(always)]
    fn join_cone(&mut self) {
        let first = std::mem::replace(&mut self.unjoined, self.facets.len());
        if first == self.facets.len() {
            return;
        }
        self.pairing.join(
            &mut self.facets[first..],
            &self.vertex_names,
            &self.rim,
            first,
        );
        if !self.pairing.pending.is_empty() {
            self.join_around(first);
        }
    }

    /// Finds the facets that `point` lies beyond and their rim. A point in the plane of a facet is not
    /// beyond it, which keeps coplanar facets as they are.
    #[inline(always)]
    fn look(&mut self, point: &Lanes) {
        let count = self.facets.len();
        self.distances.resize(count, 0.0);
        for (distance, plane) in self.distances.iter_mut().zip(&self.planes) {
            *distance = plane.dot(point);
        }
        self.visible.resize(count, 0);
        let mut found = 0;
        for (facet, distance) in self.distances.iter().enumerate() {
            self.visible[found] = facet as u32;
            found += usize::from(*distance > self.tolerance);
        }
        self.visible.truncate(found);
        self.rim.resize(6 * found, Ridge::default());
        let mut found = 0;
        for &visible in &self.visible {
            let neighbors = &self.facets[visible as usize].neighbors;
            for slot in 0..6 {
                let hidden = neighbors[slot];
                self.rim[found] = Ridge {
                    visible,
                    slot: slot as u32,
                    hidden,
                };
                let beyond = self.distances[(hidden >> 3) as usize] > self.tolerance;
                found += usize::from(!beyond);
            }
        }
        self.rim.truncate(found);
    }

    /// Makes the facets over the ridges of the rim. A new facet has the vertices of the visible facet
    /// below it, in the same slots, with the apex in the slot of the vertex that it lacks.
    #[inline(always)]
    fn raise_cone(&mut self, apex: u32) {
        let first = self.facets.len();
        for (i, ridge) in self.rim.iter().enumerate() {
            let &Ridge {
                visible,
                slot,
                hidden,
            } = ridge;
            let (below, behind) = (visible as usize, (hidden >> 3) as usize);
            let mut plane = combination(
                &self.planes[below],
                self.distances[below],
                &self.planes[behind],
                self.distances[behind],
            );
            let new = (first + i) as u32;
            self.facets[behind].neighbors[(hidden & 7) as usize] = new << 3 | slot;
            let vertices = replaced(&self.facets[below].vertices, slot, apex);
            // Also when the error is no number.
            if plane.0[ERROR] >= PLANE_ERROR_LIMIT || plane.0[ERROR].is_nan() {
                let points = std::array::from_fn(|slot| {
                    let vertex = self.vertices[vertices[slot] as usize];
                    vertex.wrench()
                });
                let between = self.planes[below].wrench() + self.planes[behind].wrench();
                plane = plane_through(&points, &between);
            }
            self.planes.push(plane);
            self.facets.push(Facet {
                vertices,
                neighbors: replaced(&[NONE; 8], slot, hidden),
            });
        }
        let count = self.facets.len();
        self.waiting.truncate(first);
        self.waiting
            .extend(self.planes[first..].iter().map(|plane| -plane.0[OFFSET]));
        self.waiting
            .resize(count.next_multiple_of(LANES), f64::INFINITY);
    }
}

impl Polytope {
    /// Joins the sides that [`Pairing`] leaves, of ridges with four sides or more: the two at either end of a
    /// walk around the four vertices, over facets that are being replaced, belong together.
    #[cold]
    #[inline(never)]
    fn join_around(&mut self, first: usize) {
        for i in 0..self.pairing.pending.len() {
            let side = self.pairing.pending[i].number;
            let ridge = self.rim[(side >> 3) as usize];
            // The facet stood on, the slot by which it is left, and that of the vertex to leave behind.
            let (mut on, mut exit) = (ridge.visible, side & 7);
            let mut entry = ridge.slot;
            // No facet is met twice.
            for _ in 0..=self.visible.len() {
                let next = self.facets[on as usize].neighbors[exit as usize];
                let number = next >> 3;
                if self.distances[number as usize] > self.tolerance {
                    let behind = self.facets[on as usize].vertices[entry as usize];
                    let found = self.facets[number as usize].vertices;
                    let found = found.iter().position(|vertex| *vertex == behind);
                    entry = next & 7;
                    exit = found.unwrap_or_default() as u32;
                    on = number;
                    continue;
                }
                let over = |r: &Ridge| r.visible == on && r.slot == exit;
                let other = self.rim.iter().position(over).unwrap_or_default();
                let facet = &mut self.facets[first + (side >> 3) as usize];
                facet.neighbors[(side & 7) as usize] = ((first + other) as u32) << 3 | entry;
                break;
            }
        }
    }
}

/// The plane through the ridge between two facets and a vertex that lies `beyond` the visible one and
/// at `below`, not beyond, the hidden one.
#[inline(always)]
fn combination(visible: &Lanes, beyond: f64, hidden: &Lanes, below: f64) -> Lanes {
    /// Mask of the error.
    const ONLY_ERROR: Lanes = Lanes([0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0]);
    // A vertex in the plane of the hidden facet yields a facet in that plane.
    let below = if below < 0.0 { below } else { 0.0 };
    let plane = hidden.zip(visible, |h, v| h * beyond - v * below);
    let normal = plane.zip(&NORMAL, |x, one| x * one);
    let shrink = 1.0 / normal.dot(&normal).sqrt();
    let error = STEP_ERROR * (1.0 + (beyond - below) * shrink);
    plane.zip(&ONLY_ERROR, |x, one| x * shrink + one * error)
}

/// `slots` with another number in one of them.
#[inline(always)]
fn replaced(slots: &[u32; 8], slot: u32, number: u32) -> [u32; 8] {
    std::array::from_fn(|i| if i as u32 == slot { number } else { slots[i] })
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
