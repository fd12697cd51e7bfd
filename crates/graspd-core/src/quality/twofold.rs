//! Numbers of twice the precision: unevaluated sums of two doubles.
//!
//! A sum or product of two doubles is rounded, but the rounding error is a double itself, and a few operations find it
//! (Knuth's two-sum; a fused multiply-add for the product). Kept beside the rounded value it makes a number of 106 bits.
//! The formulas for sums, products and quotients are those of Joldes, Muller & Popescu, "Tight and rigorous error bounds
//! for basic building blocks of double-word arithmetic" (ACM Transactions on Mathematical Software 44, 2017): relative
//! errors of at most 3·2⁻¹⁰⁶, 5·2⁻¹⁰⁶ and 10·2⁻¹⁰⁶. Some ten times slower than doubles.

use std::ops::{Add, Mul, Neg, Sub};

/// A number hi + lo with |lo| at most half a unit in the last place of hi.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(super) struct Twofold {
    hi: f64,
    lo: f64,
}

impl Twofold {
    pub const ZERO: Self = Self { hi: 0.0, lo: 0.0 };

    /// The sum of two doubles, without an error.
    pub fn sum(a: f64, b: f64) -> Self {
        let hi = a + b;
        let rest = hi - a;
        Self {
            hi,
            lo: (a - (hi - rest)) + (b - rest),
        }
    }

    /// The sum of two doubles of which the first is the greater, without an error.
    fn ordered_sum(a: f64, b: f64) -> Self {
        let hi = a + b;
        Self {
            hi,
            lo: b - (hi - a),
        }
    }

    /// The nearest double.
    pub fn value(self) -> f64 {
        self.hi
    }

    pub fn magnitude(self) -> f64 {
        self.hi.abs()
    }

    /// The quotient of two numbers.
    pub fn over(self, divisor: Self) -> Self {
        let first = self.hi / divisor.hi;
        let rest = self - divisor * Self::from(first);
        Self::ordered_sum(first, rest.hi / divisor.hi)
    }
}

impl From<f64> for Twofold {
    fn from(value: f64) -> Self {
        Self { hi: value, lo: 0.0 }
    }
}

impl Add for Twofold {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        let high = Self::sum(self.hi, other.hi);
        let low = Self::sum(self.lo, other.lo);
        let sum = Self::ordered_sum(high.hi, high.lo + low.hi);
        Self::ordered_sum(sum.hi, sum.lo + low.lo)
    }
}

impl Neg for Twofold {
    type Output = Self;

    fn neg(self) -> Self {
        Self {
            hi: -self.hi,
            lo: -self.lo,
        }
    }
}

impl Sub for Twofold {
    type Output = Self;

    fn sub(self, other: Self) -> Self {
        self + -other
    }
}

impl Mul for Twofold {
    type Output = Self;

    fn mul(self, other: Self) -> Self {
        let hi = self.hi * other.hi;
        let lost = self.hi.mul_add(other.hi, -hi);
        let cross = self.hi.mul_add(other.lo, self.lo * other.hi);
        Self::ordered_sum(hi, lost + cross)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_one_double_rounds_away_is_kept() {
        let tiny = 2.0_f64.powi(-80);
        let one = Twofold::from(1.0);
        let sum = one + Twofold::from(tiny);
        assert_eq!((sum - one).value(), tiny);
        // (1 + t)² = 1 + 2t + t²
        assert_eq!((sum * sum - one).value(), 2.0 * tiny);
        assert_eq!((sum.over(sum) - one).value(), 0.0);
        let third = one.over(Twofold::from(3.0));
        let miss = third * Twofold::from(3.0) - one;
        assert!(miss.magnitude() < 2.0_f64.powi(-100));
        assert_eq!(Twofold::sum(1.0, tiny), sum);
    }
}
