//! Independent contact regions: where each finger of a grasp may be while the others stay.
//!
//! The region of a contact holds the candidates to which that finger alone can move so that the grasp keeps
//! force closure and a given fraction of its ε, after Nguyen, "Constructing force-closure grasps" (Int. J.
//! Robotics Research 7, 1988), and Roa & Suárez, "Computation of independent contact regions for grasping 3-D
//! objects" (IEEE Trans. Robotics 25, 2009). Their regions let all fingers move at once and follow from
//! sufficient conditions. Here one finger moves at a time, and the region is exact.
//!
//! # Algorithm
//!
//! A grasp has ε > τ exactly if it reaches farther than τ along every unit wrench u, where the reach of a
//! contact along u is the greatest u·w of its wrenches w. In L1 the farthest contact counts; in L∞ the positive
//! reaches of all contacts add up. So along a u in which the fingers that stay do not reach τ, the finger that
//! moves must reach the rest: more than h = τ in L1, more than h = τ − Σ (reaches of the others) in L∞. The pair
//! (u, h) is a *cut*: it excludes every candidate that reaches no farther than h, for a few multiplications.
//! A candidate whose evaluation fails yields the u along which its grasp is weakest, and with it a new cut,
//! which usually excludes its neighbours too.
//!
//! ```text
//! cuts ← from the weakest directions of the others alone and of the whole grasp
//! open ← the candidates that no cut excludes, in an order spread over the surface
//! while open is not empty:
//!     block ← the first candidates of open
//!     evaluate the grasp with the finger at each of block            (in parallel)
//!     those with ε > τ belong to the region
//!     new cuts ← from the weakest directions of the others, a few
//!     open ← the rest of open that no new cut excludes
//! ```
//!
//! *Invariant.* A candidate leaves `open` only when it is evaluated, or when a cut proves that its evaluation
//! would fail. The region therefore does not depend on which cuts were found, nor on the number of threads.
//!
//! *Rounding.* The height of a cut is lowered by the tolerance of the hull, so a cut never excludes a candidate
//! that an evaluation would keep.
//!
//! *End.* Every round takes at least one candidate out of `open`.
//!
//! *Cost.* At worst one quality evaluation a candidate and finger; on the usual bodies cuts leave a small part of
//! them. At most `MAX_CUTS` cuts a finger, each O(n).

use rayon::prelude::*;

use super::blocks::{FACET_LIMIT, grasps_per_block};
use super::contact::{Contact, Site};
use super::interrupt::{Interrupt, Interrupted};
use super::mesh::{Adjacency, Candidate, Mesh};
use super::quality::{ACCURACY, COPLANAR_TOLERANCE, Degenerate, Evaluator, Margin};
use super::wrench::{Wrench, WrenchModel, WrenchSpace};

/// The share of ε that a grasp has to keep: above 0, at most 1.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(into = "Share", try_from = "Share"))]
pub struct Fraction(f64);

/// A [`Fraction`] as requests have it.
#[cfg(feature = "serde")]
#[derive(serde::Serialize, serde::Deserialize)]
struct Share {
    fraction: f64,
}

#[cfg(feature = "serde")]
impl From<Fraction> for Share {
    fn from(Fraction(fraction): Fraction) -> Self {
        Self { fraction }
    }
}

#[cfg(feature = "serde")]
impl TryFrom<Share> for Fraction {
    type Error = &'static str;

    fn try_from(share: Share) -> Result<Self, Self::Error> {
        Self::new(share.fraction).ok_or("the fraction must be above 0 and at most 1")
    }
}

impl Fraction {
    /// Returns the share; `None` unless `0 < share <= 1`.
    pub fn new(share: f64) -> Option<Self> {
        (share > 0.0 && share <= 1.0).then_some(Self(share))
    }
}

/// Where one finger may be while the others stay (independent contact region, Nguyen 1988, Roa & Suárez
/// 2009): the triangles at whose centroids the grasp keeps force closure and the requested fraction of its
/// quality. Every triangle was decided, none estimated.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "schema", derive(utoipa::ToSchema))]
pub struct IndependentRegion {
    /// The triangles, ascending, counted from 0 in the order of the file.
    pub triangles: Vec<u32>,
    /// Whether `triangles` was cut short: one answer lists 100,000 in all, the same number for every
    /// contact. `count` and the areas are of the whole region.
    pub truncated: bool,
    /// Triangles of the whole region.
    pub count: u64,
    /// Their area, in the mesh's unit squared.
    pub area: f64,
    /// How many of them can be reached from the contact's own triangle over edges that they share; zero
    /// when that is not among them. Absent for a free contact.
    #[cfg_attr(feature = "serde", serde(skip_serializing_if = "Option::is_none"))]
    pub connected: Option<u64>,
    /// The area of those.
    #[cfg_attr(feature = "serde", serde(skip_serializing_if = "Option::is_none"))]
    pub connected_area: Option<f64>,
}

