//! Steps of all contacts together, by a bundle of linearised cuts.

use nalgebra::{DMatrix, Vector3};

use super::program;
use super::sliding::{End, Sliding, Trial};
use crate::mesh::SurfaceContact;

/// Steps without a gain that each add a cut, before a shorter one is taken.
const NULL_STEPS: usize = 2;

/// Tries steps of all contacts together, until one is better or none can be. `keep` keeps the contacts to their
/// triangles. Returns whether one is better.
pub(super) fn step_together(sliding: &mut Sliding<'_>, keep: bool) -> Result<bool, End> {
    for _ in 0..NULL_STEPS {
        let Some(steps) = best_steps(sliding, sliding.radius, keep) else {
            break;
        };
        let trial: Vec<SurfaceContact> = sliding
            .places
            .iter()
            .zip(&steps)
            .map(|(place, step)| sliding.surface.walk(place, step))
            .collect();
        if sliding.bound(&trial) <= sliding.enough() {
            break;
        }
        match sliding.evaluate(trial)? {
            Trial::Better => return Ok(true),
            Trial::Worse(direction) => {
                if !sliding.add_cut(direction) {
                    break;
                }
            }
            Trial::Unfit => break,
        }
    }
    Ok(false)
}

/// Returns the steps of the sliding contacts, none longer than `radius`, that raise the least linearised cut most, less
/// a damping. `None` when that gains nothing.
///
/// The steps d maximise the least of hₖ + gₖ·d over the cuts, less |d|²/(2·damping), within the sides of the triangles
/// where these are near. By duality d = damping·Σ wₖ·gₖ, with weights w that solve a small
/// [quadratic program](program): those of the cuts sum to one, those of the sides are at least zero.
fn best_steps(sliding: &Sliding<'_>, radius: f64, keep: bool) -> Option<Vec<Vector3<f64>>> {
    let first = sliding.fixed.len();
    let count = sliding.places.len();
    let mut rows: Vec<Vec<Vector3<f64>>> = sliding
        .cuts
        .iter()
        .map(|cut| cut.gradient[first..].to_vec())
        .collect();
    let steepest = rows.iter().flatten().map(Vector3::norm).fold(0.0, f64::max);
    if steepest == 0.0 || !steepest.is_finite() {
        return None;
    }
    // Weights that sum to one give no step longer than the radius.
    let damping = radius / steepest;
    let mut costs: Vec<f64> = sliding.cuts.iter().map(|cut| cut.height).collect();
    if keep {
        for (contact, place) in sliding.places.iter().enumerate() {
            for (distance, away) in sliding.surface.sides(place).into_iter().flatten() {
                if distance < radius {
                    let mut row = vec![Vector3::zeros(); count];
                    row[contact] = away;
                    rows.push(row);
                    costs.push(distance);
                }
            }
        }
    }
    let n = rows.len();
    let product = |a: &[Vector3<f64>], b: &[Vector3<f64>]| -> f64 {
        a.iter().zip(b).map(|(a, b)| a.dot(b)).sum()
    };
    let products = DMatrix::from_fn(n, n, |i, j| damping * product(&rows[i], &rows[j]));
    let mut weights = Vec::new();
    program::minimize(&products, &costs, sliding.cuts.len(), &mut weights);
    let mut steps = vec![Vector3::zeros(); count];
    for (row, weight) in rows.iter().zip(&weights) {
        for (step, slope) in steps.iter_mut().zip(row) {
            *step += slope * (damping * weight);
        }
    }
    let hoped = sliding
        .cuts
        .iter()
        .zip(&rows)
        .map(|(cut, row)| cut.height + product(row, &steps))
        .fold(f64::INFINITY, f64::min);
    (hoped > sliding.enough()).then_some(steps)
}
