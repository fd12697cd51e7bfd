//! The best-first expanding polytope.
//!
//! An inner polytope grows from a simplex of the wrenches. Its facets wait in a queue by their
//! signed distance to the origin; the nearest is taken and its support wrench found. If no wrench
//! lies beyond it, it is a facet of the hull and, everything inside the inner polytope being inside
//! the hull too, its distance is the margin. Otherwise the support wrench is added. Only the
//! neighbourhood of the weakest direction is ever built. Zheng (2013), "An efficient algorithm for
//! a grasp quality measure", is the published relative.

use std::cmp::Ordering;
use std::collections::BinaryHeap;

use super::affine::{Span, widest_simplex};
use super::{COPLANAR_TOLERANCE, Degenerate, Margin, Outside, Wrench, scale};

/// A facet of the inner polytope: six vertices, the hyperplane n·x = offset through them with n
/// the outward unit normal, and across from vertex i the facet `neighbors[i]`.
#[derive(Debug, Clone)]
struct Facet {
    normal: Wrench,
    offset: f64,
    vertices: [u32; 6],
    neighbors: [u32; 6],
    alive: bool,
    /// The insertion that last looked at this facet, and what it saw.
    seen: u32,
    distance: f64,
}

/// A queue entry; the greatest is the facet with the least offset, the older one among equals.
#[derive(Debug, Clone, Copy)]
struct Waiting {
    offset: f64,
    facet: u32,
}

impl PartialEq for Waiting {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other).is_eq()
    }
}

impl Eq for Waiting {}

impl PartialOrd for Waiting {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for Waiting {
    fn cmp(&self, other: &Self) -> Ordering {
        other
            .offset
            .total_cmp(&self.offset)
            .then(other.facet.cmp(&self.facet))
    }
}

/// A ridge between a facet that the new vertex sees and one that it does not.
#[derive(Debug, Clone, Copy)]
struct Horizon {
    visible: u32,
    hidden: u32,
    /// The slot of `hidden` among the neighbours of `visible`.
    slot: u8,
}

/// One side of a ridge between two new facets: four of its vertices besides the new one, packed so
/// that equal ridges are equal numbers.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct HalfRidge {
    vertices: u128,
    facet: u32,
    slot: u8,
}

/// A facet could not be replaced: the facet limit is reached, or the facets that the new vertex sees
/// do not form a disc because rounding has folded the polytope. It stays as it was.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Unfinished;

/// The inner polytope and the memory to grow it, kept from one set to the next.
#[derive(Debug, Default)]
pub(super) struct Polytope {
    facet_limit: usize,
    facets: Vec<Facet>,
    queue: BinaryHeap<Waiting>,
    /// Coordinates of the wrenches, axis by axis, so that the search for supports vectorises.
    axes: [Vec<f64>; 6],
    visible: Vec<u32>,
    horizon: Vec<Horizon>,
    half_ridges: Vec<HalfRidge>,
    products: Vec<f64>,
    insertions: u32,
    tolerance: f64,
}

impl Polytope {
    /// A polytope of at most `facet_limit` facets, those replaced on the way included.
    pub(super) fn new(facet_limit: usize) -> Self {
        Self {
            facet_limit,
            ..Self::default()
        }
    }

    /// The margin of `wrenches`; see [`super::Evaluator`] for what `outside` asks.
    pub(super) fn margin(
        &mut self,
        wrenches: &[Wrench],
        outside: Outside,
    ) -> Result<Margin, Degenerate> {
        let scale = self.start(wrenches)?;
        let closure = super::CLOSURE_TOLERANCE * scale;
        let mut least: Option<(f64, Wrench)> = None;
        let mut exact = true;
        while let Some(next) = self.pop() {
            let facet = &self.facets[next as usize];
            let (normal, offset) = (facet.normal, facet.offset);
            let (support, height) = self.support(&normal);
            if outside == Outside::Prove && height <= closure {
                return Ok(self.found(height, normal, scale, false));
            }
            let facet = if height > offset + self.tolerance {
                match self.insert(support, next, wrenches) {
                    Ok(()) => continue,
                    Err(Unfinished) => {
                        exact = false;
                        (offset, normal)
                    }
                }
            } else {
                self.sharpen(&normal, height, wrenches)
            };
            if least.is_none_or(|(value, _)| facet.0 < value) {
                least = Some(facet);
            }
            // With the origin inside every facet left is farther, and its successors farther still.
            // From outside a far facet may yet hide a near one.
            let inside = least.is_some_and(|(value, _)| value > closure);
            if inside || !exact {
                break;
            }
        }
        let (value, normal) = least.unwrap_or((0.0, Wrench::ith(0, 1.0)));
        Ok(self.found(value, normal, scale, exact))
    }

