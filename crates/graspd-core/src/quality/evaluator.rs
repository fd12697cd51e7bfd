//! Evaluates wrench sets: the entry to every algorithm of this folder.

use super::hull::Hull;
use super::interval::Interval;
use super::lanes::{LANES, Lanes, NullaryFnOnce, vectorized};
use super::margin::{Degenerate, Margin};
use super::simplex;
use crate::wrench::Wrench;

/// Most facets built for one set unless the caller says otherwise: some 10 MB and 0.15 s.
pub const FACET_LIMIT: usize = 1 << 16;

/// Evaluates wrench sets and grasps. It holds the working memory: keep one per thread and reuse it.
///
/// ```
/// use graspd_core::quality::Evaluator;
/// use graspd_core::wrench::Wrench;
///
/// // The unit vectors along both directions of every axis: their hull is the cross-polytope, and the largest ball inside
/// // it has the radius 1/√6.
/// let wrenches: Vec<Wrench> = (0..6)
///     .flat_map(|axis| [Wrench::ith(axis, 1.0), Wrench::ith(axis, -1.0)])
///     .collect();
/// let mut evaluator = Evaluator::new();
/// let margin = evaluator.quality(&wrenches)?;
/// assert!((margin.value - 6.0_f64.sqrt().recip()).abs() < 1e-15);
///
/// // Without one of them, nothing can be exerted along it: the margin is zero, on the border.
/// let margin = evaluator.margin(&wrenches[1..])?;
/// assert!(!margin.is_force_closure());
/// # Ok::<(), graspd_core::quality::Degenerate>(())
/// ```
#[derive(Debug)]
pub struct Evaluator {
    pub(super) hull: Hull,
    pub(super) interval: Interval,
    /// Primitive wrenches of one grasp.
    pub(super) wrenches: Vec<Wrench>,
}

impl Default for Evaluator {
    fn default() -> Self {
        Self::new()
    }
}

impl Evaluator {
    /// Creates an evaluator that builds at most [`FACET_LIMIT`] facets for one set.
    pub fn new() -> Self {
        Self::with_facet_limit(FACET_LIMIT)
    }

    /// Creates an evaluator that stops after `limit` facets with the bounds known by then.
    pub fn with_facet_limit(limit: usize) -> Self {
        Self {
            hull: Hull::new(limit),
            interval: Interval::new(limit),
            wrenches: Vec::new(),
        }
    }

    /// Returns ε, exactly, of a set that contains the origin; for any other set, a hyperplane that separates it from the
    /// origin.
    ///
    /// Takes some microseconds for 32 wrenches. Any number of wrenches with any components is accepted.
    ///
    /// # Errors
    /// [`Degenerate`] when the set has no interior. A flat set is often found to lie on one side of the origin first, and
    /// then has a margin.
    pub fn quality(&mut self, wrenches: &[Wrench]) -> Result<Margin, Degenerate> {
        self.quality_above(wrenches, f64::NEG_INFINITY)
    }

    /// As [`Self::quality`] where ε exceeds `threshold`. As soon as it is known not to, returns the margin so far, inexact
    /// and with `upper` at most the threshold.
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

    /// [`Self::quality_above`] for sets other than seven wrenches, and for simplices that are too flat.
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

    /// Appends [`Self::quality`] of many sets of seven wrenches to `margins`, in order. Eight are computed at once, with
    /// the same bits as one by one.
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

    /// Returns the signed margin, exact on both sides of zero.
    ///
    /// Outside, this builds the whole hull: milliseconds for 32 wrenches. When the hull cannot be finished, the separating
    /// plane of [`Self::quality`] is returned instead, with `exact` false.
    pub fn margin(&mut self, wrenches: &[Wrench]) -> Result<Margin, Degenerate> {
        if let Some(margin) = simplex_margin(wrenches) {
            return Ok(margin);
        }
        self.hull.margin(wrenches)
    }

    /// Returns the outward unit normals of the facets at the origin of the hull of the origin and
    /// `wrenches`: the supporting hyperplanes of Roa & Suárez, Algorithm 1. A wrench w completes
    /// the set to force closure iff its dot product with every one of them is positive.
    ///
    /// The list is empty when the origin is already inside. `None` when the hull cannot be finished.
    /// Builds the whole hull around the origin: milliseconds for 24 wrenches.
    pub fn supporting_normals(
        &mut self,
        wrenches: &[Wrench],
    ) -> Result<Option<Vec<Wrench>>, Degenerate> {
        let mut with_origin = wrenches.to_vec();
        with_origin.push(Wrench::zeros());
        self.hull.facets_at_origin(&with_origin)
    }

    /// Returns the volume of the hull, in the sixth power of the wrenches' unit; zero for a flat set. `None` when the hull
    /// cannot be finished or its volume overflows. Builds the whole hull: milliseconds for 32 wrenches.
    pub fn volume(&mut self, wrenches: &[Wrench]) -> Option<f64> {
        self.hull.volume(wrenches).unwrap_or(Some(0.0))
    }
}

/// The margin of seven wrenches that are not too flat.
pub(super) fn simplex_margin(wrenches: &[Wrench]) -> Option<Margin> {
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
