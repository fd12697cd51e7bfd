//! A finite set of wrenches, laid out for fast support values.

// Lanes of several rows are taken by one number.
#![allow(clippy::needless_range_loop)]

use super::lanes::{LANES, Lanes, heights, power_of_two_below};
use super::support::{Body, Reach};
use crate::wrench::Wrench;

/// Wrenches in their order, divided by a power of two (the unit) so that their greatest component is from one to two. They
/// are stored twice: in rows, one per wrench, for products with one plane, and in blocks of eight with one column per
/// axis, for the search of the wrench farthest along a direction.
#[derive(Debug, Default)]
pub(super) struct WrenchSet {
    /// The six components, one, and zero.
    pub rows: Vec<Lanes>,
    /// The last block is filled up with the first wrench.
    blocks: Vec<[Lanes; 6]>,
    /// The power of two that all numbers were divided by.
    pub unit: f64,
    /// Length of the longest wrench, in units.
    pub scale: f64,
}

/// A wrench of the set and how far it reaches along some direction.
#[derive(Debug, Clone, Copy)]
pub(super) struct Support {
    pub wrench: u32,
    pub height: f64,
}

impl WrenchSet {
    /// Loads a set. Returns `false` when a component is not finite.
    #[inline(always)]
    pub fn load(&mut self, wrenches: &[Wrench]) -> bool {
        let mut greatest = Lanes::splat(0.0);
        // 0·x is no number where x is none or infinite, and stays so in a sum: one test at the end instead of one for
        // each component.
        let mut poison = Lanes::splat(0.0);
        for w in wrenches {
            let row = Lanes::of(w, 0.0);
            greatest = greatest.zip(&row, |g, x| if x.abs() > g { x.abs() } else { g });
            poison = poison.zip(&row, |p, x| p + x * 0.0);
        }
        let greatest = greatest.0.iter().fold(0.0, |a: f64, b| a.max(*b));
        if poison.0.iter().any(|p| p.is_nan()) {
            return false;
        }
        self.unit = power_of_two_below(greatest);
        let factor = self.unit.recip();
        self.rows.clear();
        self.blocks.clear();
        self.scale = 0.0;
        let mut squared: f64 = 0.0;
        for chunk in wrenches.chunks(LANES) {
            let mut block = [Lanes::splat(0.0); 6];
            for lane in 0..LANES {
                let wrench = chunk.get(lane).unwrap_or(&wrenches[0]);
                let row = Lanes::of(wrench, 0.0).map(|x| x * factor);
                for axis in 0..6 {
                    block[axis].0[lane] = row.0[axis];
                }
                if lane < chunk.len() {
                    squared = squared.max(row.dot(&row));
                    let mut row = row;
                    row.0[6] = 1.0;
                    self.rows.push(row);
                }
            }
            self.blocks.push(block);
        }
        self.scale = squared.sqrt();
        true
    }

    /// The wrench that reaches farthest along `direction`, not necessarily a unit vector; the first
    /// among equals. O(n).
    #[inline(always)]
    pub fn support(&self, direction: &Lanes) -> Support {
        let mut best = Lanes::splat(f64::NEG_INFINITY);
        let mut first = [0_u64; LANES];
        for (number, block) in self.blocks.iter().enumerate() {
            let height = heights(direction, block);
            for lane in 0..LANES {
                let farther = height.0[lane] > best.0[lane];
                best.0[lane] = if farther {
                    height.0[lane]
                } else {
                    best.0[lane]
                };
                first[lane] = if farther { number as u64 } else { first[lane] };
            }
        }
        let mut found = Support {
            wrench: 0,
            height: f64::NEG_INFINITY,
        };
        for lane in 0..LANES {
            let wrench = (first[lane] as u32) * LANES as u32 + lane as u32;
            let height = best.0[lane];
            if height > found.height || (height == found.height && wrench < found.wrench) {
                found = Support { wrench, height };
            }
        }
        if found.wrench as usize >= self.rows.len() {
            // A copy of the first wrench in the last block.
            found.wrench = 0;
        }
        found
    }

    /// The wrenches that reach at least `height` along `direction`, in order.
    #[inline(always)]
    pub fn reaching(&self, direction: &Lanes, height: f64) -> impl Iterator<Item = Lanes> {
        let direction = *direction;
        let rows = self.rows.iter().copied();
        rows.filter(move |row| direction.dot(row) >= height)
    }
}

/// Two wrenches that are no farther apart than this, over the scale, count as one where facets of the whole hull matter
/// that have no part in ε. Planes through both of them would be off by rounding over their distance.
pub(super) const MERGE_TOLERANCE: f64 = 1e-9;

/// Wrenches closer than this, over the scale, are the same but for rounding: a few units of 2⁻⁵² in each component.
const SAME_TOLERANCE: f64 = 1e-14;

/// One wrench for each group of nearly coincident ones: the first of them. `None` when all of them differ, or are the same
/// but for rounding. O(n log n) unless very many have a component in common.
pub(super) fn merged(wrenches: &[Wrench]) -> Option<Vec<Wrench>> {
    let scale = wrenches.iter().map(Wrench::norm).fold(0.0, f64::max);
    // Along the widest axis, a wrench that coincides with another is not far from it in the order.
    let width = |axis: usize| {
        let values = wrenches.iter().map(|w| w[axis]);
        let (least, most) = values.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, m), x| {
            (l.min(x), m.max(x))
        });
        most - least
    };
    let axis = (0..6).max_by(|a, b| width(*a).total_cmp(&width(*b)))?;
    let mut order: Vec<usize> = (0..wrenches.len()).collect();
    order.sort_by(|a, b| wrenches[*a][axis].total_cmp(&wrenches[*b][axis]));
    let mut absorbed = vec![false; wrenches.len()];
    let mut any = false;
    for (place, &i) in order.iter().enumerate() {
        if absorbed[i] {
            continue;
        }
        for &j in &order[place + 1..] {
            if wrenches[j][axis] - wrenches[i][axis] > MERGE_TOLERANCE * scale {
                break;
            }
            let apart = (wrenches[j] - wrenches[i]).norm();
            if apart <= MERGE_TOLERANCE * scale {
                absorbed[j] = true;
                any |= apart > SAME_TOLERANCE * scale;
            }
        }
    }
    let kept = wrenches.iter().zip(&absorbed);
    any.then(|| kept.filter(|(_, gone)| !**gone).map(|(w, _)| *w).collect())
}

impl Body for WrenchSet {
    #[inline(always)]
    fn scale(&self) -> f64 {
        self.scale
    }

    #[inline(always)]
    fn reach(&self, direction: &Lanes) -> Reach {
        let Support { wrench, height } = self.support(direction);
        Reach {
            point: self.rows[wrench as usize],
            height,
        }
    }
}