    /// Outward normals of the facets of the whole hull through the origin, which must be one of
    /// the wrenches. Empty when it is inside; `None` when the hull could not be finished.
    pub(super) fn facets_at_origin(
        &mut self,
        wrenches: &[Wrench],
    ) -> Result<Option<Vec<Wrench>>, Degenerate> {
        let scale = self.start(wrenches)?;
        let closure = super::CLOSURE_TOLERANCE * scale;
        let mut normals: Vec<Wrench> = Vec::new();
        while let Some(next) = self.pop() {
            let facet = &self.facets[next as usize];
            let (normal, offset) = (facet.normal, facet.offset);
            // Facets ahead in the queue only move outwards, so none through the origin is left.
            if offset > closure {
                break;
            }
            let (support, height) = self.support(&normal);
            if height > offset + self.tolerance {
                match self.insert(support, next, wrenches) {
                    Ok(()) => continue,
                    Err(Unfinished) => return Ok(None),
                }
            }
            normals.push(normal);
        }
        Ok(Some(normals))
    }

    fn found(&self, value: f64, direction: Wrench, scale: f64, exact: bool) -> Margin {
        Margin {
            value,
            upper: value,
            direction,
            scale,
            exact,
            facets: self.facets.len(),
        }
    }

    /// Clears the workspace and builds the first simplex. Returns the scale of the set.
    fn start(&mut self, wrenches: &[Wrench]) -> Result<f64, Degenerate> {
        let scale = scale(wrenches);
        let corners = widest_simplex(wrenches, scale)?;
        self.tolerance = COPLANAR_TOLERANCE * scale;
        self.facets.clear();
        self.queue.clear();
        self.insertions = 0;
        for (axis, column) in self.axes.iter_mut().enumerate() {
            column.clear();
            column.extend(wrenches.iter().map(|w| w[axis]));
        }
        for opposite in 0..7 {
            let mut vertices = [0; 6];
            let mut neighbors = [0; 6];
            let others = (0..7).filter(|&i| i != opposite);
            for (slot, i) in others.enumerate() {
                vertices[slot] = corners[i];
                neighbors[slot] = i as u32;
            }
            let points = vertices.map(|v| wrenches[v as usize]);
            let inner = wrenches[corners[opposite] as usize];
            let (normal, offset) = hyperplane(&points, &inner);
            self.push(Facet {
                normal,
                offset,
                vertices,
                neighbors,
                alive: true,
                seen: 0,
                distance: 0.0,
            });
        }
        Ok(scale)
    }

    fn push(&mut self, facet: Facet) {
        self.queue.push(Waiting {
            offset: facet.offset,
            facet: self.facets.len() as u32,
        });
        self.facets.push(facet);
    }

    /// The nearest facet that still stands.
    fn pop(&mut self) -> Option<u32> {
        loop {
            let next = self.queue.pop()?;
            if self.facets[next.facet as usize].alive {
                return Some(next.facet);
            }
        }
    }

    /// The wrench farthest along `normal`, and how far; the first among equals.
    fn support(&mut self, normal: &Wrench) -> (u32, f64) {
        let [x0, x1, x2, x3, x4, x5] = &self.axes;
        self.products.clear();
        self.products
            .extend(x0.iter().zip(x1).zip(x2).zip(x3).zip(x4).zip(x5).map(
                |(((((a, b), c), d), e), f)| {
                    normal[0] * a
                        + normal[1] * b
                        + normal[2] * c
                        + normal[3] * d
                        + normal[4] * e
                        + normal[5] * f
                },
            ));
        let mut best = (0, f64::NEG_INFINITY);
        for (i, &height) in self.products.iter().enumerate() {
            if height > best.1 {
                best = (i as u32, height);
            }
        }
        best
    }