impl IndependentRegion {
    /// Lists at most `limit` triangles; the count and the areas stay those of the whole region.
    pub fn truncate(&mut self, limit: usize) {
        self.truncated |= self.triangles.len() > limit;
        self.triangles.truncate(limit);
    }
}

/// The places that fingers may move to. It takes O(n) memory, so build it once per mesh.
#[derive(Debug)]
pub struct Places<'a> {
    mesh: &'a Mesh,
    areas: Vec<f64>,
    candidates: Vec<Candidate>,
    adjacency: Adjacency<'a>,
}

impl<'a> Places<'a> {
    /// Collects the places of a mesh: O(n) if few triangles meet at every vertex. `interrupt` is checked every
    /// few milliseconds.
    pub fn new(mesh: &'a Mesh, interrupt: Interrupt<'_>) -> Result<Self, Interrupted> {
        interrupt.check()?;
        let areas = mesh.areas().collect();
        let candidates = mesh.candidates_interruptible(interrupt)?;
        Ok(Self {
            mesh,
            areas,
            candidates,
            adjacency: Adjacency::new(mesh, interrupt)?,
        })
    }

    /// Returns the area of triangles, which are ascending indices in the file. O(n), a few milliseconds for a
    /// million.
    fn area(&self, triangles: &[u32]) -> f64 {
        let mut wanted = triangles.iter().peekable();
        let all = self.mesh.source().iter().zip(&self.areas);
        let areas = all.filter_map(|(t, area)| wanted.next_if_eq(&t).map(|_| area));
        areas.sum()
    }
}

/// Greatest number of cuts for one finger; applying one to a million candidates takes some 10 ms.
const MAX_CUTS: usize = 128;

/// Candidates to which cuts are applied between two checks of the interrupt: some milliseconds.
const BLOCK: usize = 1 << 15;

/// Greatest number of cuts from one block of evaluations, so that applying them takes no longer than finding
/// them.
const NEW_CUTS: usize = 8;

/// Finds the region of every contact, in their order, on the current rayon pool.
///
/// `margin` is that of the grasp, which must be force closure; a margin above `closure_floor` counts as force
/// closure. If ε is known as an interval, its lower end counts. The regions do not depend on the number of
/// threads. `interrupt` is checked every few milliseconds.
pub fn independent_regions(
    places: &Places,
    model: &WrenchModel,
    sites: &[Site],
    margin: &Margin,
    closure_floor: f64,
    fraction: Fraction,
    interrupt: Interrupt<'_>,
) -> Result<Vec<IndependentRegion>, Interrupted> {
    // A place with the same quality, except for rounding, must count as one that keeps all of ε.
    let wanted = fraction.0 * margin.value - COPLANAR_TOLERANCE * margin.scale;
    let contacts: Vec<Contact> = sites.iter().map(|site| site.contact).collect();
    let mut regions = Vec::with_capacity(sites.len());
    for (finger, site) in sites.iter().enumerate() {
        let exchange = Exchange {
            model,
            candidates: &places.candidates,
            contacts: &contacts,
            finger,
            threshold: wanted.max(closure_floor),
        };
        let triangles = exchange.kept(&margin.direction, interrupt)?;
        let reached = match site.triangle {
            Some(own) => {
                let reached = places.adjacency.reachable(own, &triangles, interrupt);
                Some(reached?)
            }
            None => None,
        };
        regions.push(IndependentRegion {
            truncated: false,
            count: triangles.len() as u64,
            area: places.area(&triangles),
            connected: reached.as_ref().map(|reached| reached.len() as u64),
            connected_area: reached.map(|reached| places.area(&reached)),
            triangles,
        });
    }
    Ok(regions)
}

/// The move of one finger to other candidates.
struct Exchange<'a> {
    model: &'a WrenchModel,
    candidates: &'a [Candidate],
    contacts: &'a [Contact],
    finger: usize,
    /// The bound τ that the margin has to exceed.
    threshold: f64,
}

/// A direction along which the finger that moves has to reach farther than `height`.
struct Cut {
    direction: Wrench,
    height: f64,
}

impl Cut {
    fn excludes(&self, model: &WrenchModel, contact: &Contact) -> bool {
        model.reach_bound(contact, &self.direction) <= self.height
    }
}

