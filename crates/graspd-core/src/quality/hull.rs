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
//! # What rounding can do
//!
//! The offsets of the nearest facets never fall while the origin is inside, and no wrench is beyond the hull of a set that
//! it was added to. Regular grasps, whose wrenches lie in common flats but for rounding, can break both: the surface of P is
//! then folded, and its planes prove nothing. Either sign starts the growth again with the polytope of precise.rs, which
//! costs more and cannot be folded. A plane is reported only after one pass over all wrenches: the height that belongs to
//! it is the support value of the set.
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
use super::growth::{Growing, Nearest, Unfinished};
use super::lanes::Lanes;
use super::margin::{CLOSURE_TOLERANCE, COPLANAR_TOLERANCE, Degenerate, Margin};
use super::polytope::{Polytope, plane_through};
use super::precise::PrecisePolytope;
use super::wrench_set::{Support, WrenchSet, merged};
use crate::wrench::Wrench;

/// Evaluates one wrench set after the other and keeps the memory for it.
#[derive(Debug, Default)]
pub(super) struct Hull {
    loaded: Loaded,
    polytope: Polytope,
    precise: PrecisePolytope,
    facet_limit: usize,
}

/// The set at work, and what was done with it.
#[derive(Debug, Default)]
struct Loaded {
    set: WrenchSet,
    /// Which wrenches were added. One that lies beyond a facet a second time shows that the surface is folded.
    added: Vec<bool>,
    /// Wrenches of a final facet.
    inside: Vec<Lanes>,
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

/// Facet limit of a try with the precise polytope: some 50 ms.
pub(super) const PRECISE_FACETS: usize = 1 << 14;

/// Fall of the least offset, over the scale, that shows a folded surface: ten times what the planes may be off.
pub(super) const FOLD_TOLERANCE: f64 = 10.0 * COPLANAR_TOLERANCE;

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
        self.loaded.load(wrenches)?;
        if wrenches.len() < 7 {
            // Fewer than seven points are flat; this finds the rank and the missing direction.
            self.loaded.widest_planes()?;
        }
        let threshold = threshold / self.loaded.set.unit;
        self.expanded(threshold)
    }

    /// [`Self::quality`] of the set that is loaded, in its unit.
    #[inline(always)]
    fn expanded(&mut self, threshold: f64) -> Result<Margin, Degenerate> {
        let Self {
            loaded,
            polytope,
            precise,
            facet_limit,
        } = self;
        let closing = CLOSURE_TOLERANCE * loaded.set.scale;
        // The least that ε is proven to be.
        let mut proven = 0.0;
        let (corners, planes) = match closure(&loaded.set, closing) {
            Closure::Around { corners, planes } => (corners, planes),
            Closure::Separated { direction, height } => {
                return Ok(loaded.outside(direction, height, 0));
            }
            Closure::Undecided => {
                proven = f64::NEG_INFINITY;
                loaded.widest_planes()?
            }
        };
        let threshold = threshold.max(closing);
        loaded.start(polytope, &corners, &planes, *facet_limit);
        Ok(match loaded.expand(polytope, threshold, proven) {
            Ok(margin) => margin,
            Err(folded) => {
                let limit = PRECISE_FACETS.min(*facet_limit);
                loaded.start(precise, &corners, &planes, limit);
                loaded.expand_precisely(precise, threshold, proven, &folded.0)
            }
        })
    }

    /// Returns the least offset of any facet, on whichever side the origin is; inside, it is ε to the last bit. Outside,
    /// wrenches that nearly coincide count as one, and the margin is not exact then.
    pub fn margin(&mut self, wrenches: &[Wrench]) -> Result<Margin, Degenerate> {
        self.loaded.load(wrenches)?;
        let proof = self.expanded(f64::NEG_INFINITY)?;
        if proof.is_force_closure() || proof.upper > CLOSURE_TOLERANCE * proof.scale {
            return Ok(proof);
        }
        let merged = merged(wrenches);
        if let Some(merged) = &merged {
            self.loaded.load(merged)?;
        }
        // Rounding can fold the facets of a nearly flat set so that none can be replaced any more, in one
        // order of insertion and not in another.
        let Self {
            loaded, polytope, ..
        } = self;
        let mut whole = Err(Unfinished::Folded);
        for (order, most) in [
            (Order::Oldest, self.facet_limit),
            (Order::Nearest, RETRY_FACETS.min(self.facet_limit)),
        ] {
            if whole.is_err() {
                let (corners, planes) = loaded.widest_planes()?;
                loaded.start(polytope, &corners, &planes, most);
                whole = loaded.least_facet(polytope, order);
            }
        }
        let closing = CLOSURE_TOLERANCE * loaded.set.scale;
        Ok(match whole {
            Ok(Some(found)) if found.lower <= closing => {
                let exact = merged.is_none();
                loaded.margin_of(&found, exact, polytope.facet_count())
            }
            _ => proof,
        })
    }

    /// Outward normals of the facets of the whole hull through the origin, which must be one of
    /// the wrenches. Empty when it is inside; `None` when the hull could not be finished.
    pub fn facets_at_origin(
        &mut self,
        wrenches: &[Wrench],
    ) -> Result<Option<Vec<Wrench>>, Degenerate> {
        let Self {
            loaded, polytope, ..
        } = self;
        loaded.load(wrenches)?;
        let (corners, planes) = loaded.widest_planes()?;
        loaded.start(polytope, &corners, &planes, self.facet_limit);
        let closing = CLOSURE_TOLERANCE * loaded.set.scale;
        let mut normals: Vec<Wrench> = Vec::new();
        let mut from = 0;
        while let Some(nearest) = polytope.any(&mut from) {
            // What replaces it is farther out still, so none through the origin comes of it.
            if nearest.offset > closing {
                continue;
            }
            let support = loaded.set.support(&nearest.normal);
            match loaded.advance(polytope, &nearest, support) {
                Ok(None) => {}
                Ok(Some(_)) => normals.push(nearest.normal.wrench()),
                Err(_) => return Ok(None),
            }
        }
        Ok(Some(normals))
    }

    /// The volume of the hull, in the sixth power of the unit of the wrenches; `None` when the hull
    /// could not be finished, or is too large for a number. Wrenches that nearly coincide count as one.
    pub fn volume(&mut self, wrenches: &[Wrench]) -> Result<Option<f64>, Degenerate> {
        let Self {
            loaded,
            polytope,
            precise,
            facet_limit,
        } = self;
        let merged = merged(wrenches);
        loaded.load(merged.as_deref().unwrap_or(wrenches))?;
        let (corners, planes) = loaded.widest_planes()?;
        loaded.start(polytope, &corners, &planes, *facet_limit);
        let volume = match loaded.volume(polytope) {
            Err(Unfinished::Folded) => {
                loaded.start(precise, &corners, &planes, *facet_limit);
                loaded.volume(precise)
            }
            volume => volume,
        };
        let unit = loaded.set.unit;
        let volume = volume.map(|volume| (0..6).fold(volume, |volume, _| volume * unit));
        Ok(volume.ok().filter(|volume| volume.is_finite()))
    }
}

