//! The slow, obviously right twin of the hull code: every six wrenches that define a hyperplane
//! are tried, and those with all others on one side are facets.

use nalgebra::{SMatrix, SVector};

use crate::wrench::Wrench;

/// The least facet offset, or `None` when no six wrenches bound the set.
/// O(n⁷); meant for at most 14 wrenches.
pub(super) fn margin(wrenches: &[Wrench]) -> Option<f64> {
    let n = wrenches.len();
    let scale = scale(wrenches);
    let mut least: Option<f64> = None;
    for subset in subsets_of_six(n) {
        let base = wrenches[subset[0]];
        let edges = SMatrix::<f64, 5, 6>::from_fn(|r, c| wrenches[subset[r + 1]][c] - base[c]);
        let Some(normal) = kernel(edges) else {
            continue;
        };
        let offset = normal.dot(&base);
        let (mut low, mut high) = (0.0_f64, 0.0_f64);
        for w in wrenches {
            let d = normal.dot(w) - offset;
            low = low.min(d);
            high = high.max(d);
        }
        let slack = 1e-11 * scale;
        let signed = match (high <= slack, low >= -slack) {
            (true, false) => offset,
            (false, true) => -offset,
            _ => continue,
        };
        least = Some(least.map_or(signed, |l| l.min(signed)));
    }
    least
}

/// The unit vector orthogonal to five independent rows, by Gauss-Jordan with full pivoting; `None`
/// when they are nearly dependent.
fn kernel(mut m: SMatrix<f64, 5, 6>) -> Option<SVector<f64, 6>> {
    let size = m.amax();
    let mut order = [0, 1, 2, 3, 4, 5];
    for step in 0..5 {
        let (mut pr, mut pc) = (step, step);
        for r in step..5 {
            for c in step..6 {
                if m[(r, c)].abs() > m[(pr, pc)].abs() {
                    (pr, pc) = (r, c);
                }
            }
        }
        if m[(pr, pc)].abs() < 1e-6 * size {
            return None;
        }
        m.swap_rows(step, pr);
        m.swap_columns(step, pc);
        order.swap(step, pc);
        for r in 0..5 {
            if r != step {
                let factor = m[(r, step)] / m[(step, step)];
                for c in step..6 {
                    m[(r, c)] -= factor * m[(step, c)];
                }
            }
        }
    }
    let mut kernel = SVector::<f64, 6>::zeros();
    kernel[order[5]] = 1.0;
    for r in 0..5 {
        kernel[order[r]] = -m[(r, 5)] / m[(r, r)];
    }
    Some(kernel.normalize())
}

fn subsets_of_six(n: usize) -> impl Iterator<Item = [usize; 6]> {
    let mut next = (n >= 6).then_some([0, 1, 2, 3, 4, 5]);
    std::iter::from_fn(move || {
        let current = next?;
        next = (0..6).rev().find(|&i| current[i] < n - 6 + i).map(|i| {
            let mut following = current;
            for (step, slot) in following[i..].iter_mut().enumerate() {
                *slot = current[i] + 1 + step;
            }
            following
        });
        Some(current)
    })
}

/// Length of the longest wrench.
pub(super) fn scale(wrenches: &[Wrench]) -> f64 {
    wrenches
        .iter()
        .map(Wrench::norm_squared)
        .fold(0.0, f64::max)
        .sqrt()
}
