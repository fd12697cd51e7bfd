//! Moves of one contact by a given distance in all directions.

use std::f64::consts::TAU;
use std::ops::ControlFlow;

use super::cut::{Reaches, combined, farthest, reach_of};
use super::{End, LEAST_GAIN, Polish, Trial};
use crate::core::contact::Contact;
use crate::core::mesh::SurfaceContact;
use crate::core::wrench::Wrench;

/// Directions that a contact is moved in.
const DIRECTIONS: usize = 8;

/// Moves that are evaluated before a shorter distance is tried.
const MOST_TRIED: usize = 8;

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
    pub(super) fn move_one(&mut self, distance: f64) -> ControlFlow<End, bool> {
        let mut moves = self.moves(distance);
        let cuts: Vec<Wrench> = self.cuts.iter().map(|cut| cut.direction).collect();
        for direction in &cuts {
            self.bound(&mut moves, direction);
        }
        for _ in 0..MOST_TRIED {
            let best = moves
                .iter()
                .enumerate()
                .reduce(|a, b| if b.1.bound > a.1.bound { b } else { a });
            let Some((index, best)) = best else { break };
            if best.bound <= self.margin.value * (1.0 + LEAST_GAIN) {
                break;
            }
            let mut trial = self.places.clone();
            trial[best.contact] = best.place;
            match self.try_out(trial)? {
                Trial::Better => return ControlFlow::Continue(true),
                Trial::Worse(direction) => {
                    moves.swap_remove(index);
                    self.bound(&mut moves, &direction);
                    self.add_cut(direction);
                }
                Trial::Unfit => {
                    moves.swap_remove(index);
                }
            }
        }
        ControlFlow::Continue(false)
    }

    fn moves(&self, distance: f64) -> Vec<Move> {
        let mut moves = Vec::new();
        for (contact, from) in self.places.iter().enumerate() {
            let (t1, t2) = self.model.tangents(&Contact::from(from));
            for k in 0..DIRECTIONS {
                let (sin, cos) = (TAU * k as f64 / DIRECTIONS as f64).sin_cos();
                let place = self.surface.walk(from, &((t1 * cos + t2 * sin) * distance));
                let mut columns = Vec::new();
                reach_of(self.model, &(&place).into(), &mut columns);
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

    /// Lowers bounds to the support along a direction.
    fn bound(&self, moves: &mut [Move], direction: &Wrench) {
        let reaches = Reaches::new(self.model, &self.contacts);
        let first = self.fixed.len();
        let others: Vec<f64> = (0..self.places.len())
            .map(|contact| reaches.of_others(first + contact, direction))
            .collect();
        for one in moves {
            let (height, _) = farthest(self.model, &one.columns, direction);
            let height = combined(self.model.space, others[one.contact], height);
            one.bound = one.bound.min(height);
        }
    }
}
