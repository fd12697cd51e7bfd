//! The margin of seven wrenches: their hull is a simplex and needs no hull algorithm.
//!
//! # Idea
//!
//! The inverse of the 6 × 6 matrix with columns wᵢ − w₀ has rows aᵢ. The functions λᵢ(x) = aᵢ·x + bᵢ, bᵢ = −aᵢ·w₀, are
//! the barycentric coordinates of x, and λ₀ is one minus their sum. The facet opposite wrench i is λᵢ = 0, at the signed
//! distance bᵢ/‖aᵢ‖ from the origin. So one inverse gives all seven facets:
//!
//! ```text
//! A ← inverse of [w₁ − w₀ … w₆ − w₀]
//! margin ← min over i of bᵢ / ‖aᵢ‖
//! correct the deciding plane once with the rows of A
//! ```
//!
//! # Accuracy
//!
//! The correction is one step of iterative refinement, which squares the error of the deciding plane. A simplex that is
//! too slender for that ([`SLENDERNESS_LIMIT`]), or whose elimination grows too much ([`FACTOR_LIMIT`]), is left to the
//! polytope.
//!
//! # Cost
//!
//! Some 600 multiplications and no branch. Everything is written over [`Number`], so that eight sets are computed side
//! by side, with the same bits as one.

// Rows and columns are taken by number.
#![allow(clippy::needless_range_loop)]

use super::lanes::Number;
use super::margin::Margin;
use crate::wrench::Wrench;

/// Greatest ‖aᵢ‖ times the scale at which the inverse is trusted: the longest wrench over the least
/// height of the simplex. The deciding plane is corrected once, which squares its error.
const SLENDERNESS_LIMIT: f64 = 1e4;

/// Greatest factor of the elimination that is trusted. Of two pivots the greater is taken, so that next
/// to no set is refused.
const FACTOR_LIMIT: f64 = 1e4;

/// Squared lengths whose squares neither overflow nor vanish.
const USABLE: std::ops::RangeInclusive<f64> = 1e-100..=1e100;

/// The exact margins of as many simplices as `F` has numbers; `None` for one that is too flat or too
/// large for this form, or not finite.
#[inline(always)]
pub(super) fn margins<F: Number, const N: usize>(sets: &[&[Wrench; 7]; N]) -> [Option<Margin>; N] {
    let base: [F; 6] = std::array::from_fn(|c| F::gather(|set| sets[set][0][c]));
    let edges: [[F; 6]; 6] = std::array::from_fn(|c| {
        std::array::from_fn(|i| F::gather(|set| sets[set][i + 1][c]).sub(base[c]))
    });
    let mut longest = squared(&base);
    for i in 0..6 {
        let length = squared(&std::array::from_fn(|c| edges[c][i].add(base[c])));
        longest = F::where_less(longest, length, length, longest);
    }
    let inverse = invert(edges, base);

    let mut least = Facet::new(
        std::array::from_fn(|c| sum(&std::array::from_fn(|i| inverse.rows[i][c])).map(|x| -x)),
        sum(&inverse.base).map(|x| 1.0 + x),
        F::all(1.0),
    );
    let mut steepest = least.squared;
    for i in 0..6 {
        let b = inverse.base[i].map(|x| -x);
        let facet = Facet::new(inverse.rows[i], b, F::all(0.0));
        // Also when it is no number.
        steepest = F::where_less(facet.squared, steepest, steepest, facet.squared);
        least.take_nearer(&facet);
    }
    let deciding = least.corrected(&inverse, &edges, &base);
    let shrink = deciding.squared.map(|s| 1.0 / s.sqrt());
    let values = deciding.b.mul(shrink);
    std::array::from_fn(|set| {
        let (longest, value) = (longest.of(set), values.of(set));
        let sound = steepest.of(set) * longest <= SLENDERNESS_LIMIT * SLENDERNESS_LIMIT
            && inverse.factor.of(set) <= FACTOR_LIMIT
            && USABLE.contains(&longest)
            && value.is_finite();
        sound.then(|| Margin {
            value,
            upper: value,
            direction: Wrench::from_fn(|c, _| -deciding.normal[c].of(set) * shrink.of(set)),
            scale: longest.sqrt(),
            exact: true,
            facets: 7,
        })
    })
}

#[inline(always)]
fn sum<F: Number>(x: &[F; 6]) -> F {
    (x[0].add(x[1])).add(x[2].add(x[3])).add(x[4].add(x[5]))
}

#[inline(always)]
fn dot<F: Number>(a: &[F; 6], b: &[F; 6]) -> F {
    sum(&std::array::from_fn(|c| a[c].mul(b[c])))
}

#[inline(always)]
fn squared<F: Number>(x: &[F; 6]) -> F {
    dot(x, x)
}

/// λ(x) = a·x + b of a facet, with ‖a‖².
#[derive(Clone, Copy)]
struct Facet<F> {
    normal: [F; 6],
    b: F,
    squared: F,
    /// One for the facet opposite the first wrench, else zero.
    first: F,
}