    /// Replaces the facets that wrench `apex` lies beyond, `seed` among them, by the cone of the
    /// apex over their rim.
    fn insert(&mut self, apex: u32, seed: u32, wrenches: &[Wrench]) -> Result<(), Unfinished> {
        let point = wrenches[apex as usize];
        self.collect_visible(&point, seed);
        if self.facets.len() + self.horizon.len() > self.facet_limit {
            return Err(Unfinished);
        }
        self.collect_half_ridges();
        if !self.ridges_pair_up() {
            return Err(Unfinished);
        }
        let first = self.facets.len() as u32;
        for i in 0..self.horizon.len() {
            let facet = self.cone_facet(self.horizon[i], apex).ok_or_else(|| {
                self.facets.truncate(first as usize);
                Unfinished
            })?;
            self.facets.push(facet);
        }
        for pair in self.half_ridges.chunks_exact(2) {
            let (a, b) = (pair[0], pair[1]);
            self.facets[(first + a.facet) as usize].neighbors[a.slot as usize] = first + b.facet;
            self.facets[(first + b.facet) as usize].neighbors[b.slot as usize] = first + a.facet;
        }
        for (i, rim) in self.horizon.iter().enumerate() {
            let hidden = &mut self.facets[rim.hidden as usize];
            if let Some(slot) = hidden.neighbors.iter().position(|&n| n == rim.visible) {
                hidden.neighbors[slot] = first + i as u32;
            }
        }
        for &facet in &self.visible {
            self.facets[facet as usize].alive = false;
        }
        for facet in first..self.facets.len() as u32 {
            let offset = self.facets[facet as usize].offset;
            self.queue.push(Waiting { offset, facet });
        }
        Ok(())
    }

    /// Walks from `seed` over the facets that `point` lies beyond and notes their rim. A point in
    /// the hyperplane of a facet is not beyond it, which keeps coplanar facets as they are.
    fn collect_visible(&mut self, point: &Wrench, seed: u32) {
        self.insertions += 1;
        let insertion = self.insertions;
        self.visible.clear();
        self.horizon.clear();
        let start = &mut self.facets[seed as usize];
        start.seen = insertion;
        start.distance = start.normal.dot(point) - start.offset;
        self.visible.push(seed);
        let mut at = 0;
        while let Some(&current) = self.visible.get(at) {
            at += 1;
            let neighbors = self.facets[current as usize].neighbors;
            for (slot, &next) in neighbors.iter().enumerate() {
                let facet = &mut self.facets[next as usize];
                let first_look = facet.seen != insertion;
                if first_look {
                    facet.seen = insertion;
                    facet.distance = facet.normal.dot(point) - facet.offset;
                }
                if facet.distance <= self.tolerance {
                    self.horizon.push(Horizon {
                        visible: current,
                        hidden: next,
                        slot: slot as u8,
                    });
                } else if first_look {
                    self.visible.push(next);
                }
            }
        }
    }

    /// Lists the sides of the ridges through the apex, equal ridges next to each other. The
    /// vertices of a cone facet are those of its rim ridge, in their order in the visible facet,
    /// and the apex last.
    fn collect_half_ridges(&mut self) {
        self.half_ridges.clear();
        for (i, rim) in self.horizon.iter().enumerate() {
            let ridge = ridge(&self.facets[rim.visible as usize], rim.slot);
            for slot in 0..5 {
                let mut four = [0; 4];
                for (k, j) in (0..5).filter(|&j| j != slot).enumerate() {
                    four[k] = ridge[j];
                }
                four.sort_unstable();
                let vertices = four
                    .iter()
                    .fold(0, |packed, &v| packed << 32 | u128::from(v));
                self.half_ridges.push(HalfRidge {
                    vertices,
                    facet: i as u32,
                    slot: slot as u8,
                });
            }
        }
        self.half_ridges.sort_unstable();
    }

