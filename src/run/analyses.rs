//! What is told of a grasp only when it is asked for: from the wire to the core and back.

use nalgebra::Vector3;

use super::settings::out_of_range;
use crate::wire::{
    Analyses, IndependentRegion, Problem, RegionSettings, Robustness, RobustnessSettings,
    TaskQuality,
};
use graspd_core::analysis::{Analysis, AnalysisSettings};
use graspd_core::effort::External;
use graspd_core::independent::{Fraction, Region};
use graspd_core::robustness::Scatter;

/// Triangles of regions that one answer lists.
const MAX_TRIANGLES: usize = 100_000;

/// What was asked for, as it is answered.
#[derive(Default)]
pub(super) struct Told {
    pub robustness: Option<Robustness>,
    pub independent_regions: Option<Vec<IndependentRegion>>,
    pub task_quality: Option<TaskQuality>,
    pub gravity_quality: Option<f64>,
}

/// As safe as [`super::settings::settings`].
pub(super) fn settings(asked: &Analyses) -> Result<AnalysisSettings, Problem> {
    let Analyses {
        robustness,
        independent_regions,
        task_wrenches,
        gravity,
    } = asked;
    let regions = independent_regions.map(|RegionSettings { fraction }| {
        Fraction::new(fraction).ok_or_else(|| out_of_range("independent_regions"))
    });
    let scatter = robustness.map(|settings| match settings {
        RobustnessSettings {
            sigma,
            samples: samples @ 1..,
            seed,
        } if sigma > 0.0 => Ok(Scatter {
            sigma,
            samples: samples as usize,
            seed,
        }),
        _ => Err(out_of_range("robustness")),
    });
    let tasks = task_wrenches.iter().flatten();
    Ok(AnalysisSettings {
        robustness: scatter.transpose()?,
        regions: regions.transpose()?,
        tasks: tasks
            .map(|&[fx, fy, fz, tx, ty, tz]| External {
                force: Vector3::new(fx, fy, fz),
                torque: Vector3::new(tx, ty, tz),
            })
            .collect(),
        gravity: gravity.map(Vector3::from),
    })
}

/// What one of `grasps` grasps of an answer is told to be.
pub(super) fn told(asked: &Analyses, found: &Analysis, grasps: usize) -> Told {
    let robustness = asked.robustness.zip(found.robustness);
    let least = found.tasks.iter().copied().enumerate();
    let least = least.min_by(|(_, a), (_, b)| a.total_cmp(b));
    Told {
        robustness: robustness.map(|(settings, found)| Robustness {
            sigma: settings.sigma,
            samples: settings.samples,
            seed: settings.seed,
            expected: found.expected,
            percentile_5: found.percentile_5,
            force_closure_probability: found.force_closure_probability,
        }),
        independent_regions: found.regions.as_ref().map(|regions| {
            let share = MAX_TRIANGLES / (grasps * regions.len()).max(1);
            regions.iter().map(|found| region(found, share)).collect()
        }),
        task_quality: least.map(|(weakest, least)| TaskQuality {
            per_wrench: found.tasks.clone(),
            least,
            weakest: weakest as u32,
        }),
        gravity_quality: found.gravity,
    }
}

/// A region with at most `limit` triangles listed.
fn region(found: &Region, limit: usize) -> IndependentRegion {
    let shown = found.triangles.len().min(limit);
    IndependentRegion {
        triangles: found.triangles[..shown].to_vec(),
        truncated: shown < found.triangles.len(),
        count: found.triangles.len() as u64,
        area: found.area,
        connected: found.connected.map(|patch| patch.triangles as u64),
        connected_area: found.connected.map(|patch| patch.area),
    }
}
