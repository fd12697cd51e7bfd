//! Small convex quadratic programs over a simplex.
//!
//! The active-set method of Wolfe (1976) for the nearest point of a polytope, with a linear term.
//!
//! ```text
//! support ← the components of x that are not zero
//! repeat
//!     target ← the stationary point of the objective with all other components at zero     one linear system
//!     go from x towards the target, until a component would turn negative: drop that one and repeat
//!     let in the component outside that lowers the objective fastest; stop when there is none
//! ```
//!
//! Invariant: x meets the conditions and the objective never rises. When no component lowers it, the conditions of
//! Karush, Kuhn and Tucker hold, which suffice as the program is convex. It ends after 8 rounds for each component at the latest, as
//! rounding and ties could bring a support back. A round costs O(support³).

use nalgebra::{DMatrix, DVector};

/// Added to the diagonal, over its greatest entry, so that vectors that depend on each other leave
/// the linear systems solvable. Moves the minimum by as much.
const REGULARIZATION: f64 = 1e-12;

/// A term that would lower the objective at less than this rate, over the greatest cost, is left out.
const OPTIMALITY: f64 = 1e-11;

/// Finds the x ≥ 0 that minimises ½·xᵀQx + c·x while its first `shares` components sum to one.
///
/// `products` is Q, positive semidefinite, and `costs` is c. `x` holds where to start; it may be shorter than `costs`.
/// All zero starts anywhere, else it must meet the conditions. Where a system cannot be solved, or after the last
/// round, `x` is the best so far.
pub(super) fn minimize(products: &DMatrix<f64>, costs: &[f64], shares: usize, x: &mut Vec<f64>) {
    let n = costs.len();
    x.resize(n, 0.0);
    let mut support: Vec<usize> = (0..n).filter(|&i| x[i] > 0.0).collect();
    if support.is_empty() {
        let value = |i: usize| 0.5 * products[(i, i)] + costs[i];
        let lowest = (0..shares).min_by(|&i, &j| value(i).total_cmp(&value(j)));
        let Some(lowest) = lowest else { return };
        x[lowest] = 1.0;
        support.push(lowest);
    }
    let greatest = products.diagonal().amax();
    let tolerance = OPTIMALITY * costs.iter().fold(greatest, |m, c| m.max(c.abs()));
    for _ in 0..8 * n {
        let Some((target, level)) = stationary(products, costs, shares, &support, greatest) else {
            break;
        };
        // As far towards the stationary point as nothing turns negative.
        let mut step = 1.0;
        let mut leaving = None;
        for (place, &i) in support.iter().enumerate() {
            if target[place] <= 0.0 {
                let share = x[i] / (x[i] - target[place]);
                if share < step || leaving.is_none() {
                    (step, leaving) = (share.min(step), Some(place));
                }
            }
        }
        for (place, &i) in support.iter().enumerate() {
            x[i] = (x[i] + step * (target[place] - x[i])).max(0.0);
        }
        if let Some(place) = leaving {
            x[support.remove(place)] = 0.0;
            if support.is_empty() {
                break;
            }
            continue;
        }
        let slope = |i: usize| {
            let quadratic: f64 = support.iter().map(|&j| products[(i, j)] * x[j]).sum();
            quadratic + costs[i] - if i < shares { level } else { 0.0 }
        };
        let entering = (0..n)
            .filter(|i| !support.contains(i))
            .map(|i| (i, slope(i)))
            .min_by(|a, b| a.1.total_cmp(&b.1));
        match entering {
            Some((i, slope)) if slope < -tolerance => support.push(i),
            _ => break,
        }
    }
}

/// Returns the stationary point of the objective on the support, and the multiplier of the sum.
fn stationary(
    products: &DMatrix<f64>,
    costs: &[f64],
    shares: usize,
    support: &[usize],
    greatest: f64,
) -> Option<(DVector<f64>, f64)> {
    let k = support.len();
    let mut system = DMatrix::zeros(k + 1, k + 1);
    let mut right = DVector::zeros(k + 1);
    for (row, &i) in support.iter().enumerate() {
        for (column, &j) in support.iter().enumerate() {
            system[(row, column)] = products[(i, j)];
        }
        system[(row, row)] += REGULARIZATION * greatest;
        if i < shares {
            system[(row, k)] = 1.0;
            system[(k, row)] = 1.0;
        }
        right[row] = -costs[i];
    }
    right[k] = 1.0;
    let solution = system.lu().solve(&right)?;
    let finite = solution.iter().all(|x| x.is_finite());
    finite.then(|| (solution.rows(0, k).into_owned(), -solution[k]))
}

#[cfg(test)]
mod tests {
    use rand::{Rng, SeedableRng};
    use rand_pcg::Pcg64;

    use super::*;

    fn uniform(rng: &mut Pcg64) -> f64 {
        (rng.next_u64() >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    }

    /// By the conditions of Karush, Kuhn and Tucker, which suffice for a convex program.
    #[test]
    fn the_minimum_is_one() {
        let mut rng = Pcg64::seed_from_u64(1);
        for round in 0..300 {
            let (shares, others) = (1 + round % 12, round % 7);
            let n = shares + others;
            let vectors = DMatrix::from_fn(1 + round % 9, n, |_, _| uniform(&mut rng));
            let products = vectors.transpose() * &vectors;
            // A cost above zero bounds the objective where no sum does.
            let costs: Vec<f64> = (0..n).map(|_| uniform(&mut rng).abs()).collect();
            let mut x = Vec::new();
            minimize(&products, &costs, shares, &mut x);
            assert!(x.iter().all(|&x| x >= 0.0));
            assert!((x[..shares].iter().sum::<f64>() - 1.0).abs() < 1e-9);
            let slopes = &products * DVector::from_column_slice(&x) + DVector::from_vec(costs);
            let level = slopes.rows(0, shares).min();
            for i in 0..n {
                let slope = slopes[i] - if i < shares { level } else { 0.0 };
                assert!(slope > -1e-6, "{round}: {slope}");
                assert!(x[i] * slope < 1e-6, "{round}: {} {slope}", x[i]);
            }
        }
    }

    #[test]
    fn nothing_breaks_it() {
        let minimum = |products: &DMatrix<f64>, costs: &[f64], shares: usize| {
            let mut x = Vec::new();
            minimize(products, costs, shares, &mut x);
            x
        };
        let zeros = DMatrix::zeros(3, 3);
        assert_eq!(minimum(&zeros, &[0.0, 1.0, 0.0], 2), [1.0, 0.0, 0.0]);
        assert!(minimum(&DMatrix::zeros(0, 0), &[], 0).is_empty());
        let bad = DMatrix::from_element(2, 2, f64::NAN);
        assert_eq!(minimum(&bad, &[0.0, 0.0], 2).len(), 2);
    }
}
