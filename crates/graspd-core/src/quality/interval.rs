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
use super::grasp::ACCURACY;
use super::growth::{Growing, Unfinished};
use super::hull::{FOLD_TOLERANCE, PRECISE_FACETS, widest_planes};
use super::lanes::{Lanes, NullaryFnOnce, vectorized};
use super::margin::{CLOSURE_TOLERANCE, COPLANAR_TOLERANCE, Degenerate, Margin};
use super::polytope::Polytope;
use super::precise::PrecisePolytope;
use super::support::{Body, Space};
use crate::contact::Contact;
use crate::wrench::{Wrench, WrenchModel, WrenchSpace};

/// What rounding may add to a relative width that is just as wide as it may be.
const ROUNDING: f64 = 1e-9;

/// Evaluates one grasp after the other and keeps the memory for it.
#[derive(Debug, Default)]
pub(super) struct Interval {
    space: Space,
    polytope: Polytope,
    precise: PrecisePolytope,
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
        if inside.is_force_closure() {
            return Ok(inside);
        }
        // A flat space lies on one side of the origin too, and its rank says more.
        widest_planes(&self.space.samples, self.space.scale())?;
        // Zero is in every L∞ space.
        if model.space == WrenchSpace::Linf {
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
        let ends = (-gap.greatest, -gap.least);
        Ok(between(
            &self.space,
            ends,
            gap.direction,
            !wide,
            inside.facets,
        ))
    }

    /// The distance of the origin from the wrench space, to a relative `accuracy`, but never more than a direction proves;
    /// zero when the space cannot be distinguished from one that holds the origin. `start` is a direction along which the space does
    /// not reach the origin.
    pub fn distance(
        &mut self,
        model: &WrenchModel,
        contacts: &[Contact],
        start: &Wrench,
        accuracy: f64,
    ) -> f64 {
        if !self.space.load(model, contacts) {
            return 0.0;
        }
        let gap = distance(&self.space, &Lanes::of(start, 0.0), accuracy);
        gap.least.max(0.0) * self.space.unit
    }

    #[inline(always)]
    fn expanded(&mut self, accuracy: f64, threshold: f64) -> Result<Margin, Degenerate> {
        let Self {
            space,
            polytope,
            precise,
            facet_limit,
        } = self;
        let scale = space.scale();
        // The least that ε is proven to be.
        let mut proven = 0.0;
        let (corners, planes) = match closure(space, CLOSURE_TOLERANCE * scale) {
            Closure::Around { corners, planes } => (corners, planes),
            Closure::Separated { direction, height } => {
                return Ok(outside(space, direction, height, 0));
            }
            Closure::Undecided => {
                proven = f64::NEG_INFINITY;
                widest_planes(&space.samples, scale)?
            }
        };
        let tolerance = COPLANAR_TOLERANCE * scale;
        polytope.start(&corners, &planes, tolerance, *facet_limit);
        let wanted = Wanted {
            accuracy,
            threshold,
            proven,
        };
        Ok(match expand(space, polytope, &wanted) {
            Ok(margin) => margin,
            Err(folded) => {
                let limit = PRECISE_FACETS.min(*facet_limit);
                precise.start(&corners, &planes, tolerance, limit);
                expand_precisely(space, precise, &wanted, &folded)
            }
        })
    }
}

/// What an expansion is for: an interval of a relative width of `accuracy` where ε exceeds `threshold`. ε is known to be at
/// least `proven`, zero where the origin is in the simplex that the growth starts with.
struct Wanted {
    accuracy: f64,
    threshold: f64,
    proven: f64,
}

/// The surface was found to be folded. By then ε was proven to be from `proven` to `upper`, which is reached along `weakest`.
struct Folded {
    proven: f64,
    upper: f64,
    weakest: Wrench,
}

