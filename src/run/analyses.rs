//! The analyses of a grasp that a request asks for: settings for the core, lists of a bounded length.

use nalgebra::Vector3;

use super::settings::out_of_range;
use crate::wire::{Analyses, Problem, RegionSettings, RobustnessSettings};
use graspd_core::analysis::AnalysisSettings;
use graspd_core::effort::ExternalWrench;
use graspd_core::independent::{Fraction, IndependentRegion};
use graspd_core::robustness::Scatter;

/// Triangles of regions that one answer lists.
const MAX_TRIANGLES: usize = 100_000;

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
            samples,
            seed,
        }),
        _ => Err(out_of_range("robustness")),
    });
    let tasks = task_wrenches.iter().flatten();
    Ok(AnalysisSettings {
        robustness: scatter.transpose()?,
        regions: regions.transpose()?,
        tasks: tasks
            .map(|&[fx, fy, fz, tx, ty, tz]| ExternalWrench {
                force: Vector3::new(fx, fy, fz),
                torque: Vector3::new(tx, ty, tz),
            })
            .collect(),
        gravity: gravity.map(Vector3::from),
    })
}

/// Cuts the lists of triangles short, so that an answer with `grasps` grasps lists at most
/// [`MAX_TRIANGLES`], the same number for every contact.
pub(super) fn shorten(regions: &mut Option<Vec<IndependentRegion>>, grasps: usize) {
    let Some(regions) = regions else {
        return;
    };
    let share = MAX_TRIANGLES / (grasps * regions.len()).max(1);
    for region in regions {
        region.truncate(share);
    }
}