/// The surface was found to be folded. These bounds were proven by then.
struct Folded(Found);

impl Loaded {
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

    /// Starts with a simplex, for at most `facet_limit` facets.
    #[inline(always)]
    fn start(
        &mut self,
        polytope: &mut impl Growing,
        corners: &[Lanes; 7],
        planes: &[Lanes; 7],
        facet_limit: usize,
    ) {
        self.added.clear();
        self.added.resize(self.set.rows.len(), false);
        let tolerance = COPLANAR_TOLERANCE * self.set.scale;
        polytope.start(corners, planes, tolerance, facet_limit);
    }

    /// The most spread seven wrenches, wherever the origin is, with the planes of their simplex.
    fn widest_planes(&self) -> Result<([Lanes; 7], [Lanes; 7]), Degenerate> {
        widest_planes(&self.set.rows, self.set.scale)
    }

    /// Takes one step at a facet: returns it when it is a facet of the hull, else adds the support wrench beyond it. One
    /// that was added before is not beyond the hull; when it seems so by more than a set may be thin, the surface is folded.
    #[inline(always)]
    fn advance(
        &mut self,
        polytope: &mut impl Growing,
        nearest: &Nearest,
        support: Support,
    ) -> Result<Option<Found>, Unfinished> {
        if support.height <= nearest.offset + COPLANAR_TOLERANCE * self.set.scale {
            return Ok(Some(self.sharpened(nearest, support)));
        }
        let added = &mut self.added[support.wrench as usize];
        if *added {
            let found = unfinished(nearest, support.height);
            let slack = CLOSURE_TOLERANCE * self.set.scale;
            return match found.upper - found.lower <= slack {
                true => Ok(Some(found)),
                false => Err(Unfinished::Folded),
            };
        }
        *added = true;
        let row = self.set.rows[support.wrench as usize];
        if polytope.insert(&row)? {
            return Ok(None);
        }
        // Beyond by no more than the rounding of the product that says so.
        Ok(Some(self.sharpened(nearest, support)))
    }

