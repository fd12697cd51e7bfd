//! A certified interval on the quality of a wrench space that is known by its support points alone.
//!
//! # Idea
//!
//! Round friction cones and the L∞ space have no finite set of vertices, or exponentially many. Both have a support point
//! in closed form along any direction (support.rs), and that is all the expanding polytope of hull.rs needs:
//!
//! ```text
//! P ← a simplex of support points around the origin
//! upper ← ∞
//! loop
//!     F ← the facet of P nearest to the origin, with the normal u
//!     upper ← min(upper, support value along u)
//!     if upper − offset(F) ≤ accuracy · upper: return [offset(F), upper]
//!     P ← hull(P ∪ {the support point along u})
//! ```
//!
//! # Invariant
//!
//! P stays inside the space, so its least facet offset bounds ε from below. The support value along any unit direction
//! bounds it from above. Both ends are widened by the rounding tolerance before they are returned.
//!
//! # Why it ends
//!
//! Where the space is a polytope, its facets are reached exactly. Where it is curved, the bounds meet in the limit only;
//! each halving of the gap takes a bounded number of support points, and the facet limit ends the worst cases with the
//! interval reached by then, which is still certified.

use super::closure::{Closure, closure};
use super::distance::distance;
use super::hull::widest_planes;
use super::lanes::{Lanes, NullaryFnOnce, vectorized};
use super::margin::{CLOSURE_TOLERANCE, COPLANAR_TOLERANCE, Degenerate, Margin};
use super::polytope::{Polytope, Unfinished};
use super::support::{Body, Space};
use crate::contact::Contact;
use crate::wrench::{Wrench, WrenchModel, WrenchSpace};

/// Evaluates one grasp after the other and keeps the memory for it.
#[derive(Debug, Default)]
pub(super) struct Interval {
    space: Space,
    polytope: Polytope,
    facet_limit: usize,
}

impl Interval {
    /// Builds at most `facet_limit` facets for one grasp, including those replaced on the way.
    pub fn new(facet_limit: usize) -> Self {
        Self {
            facet_limit,
            ..Self::default()
        }
    }

    /// An interval on ε of a width at most `accuracy` times its upper end, or a plane that proves the
    /// origin outside. Stops, with the interval so far, as soon as ε is known not to exceed `threshold`.
    pub fn quality(
        &mut self,
        model: &WrenchModel,
        contacts: &[Contact],
        accuracy: f64,
        threshold: f64,
    ) -> Result<Margin, Degenerate> {
        if !self.space.load(model, contacts) {
            return Err(Degenerate::not_finite());
        }
        vectorized(Expansion {
            threshold: threshold / self.space.unit,
            interval: self,
            accuracy,
        })
    }

    /// As [`Self::quality`], but outside, in L1, an interval on minus the distance of the origin from the
    /// space, which is the least support value here too.
    pub fn margin(
        &mut self,
        model: &WrenchModel,
        contacts: &[Contact],
        accuracy: f64,
    ) -> Result<Margin, Degenerate> {
        let inside = self.quality(model, contacts, accuracy, f64::NEG_INFINITY)?;
        // Zero is in every L∞ space.
        if inside.is_force_closure() || model.space == WrenchSpace::Linf {
            return Ok(inside);
        }
        let start = Lanes::of(&inside.direction, 0.0);
        let gap = distance(&self.space, &start, accuracy);
        // Nothing separates the origin better than what proved it outside.
        if gap.least <= -inside.upper / self.space.unit {
            return Ok(inside);
        }
        let tolerance = COPLANAR_TOLERANCE * self.space.scale();
        let wide = gap.greatest - gap.least > accuracy * gap.greatest + tolerance;
        Ok(self.between(-gap.greatest, -gap.least, gap.direction, !wide))
    }

    #[inline(always)]
    fn expanded(&mut self, accuracy: f64, threshold: f64) -> Result<Margin, Degenerate> {
        let scale = self.space.scale();
        let (corners, planes) = match closure(&self.space, CLOSURE_TOLERANCE * scale) {
            Closure::Around { corners, planes } => (corners, planes),
            Closure::Separated { direction, height } => {
                return Ok(self.outside(direction, height));
            }
            Closure::Undecided => widest_planes(&self.space.samples, scale)?,
        };
        let tolerance = COPLANAR_TOLERANCE * scale;
        self.polytope
            .start(&corners, &planes, tolerance, self.facet_limit);
        Ok(self.expand(accuracy, threshold))
    }

    #[inline(always)]
    fn expand(&mut self, accuracy: f64, threshold: f64) -> Margin {
        let closing = CLOSURE_TOLERANCE * self.space.scale();
        let tolerance = COPLANAR_TOLERANCE * self.space.scale();
        let mut upper = f64::INFINITY;
        let mut weakest = Lanes::splat(0.0);
        // No facet of the polytope that is nearer than this is left.
        let mut enough = f64::INFINITY;
        while let Some(nearest) = self.polytope.nearest() {
            let reach = self.space.reach(&nearest.normal);
            if reach.height <= closing {
                return self.outside(nearest.normal.wrench(), reach.height);
            }
            if reach.height < upper {
                (upper, weakest) = (reach.height, nearest.normal);
                // Both ends are widened by a tolerance in the end.
                let width = (accuracy * upper - 2.0 * tolerance).max(tolerance);
                enough = upper - width;
            }
            if upper + tolerance <= threshold {
                return self.between(nearest.offset, upper, weakest.wrench(), false);
            }
            if nearest.offset >= enough {
                break;
            }
            if upper <= threshold {
                return self.between(nearest.offset, upper, weakest.wrench(), false);
            }
            if reach.height <= nearest.offset + tolerance {
                // A facet of the space itself.
                enough = nearest.offset;
                break;
            }
            match self.polytope.insert(&reach.point) {
                Ok(true) => {}
                Ok(false) => {
                    // Beyond by no more than the rounding of the product that says so.
                    enough = nearest.offset;
                    break;
                }
                Err(Unfinished) => {
                    return self.between(nearest.offset, upper, weakest.wrench(), false);
                }
            }
        }
        self.between(enough, upper, weakest.wrench(), true)
    }

    /// The interval, widened by what rounding may have moved its ends.
    fn between(&self, lower: f64, upper: f64, direction: Wrench, exact: bool) -> Margin {
        let tolerance = COPLANAR_TOLERANCE * self.space.scale();
        self.margin_of(lower - tolerance, upper + tolerance, direction, exact)
    }

    fn outside(&self, direction: Wrench, height: f64) -> Margin {
        self.margin_of(height, height, direction, false)
    }

    fn margin_of(&self, lower: f64, upper: f64, direction: Wrench, exact: bool) -> Margin {
        let unit = self.space.unit;
        Margin {
            value: lower * unit,
            upper: upper * unit,
            direction,
            scale: self.space.scale() * unit,
            exact,
            facets: self.polytope.facet_count(),
        }
    }
}

/// [`Interval::expanded`], vectorized.
struct Expansion<'a> {
    interval: &'a mut Interval,
    accuracy: f64,
    threshold: f64,
}

impl NullaryFnOnce for Expansion<'_> {
    type Output = Result<Margin, Degenerate>;

    #[inline(always)]
    fn call(self) -> Self::Output {
        self.interval.expanded(self.accuracy, self.threshold)
    }
}
