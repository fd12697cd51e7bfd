//! Random grasps whose contacts are as far apart as is asked for.

use super::problem::{Grasp, Problem};
use crate::interrupt::{Interrupt, Interrupted};
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
/// O(m) draws, and O(n·m) where few candidates fit; `interrupt` is checked before each pass over the
/// candidates.
pub(super) fn random_grasp(
    problem: &Problem,
    stream: &mut Stream,
    interrupt: Interrupt<'_>,
) -> Result<Option<Grasp>, Interrupted> {
    if !problem.is_spaced() {
        let grasp = stream.subset(problem.len(), problem.contacts());
        return Ok(Some(grasp));
    }
    for _ in 0..STARTS {
        if let Some(mut grasp) = draw(problem, stream, interrupt)? {
            grasp.sort_unstable();
            return Ok(Some(grasp));
        }
    }
    Ok(None)
}

/// One try, in the order of the draws.
fn draw(
    problem: &Problem,
    stream: &mut Stream,
    interrupt: Interrupt<'_>,
) -> Result<Option<Vec<u32>>, Interrupted> {
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
        interrupt.check()?;
        let fits = |c: &u32| !chosen.contains(c) && problem.fits_beside(&chosen[sifted..], *c);
        let rest: Vec<u32> = match pool.take() {
            Some(pool) => pool.into_iter().filter(fits).collect(),
            None => (0..problem.len() as u32).filter(fits).collect(),
        };
        if rest.is_empty() {
            return Ok(None);
        }
        sifted = chosen.len();
        chosen.push(rest[stream.below(rest.len())]);
        pool = Some(rest);
    }
    Ok(Some(chosen))
}
