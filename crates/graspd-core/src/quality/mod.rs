//! Grasp quality: how large an origin-centred ball fits into the convex hull of a wrench set.
//!
//! For a unit direction u the support of the set is h(u) = max u·w over its wrenches w. The
//! quality ε is the minimum of h over all unit u (Ferrari & Canny 1992); it is reached at the
//! outward normal of a facet of the hull. The signed margin is the least offset of any facet:
//! ε when the origin is inside, zero or negative when it is not.
//!
//! Every length below is in the unit of the wrenches, and every tolerance is relative to the
//! longest wrench of the set, called its scale.

mod affine;
mod closure;
mod distance;
mod grasp;
mod hull;
mod interval;
pub(super) mod lanes;
mod pairing;
mod polytope;
mod simplex;
mod support;
mod wrench_set;

#[cfg(test)]
mod oracle;
#[cfg(test)]
mod space_tests;
#[cfg(test)]
mod tests;

use super::wrench::Wrench;
pub use affine::Span;
pub use grasp::ACCURACY;
use hull::Hull;
use interval::Interval;
use lanes::{LANES, Lanes, NullaryFnOnce, vectorized};

/// A wrench this little beyond a facet counts as lying in it. The signed distance of a point is
/// a sum of seven products, so it carries a few units of 2⁻⁵² ≈ 2·10⁻¹⁶; hyperplanes are made
/// from their neighbours in chains of some tens of steps, each adding as much. 10⁻¹² leaves a
/// hundredfold reserve and bounds the error of ε by itself: a facet that nothing exceeds by more
/// than t is within t of the true answer.
pub const COPLANAR_TOLERANCE: f64 = 1e-12;

/// A set thinner than this in some direction is treated as flat. Its ε could not exceed this
/// number; a hundred times [`COPLANAR_TOLERANCE`], so that every facet of a set that is not flat
/// is told apart from its opposite.
pub const RANK_TOLERANCE: f64 = 1e-10;

/// The origin is inside when the margin exceeds this. Margins closer to zero than a set may be
/// thin cannot be told from zero.
pub const CLOSURE_TOLERANCE: f64 = RANK_TOLERANCE;

/// Most facets built for one set unless the caller says otherwise: some 10 MB and 0.15 s.
pub const FACET_LIMIT: usize = 1 << 16;

/// Where the origin stands in the hull of a wrench set of full rank.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Margin {
    /// Signed distance from the origin to the nearest facet: ε when positive. From outside, and only
    /// there, the facets of a nearly flat set are so ill-conditioned that rounding moves it by far
    /// more than [`COPLANAR_TOLERANCE`]. Of a space that is no finite hull see
    /// [`Evaluator::grasp_margin`].
    pub value: f64,
    /// Unit outward normal of that facet. Inside, −direction is the disturbance that the grasp
    /// resists worst; outside, the grasp can exert nothing along +direction.
    pub direction: Wrench,
    /// Least support value found, never below the value to rounding: ε is from `value` to `upper`. They
    /// differ where the wrench space is no polytope, and where the hull could not be finished.
    pub upper: f64,
    /// Longest wrench of the set, or a bound on it; tolerances are relative to it.
    pub scale: f64,
    /// `false` when `value` and `direction` are only those of some hyperplane that has every wrench
    /// on its far side and so proves the origin outside, or when the hull could not be finished, at
    /// its facet limit for one; inside, `value` is then a lower bound on ε.
    pub exact: bool,
    /// Facets built on the way.
    pub facets: usize,
}

impl Margin {
    /// Whether the origin lies strictly inside the hull.
    pub fn is_force_closure(&self) -> bool {
        self.value > CLOSURE_TOLERANCE * self.scale
    }
}

/// The wrenches do not span the space: their hull has no interior and the grasp no quality.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
#[error("the wrenches span only {rank} of 6 dimensions")]
pub struct Degenerate {
    /// Dimension of the smallest flat through the wrenches, 0 to 5.
    pub rank: usize,
    /// A unit direction in which all wrenches have the same component, zero or negative: nothing
    /// can be exerted along it.
    pub direction: Wrench,
}

impl Degenerate {
    /// The verdict on a set with a component that is not finite: it spans nothing.
    fn not_finite() -> Self {
        Self {
            rank: 0,
            direction: Wrench::zeros(),
        }
    }
}

/// Evaluates wrench sets. Holds the working memory, so keep one per thread and reuse it.
#[derive(Debug)]
pub struct Evaluator {
    hull: Hull,
    interval: Interval,
    /// Primitive wrenches of one grasp.
    wrenches: Vec<Wrench>,
}

impl Default for Evaluator {
    fn default() -> Self {
        Self::new()
    }
}

impl Evaluator {
    /// An evaluator that builds at most [`FACET_LIMIT`] facets for one set.
    pub fn new() -> Self {
        Self::with_facet_limit(FACET_LIMIT)
    }

    /// An evaluator that gives a set up, with the bound it has by then, after `limit` facets.
    pub fn with_facet_limit(limit: usize) -> Self {
        Self {
            hull: Hull::new(limit),
            interval: Interval::new(limit),
            wrenches: Vec::new(),
        }
    }

