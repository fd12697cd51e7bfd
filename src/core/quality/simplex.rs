//! Seven wrenches: their hull is a simplex and needs no hull algorithm.
//!
//! The inverse of the 7 × 7 matrix with columns (wᵢ; 1) has rows (aᵢ, bᵢ) with the barycentric
//! coordinates λᵢ(x) = aᵢ·x + bᵢ. The facet opposite wrench i is λᵢ = 0, at bᵢ/‖aᵢ‖ from the origin.
//! Eight sets are inverted at once, one a lane; a single set takes a lane of its own and gives the
//! same bits.

// Lanes of several rows are taken by one number.
#![allow(clippy::needless_range_loop)]

use super::lanes::{LANES, Lanes};
use super::wrench_set::power_of_two_below;
use super::{Margin, Wrench};

/// Greatest ‖aᵢ‖ times the scale at which the inverse is trusted: the longest wrench over the least
/// height of the simplex. The planes' relative error stays below that times some units of 2⁻⁵², 10⁻¹¹ at
/// worst and usually a hundredth.
const SLENDERNESS_LIMIT: f64 = 1e4;

/// The exact margins of up to eight simplices; `None` for one that is too flat for this form, or not
/// finite.
#[inline(always)]
pub(super) fn margins(sets: &[[Wrench; 7]]) -> [Option<Margin>; LANES] {
    let mut units = Lanes::splat(1.0);
    let mut scales = Lanes::splat(1.0);
    // matrix[component][wrench]; idle lanes hold the unit matrix.
    let mut matrix = [[Lanes::splat(0.0); 7]; 7];
    for i in 0..7 {
        matrix[i][i] = Lanes::splat(1.0);
    }
    for (lane, set) in sets.iter().enumerate().take(LANES) {
        let greatest = set.iter().flat_map(|w| w.iter()).fold(0.0, |g, x| {
            let size = x.abs();
            if size > g { size } else { g }
        });
        let unit = power_of_two_below(greatest);
        let factor = unit.recip();
        let mut squared = 0.0;
        for (i, w) in set.iter().enumerate() {
            let row = Lanes::of(w, 0.0).map(|x| x * factor);
            for component in 0..6 {
                matrix[component][i].0[lane] = row.0[component];
            }
            matrix[6][i].0[lane] = 1.0;
            let length = row.dot(&row);
            squared = if length > squared { length } else { squared };
        }
        units.0[lane] = unit;
        scales.0[lane] = squared;
    }
    let scales = scales.map(f64::sqrt);
    invert(&mut matrix);

    let mut least = Lanes::splat(f64::INFINITY);
    let mut slenderness = Lanes::splat(0.0);
    let mut direction = [Lanes::splat(0.0); 6];
    for row in &matrix {
        let mut squared = row[0].map(|x| x * x);
        for component in 1..6 {
            squared = squared.zip(&row[component], |s, x| s + x * x);
        }
        let norm = squared.map(f64::sqrt);
        // Also when the norm is no number.
        slenderness = slenderness.zip(&norm, |s, n| if n <= s { s } else { n });
        let shrink = norm.map(|n| 1.0 / n);
        let offset = row[6].zip(&shrink, |b, s| b * s);
        for component in 0..6 {
            for lane in 0..LANES {
                let normal = -row[component].0[lane] * shrink.0[lane];
                let nearer = offset.0[lane] < least.0[lane];
                direction[component].0[lane] = if nearer {
                    normal
                } else {
                    direction[component].0[lane]
                };
            }
        }
        least = least.zip(&offset, |l, o| if o < l { o } else { l });
    }
    std::array::from_fn(|lane| {
        let scale = scales.0[lane];
        let value = least.0[lane] * units.0[lane];
        let sound = slenderness.0[lane] * scale <= SLENDERNESS_LIMIT && value.is_finite();
        (lane < sets.len() && sound).then(|| Margin {
            value,
            upper: value,
            direction: Wrench::from_fn(|component, _| direction[component].0[lane]),
            scale: scale * units.0[lane],
            exact: true,
            facets: 7,
        })
    })
}

/// Inverts in place, lane by lane, but for the order of the rows: Gauss-Jordan elimination, at each
/// component with the remaining wrench that has most of it.
#[inline(always)]
fn invert(matrix: &mut [[Lanes; 7]; 7]) {
    for k in 0..7 {
        for other in k + 1..7 {
            let (now, then) = (matrix[k][k], matrix[k][other]);
            for row in matrix.iter_mut() {
                for lane in 0..LANES {
                    let swap = then.0[lane].abs() > now.0[lane].abs();
                    let (a, b) = (row[k].0[lane], row[other].0[lane]);
                    row[k].0[lane] = if swap { b } else { a };
                    row[other].0[lane] = if swap { a } else { b };
                }
            }
        }
        let shrink = matrix[k][k].map(|x| 1.0 / x);
        matrix[k][k] = Lanes::splat(1.0);
        for column in 0..7 {
            matrix[k][column] = matrix[k][column].zip(&shrink, |x, s| x * s);
        }
        let pivot = matrix[k];
        for row in 0..7 {
            if row == k {
                continue;
            }
            let factor = matrix[row][k];
            matrix[row][k] = Lanes::splat(0.0);
            for column in 0..7 {
                for lane in 0..LANES {
                    matrix[row][column].0[lane] -= factor.0[lane] * pivot[column].0[lane];
                }
            }
        }
    }
}
