//! The flat spanned by a wrench set, by Gram-Schmidt with the farthest point first.

use super::lanes::Lanes;
use super::margin::{Degenerate, RANK_TOLERANCE};
use crate::wrench::Wrench;

/// An orthonormal basis that grows by one direction at a time, with the wrenches it came from.
#[derive(Debug, Clone, Copy)]
pub struct Span {
    basis: [Wrench; 6],
    dimension: usize,
}

impl Default for Span {
    fn default() -> Self {
        Self::new()
    }
}

impl Span {
    /// The empty span.
    pub fn new() -> Self {
        Self {
            basis: [Wrench::zeros(); 6],
            dimension: 0,
        }
    }

    /// The part of `vector` outside the span. Applied twice, because one pass of Gram-Schmidt
    /// leaves an error relative to the vector and not to its remainder.
    pub fn reject(&self, vector: &Wrench) -> Wrench {
        let mut rest = *vector;
        for _ in 0..2 {
            for b in &self.basis[..self.dimension] {
                rest -= b * b.dot(&rest);
            }
        }
        rest
    }

    /// Adds a unit direction orthogonal to the span, which must have fewer than six.
    pub fn push(&mut self, direction: Wrench) {
        self.basis[self.dimension] = direction;
        self.dimension += 1;
    }

    /// A unit vector orthogonal to a span of at most five dimensions.
    pub fn orthogonal(&self) -> Wrench {
        let rest = (0..6)
            .map(|axis| self.reject(&Wrench::ith(axis, 1.0)))
            .max_by(|a, b| a.norm_squared().total_cmp(&b.norm_squared()))
            .unwrap_or_else(Wrench::zeros);
        self.reject(&rest.normalize()).normalize()
    }
}

/// Returns the numbers of seven affinely independent wrenches, each chosen farthest from the flat through those before it.
/// `scale` is the length of the longest wrench. O(n).
///
/// # Errors
/// [`Degenerate`], with the rank and a missing direction, when there are none.
pub(super) fn widest_simplex(wrenches: &[Lanes], scale: f64) -> Result<[u32; 7], Degenerate> {
    let mut chosen = [0_u32; 7];
    let mut span = Span::new();
    let points: Vec<Wrench> = wrenches.iter().map(Lanes::wrench).collect();
    let first = farthest(&points).unwrap_or(0);
    chosen[0] = first as u32;
    let mut rests: Vec<Wrench> = points.iter().map(|w| w - points[first]).collect();
    for rank in 0..6 {
        let next = farthest(&rests).filter(|&i| rests[i].norm() > RANK_TOLERANCE * scale);
        let Some(next) = next else {
            return Err(degenerate(&points, &span, rank));
        };
        chosen[rank + 1] = next as u32;
        let rest = span.reject(&(points[next] - points[first]));
        let direction = rest.normalize();
        span.push(direction);
        for rest in &mut rests {
            *rest -= direction * direction.dot(rest);
        }
    }
    Ok(chosen)
}

fn farthest(vectors: &[Wrench]) -> Option<usize> {
    let mut best = None;
    let mut length = -1.0;
    for (i, v) in vectors.iter().enumerate() {
        let squared = v.norm_squared();
        if squared > length {
            (best, length) = (Some(i), squared);
        }
    }
    best
}

fn degenerate(wrenches: &[Wrench], span: &Span, rank: usize) -> Degenerate {
    let mut direction = span.orthogonal();
    if wrenches.first().is_some_and(|w| w.dot(&direction) > 0.0) {
        direction = -direction;
    }
    Degenerate { rank, direction }
}

/// The unit normal near `guess` of the hyperplane through `points` (six components; the rest is not
/// looked at), from those of them that a greedy choice finds most widely spread; `None` when they do not
/// define one by more than a thousand tolerances. Uses the points up.
#[inline(always)]
pub(super) fn widest_normal(points: &mut [Lanes], guess: &Lanes, tolerance: f64) -> Option<Lanes> {
    let base = *points.first()?;
    for point in &mut *points {
        *point = point.zip(&base, |x, b| x - b);
        point.0[6] = 0.0;
    }
    let mut normal = *guess;
    normal.0[6] = 0.0;
    let mut basis = [Lanes::splat(0.0); 5];
    for known in 0..5 {
        let mut farthest = (0.0, Lanes::splat(0.0));
        for point in &*points {
            let squared = point.dot(point);
            if squared > farthest.0 {
                farthest = (squared, *point);
            }
        }
        let length = farthest.0.sqrt();
        if length <= 1e3 * tolerance {
            return None;
        }
        let mut direction = farthest.1.map(|x| x / length);
        // What rounding has left of the earlier directions.
        for earlier in &basis[..known] {
            direction = without(&direction, earlier);
        }
        direction = unit(&direction);
        basis[known] = direction;
        for point in &mut *points {
            *point = without(point, &direction);
        }
    }
    for _ in 0..2 {
        for direction in &basis {
            normal = without(&normal, direction);
        }
        normal = unit(&normal);
    }
    normal.0[0].is_finite().then_some(normal)
}

/// What of `vector` is orthogonal to a unit direction.
#[inline(always)]
fn without(vector: &Lanes, direction: &Lanes) -> Lanes {
    let along = vector.dot(direction);
    vector.zip(direction, |v, d| v - d * along)
}

#[inline(always)]
fn unit(vector: &Lanes) -> Lanes {
    let shrink = vector.dot(vector).sqrt().recip();
    vector.map(|x| x * shrink)
}
