//! Continuous improvement of a grasp: its contacts slide over the surface.
//!
//! A search chooses among candidates; the best place of a finger lies between them. While no contact leaves its
//! triangle, ε is the least of many smooth functions of the positions, one for each facet of the wrench space. Such a
//! function has kinks, where a step along the gradient of one facet runs into another, so the polish keeps a bundle of
//! facets: a proximal bundle method (Lemaréchal 1975, Kiwiel 1990).
//!
//! ```text
//! cuts ← the weakest facet of the start, with its height and its gradient in the positions      cut
//! radius ← 0.05 of the body
//! while radius > 10⁻⁶ of the body
//!     a step of all contacts: the steps that raise the least linearised cut most, less a damping   bundle
//!         walk them over the surface, across edges, and evaluate
//!         better: take it; else add the facet that binds there, and try once more
//!     or the same with every contact kept to its triangle
//!     or a move of one contact, those first that the cuts leave the most hope for                  moves
//!     radius ← twice the radius when one of them was better, else half
//! ```
//!
//! Where a triangle ends the normal jumps, and ε with it. So the model of smooth functions is wrong across an edge:
//! the same step is also tried within the triangles, and single contacts are moved all around.
//!
//! Invariants. A trial is taken only when its evaluated ε is greater by a share of 10⁻⁹ at least, so ε never falls. The
//! support of the wrench space along any direction is at least ε, so a cut bounds ε of every trial from above, and a
//! trial whose bound is too low is not evaluated.
//!
//! It ends at the limit of evaluations, or when the radius is too small. Each halving of the radius follows at most
//! eight evaluations without a gain, and the radius grows only with a gain. An evaluation is a hull; the program that
//! finds a step has [`MAX_CUTS`](sliding::MAX_CUTS) and some sides of triangles as its size, so it costs less.

mod bundle;
mod cut;
mod moves;
mod program;
mod sliding;

#[cfg(test)]
mod tests;

use super::evaluator::SEARCH_FACET_LIMIT;
use crate::contact::Contact;
use crate::interrupt::Interrupt;
use crate::interrupt::Interrupted;
use crate::mesh::{Surface, SurfaceContact};
use crate::quality::{ACCURACY, Degenerate, Evaluator, Margin};
use crate::wrench::WrenchModel;
use bundle::step_together;
use moves::move_one;
use sliding::{End, Sliding, all_contacts};

/// Length of the first steps and of the shortest, over the radius of the body.
const FIRST_RADIUS: f64 = 0.05;
const LAST_RADIUS: f64 = 1e-6;

/// How long to polish.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct PolishSettings {
    /// Most evaluations of the quality, that of the start included.
    pub evaluation_limit: u64,
}

impl Default for PolishSettings {
    fn default() -> Self {
        Self {
            evaluation_limit: 300,
        }
    }
}

/// A grasp that no sliding of its contacts improves much, or as far as it came.
#[derive(Debug, Clone, PartialEq)]
pub struct Polished {
    /// The contacts that slid, in the order of the start.
    pub contacts: Vec<SurfaceContact>,
    /// Of all contacts, the fixed ones included: exact, or an interval of relative width [`ACCURACY`].
    pub margin: Margin,
    /// `margin.value` less that of the start; never negative.
    pub gain: f64,
    /// Evaluations of the quality, without those that confirm the outcome of unfinished hulls.
    pub evaluations: u64,
    /// Why it was interrupted, when it was.
    pub stopped: Option<Interrupted>,
}

/// Slides the contacts of `start` over the surface to where ε, together with the `fixed` contacts, is
/// greater; each contact has the normal of the triangle that it is in.
///
/// The value of the margin never falls. A grasp that is not force closure is returned as it is. Only
/// contacts that are `allowed` are evaluated, except those of the start. `interrupt` is checked before
/// each evaluation and ends the polish with the best contacts so far, or with the start where hulls could not be
/// finished. The same input gives the same output to the last bit. It takes some milliseconds for 4 contacts with 8
/// edges.
///
/// # Errors
/// When the wrenches of the start do not span the space.
pub fn polish(
    surface: &Surface<'_>,
    model: &WrenchModel,
    fixed: &[Contact],
    start: &[SurfaceContact],
    settings: PolishSettings,
    allowed: &dyn Fn(&[SurfaceContact]) -> bool,
    interrupt: Interrupt<'_>,
) -> Result<Polished, Degenerate> {
    let mut evaluator = Evaluator::with_facet_limit(SEARCH_FACET_LIMIT);
    let contacts = all_contacts(fixed, start);
    let margin = evaluator.grasp_quality(model, &contacts, ACCURACY)?;
    let mut sliding = Sliding {
        surface,
        model,
        fixed,
        evaluation_limit: settings.evaluation_limit,
        allowed,
        interrupt,
        evaluator,
        evaluations: 1,
        places: start.to_vec(),
        contacts,
        margin,
        cuts: Vec::new(),
        radius: FIRST_RADIUS * surface.mesh().report().bounding_radius,
    };
    let mut stopped = None;
    if margin.is_force_closure()
        && let Err(End::Interrupted(why)) = improve(&mut sliding)
    {
        stopped = Some(why);
    }
    let mut polished = Polished {
        contacts: sliding.places,
        margin: sliding.margin,
        gain: sliding.margin.value - margin.value,
        evaluations: sliding.evaluations,
        stopped,
    };
    if polished.gain > 0.0 && !(margin.exact && polished.margin.exact) {
        // An unfinished hull gives a bound, and two bounds do not show which grasp is better.
        if polished.stopped.is_some() {
            (polished.contacts, polished.margin, polished.gain) = (start.to_vec(), margin, 0.0);
            return Ok(polished);
        }
        confirm(&mut polished, model, fixed, start)?;
    }
    Ok(polished)
}

/// Improves the contacts step by step, until the steps are too short.
fn improve(sliding: &mut Sliding<'_>) -> Result<(), End> {
    let size = sliding.surface.mesh().report().bounding_radius;
    sliding.track(sliding.margin.direction);
    // Whether the last good step kept contacts to their triangles: the next one is likely to as well.
    let mut keep = false;
    while sliding.radius > LAST_RADIUS * size {
        let mut better = step_together(sliding, keep)?;
        if !better && step_together(sliding, !keep)? {
            (better, keep) = (true, !keep);
        }
        better = better || move_one(sliding, sliding.radius)?;
        sliding.radius = if better {
            (2.0 * sliding.radius).min(size)
        } else {
            0.5 * sliding.radius
        };
    }
    Ok(())
}

/// Compares start and end with the facet limit of results, where a hull was not finished within that of the search.
fn confirm(
    polished: &mut Polished,
    model: &WrenchModel,
    fixed: &[Contact],
    start: &[SurfaceContact],
) -> Result<(), Degenerate> {
    let mut evaluator = Evaluator::new();
    let mut evaluate =
        |places| evaluator.grasp_quality(model, &all_contacts(fixed, places), ACCURACY);
    let before = evaluate(start)?;
    match evaluate(&polished.contacts) {
        Ok(after) if after.value > before.value => {
            (polished.margin, polished.gain) = (after, after.value - before.value);
        }
        _ => {
            polished.contacts = start.to_vec();
            (polished.margin, polished.gain) = (before, 0.0);
        }
    }
    Ok(())
}
