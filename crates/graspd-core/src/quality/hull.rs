//! Quality of a finite wrench set, by the best-first expanding polytope.
//!
//! # Idea
//!
//! The hull of a few dozen wrenches in six dimensions has thousands of facets, but one of them decides ε. So the
//! hull is never built. A polytope inside it grows, always at its weakest place: where its facet nearest to the
//! origin is.
//!
//! ```text
//! P ← a simplex of seven wrenches around the origin          (closure.rs; none: not force closure)
//! loop
//!     F ← the facet of P nearest to the origin
//!     w ← the wrench farthest along the normal of F          (wrench_set.rs)
//!     if w is not above F by more than the tolerance: return the offset of F
//!     if w is not above the origin: return "outside", with the normal of F as the proof
//!     P ← hull(P ∪ {w})                                      (polytope.rs)
//! ```
//!
//! # Invariant, and why the answer is exact
//!
//! P lies inside the hull, so the least offset of its facets is a lower bound on ε. The support value of the set along
//! any unit direction is an upper bound. At the end both meet at F: no wrench lies above it, so F is a facet of the hull
//! itself. Its plane is then solved anew from the wrenches that lie in it, so that no rounding of the way there enters
//! the answer.
//!
//! # Why it ends, and what it costs
//!
//! No wrench is added twice, so there are at most n insertions; the facet limit bounds each. For the 32 wrenches of four
//! fingers some 100 to 300 facets are built (docs/quality.md has the measurements). The threshold of a search ends most evaluations
//! after a few of them: the first support value below it proves that the grasp is no better.
//!
//! Outside, the exact margin and the volume do need the whole hull. It grows the same way, in the order in which facets
//! come, until every facet is final.
//!
//! Zheng (2013), "An efficient algorithm for a grasp quality measure" (IEEE Transactions on Robotics 29), is the
//! published relative.

use super::affine::{widest_normal, widest_simplex};
use super::closure::{Closure, closure};
use super::lanes::Lanes;
use super::margin::{CLOSURE_TOLERANCE, COPLANAR_TOLERANCE, Degenerate, Margin};
use super::polytope::{Nearest, Polytope, Unfinished, plane_through};
use super::wrench_set::{Support, WrenchSet};
use crate::wrench::Wrench;

/// Evaluates one wrench set after the other and keeps the memory for it.
#[derive(Debug, Default)]
pub(super) struct Hull {
    set: WrenchSet,
    polytope: Polytope,
    /// Which wrenches were added. None is added twice, which bounds the work: a wrench that seems to lie beyond a facet
    /// a second time does so by rounding alone, in a set that is flat otherwise.
    added: Vec<bool>,
    /// Wrenches of a final facet.
    inside: Vec<Lanes>,
    facet_limit: usize,
}

/// The facet found nearest so far: outward unit normal, offset, and the support value along it.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Found {
    direction: Wrench,
    lower: f64,
    upper: f64,
}

/// Facet limit of a second try in the order of the offsets. Finding the nearest facet is linear in their number, so the
/// time grows with its square: some 5 ms.
const RETRY_FACETS: usize = 1 << 13;

/// In which order the facets of a whole hull are taken.
#[derive(Debug, Clone, Copy)]
enum Order {
    /// In constant time each.
    Oldest,
    Nearest,
}

impl Hull {
    /// Builds at most `facet_limit` facets for one set, including those replaced on the way.
    pub fn new(facet_limit: usize) -> Self {
        Self {
            facet_limit,
            ..Self::default()
        }
    }

    /// Returns ε of a set with the origin inside, or a plane that proves it outside. Stops as soon as ε is known not to
    /// exceed `threshold`.
    #[inline(always)]
    pub fn quality(&mut self, wrenches: &[Wrench], threshold: f64) -> Result<Margin, Degenerate> {
        self.load(wrenches)?;
        if wrenches.len() < 7 {
            // Fewer than seven points are flat; this finds the rank and the missing direction.
            self.start_widest(self.facet_limit)?;
        }
        let threshold = threshold / self.set.unit;
        self.expanded(threshold)
    }

    /// [`Self::quality`] of the set that is loaded, in its unit.
    #[inline(always)]
    fn expanded(&mut self, threshold: f64) -> Result<Margin, Degenerate> {
        let closing = CLOSURE_TOLERANCE * self.set.scale;
        match closure(&self.set, closing) {
            Closure::Around { corners, planes } => {
                self.start(&corners, &planes, self.facet_limit);
            }
            Closure::Separated { direction, height } => {
                return Ok(self.outside(direction, height));
            }
            Closure::Undecided => self.start_widest(self.facet_limit)?,
        }
        Ok(self.expand(threshold.max(closing)))
    }

