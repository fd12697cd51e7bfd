//! Where the origin stands in the hull of a wrench set, and when that is decided.

use crate::wrench::Wrench;

/// A wrench beyond a facet by no more than this counts as lying in it. The signed distance of a point is
/// a sum of seven products, so it carries a few units of 2⁻⁵² ≈ 2·10⁻¹⁶; hyperplanes are made
/// from their neighbours in chains of some tens of steps, each adding as much. 10⁻¹² leaves a
/// hundredfold reserve and bounds the error of ε by itself: a facet that nothing exceeds by more
/// than t is within t of the true answer.
pub const COPLANAR_TOLERANCE: f64 = 1e-12;

/// A set thinner than this in some direction is treated as flat. Its ε could not exceed this
/// number; a hundred times [`COPLANAR_TOLERANCE`], so that every facet of a set that is not flat
/// can be distinguished from its opposite.
pub const RANK_TOLERANCE: f64 = 1e-10;

/// The origin is inside when the margin exceeds this. Margins closer to zero than a set may be
/// thin cannot be told from zero.
pub const CLOSURE_TOLERANCE: f64 = RANK_TOLERANCE;

/// Where the origin stands in the hull of a wrench set of full rank.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Margin {
    /// Signed distance from the origin to the nearest facet: ε when positive. From outside, and only
    /// there, the facets of a nearly flat set are so ill-conditioned that rounding moves it by far
    /// more than [`COPLANAR_TOLERANCE`]. Of a space that is no finite hull see
    /// [`Evaluator::grasp_margin`](super::Evaluator::grasp_margin).
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
    /// The result for a set with a component that is not finite: it spans nothing.
    pub(super) fn not_finite() -> Self {
        Self {
            rank: 0,
            direction: Wrench::zeros(),
        }
    }
}
