//! Random grasps whose contacts keep the spacing.

use super::problem::{Grasp, SearchProblem};
use crate::interrupt::{Interrupt, Interrupted};
use crate::random::Stream;

/// Most tries for one random grasp.
const TRIES: usize = 4;

/// Candidates drawn blindly for a contact before all are filtered. So many
/// find one in most cases where one candidate in ten keeps the spacing.
const DRAWS: usize = 32;

/// Draws a random grasp that [keeps the spacing](SearchProblem::keeps_spacing); any m-subset where there is none to
/// keep.
///
/// Contacts are drawn one after the other, evenly from the candidates that keep the spacing with those before.
/// `None` when that came to a dead end four times, which does not prove that there is no such grasp.
/// O(m) draws, and O(n·m) where few candidates keep the spacing; `interrupt` is checked before each pass over the
/// candidates.
pub(super) fn random_grasp(
    problem: &SearchProblem,
    stream: &mut Stream,
    interrupt: Interrupt<'_>,
) -> Result<Option<Grasp>, Interrupted> {
    if !problem.has_spacing() {
        let grasp = stream.subset(problem.len(), problem.contacts());
        return Ok(Some(grasp));
    }
    for _ in 0..TRIES {
        if let Some(mut grasp) = draw(problem, stream, interrupt)? {
            grasp.sort_unstable();
            return Ok(Some(grasp));
        }
    }
    Ok(None)
}

/// Tries once; returns the contacts in the order of the draws.
fn draw(
    problem: &SearchProblem,
    stream: &mut Stream,
    interrupt: Interrupt<'_>,
) -> Result<Option<Vec<u32>>, Interrupted> {
    let mut chosen: Vec<u32> = Vec::with_capacity(problem.contacts());
    // The candidates that keep the spacing with the first `filtered` of the chosen; `None` stands for all.
    let mut pool: Option<Vec<u32>> = None;
    let mut filtered = 0;
    while chosen.len() < problem.contacts() {
        let blind = (0..DRAWS)
            .map(|_| match &pool {
                Some(pool) => pool[stream.below(pool.len())],
                None => stream.below(problem.len()) as u32,
            })
            .find(|c| !chosen.contains(c) && problem.keeps_spacing_with(&chosen, *c));
        if let Some(candidate) = blind {
            chosen.push(candidate);
            continue;
        }
        interrupt.check()?;
        let remains =
            |c: &u32| !chosen.contains(c) && problem.keeps_spacing_with(&chosen[filtered..], *c);
        let rest: Vec<u32> = match pool.take() {
            Some(pool) => pool.into_iter().filter(remains).collect(),
            None => (0..problem.len() as u32).filter(remains).collect(),
        };
        if rest.is_empty() {
            return Ok(None);
        }
        filtered = chosen.len();
        chosen.push(rest[stream.below(rest.len())]);
        pool = Some(rest);
    }
    Ok(Some(chosen))
}
