//! Eight numbers side by side, and the widest vector instructions of this processor.
//!
//! Loops over [`Lanes`] are plain Rust that the compiler turns into vector instructions inside
//! [`vectorized`]. Only sums and products are written, never fused, and in a fixed order, so that
//! every processor computes the same bits.

// Lanes of several rows are taken by one number.
#![allow(clippy::needless_range_loop)]

use pulp::Arch;
pub(crate) use pulp::NullaryFnOnce;

use crate::wrench::Wrench;

/// How many numbers are computed side by side.
pub(super) const LANES: usize = 8;

/// Eight numbers, aligned to a cache line.
#[derive(Debug, Clone, Copy, PartialEq)]
#[repr(align(64))]
pub(super) struct Lanes(pub [f64; LANES]);

impl Lanes {
    #[inline(always)]
    pub fn splat(value: f64) -> Self {
        Self([value; LANES])
    }

    /// The six components of a wrench, then `seventh` and zero.
    #[inline(always)]
    pub fn of(wrench: &Wrench, seventh: f64) -> Self {
        let w = wrench;
        Self([w[0], w[1], w[2], w[3], w[4], w[5], seventh, 0.0])
    }

    /// The first six as a wrench.
    #[inline(always)]
    pub fn wrench(&self) -> Wrench {
        Wrench::from_fn(|axis, _| self.0[axis])
    }

    #[inline(always)]
    pub fn map(mut self, f: impl Fn(f64) -> f64) -> Self {
        for lane in 0..LANES {
            self.0[lane] = f(self.0[lane]);
        }
        self
    }

    #[inline(always)]
    pub fn zip(mut self, other: &Self, f: impl Fn(f64, f64) -> f64) -> Self {
        for lane in 0..LANES {
            self.0[lane] = f(self.0[lane], other.0[lane]);
        }
        self
    }

    /// The sum of the products of all eight.
    #[inline(always)]
    pub fn dot(&self, other: &Self) -> f64 {
        let products = self.zip(other, |a, b| a * b).0;
        let halves: [f64; 4] = std::array::from_fn(|i| products[i] + products[i + 4]);
        (halves[0] + halves[2]) + (halves[1] + halves[3])
    }
}

/// One number or one number a lane, computed alike to the last bit.
pub(super) trait Number: Copy {
    /// The number of each set.
    fn gather(f: impl Fn(usize) -> f64) -> Self;
    /// The number of one set.
    fn of(self, set: usize) -> f64;
    fn map(self, f: impl Fn(f64) -> f64) -> Self;
    fn zip(self, other: Self, f: impl Fn(f64, f64) -> f64) -> Self;
    /// `then` where `a < b`, else `other`; also `other` where either is no number.
    fn where_less(a: Self, b: Self, then: Self, other: Self) -> Self;

    #[inline(always)]
    fn all(value: f64) -> Self {
        Self::gather(|_| value)
    }
    #[inline(always)]
    fn add(self, other: Self) -> Self {
        self.zip(other, |a, b| a + b)
    }
    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        self.zip(other, |a, b| a - b)
    }
    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        self.zip(other, |a, b| a * b)
    }
}

impl Number for f64 {
    #[inline(always)]
    fn gather(f: impl Fn(usize) -> f64) -> Self {
        f(0)
    }
    #[inline(always)]
    fn of(self, _: usize) -> f64 {
        self
    }
    #[inline(always)]
    fn map(self, f: impl Fn(f64) -> f64) -> Self {
        f(self)
    }
    #[inline(always)]
    fn zip(self, other: Self, f: impl Fn(f64, f64) -> f64) -> Self {
        f(self, other)
    }
    #[inline(always)]
    fn where_less(a: Self, b: Self, then: Self, other: Self) -> Self {
        if a < b { then } else { other }
    }
}

impl Number for Lanes {
    #[inline(always)]
    fn gather(f: impl Fn(usize) -> f64) -> Self {
        Self([f(0), f(1), f(2), f(3), f(4), f(5), f(6), f(7)])
    }
    #[inline(always)]
    fn of(self, set: usize) -> f64 {
        self.0[set]
    }
    #[inline(always)]
    fn map(self, f: impl Fn(f64) -> f64) -> Self {
        Lanes::map(self, f)
    }
    #[inline(always)]
    fn zip(self, other: Self, f: impl Fn(f64, f64) -> f64) -> Self {
        Lanes::zip(self, &other, f)
    }
    #[inline(always)]
    fn where_less(a: Self, b: Self, then: Self, mut other: Self) -> Self {
        for lane in 0..LANES {
            other.0[lane] = if a.0[lane] < b.0[lane] {
                then.0[lane]
            } else {
                other.0[lane]
            };
        }
        other
    }
}

/// Runs work with the widest vector instructions found at run time.
///
/// The work is compiled once for each set of instructions, as far as it is inlined: `call` and all that
/// matters beneath it must be `#[inline(always)]`, which a closure cannot be.
pub(crate) fn vectorized<W: NullaryFnOnce>(work: W) -> W::Output {
    Arch::new().dispatch(work)
}

/// Sets whose greatest component is below this count as all zero: the reciprocal of anything
/// smaller overflows.
const LEAST_COMPONENT: f64 = 1e-300;

/// The heights of eight wrenches along `direction`.
#[inline(always)]
pub(super) fn heights(direction: &Lanes, block: &[Lanes; 6]) -> Lanes {
    let mut height = block[0].map(|x| x * direction.0[0]);
    for axis in 1..6 {
        height = height.zip(&block[axis], |h, x| h + x * direction.0[axis]);
    }
    height
}

/// The greatest power of two that is not above a finite positive number; one for what is too small
/// to divide by.
pub(super) fn power_of_two_below(x: f64) -> f64 {
    if x < LEAST_COMPONENT {
        return 1.0;
    }
    const EXPONENT: u64 = 0x7ff0_0000_0000_0000;
    f64::from_bits(x.to_bits() & EXPONENT)
}
