//! The flat spanned by a wrench set, by Gram-Schmidt with the farthest point first.

use super::{Degenerate, RANK_TOLERANCE, Wrench};

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

/// Indices of seven affinely independent wrenches, spread as widely as a greedy choice can, or
/// why there are none. O(n); `scale` is the length of the longest wrench.
pub(super) fn widest_simplex(wrenches: &[Wrench], scale: f64) -> Result<[u32; 7], Degenerate> {
    let mut chosen = [0_u32; 7];
    let mut span = Span::new();
    let mut rests: Vec<Wrench> = Vec::with_capacity(wrenches.len());
    if let Some(first) = farthest(wrenches) {
        chosen[0] = first as u32;
        rests.extend(wrenches.iter().map(|w| w - wrenches[first]));
    }
    for rank in 0..6 {
        let next = farthest(&rests).filter(|&i| rests[i].norm() > RANK_TOLERANCE * scale);
        let Some(next) = next else {
            return Err(degenerate(wrenches, &span, rank));
        };
        chosen[rank + 1] = next as u32;
        let base = wrenches[chosen[0] as usize];
        let rest = span.reject(&(wrenches[next] - base));
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
