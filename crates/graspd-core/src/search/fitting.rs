//! Random grasps whose contacts are as far apart as is asked for.

use std::ops::ControlFlow;

use super::problem::{Grasp, Problem};
use crate::random::Stream;

/// First contacts that are tried before a grasp is given up.
const STARTS: usize = 4;

/// Candidates drawn blindly for a contact before all are looked through for those that fit. So many
/// find one in most cases where one candidate in ten fits.
const DRAWS: usize = 32;

/// A random grasp that [fits](Problem::fits); any m-subset where there is no distance to keep.
///
/// Contacts are drawn one after the other, evenly from the candidates that fit beside those before.
/// `None` when that came to a dead end four times, which does not prove that there is no such grasp.
/// O(m) draws, and O(n·m) where few candidates fit; `poll` is called before each pass over the
/// candidates.
pub(super) fn random_grasp<B>(
    problem: &Problem,
    stream: &mut Stream,
    poll: &mut dyn FnMut() -> ControlFlow<B>,
) -> ControlFlow<B, Option<Grasp>> {
    if !problem.is_spaced() {
        let grasp = stream.subset(problem.len(), problem.contacts());
        return ControlFlow::Continue(Some(grasp));
    }
    for _ in 0..STARTS {
        if let Some(mut grasp) = draw(problem, stream, poll)? {
            grasp.sort_unstable();
            return ControlFlow::Continue(Some(grasp));
        }
    }
    ControlFlow::Continue(None)
}

/// One try, in the order of the draws.
fn draw<B>(
    problem: &Problem,
    stream: &mut Stream,
    poll: &mut dyn FnMut() -> ControlFlow<B>,
) -> ControlFlow<B, Option<Vec<u32>>> {
    let mut chosen: Vec<u32> = Vec::with_capacity(problem.contacts());
    // The candidates that fit beside the first `sifted` of the chosen; all, until it is made.
    let mut pool: Option<Vec<u32>> = None;
    let mut sifted = 0;
    while chosen.len() < problem.contacts() {
        let blind = (0..DRAWS)
            .map(|_| match &pool {
                Some(pool) => pool[stream.below(pool.len())],
                None => stream.below(problem.len()) as u32,
            })
            .find(|c| !chosen.contains(c) && problem.fits_beside(&chosen, *c));
        if let Some(candidate) = blind {
            chosen.push(candidate);
            continue;
        }
        poll()?;
        let fits = |c: &u32| !chosen.contains(c) && problem.fits_beside(&chosen[sifted..], *c);
        let rest: Vec<u32> = match pool.take() {
            Some(pool) => pool.into_iter().filter(fits).collect(),
            None => (0..problem.len() as u32).filter(fits).collect(),
        };
        if rest.is_empty() {
            return ControlFlow::Continue(None);
        }
        sifted = chosen.len();
        chosen.push(rest[stream.below(rest.len())]);
        pool = Some(rest);
    }
    ControlFlow::Continue(Some(chosen))
}