    /// Returns the least offset of any facet, on whichever side the origin is; inside, it is ε to the last bit.
    pub fn margin(&mut self, wrenches: &[Wrench]) -> Result<Margin, Degenerate> {
        self.load(wrenches)?;
        let proof = self.expanded(f64::NEG_INFINITY)?;
        if proof.is_force_closure() {
            return Ok(proof);
        }
        // Rounding can fold the facets of a nearly flat set so that none can be replaced any more, in one
        // order of insertion and not in another.
        let mut whole = Err(Unfinished);
        for (order, most) in [
            (Order::Oldest, self.facet_limit),
            (Order::Nearest, RETRY_FACETS.min(self.facet_limit)),
        ] {
            if whole.is_err() {
                self.start_widest(most)?;
                whole = self.least_facet(order);
            }
        }
        let closing = CLOSURE_TOLERANCE * self.set.scale;
        Ok(match whole {
            Ok(Some(found)) if found.lower <= closing => self.margin_of(&found, true),
            _ => proof,
        })
    }

    /// The facet of the whole hull with the least offset, once a simplex is started with.
    fn least_facet(&mut self, order: Order) -> Result<Option<Found>, Unfinished> {
        let mut least: Option<Found> = None;
        let mut from = 0;
        while let Some(facet) = match order {
            Order::Oldest => self.polytope.any(&mut from),
            Order::Nearest => self.polytope.nearest(),
        } {
            let support = self.set.support(&facet.normal);
            match self.advance(&facet, support) {
                Ok(None) => {}
                Ok(Some(found)) if self.is_sharp(&found) => {
                    if least.is_none_or(|l| found.lower < l.lower) {
                        least = Some(found);
                    }
                }
                // The least facet may be among those that were not reached.
                Ok(Some(_)) | Err(Unfinished) => return Err(Unfinished),
            }
        }
        Ok(least)
    }

    /// Outward normals of the facets of the whole hull through the origin, which must be one of
    /// the wrenches. Empty when it is inside; `None` when the hull could not be finished.
    pub fn facets_at_origin(
        &mut self,
        wrenches: &[Wrench],
    ) -> Result<Option<Vec<Wrench>>, Degenerate> {
        self.load(wrenches)?;
        self.start_widest(self.facet_limit)?;
        let closing = CLOSURE_TOLERANCE * self.set.scale;
        let mut normals: Vec<Wrench> = Vec::new();
        let mut from = 0;
        while let Some(nearest) = self.polytope.any(&mut from) {
            // What replaces it is farther out still, so none through the origin comes of it.
            if nearest.offset > closing {
                continue;
            }
            let support = self.set.support(&nearest.normal);
            match self.advance(&nearest, support) {
                Ok(None) => {}
                Ok(Some(found)) if self.is_sharp(&found) => {
                    normals.push(nearest.normal.wrench());
                }
                Ok(Some(_)) | Err(Unfinished) => return Ok(None),
            }
        }
        Ok(Some(normals))
    }

    /// The volume of the hull, in the sixth power of the unit of the wrenches; `None` when the hull
    /// could not be finished, or is too large for a number.
    pub fn volume(&mut self, wrenches: &[Wrench]) -> Result<Option<f64>, Degenerate> {
        self.load(wrenches)?;
        self.start_widest(self.facet_limit)?;
        let mut from = 0;
        while let Some(nearest) = self.polytope.any(&mut from) {
            let support = self.set.support(&nearest.normal);
            if self.advance(&nearest, support) == Err(Unfinished) {
                return Ok(None);
            }
        }
        let unit = self.set.unit;
        let volume = (0..6).fold(self.polytope.volume(), |volume, _| volume * unit);
        Ok(volume.is_finite().then_some(volume))
    }

    #[inline(always)]
    fn load(&mut self, wrenches: &[Wrench]) -> Result<(), Degenerate> {
        if !self.set.load(wrenches) {
            return Err(Degenerate::not_finite());
        }
        if self.set.scale > 0.0 {
            return Ok(());
        }
        // Nothing at all, or all zero.
        let flat = widest_simplex(&self.set.rows, 0.0);
        Err(flat.err().unwrap_or_else(Degenerate::not_finite))
    }

    #[inline(always)]
    fn start(&mut self, corners: &[Lanes; 7], planes: &[Lanes; 7], facet_limit: usize) {
        self.added.clear();
        self.added.resize(self.set.rows.len(), false);
        let tolerance = COPLANAR_TOLERANCE * self.set.scale;
        self.polytope.start(corners, planes, tolerance, facet_limit);
    }