    /// Grows the polytope until its nearest facet is one of the hull, or the origin proves to be
    /// outside, or ε not to exceed `threshold`. ε is known to be at least `proven`, zero where the origin is in the
    /// simplex that the growth starts with; from there on the least offset never falls.
    #[inline(always)]
    fn expand(
        &mut self,
        polytope: &mut impl Growing,
        threshold: f64,
        proven: f64,
    ) -> Result<Margin, Folded> {
        let closing = CLOSURE_TOLERANCE * self.set.scale;
        let fold = FOLD_TOLERANCE * self.set.scale;
        let mut bounds = Found {
            direction: Wrench::zeros(),
            lower: proven,
            upper: f64::INFINITY,
        };
        while let Some(nearest) = polytope.nearest() {
            if nearest.offset < bounds.lower - fold {
                return Err(Folded(bounds));
            }
            if nearest.offset >= 0.0 {
                bounds.lower = nearest.offset.max(bounds.lower);
            }
            let support = self.set.support(&nearest.normal);
            if support.height <= closing {
                let facets = polytope.facet_count();
                return Ok(self.outside(nearest.normal.wrench(), support.height, facets));
            }
            if support.height < bounds.upper {
                bounds.upper = support.height;
                bounds.direction = nearest.normal.wrench();
            }
            match self.advance(polytope, &nearest, support) {
                Ok(Some(found)) if found.upper - found.lower <= fold => {
                    return Ok(self.margin_of(&found, true, polytope.facet_count()));
                }
                Ok(Some(_)) | Err(Unfinished::Folded) => return Err(Folded(bounds)),
                Ok(None) if bounds.upper > threshold => {}
                Ok(None) | Err(Unfinished::Limit) => {
                    let found = unfinished(&nearest, bounds.upper);
                    return Ok(self.margin_of(&found, false, polytope.facet_count()));
                }
            }
        }
        Err(Folded(bounds))
    }

    /// [`Self::expand`] where doubles fold the surface. Should even this polytope fail, the better of the bounds before and
    /// after are returned.
    #[cold]
    #[inline(never)]
    fn expand_precisely(
        &mut self,
        polytope: &mut PrecisePolytope,
        threshold: f64,
        proven: f64,
        before: &Found,
    ) -> Margin {
        self.expand(polytope, threshold, proven)
            .unwrap_or_else(|Folded(after)| {
                let nearer = match before.upper < after.upper {
                    true => before,
                    false => &after,
                };
                let found = Found {
                    lower: before.lower.max(after.lower).max(-self.set.scale),
                    upper: nearer.upper.min(self.set.scale),
                    ..*nearer
                };
                self.margin_of(&found, false, polytope.facet_count())
            })
    }

    /// The facet of the whole hull with the least offset.
    fn least_facet(
        &mut self,
        polytope: &mut impl Growing,
        order: Order,
    ) -> Result<Option<Found>, Unfinished> {
        let mut least: Option<Found> = None;
        let mut from = 0;
        while let Some(facet) = match order {
            Order::Oldest => polytope.any(&mut from),
            Order::Nearest => polytope.nearest(),
        } {
            let support = self.set.support(&facet.normal);
            if let Some(found) = self.advance(polytope, &facet, support)?
                && least.is_none_or(|l| found.lower < l.lower)
            {
                least = Some(found);
            }
        }
        Ok(least)
    }

    /// The volume of the whole hull, in the unit of the set.
    fn volume(&mut self, polytope: &mut impl Growing) -> Result<f64, Unfinished> {
        let mut from = 0;
        while let Some(nearest) = polytope.any(&mut from) {
            let support = self.set.support(&nearest.normal);
            self.advance(polytope, &nearest, support)?;
        }
        Ok(polytope.volume())
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

    fn outside(&self, direction: Wrench, height: f64, facets: usize) -> Margin {
        let found = Found {
            direction,
            lower: height,
            upper: height,
        };
        self.margin_of(&found, false, facets)
    }

    #[inline(always)]
    fn margin_of(&self, found: &Found, exact: bool, facets: usize) -> Margin {
        let unit = self.set.unit;
        Margin {
            value: found.lower * unit,
            upper: found.upper * unit,
            direction: found.direction,
            scale: self.set.scale * unit,
            exact,
            facets,
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