    /// ε, exactly, of a set that contains the origin; for any other a hyperplane that proves it.
    ///
    /// Takes some microseconds for 32 wrenches. `Err` when the set has no interior, as far as that
    /// is noticed: a flat set is usually found outside first.
    ///
    /// # Panics
    /// Never, whatever the wrenches and however many.
    pub fn quality(&mut self, wrenches: &[Wrench]) -> Result<Margin, Degenerate> {
        self.quality_above(wrenches, f64::NEG_INFINITY)
    }

    /// As [`Self::quality`], but only where ε exceeds `threshold`: once it is known not to, the margin
    /// so far is returned, inexact, with `upper` at most the threshold.
    pub fn quality_above(
        &mut self,
        wrenches: &[Wrench],
        threshold: f64,
    ) -> Result<Margin, Degenerate> {
        if let Some(margin) = simplex_margin(wrenches) {
            return Ok(margin);
        }
        self.expanded_quality(wrenches, threshold)
    }

    /// [`Self::quality_above`] of what is no simplex, or too flat for one.
    fn expanded_quality(
        &mut self,
        wrenches: &[Wrench],
        threshold: f64,
    ) -> Result<Margin, Degenerate> {
        vectorized(Quality {
            hull: &mut self.hull,
            wrenches,
            threshold,
        })
    }

    /// [`Self::quality`] of many sets of seven wrenches, appended to `margins` in their order: to the last
    /// bit the same, but eight at once.
    pub fn qualities_of_sevens(
        &mut self,
        sets: &[[Wrench; 7]],
        margins: &mut Vec<Result<Margin, Degenerate>>,
    ) {
        for chunk in sets.chunks(LANES) {
            let eight = std::array::from_fn(|i| chunk.get(i).unwrap_or(&chunk[0]));
            let found: [_; LANES] = vectorized(Eight(eight));
            for (set, margin) in chunk.iter().zip(found) {
                margins
                    .push(margin.map_or_else(|| self.expanded_quality(set, f64::NEG_INFINITY), Ok));
            }
        }
    }

    /// The signed margin, exactly on both sides of zero.
    ///
    /// Outside, this needs the whole hull: milliseconds for 32 wrenches. Of a hull that cannot be
    /// finished only the proof is returned that the origin is outside, as by [`Self::quality`], and not
    /// called exact.
    pub fn margin(&mut self, wrenches: &[Wrench]) -> Result<Margin, Degenerate> {
        if let Some(margin) = simplex_margin(wrenches) {
            return Ok(margin);
        }
        self.hull.margin(wrenches)
    }

    /// The outward unit normals of the facets at the origin of the hull of the origin and
    /// `wrenches`: the supporting hyperplanes of Roa & Suárez, Algorithm 1. A wrench w completes
    /// the set to force closure iff its dot product with every one of them is positive.
    ///
    /// Empty when the origin is already inside; `None` when the hull could not be finished.
    /// Builds the whole hull around the origin: milliseconds for 24 wrenches.
    pub fn supporting_normals(
        &mut self,
        wrenches: &[Wrench],
    ) -> Result<Option<Vec<Wrench>>, Degenerate> {
        let mut with_origin = wrenches.to_vec();
        with_origin.push(Wrench::zeros());
        self.hull.facets_at_origin(&with_origin)
    }

    /// The volume of the hull, in the sixth power of the wrenches' unit: zero for a flat set, `None`
    /// when the hull could not be finished or its volume is too large for a number. Builds the whole hull: milliseconds for 32 wrenches.
    pub fn volume(&mut self, wrenches: &[Wrench]) -> Option<f64> {
        self.hull.volume(wrenches).unwrap_or(Some(0.0))
    }
}

/// The margin of seven wrenches that are not too flat.
fn simplex_margin(wrenches: &[Wrench]) -> Option<Margin> {
    let seven = <&[Wrench; 7]>::try_from(wrenches).ok()?;
    let [margin] = vectorized(One([seven]));
    margin
}

/// [`Hull::quality`], vectorized.
struct Quality<'a> {
    hull: &'a mut Hull,
    wrenches: &'a [Wrench],
    threshold: f64,
}

impl NullaryFnOnce for Quality<'_> {
    type Output = Result<Margin, Degenerate>;

    #[inline(always)]
    fn call(self) -> Self::Output {
        self.hull.quality(self.wrenches, self.threshold)
    }
}

/// [`simplex::margins`] of one set, vectorized.
struct One<'a>([&'a [Wrench; 7]; 1]);

impl NullaryFnOnce for One<'_> {
    type Output = [Option<Margin>; 1];

    #[inline(always)]
    fn call(self) -> Self::Output {
        simplex::margins::<f64, 1>(&self.0)
    }
}

/// [`simplex::margins`] of eight sets, vectorized.
struct Eight<'a>([&'a [Wrench; 7]; LANES]);

impl NullaryFnOnce for Eight<'_> {
    type Output = [Option<Margin>; LANES];

    #[inline(always)]
    fn call(self) -> Self::Output {
        simplex::margins::<Lanes, LANES>(&self.0)
    }
}

#[cfg(test)]
/// Length of the longest wrench.
fn scale(wrenches: &[Wrench]) -> f64 {
    wrenches
        .iter()
        .map(Wrench::norm_squared)
        .fold(0.0, f64::max)
        .sqrt()
}
