//! Finds a simplex of wrenches around the origin, or a direction along which no wrench reaches.
//!
//! # Idea
//!
//! "The origin is a convex combination of the wrenches" is a linear program, and this is its dual simplex method with the
//! deepest facet first. It needs support points only, so it works on curved wrench spaces as well.
//!
//! ```text
//! S ← a simplex around the origin whose corners are no wrenches
//! loop
//!     F ← in the first seven steps facet 1, 2, … of S; then the facet that the origin is farthest beyond
//!     if the origin is beyond none: return S
//!     p ← the support point along the normal of F, on the origin's side
//!     if p does not reach beyond the origin: return that normal as the proof
//!     S ← S with the corner opposite F replaced by p
//! ```
//!
//! # Invariant
//!
//! S is kept as its barycentric functions λᵢ(x) = aᵢ·x + bᵢ, the rows of the inverse of the matrix with columns (wᵢ; 1).
//! A replacement is a rank-one update of that inverse; the rounding that it accumulates is removed at the end by Newton's
//! iteration for the inverse.
//!
//! # Why it ends
//!
//! Each step moves a facet towards the origin, but ties can make the method cycle. [`STEP_LIMIT`] ends it; the caller
//! then starts from the widest simplex instead. Some ten steps are usual, a few hundred nanoseconds in all.

// Lanes of several rows are taken by one number.
#![allow(clippy::needless_range_loop)]

use super::lanes::Lanes;
use super::support::Body;
use crate::wrench::Wrench;

/// Corners replaced before the search is given up. Some ten are usual; a cycle among ties, which the
/// rule of the deepest facet does not exclude, ends here.
const STEP_LIMIT: usize = 60;

/// The origin is this little beyond a facet of the simplex, in units of the scale, and still counts as
/// inside: rounding of the offset.
const INSIDE_TOLERANCE: f64 = 1e-14;

/// Greatest distance of a corner from where its barycentric functions have it, in units of the scale,
/// that is left as it is: a few times the rounding of the product that measures it.
const INVERSE_TOLERANCE: f64 = 1e-14;

/// Rounds of Newton's iteration for the inverse; one is usual, and each squares the error.
const INVERSE_ROUNDS: usize = 4;

/// What was found out.
#[expect(
    clippy::large_enum_variant,
    reason = "made once an evaluation, on the stack"
)]
pub(super) enum Closure {
    /// The origin is in this simplex, or on its border to rounding. Planes are outward unit normals and
    /// minus offsets, `planes[i]` opposite `corners[i]`.
    Around {
        corners: [Lanes; 7],
        planes: [Lanes; 7],
    },
    /// No wrench reaches farther than `height`, at most the tolerance, along the unit direction.
    Separated { direction: Wrench, height: f64 },
    /// Neither: ties or a nearly flat simplex.
    Undecided,
}

/// The barycentric functions of a simplex, one a lane: columns a₁…a₆ and b.
struct Simplex {
    columns: [Lanes; 7],
    corners: [Lanes; 7],
}

/// Looks for a simplex of wrenches around the origin. A direction along which nothing reaches
/// farther than `tolerance` proves that there is none. Some hundred nanoseconds.
#[inline(always)]
pub(super) fn closure(body: &impl Body, tolerance: f64) -> Closure {
    let mut simplex = Simplex::artificial();
    for step in 0..STEP_LIMIT {
        let norms = simplex.norms();
        let offsets = simplex.columns[6].zip(&norms, |b, norm| b / norm);
        let lane = if step < 7 {
            step
        } else {
            let mut deepest = 0;
            for lane in 1..7 {
                if offsets.0[lane] < offsets.0[deepest] {
                    deepest = lane;
                }
            }
            if offsets.0[deepest] >= -INSIDE_TOLERANCE * body.scale() {
                return simplex.settled(body.scale());
            }
            deepest
        };
        let side = if offsets.0[lane] < 0.0 { -1.0 } else { 1.0 };
        let outward = simplex.gradient(lane, side / norms.0[lane]);
        let reach = body.reach(&outward);
        if reach.height <= tolerance {
            return Closure::Separated {
                direction: outward.wrench(),
                height: reach.height,
            };
        }
        simplex.replace(lane, &reach.point);
    }
    Closure::Undecided
}