    /// Starts with the most spread seven wrenches, wherever the origin is, for at most `facet_limit` facets.
    fn start_widest(&mut self, facet_limit: usize) -> Result<(), Degenerate> {
        let (corners, planes) = widest_planes(&self.set.rows, self.set.scale)?;
        self.start(&corners, &planes, facet_limit);
        Ok(())
    }

    /// Takes one step at a facet: returns it when it is a facet of the hull, else adds the support wrench beyond it.
    #[inline(always)]
    fn advance(
        &mut self,
        nearest: &Nearest,
        support: Support,
    ) -> Result<Option<Found>, Unfinished> {
        if support.height <= nearest.offset + COPLANAR_TOLERANCE * self.set.scale {
            return Ok(Some(self.sharpened(nearest, support)));
        }
        let added = &mut self.added[support.wrench as usize];
        if *added {
            return Ok(Some(unfinished(nearest, support.height)));
        }
        *added = true;
        let row = self.set.rows[support.wrench as usize];
        if self.polytope.insert(&row)? {
            return Ok(None);
        }
        // Beyond by no more than the rounding of the product that says so.
        Ok(Some(self.sharpened(nearest, support)))
    }

    /// Whether a facet is one of the hull to the tolerance that separates flat sets from others.
    fn is_sharp(&self, found: &Found) -> bool {
        found.upper - found.lower <= CLOSURE_TOLERANCE * self.set.scale
    }

    /// Grows the polytope until its nearest facet is one of the hull, or the origin proves to be
    /// outside, or ε not to exceed `threshold`.
    #[inline(always)]
    fn expand(&mut self, threshold: f64) -> Margin {
        let closing = CLOSURE_TOLERANCE * self.set.scale;
        let mut upper = f64::INFINITY;
        while let Some(nearest) = self.polytope.nearest() {
            let support = self.set.support(&nearest.normal);
            upper = upper.min(support.height);
            if support.height <= closing {
                return self.outside(nearest.normal.wrench(), support.height);
            }
            match self.advance(&nearest, support) {
                Ok(Some(found)) => return self.margin_of(&found, self.is_sharp(&found)),
                Ok(None) if upper > threshold => {}
                Ok(None) | Err(Unfinished) => {
                    return self.margin_of(&unfinished(&nearest, upper), false);
                }
            }
        }
        self.outside(Wrench::ith(0, 1.0), 0.0)
    }

    /// The plane of a final facet, solved anew from the widest spread of wrenches that lie in it, so
    /// that the rounding of the chain that led to it does not enter the answer. A support value
    /// bounds ε from above for any unit normal, so the lesser of old and new is kept.
    #[inline(always)]
    fn sharpened(&mut self, nearest: &Nearest, support: Support) -> Found {
        let mut found = Found {
            direction: nearest.normal.wrench(),
            lower: support.height,
            upper: support.height,
        };
        let tolerance = COPLANAR_TOLERANCE * self.set.scale;
        self.inside.clear();
        let inside = self
            .set
            .reaching(&nearest.normal, support.height - tolerance);
        self.inside.extend(inside);
        if let Some(sharp) = widest_normal(&mut self.inside, &nearest.normal, tolerance) {
            let height = self.set.support(&sharp).height;
            if height < found.lower {
                found = Found {
                    direction: sharp.wrench(),
                    lower: height,
                    upper: height,
                };
            }
        }
        found
    }

    fn outside(&self, direction: Wrench, height: f64) -> Margin {
        let found = Found {
            direction,
            lower: height,
            upper: height,
        };
        self.margin_of(&found, false)
    }

    #[inline(always)]
    fn margin_of(&self, found: &Found, exact: bool) -> Margin {
        let unit = self.set.unit;
        Margin {
            value: found.lower * unit,
            upper: found.upper * unit,
            direction: found.direction,
            scale: self.set.scale * unit,
            exact,
            facets: self.polytope.facet_count(),
        }
    }
}

/// The most spread seven of some points, and the planes of their facets, each opposite its corner.
pub(super) fn widest_planes(
    points: &[Lanes],
    scale: f64,
) -> Result<([Lanes; 7], [Lanes; 7]), Degenerate> {
    let corners = widest_simplex(points, scale)?.map(|corner| points[corner as usize]);
    let points = corners.map(|corner| corner.wrench());
    let planes = std::array::from_fn(|opposite| {
        let others: [Wrench; 6] =
            std::array::from_fn(|slot| points[slot + usize::from(slot >= opposite)]);
        let outward = others.iter().sum::<Wrench>() / 6.0 - points[opposite];
        plane_through(&others, &outward)
    });
    Ok((corners, planes))
}

/// The bounds known when the growth ends at a facet that is not one of the hull.
fn unfinished(nearest: &Nearest, upper: f64) -> Found {
    Found {
        direction: nearest.normal.wrench(),
        lower: nearest.offset,
        upper,
    }
}