impl Exchange<'_> {
    /// Returns the triangles of the candidates to which the finger can move, ascending.
    fn kept(&self, weakest: &Wrench, interrupt: Interrupt<'_>) -> Result<Vec<u32>, Interrupted> {
        interrupt.check()?;
        let others = self.others();
        let alone = match others.is_empty() {
            true => None,
            false => Some(self.evaluate(&mut evaluator(), &others)),
        };
        let direction = match alone {
            // The others alone suffice, and one more finger takes nothing from their reach.
            Some(Ok(())) => return Ok(self.candidates.iter().map(|c| c.triangle).collect()),
            Some(Err(direction)) => Some(direction),
            None => None,
        };
        let known = direction.iter().chain([weakest]);
        let first: Vec<Cut> = known.filter_map(|u| self.cut(&others, u)).collect();
        let mut cuts = first.len();
        let mut open = self.uncut(&spread(self.candidates.len()), &first, interrupt)?;
        let mut at = 0;
        let mut kept = Vec::new();
        let block = grasps_per_block(self.model, self.contacts.len());
        while at < open.len() {
            interrupt.check()?;
            let now = &open[at..open.len().min(at + block)];
            let verdicts: Vec<Result<(), Wrench>> = now
                .par_iter()
                .map_init(evaluator, |evaluator, &candidate| {
                    let mut contacts = self.contacts.to_vec();
                    contacts[self.finger] = self.contact(candidate);
                    self.evaluate(evaluator, &contacts)
                })
                .collect();
            // Neighbours tend to fail along the same direction: a cut that already excludes a failed candidate
            // makes another one from it pointless.
            let mut fresh: Vec<Cut> = Vec::new();
            for (&candidate, verdict) in now.iter().zip(verdicts) {
                let Err(direction) = verdict else {
                    kept.push(self.candidates[candidate as usize].triangle);
                    continue;
                };
                let there = self.contact(candidate);
                let wanted = fresh.len() < NEW_CUTS.min(MAX_CUTS - cuts);
                if wanted && !fresh.iter().any(|cut| cut.excludes(self.model, &there)) {
                    fresh.extend(self.cut(&others, &direction));
                }
            }
            at += now.len();
            if !fresh.is_empty() {
                cuts += fresh.len();
                open = self.uncut(&open[at..], &fresh, interrupt)?;
                at = 0;
            }
        }
        kept.sort_unstable();
        Ok(kept)
    }

    fn others(&self) -> Vec<Contact> {
        let mut others = self.contacts.to_vec();
        others.remove(self.finger);
        others
    }

    fn contact(&self, candidate: u32) -> Contact {
        Contact::from(&self.candidates[candidate as usize])
    }

    /// Succeeds if the contacts exceed the threshold; fails with a unit direction along which they do not.
    fn evaluate(&self, evaluator: &mut Evaluator, contacts: &[Contact]) -> Result<(), Wrench> {
        match evaluator.grasp_quality_above(self.model, contacts, ACCURACY, self.threshold) {
            Ok(margin) if margin.value > self.threshold && margin.is_force_closure() => Ok(()),
            Ok(Margin { direction, .. }) | Err(Degenerate { direction, .. }) => Err(direction),
        }
    }

    /// Makes a cut along a direction; `None` if the others reach far enough without the finger, or if the
    /// direction has no length.
    fn cut(&self, others: &[Contact], direction: &Wrench) -> Option<Cut> {
        let reaches = others.iter().map(|at| self.model.reach(at, direction));
        let height = match self.model.space {
            WrenchSpace::L1 => {
                let farthest = reaches.fold(f64::NEG_INFINITY, f64::max);
                (farthest <= self.threshold).then_some(self.threshold)?
            }
            WrenchSpace::Linf => {
                let sum: f64 = reaches.map(|reach| reach.max(0.0)).sum();
                (sum < self.threshold).then_some(self.threshold - sum)?
            }
        };
        // Rounding must not make the cut exclude a candidate that an evaluation would keep.
        let height = height * (1.0 - COPLANAR_TOLERANCE) - COPLANAR_TOLERANCE * direction.norm();
        let usable = direction.norm_squared() > 0.5 && height > 0.0;
        usable.then_some(Cut {
            direction: *direction,
            height,
        })
    }

    fn uncut(
        &self,
        candidates: &[u32],
        cuts: &[Cut],
        interrupt: Interrupt<'_>,
    ) -> Result<Vec<u32>, Interrupted> {
        let open = |candidate: &u32| {
            let contact = self.contact(*candidate);
            !cuts.iter().any(|cut| cut.excludes(self.model, &contact))
        };
        let mut uncut = Vec::new();
        for block in candidates.chunks(BLOCK) {
            interrupt.check()?;
            uncut.par_extend(block.par_iter().copied().filter(open));
        }
        Ok(uncut)
    }
}

fn evaluator() -> Evaluator {
    Evaluator::with_facet_limit(FACET_LIMIT)
}

/// Returns all numbers below `n`, in an order whose beginning is evenly spread. Neighbours in a file are often
/// neighbours on the surface, and cuts from all over the surface exclude more.
fn spread(n: usize) -> Vec<u32> {
    let step = n.isqrt().max(1);
    (0..step)
        .flat_map(|first| (first..n).step_by(step))
        .map(|index| index as u32)
        .collect()
}

#[cfg(test)]
mod tests;