impl<F: Number> Facet<F> {
    #[inline(always)]
    fn new(normal: [F; 6], b: F, first: F) -> Self {
        Self {
            normal,
            b,
            squared: squared(&normal),
            first,
        }
    }

    /// b|b|/‖a‖² grows with b/‖a‖, and fractions are compared without a division.
    #[inline(always)]
    fn take_nearer(&mut self, other: &Self) {
        let ours = self.b.mul(self.b.map(f64::abs)).mul(other.squared);
        let theirs = other.b.mul(other.b.map(f64::abs)).mul(self.squared);
        let nearer = |then: F, now: F| F::where_less(theirs, ours, then, now);
        for c in 0..6 {
            self.normal[c] = nearer(other.normal[c], self.normal[c]);
        }
        self.b = nearer(other.b, self.b);
        self.squared = nearer(other.squared, self.squared);
        self.first = nearer(other.first, self.first);
    }

    /// The facet with its components in their own order, and what its plane misses the wrenches by that
    /// it should hold taken back with their rows of the inverse.
    #[inline(always)]
    fn corrected(&self, inverse: &Inverse<F>, edges: &[[F; 6]; 6], base: &[F; 6]) -> Self {
        let mut normal = inverse.restored(self.normal);
        let mut correction = [F::all(0.0); 6];
        for i in 0..6 {
            let height = dot(&normal, &std::array::from_fn(|c| edges[c][i]));
            // One at the wrench opposite, minus one from it where that is the first, else zero.
            let miss = height.map(|h| {
                let wanted = if h > 0.5 { 1.0 } else { 0.0 };
                h - if h < -0.5 { -1.0 } else { wanted }
            });
            for c in 0..6 {
                correction[c] = correction[c].add(miss.mul(inverse.rows[i][c]));
            }
        }
        let correction = inverse.restored(correction);
        for c in 0..6 {
            normal[c] = normal[c].sub(correction[c]);
        }
        Self::new(normal, self.first.sub(dot(&normal, base)), self.first)
    }
}

/// An inverse, its columns exchanged as the rows of the matrix were: k with k + 1, from k = 0 on, where the
/// first of two sizes was less.
struct Inverse<F> {
    rows: [[F; 6]; 6],
    /// The inverse times the first wrench.
    base: [F; 6],
    sizes: [(F, F); 5],
    /// Greatest factor of the elimination.
    factor: F,
}

impl<F: Number> Inverse<F> {
    /// The components of a row in their own order.
    #[inline(always)]
    fn restored(&self, mut row: [F; 6]) -> [F; 6] {
        for k in (0..5).rev() {
            exchange(&mut row, k, self.sizes[k]);
        }
        row
    }
}

/// Exchanges entries k and k + 1 where the first size is less.
#[inline(always)]
fn exchange<F: Number>(row: &mut [F; 6], k: usize, (now, then): (F, F)) {
    let (a, b) = (row[k], row[k + 1]);
    row[k] = F::where_less(now, then, b, a);
    row[k + 1] = F::where_less(now, then, a, b);
}

/// Gauss-Jordan elimination in place, of `matrix[component][column]` and one more column.
#[inline(always)]
fn invert<F: Number>(mut matrix: [[F; 6]; 6], mut base: [F; 6]) -> Inverse<F> {
    let mut sizes = [(F::all(0.0), F::all(0.0)); 5];
    let mut greatest = F::all(0.0);
    for k in 0..6 {
        if k < 5 {
            sizes[k] = (matrix[k][k].map(f64::abs), matrix[k + 1][k].map(f64::abs));
            let (now, then) = sizes[k];
            for column in 0..6 {
                let (a, b) = (matrix[k][column], matrix[k + 1][column]);
                matrix[k][column] = F::where_less(now, then, b, a);
                matrix[k + 1][column] = F::where_less(now, then, a, b);
            }
            exchange(&mut base, k, sizes[k]);
        }
        let shrink = matrix[k][k].map(|x| 1.0 / x);
        matrix[k][k] = F::all(1.0);
        let pivot: [F; 6] = std::array::from_fn(|column| matrix[k][column].mul(shrink));
        matrix[k] = pivot;
        base[k] = base[k].mul(shrink);
        for row in 0..6 {
            if row == k {
                continue;
            }
            let factor = matrix[row][k];
            let size = factor.mul(shrink).map(f64::abs);
            // Also when it is no number.
            greatest = F::where_less(size, greatest, greatest, size);
            matrix[row][k] = F::all(0.0);
            for column in 0..6 {
                matrix[row][column] = matrix[row][column].sub(factor.mul(pivot[column]));
            }
            base[row] = base[row].sub(factor.mul(base[k]));
        }
    }
    Inverse {
        rows: matrix,
        base,
        sizes,
        factor: greatest,
    }
}