impl Simplex {
    /// A simplex around the origin whose corners are no wrenches.
    #[inline(always)]
    fn artificial() -> Self {
        let mut columns = [Lanes::splat(0.0); 7];
        for axis in 0..6 {
            columns[axis].0[axis] = 1.0;
            columns[axis].0[6] = -1.0;
        }
        columns[6] = Lanes::splat(1.0 / 7.0);
        // The lane that is no corner: a function that never decides anything.
        columns[6].0[7] = 1.0;
        columns[0].0[7] = 1.0;
        Self {
            columns,
            corners: [Lanes::splat(0.0); 7],
        }
    }

    /// ‖aᵢ‖ of every corner.
    #[inline(always)]
    fn norms(&self) -> Lanes {
        let mut squares = self.columns[0].map(|x| x * x);
        for column in &self.columns[1..6] {
            squares = squares.zip(column, |s, x| s + x * x);
        }
        squares.map(f64::sqrt)
    }

    /// factor · aᵢ.
    #[inline(always)]
    fn gradient(&self, lane: usize, factor: f64) -> Lanes {
        let mut gradient = Lanes::splat(0.0);
        for axis in 0..6 {
            gradient.0[axis] = self.columns[axis].0[lane] * factor;
        }
        gradient
    }

    /// The barycentric coordinates of a point given as six components and one.
    #[inline(always)]
    fn coordinates(&self, point: &Lanes) -> Lanes {
        let mut values = self.columns[0].map(|x| x * point.0[0]);
        for axis in 1..7 {
            values = values.zip(&self.columns[axis], |v, x| v + x * point.0[axis]);
        }
        values
    }

    #[inline(always)]
    fn replace(&mut self, lane: usize, point: &Lanes) {
        let values = self.coordinates(point);
        let shrink = values.0[lane].recip();
        for column in &mut self.columns {
            let own = column.0[lane] * shrink;
            *column = column.zip(&values, |x, v| x - v * own);
            column.0[lane] = own;
        }
        self.restore_idle_lane();
        self.corners[lane] = *point;
    }

    #[inline(always)]
    fn restore_idle_lane(&mut self) {
        for column in &mut self.columns {
            column.0[7] = 0.0;
        }
        self.columns[0].0[7] = 1.0;
        self.columns[6].0[7] = 1.0;
    }

    /// The planes of the facets, once the rounding of all replacements is mended.
    #[inline(always)]
    fn settled(mut self, scale: f64) -> Closure {
        let points = self.corners;
        let limits = self.norms().map(|norm| norm * (INVERSE_TOLERANCE * scale));
        for round in 0..=INVERSE_ROUNDS {
            // R·A − 1, one column a corner.
            let mut error = [Lanes::splat(0.0); 7];
            let mut greatest = Lanes::splat(0.0);
            for corner in 0..7 {
                error[corner] = self.coordinates(&points[corner]);
                error[corner].0[corner] -= 1.0;
                error[corner].0[7] = 0.0;
                greatest =
                    greatest.zip(&error[corner], |g, e| if e.abs() > g { e.abs() } else { g });
            }
            if greatest
                .0
                .iter()
                .zip(&limits.0)
                .all(|(e, limit)| e <= limit)
            {
                break;
            }
            // Also when the error is no number.
            if round == INVERSE_ROUNDS || !greatest.0.iter().all(|e| *e < 0.1) {
                return Closure::Undecided;
            }
            // R ← R − (R·A − 1)·R
            for column in &mut self.columns {
                let old = *column;
                for corner in 0..7 {
                    let factor = old.0[corner];
                    *column = column.zip(&error[corner], |x, e| x - e * factor);
                }
            }
            self.restore_idle_lane();
        }
        let norms = self.norms();
        let mut planes = [Lanes::splat(0.0); 7];
        for lane in 0..7 {
            let shrink = -norms.0[lane].recip();
            planes[lane] = self.gradient(lane, shrink);
            planes[lane].0[6] = self.columns[6].0[lane] * shrink;
        }
        Closure::Around {
            corners: self.corners,
            planes,
        }
    }
}
