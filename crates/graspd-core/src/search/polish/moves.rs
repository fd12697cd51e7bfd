//! Moves of one contact by a given distance in all directions.

use std::f64::consts::TAU;

use super::cut::{Reaches, push_columns};
use super::{End, Polish, Trial};
use crate::contact::Contact;
use crate::mesh::SurfaceContact;
use crate::wrench::Wrench;

/// Directions that a contact is moved in.
const DIRECTIONS: usize = 16;

/// Moves that are evaluated before a shorter distance is tried.
const MOST_TRIED: usize = 4;

/// A move of one contact, with the least height of the cuts after it: ε is no more.
struct Move {
    contact: usize,
    place: SurfaceContact,
    columns: Vec<Wrench>,
    bound: f64,
}

impl Polish<'_> {
    /// Moves one contact by `distance` to where the cuts bound ε least, and the next, until one move is
    /// better or no bound exceeds ε. `false` when none is.
    pub(super) fn move_one(&mut self, distance: f64) -> Result<bool, End> {
        let mut moves = self.moves(distance);
        let (contacts, first) = (self.contacts.clone(), self.fixed.len());
        let reaches = Reaches::new(self.model, &contacts);
        for cut in &self.cuts {
            lower(&mut moves, &reaches, first, &cut.direction);
        }
        for _ in 0..MOST_TRIED {
            let best = moves
                .iter()
                .enumerate()
                .reduce(|a, b| if b.1.bound > a.1.bound { b } else { a });
            let Some((index, best)) = best else { break };
            if best.bound <= self.enough() {
                break;
            }
            let mut trial = self.places.clone();
            trial[best.contact] = best.place;
            match self.try_out(trial)? {
                Trial::Better => return Ok(true),
                Trial::Worse(direction) => {
                    moves.swap_remove(index);
                    lower(&mut moves, &reaches, first, &direction);
                    self.add_cut(direction);
                }
                Trial::Unfit => {
                    moves.swap_remove(index);
                }
            }
        }
        Ok(false)
    }

    fn moves(&self, distance: f64) -> Vec<Move> {
        let mut moves = Vec::new();
        for (contact, from) in self.places.iter().enumerate() {
            let (t1, t2) = self.model.tangents(&Contact::from(from));
            for k in 0..DIRECTIONS {
                let (sin, cos) = (TAU * k as f64 / DIRECTIONS as f64).sin_cos();
                let place = self.surface.walk(from, &((t1 * cos + t2 * sin) * distance));
                let mut columns = Vec::new();
                push_columns(self.model, &Contact::from(&place), &mut columns);
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
}

/// Lowers the bounds to the support along a direction; the contacts before the `first` do not move.
fn lower(moves: &mut [Move], reaches: &Reaches<'_>, first: usize, direction: &Wrench) {
    let others = reaches.without_each(direction);
    for one in moves {
        let height = reaches.with_another(others[first + one.contact], &one.columns, direction);
        one.bound = one.bound.min(height);
    }
}
