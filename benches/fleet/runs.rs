//! A planner that only waits, and when it did.

use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

use graspd::jobs::Runner;
use serde_json::json;
use serde_json::value::to_raw_value;

/// The interval in which each run waited.
#[derive(Default)]
pub struct Runs(Mutex<Vec<(Instant, Instant)>>);

impl Runs {
    /// The planner.
    pub fn runner(self: Arc<Self>, wait: Duration) -> Arc<Runner> {
        Arc::new(move |_, _, _, _| {
            let begun = Instant::now();
            std::thread::sleep(wait);
            let run = (begun, Instant::now());
            self.0.lock().expect("whole times").push(run);
            Ok(to_raw_value(&json!({"force_closure": false})).expect("JSON"))
        })
    }

    pub fn count(&self) -> usize {
        self.0.lock().expect("whole times").len()
    }

    /// Which part of their time `workers` waited in a planner, and the time that is meant: from the moment at
    /// which as many runs had begun to the moment at which the last one began.
    pub fn busy(&self, workers: usize) -> (f64, Duration) {
        let mut runs = self.0.lock().expect("whole times").clone();
        runs.sort();
        let (first, last) = (runs[workers.min(runs.len()) - 1].0, runs[runs.len() - 1].0);
        let overlap = |(begun, ended): &(Instant, Instant)| {
            ended
                .min(&last)
                .saturating_duration_since(*begun.max(&first))
        };
        let waited: Duration = runs.iter().map(overlap).sum();
        let window = last - first;
        let share = waited.as_secs_f64() / (workers as f64 * window.as_secs_f64());
        (share, window)
    }
}
