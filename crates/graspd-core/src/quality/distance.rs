//! The distance of the origin from a convex set that does not contain it.
//!
//! Wolfe (1976), "Finding the nearest point in a polytope" (Mathematical Programming 11). A small set of support points,
//! the corral, and their convex combination nearest to the origin are kept:
//!
//! ```text
//! C ← {a support point}
//! loop
//!     x ← the point of hull(C) nearest to the origin; drop from C the points that x does not need
//!     p ← the support point along −x
//!     if p reaches no closer to the origin than x: return ‖x‖
//!     C ← C ∪ {p}
//! ```
//!
//! ‖x‖ bounds the distance from above and falls in every step; the support value along −x/‖x‖ bounds it from below. A
//! corral has at most seven points, so a step is a least-squares problem of that size. [`STEP_LIMIT`] ends the search.

use nalgebra::{DMatrix, DVector};

use super::lanes::Lanes;
use super::support::Body;
use crate::wrench::Wrench;

/// Support points added before the search is given up. Some tens are usual.
const STEP_LIMIT: usize = 500;

/// A weight below this share of the whole is zero but for rounding.
const LEAST_WEIGHT: f64 = 1e-14;

/// The distance is from `least`, which is negative when nothing separates, to `greatest`.
#[derive(Debug, Clone, Copy)]
pub(super) struct Gap {
    pub least: f64,
    pub greatest: f64,
    /// The unit direction along which the set reaches to −`least`.
    pub direction: Wrench,
}

/// The distance of the origin from `body`, until its bounds differ by at most `accuracy` times the
/// greater, as far as that can be reached. `start` is the first direction looked along.
pub(super) fn distance(body: &impl Body, start: &Lanes, accuracy: f64) -> Gap {
    let first = body.reach(start);
    let mut corral = vec![first.point.wrench()];
    let mut weights = vec![1.0];
    let mut gap = Gap {
        least: -first.height,
        greatest: f64::INFINITY,
        direction: start.wrench(),
    };
    for _ in 0..STEP_LIMIT {
        let nearest: Wrench = corral.iter().zip(&weights).map(|(p, w)| p * *w).sum();
        let length = nearest.norm();
        gap.greatest = gap.greatest.min(length);
        let direction = -nearest / length;
        if !direction.iter().all(|x| x.is_finite()) {
            break;
        }
        let reach = body.reach(&Lanes::of(&direction, 0.0));
        if -reach.height > gap.least {
            (gap.least, gap.direction) = (-reach.height, direction);
        }
        if gap.greatest - gap.least <= accuracy * gap.greatest {
            break;
        }
        corral.push(reach.point.wrench());
        weights.push(0.0);
        if !shrink(&mut corral, &mut weights) {
            break;
        }
    }
    gap
}

/// Moves the weights to the nearest convex combination of a subset of the corral, and drops the others.
/// `false` when its points are too nearly dependent.
fn shrink(corral: &mut Vec<Wrench>, weights: &mut Vec<f64>) -> bool {
    while let Some(wanted) = nearest_of_flat(corral) {
        let reachable = wanted
            .iter()
            .zip(&*weights)
            .filter(|(to, _)| **to <= LEAST_WEIGHT)
            .map(|(to, from)| from / (from - to).max(f64::MIN_POSITIVE))
            .fold(1.0, f64::min);
        for (weight, to) in weights.iter_mut().zip(&wanted) {
            *weight += (to - *weight) * reachable;
        }
        let kept: Vec<bool> = weights.iter().map(|w| *w > LEAST_WEIGHT).collect();
        let all = kept.iter().all(|kept| *kept);
        let mut keep = kept.iter();
        corral.retain(|_| keep.next().is_some_and(|kept| *kept));
        weights.retain(|w| *w > LEAST_WEIGHT);
        let sum: f64 = weights.iter().sum();
        weights.iter_mut().for_each(|w| *w /= sum);
        if all {
            return true;
        }
    }
    false
}

/// The weights, some negative, of the point of the flat through the corral that is nearest to the origin.
fn nearest_of_flat(corral: &[Wrench]) -> Option<Vec<f64>> {
    let n = corral.len();
    // Any positive number in the place of the squared size gives the same weights.
    let size = corral.iter().map(Wrench::norm_squared).fold(0.0, f64::max);
    let products = DMatrix::from_fn(n, n, |i, j| corral[i].dot(&corral[j]) + size);
    let solved = products.cholesky()?.solve(&DVector::from_element(n, 1.0));
    let sum = solved.sum();
    let weights: Vec<f64> = solved.iter().map(|x| x / sum).collect();
    weights.iter().all(|w| w.is_finite()).then_some(weights)
}
