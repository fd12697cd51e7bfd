//! Moves of one contact by a given distance in all directions.

use std::f64::consts::TAU;

use super::cut::{GraspSupport, push_columns};
use super::sliding::{End, Sliding, Trial};
use crate::contact::Contact;
use crate::mesh::SurfaceContact;
use crate::wrench::Wrench;

/// Directions that a contact is moved in.
const DIRECTIONS: usize = 16;

/// Moves that are evaluated before a shorter distance is tried.
const MOST_TRIED: usize = 4;

/// A move of one contact, with the least height of the cuts after it, which ε does not exceed.
struct Move {
    contact: usize,
    place: SurfaceContact,
    columns: Vec<Wrench>,
    bound: f64,
}

/// Tries moves of one contact by `distance`, the one with the greatest bound on ε first, until one is better or no bound
/// exceeds ε. Returns whether one is better.
pub(super) fn move_one(sliding: &mut Sliding<'_>, distance: f64) -> Result<bool, End> {
    let mut moves = moves(sliding, distance);
    let (contacts, first) = (sliding.contacts.clone(), sliding.fixed.len());
    let support = GraspSupport::new(sliding.model, &contacts);
    for cut in &sliding.cuts {
        lower(&mut moves, &support, first, &cut.direction);
    }
    for _ in 0..MOST_TRIED {
        let best = moves
            .iter()
            .enumerate()
            .reduce(|a, b| if b.1.bound > a.1.bound { b } else { a });
        let Some((index, best)) = best else { break };
        if best.bound <= sliding.enough() {
            break;
        }
        let mut trial = sliding.places.clone();
        trial[best.contact] = best.place;
        match sliding.evaluate(trial)? {
            Trial::Better => return Ok(true),
            Trial::Worse(direction) => {
                moves.swap_remove(index);
                lower(&mut moves, &support, first, &direction);
                sliding.add_cut(direction);
            }
            Trial::Unfit => {
                moves.swap_remove(index);
            }
        }
    }
    Ok(false)
}

/// All contacts moved by `distance` in all directions.
fn moves(sliding: &Sliding<'_>, distance: f64) -> Vec<Move> {
    let mut moves = Vec::new();
    for (contact, from) in sliding.places.iter().enumerate() {
        let (t1, t2) = sliding.model.tangents(&Contact::from(from));
        for k in 0..DIRECTIONS {
            let (sin, cos) = (TAU * k as f64 / DIRECTIONS as f64).sin_cos();
            let place = sliding
                .surface
                .walk(from, &((t1 * cos + t2 * sin) * distance));
            let mut columns = Vec::new();
            push_columns(sliding.model, &Contact::from(&place), &mut columns);
            moves.push(Move {
                contact,
                place,
                columns,
                bound: f64::INFINITY,
            });
        }
    }
    moves
}

/// Lowers the bounds to the support along a direction; the contacts before the `first` do not move.
fn lower(moves: &mut [Move], support: &GraspSupport<'_>, first: usize, direction: &Wrench) {
    let others = support.without_each(direction);
    for one in moves {
        let height = support.with_another(others[first + one.contact], &one.columns, direction);
        one.bound = one.bound.min(height);
    }
}
