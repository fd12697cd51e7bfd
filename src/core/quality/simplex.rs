//! Seven wrenches: their hull is a simplex and needs no hull algorithm.

use nalgebra::{SMatrix, SVector};

use super::{Margin, Wrench, scale};

/// Greatest condition, in the 1-norm, at which the inverse is trusted: its relative error stays
/// below condition · 2⁻⁵² ≈ 2·10⁻¹².
const CONDITION_LIMIT: f64 = 1e4;

/// The exact margin of a simplex, or `None` when it is too flat for this form.
///
/// The inverse of the 7 × 7 matrix with columns (w; 1) has rows (aᵢ, bᵢ) with barycentric
/// coordinates λᵢ(x) = aᵢ·x + bᵢ. The facet opposite wrench i is λᵢ = 0, at bᵢ/‖aᵢ‖ from the
/// origin. The last row is set to the scale of the set so that the condition does not depend on
/// the unit. A few hundred nanoseconds.
pub(super) fn margin(wrenches: &[Wrench; 7]) -> Option<Margin> {
    let scale = scale(wrenches);
    let matrix = SMatrix::<f64, 7, 7>::from_fn(|row, column| {
        if row < 6 {
            wrenches[column][row]
        } else {
            scale
        }
    });
    let inverse = matrix.lu().try_inverse()?;
    let condition = one_norm(&matrix) * one_norm(&inverse);
    if condition.is_nan() || condition > CONDITION_LIMIT {
        return None;
    }
    let (value, normal) = (0..7)
        .map(|i| {
            let row: SVector<f64, 7> = inverse.row(i).transpose();
            let gradient = row.fixed_rows::<6>(0).into_owned();
            let length = gradient.norm();
            (row[6] * scale / length, -gradient / length)
        })
        .min_by(|(a, _), (b, _)| a.total_cmp(b))?;
    Some(Margin {
        value,
        upper: value,
        direction: normal,
        scale,
        exact: true,
        facets: 7,
    })
}

fn one_norm(matrix: &SMatrix<f64, 7, 7>) -> f64 {
    matrix
        .column_iter()
        .map(|c| c.lp_norm(1))
        .fold(0.0, f64::max)
}