    /// Whether each ridge through the apex has exactly two sides.
    fn ridges_pair_up(&self) -> bool {
        let sides = &self.half_ridges;
        let twice = |pair: &[HalfRidge]| matches!(pair, [a, b] if a.vertices == b.vertices);
        !sides.is_empty()
            && sides.chunks(2).all(twice)
            && sides.windows(3).all(|w| w[0].vertices != w[2].vertices)
    }

    /// The facet through a rim ridge and the apex. Every hyperplane through the ridge is a
    /// combination of those of its two facets, so none is solved for. `None` when the two are
    /// opposite each other, as only a polytope folded flat by rounding has them.
    fn cone_facet(&self, rim: Horizon, apex: u32) -> Option<Facet> {
        let visible = &self.facets[rim.visible as usize];
        let hidden = &self.facets[rim.hidden as usize];
        let beyond = visible.distance;
        let below = hidden.distance.min(0.0);
        let normal = hidden.normal * beyond - visible.normal * below;
        let length = normal.norm();
        if length <= super::RANK_TOLERANCE * (beyond - below) {
            return None;
        }
        let ridge = ridge(visible, rim.slot);
        let mut vertices = [apex; 6];
        vertices[..5].copy_from_slice(&ridge);
        let mut neighbors = [u32::MAX; 6];
        neighbors[5] = rim.hidden;
        Some(Facet {
            normal: normal / length,
            offset: (hidden.offset * beyond - visible.offset * below) / length,
            vertices,
            neighbors,
            alive: true,
            seen: 0,
            distance: 0.0,
        })
    }

    /// The hyperplane of a final facet, solved anew from the widest spread of wrenches that lie in
    /// it, so that the rounding of the chain that led to it does not enter the answer. A support
    /// value bounds ε from above for any unit normal, so the lesser of old and new is kept.
    fn sharpen(&mut self, normal: &Wrench, height: f64, wrenches: &[Wrench]) -> (f64, Wrench) {
        let inside: Vec<Wrench> = self
            .products
            .iter()
            .zip(wrenches)
            .filter(|(product, _)| height - **product <= self.tolerance)
            .map(|(_, w)| *w)
            .collect();
        let Some(sharp) = widest_normal(&inside, normal, self.tolerance) else {
            return (height, *normal);
        };
        let (_, sharp_height) = self.support(&sharp);
        if sharp_height < height {
            (sharp_height, sharp)
        } else {
            (height, *normal)
        }
    }
}

/// The five vertices of `facet` other than the one in `slot`.
fn ridge(facet: &Facet, slot: u8) -> [u32; 5] {
    let mut ridge = [0; 5];
    let others = (0..6).filter(|&j| j != slot as usize);
    for (k, j) in others.enumerate() {
        ridge[k] = facet.vertices[j];
    }
    ridge
}

/// The hyperplane through six points, its unit normal pointing away from `inner`.
fn hyperplane(points: &[Wrench; 6], inner: &Wrench) -> (Wrench, f64) {
    let mut span = Span::new();
    for p in &points[1..] {
        let rest = span.reject(&(p - points[0]));
        span.push(rest.normalize());
    }
    let normal = span.reject(&span.reject(&(points[0] - inner)).normalize());
    let normal = normal.normalize();
    (normal, normal.dot(&points[0]))
}

/// The unit normal near `guess` of the hyperplane through `points`, from six of them chosen as
/// widely spread as a greedy choice can; `None` when they do not define one.
fn widest_normal(points: &[Wrench], guess: &Wrench, tolerance: f64) -> Option<Wrench> {
    let base = points.first()?;
    let mut span = Span::new();
    for _ in 0..5 {
        let rest = points
            .iter()
            .map(|p| span.reject(&(p - base)))
            .max_by(|a, b| a.norm_squared().total_cmp(&b.norm_squared()))?;
        if rest.norm() <= 1e3 * tolerance {
            return None;
        }
        span.push(rest.normalize());
    }
    Some(span.reject(&span.reject(guess).normalize()).normalize())
}