/// Grows the polytope until its nearest facet is as far from the origin as the space reaches along some direction, to
/// `accuracy`.
#[inline(always)]
fn expand(space: &Space, polytope: &mut impl Growing, wanted: &Wanted) -> Result<Margin, Folded> {
    let &Wanted {
        accuracy,
        threshold,
        mut proven,
    } = wanted;
    let closing = CLOSURE_TOLERANCE * space.scale();
    let tolerance = COPLANAR_TOLERANCE * space.scale();
    let fold = FOLD_TOLERANCE * space.scale();
    let mut upper = f64::INFINITY;
    let mut weakest = Lanes::splat(0.0);
    // No facet of the polytope that is nearer than this is left.
    let mut enough = None;
    while let Some(nearest) = polytope.nearest() {
        if nearest.offset < proven - fold {
            break;
        }
        if nearest.offset >= 0.0 {
            proven = nearest.offset.max(proven);
        }
        let reach = space.reach(&nearest.normal);
        if reach.height <= closing {
            let facets = polytope.facet_count();
            return Ok(outside(
                space,
                nearest.normal.wrench(),
                reach.height,
                facets,
            ));
        }
        if reach.height < upper {
            (upper, weakest) = (reach.height, nearest.normal);
        }
        let so_far = |exact, facets| {
            let ends = (nearest.offset, upper);
            Ok(between(space, ends, weakest.wrench(), exact, facets))
        };
        if upper + tolerance <= threshold {
            return so_far(false, polytope.facet_count());
        }
        // Both ends are widened by a tolerance in the end.
        let width = (accuracy * upper - 2.0 * tolerance).max(tolerance);
        if nearest.offset >= upper - width {
            enough = Some(upper - width);
            break;
        }
        if upper <= threshold {
            return so_far(false, polytope.facet_count());
        }
        if reach.height <= nearest.offset + tolerance {
            // A facet of the space itself.
            enough = Some(nearest.offset);
            break;
        }
        match polytope.insert(&reach.point) {
            Ok(true) => {}
            Ok(false) => {
                // Beyond by no more than the rounding of the product that says so.
                enough = Some(nearest.offset);
                break;
            }
            Err(Unfinished::Limit) => return so_far(false, polytope.facet_count()),
            Err(Unfinished::Folded) => break,
        }
    }
    let folded = Folded {
        proven,
        upper,
        weakest: weakest.wrench(),
    };
    let enough = enough.ok_or(folded)?;
    // Where ε is next to nothing beside the scale, rounding alone makes the interval wider than it may be.
    let allowed = accuracy.max(ACCURACY) * (1.0 + ROUNDING);
    let exact = upper - enough + 2.0 * tolerance <= allowed * upper;
    let facets = polytope.facet_count();
    let ends = (enough, upper);
    Ok(between(space, ends, weakest.wrench(), exact, facets))
}

/// [`expand`] where doubles fold the surface.
#[cold]
#[inline(never)]
fn expand_precisely(
    space: &Space,
    polytope: &mut PrecisePolytope,
    wanted: &Wanted,
    before: &Folded,
) -> Margin {
    expand(space, polytope, wanted).unwrap_or_else(|folded| {
        let proven = before.proven.max(folded.proven).max(-space.scale());
        let nearer = match before.upper < folded.upper {
            true => before,
            false => &folded,
        };
        let ends = (proven, nearer.upper.min(space.scale()));
        let facets = polytope.facet_count();
        between(space, ends, nearer.weakest, false, facets)
    })
}

/// The interval, widened by what rounding may have moved its ends.
fn between(
    space: &Space,
    (lower, upper): (f64, f64),
    direction: Wrench,
    exact: bool,
    facets: usize,
) -> Margin {
    let tolerance = COPLANAR_TOLERANCE * space.scale();
    let ends = (lower - tolerance, upper + tolerance);
    margin_of(space, ends, direction, exact, facets)
}

fn outside(space: &Space, direction: Wrench, height: f64, facets: usize) -> Margin {
    margin_of(space, (height, height), direction, false, facets)
}

fn margin_of(
    space: &Space,
    (lower, upper): (f64, f64),
    direction: Wrench,
    exact: bool,
    facets: usize,
) -> Margin {
    let unit = space.unit;
    Margin {
        value: lower * unit,
        upper: upper * unit,
        direction,
        scale: space.scale() * unit,
        exact,
        facets,
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
