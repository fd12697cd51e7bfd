//! Statistics over runs repeated with other seeds.

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use graspd_core::search::StopReason;

/// The trials of a run, which differ in their seeds only, with statistics over them.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct Trials {
    /// Trials that were run; fewer than requested when time ran out or the job was cancelled.
    pub count: u32,
    /// How many of them found a force-closure grasp.
    pub force_closures: u32,
    /// The qualities of the first grasps.
    pub initial: Option<Statistics>,
    /// The qualities of the best grasps, of the trials that found one.
    pub last: Option<Statistics>,
    /// The quality of the best grasp divided by that of the first, of the trials that have both.
    pub ratio: Option<Statistics>,
    pub evaluations: Option<Statistics>,
    /// The seconds that each trial took.
    #[serde(default)]
    pub elapsed_s: Option<Statistics>,
    pub runs: Vec<Trial>,
}

/// Statistics of at least one number.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct Statistics {
    pub mean: f64,
    /// Standard deviation of the sample (n − 1); zero for a single number.
    pub sd: f64,
    pub min: f64,
    pub max: f64,
}

/// The outcome of one trial.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct Trial {
    pub seed: u64,
    /// Quality ε of the first grasp.
    pub initial: Option<f64>,
    /// Quality ε of the best grasp.
    pub last: Option<f64>,
    pub evaluations: u64,
    pub stopped_because: StopReason,
    pub elapsed_s: f64,
}

impl Statistics {
    /// Computes the statistics; `None` without values.
    pub fn of(values: impl IntoIterator<Item = f64>) -> Option<Self> {
        let values: Vec<f64> = values.into_iter().collect();
        let count = values.len() as f64;
        let mean = values.iter().sum::<f64>() / count;
        let squares: f64 = values.iter().map(|x| (x - mean).powi(2)).sum();
        (!values.is_empty()).then(|| Self {
            mean,
            sd: (squares / (count - 1.0).max(1.0)).sqrt(),
            min: values.iter().copied().fold(f64::INFINITY, f64::min),
            max: values.iter().copied().fold(f64::NEG_INFINITY, f64::max),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::Statistics;

    #[test]
    fn statistics_of_known_samples() {
        assert_eq!(Statistics::of([]), None);
        let one = Statistics::of([3.0]).unwrap();
        assert_eq!((one.mean, one.sd, one.min, one.max), (3.0, 0.0, 3.0, 3.0));
        let few = Statistics::of([2.0, 4.0, 4.0, 4.0, 5.0, 5.0, 7.0, 9.0]).unwrap();
        assert_eq!((few.mean, few.min, few.max), (5.0, 2.0, 9.0));
        assert!((few.sd - (32.0_f64 / 7.0).sqrt()).abs() < 1e-15);
    }
}
