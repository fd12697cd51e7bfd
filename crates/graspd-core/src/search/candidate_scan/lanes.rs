//! Sixteen numbers side by side.

// Lanes of several rows share one index.
#![allow(clippy::needless_range_loop)]

/// Candidates bounded side by side.
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
pub(super) fn dot(a: &[Singles; 3], b: &[Singles; 3]) -> Singles {
    let product = |axis: usize| a[axis].zip(&b[axis], |x, y| x * y);
    product(0).plus(&product(1)).plus(&product(2))
}
