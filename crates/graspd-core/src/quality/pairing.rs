//! Finds which new facets of a growing polytope are neighbours.
//!
//! An insertion replaces the visible facets by a cone of the new vertex (the apex) over their rim. Two facets of the cone
//! are neighbours when they share a ridge: the apex and four vertices of the rim. The textbook way is a hash table of
//! vertex sets. This one has neither sets nor branches:
//!
//! ```text
//! every vertex has a random 64-bit name; the name of a ridge is the exclusive or of its four
//! for each side of each ridge:  table[name's low bits] ^= number of the side, and count it
//! for each side:                two sides there → the other one is table[...] ^ own number
//!                               more → the side tries again under other bits of its name
//! ```
//!
//! The rim is closed, so every ridge has an even number of sides. Two sides alone in their place of the table therefore
//! belong to each other; that they meet by chance, with 64-bit names, does not happen in practice, and the table is
//! 32 times larger than the rim so that few sides share a place. Ridges with four or more sides, which only rounding
//! makes, are returned in `pending` for the polytope to resolve by walking around them.

// Slots of several facets are taken by one number.
#![allow(clippy::needless_range_loop)]

use super::facet::{Facet, Ridge};

/// Finds the pairs of new facets that share a ridge.
///
/// Two cone facets are neighbours across the ridge of the apex and four vertices of the rim. Each side of
/// each such ridge goes by the exclusive or of the four names. In a table under some bits of that, the
/// numbers of both sides meet in one exclusive or, from which either side learns the other without a
/// branch. Every name has an even number of sides, because the rim is closed, so two that have a place in the
/// table for themselves belong together; where more meet, they try again under other bits.
#[derive(Debug, Default)]
pub(super) struct Pairing {
    /// Exclusive or of the sides, and how many they are times 2³². All zero between two uses.
    table: Vec<u64>,
    /// Sides that have not found their other.
    pub pending: Vec<Side>,
    failed: Vec<Side>,
}

/// One side of a ridge through the apex.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Side {
    /// The exclusive or of the names of the four vertices.
    name: u64,
    /// Place of the facet among the new ones times eight, plus the slot across which the other side is.
    pub number: u32,
}

/// Places in the table for each ridge of the rim, over which the facet has five sides: so that few meet.
const TABLE_SHARE: usize = 32;

/// Tables tried before the sides left over are given up: those of ridges with more than two sides.
const TURNS: u32 = 6;

/// One side in the upper half of an entry.
const ONE: u64 = 1 << 32;

impl Pairing {
    /// Makes the new `facets`, the first of which has the number `first`, neighbours of each other. The sides
    /// of ridges that have more than two are left in `pending`.
    #[inline(always)]
    pub fn join(
        &mut self,
        facets: &mut [Facet],
        vertex_names: &[u64],
        rim: &[Ridge],
        first: usize,
    ) {
        let size = (rim.len() * TABLE_SHARE).next_power_of_two();
        if self.table.len() < size {
            self.table.resize(size, 0);
        }
        let table = &mut self.table[..size];
        // One more than there are, so that the last may be written before it is known to count.
        self.pending.resize(5 * facets.len() + 1, Side::default());
        let mut count = 0;
        for (i, (facet, ridge)) in facets.iter().zip(rim).enumerate() {
            let names: [u64; 6] =
                std::array::from_fn(|slot| vertex_names[facet.vertices[slot] as usize]);
            let all = names.iter().fold(0, |all, name| all ^ name);
            for slot in 0..6 {
                self.pending[count] = Side {
                    name: all ^ names[slot],
                    number: (i as u32) << 3 | slot as u32,
                };
                count += usize::from(slot as u32 != ridge.slot);
            }
        }
        self.pending.truncate(count);
        for turn in 0..TURNS {
            if self.pending.is_empty() {
                break;
            }
            let place = |side: &Side| (side.name.rotate_left(11 * turn) as usize) & (size - 1);
            for side in &self.pending {
                let entry = &mut table[place(side)];
                *entry = (*entry + ONE) ^ u64::from(side.number);
            }
            self.failed.clear();
            for side in &self.pending {
                let entry = table[place(side)];
                if entry >> 32 == 2 {
                    let other = (entry as u32) ^ side.number;
                    let facet = &mut facets[(side.number >> 3) as usize];
                    facet.neighbors[(side.number & 7) as usize] = ((first as u32) << 3) + other;
                } else {
                    self.failed.push(*side);
                }
            }
            for side in &self.pending {
                table[place(side)] = 0;
            }
            std::mem::swap(&mut self.pending, &mut self.failed);
        }
    }
}

/// A number that tells a vertex from all others in every bit (SplitMix64's finaliser).
#[inline(always)]
pub(super) fn name(vertex: u32) -> u64 {
    let mut z = (u64::from(vertex) + 1).wrapping_mul(0x9e37_79b9_7f4a_7c15);
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ (z >> 31)
}
