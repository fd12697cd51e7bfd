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
mod evaluator;
mod facet;
mod grasp;
mod growth;
mod hull;
mod interval;
pub(crate) mod lanes;
mod margin;
mod pairing;
mod polytope;
mod precise;
mod simplex;
mod support;
mod twofold;
mod wrench_set;

#[cfg(test)]
mod oracle;
#[cfg(test)]
mod regular_tests;
#[cfg(test)]
mod space_tests;
#[cfg(test)]
mod tests;

pub use affine::Span;
pub use evaluator::{Evaluator, FACET_LIMIT};
pub use grasp::ACCURACY;
pub use margin::{CLOSURE_TOLERANCE, COPLANAR_TOLERANCE, Degenerate, Margin, RANK_TOLERANCE};
