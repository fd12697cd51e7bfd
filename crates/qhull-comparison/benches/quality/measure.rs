//! Time per evaluation, engine and Qhull taking turns in one thread.

use std::ffi::CStr;
use std::hint::black_box;
use std::time::{Duration, Instant};

use graspd_core::quality::Evaluator;
use graspd_core::wrench::Wrench;

use qhull_comparison::{Silence, points};

/// How much time may be spent on one row.
#[derive(Debug, Clone, Copy)]
pub struct Effort {
    /// Turns of engine and Qhull.
    pub rounds: usize,
    /// Qhull's share of a round; it decides how many sets are used.
    pub qhull: Duration,
    /// The engine's share of a round.
    pub engine: Duration,
}

/// Times in seconds per evaluation.
#[derive(Debug, Clone, Copy)]
pub struct Timing {
    /// Median of the rounds.
    pub median: f64,
    /// Greatest less least round over the median.
    pub spread: f64,
}

/// Engine and Qhull on the same sets.
#[derive(Debug, Clone, Copy)]
pub struct Comparison {
    pub sets: usize,
    pub closures: usize,
    /// Facets that the engine builds for a set, on average.
    pub facets: f64,
    pub engine: Timing,
    /// The batch form; only sets of seven have one.
    pub batch: Option<Timing>,
    pub qhull: Timing,
}

/// Most and fewest sets in one row: enough of them that the branch predictor learns none by heart.
const SETS: std::ops::RangeInclusive<usize> = 8..=200;

/// Times `sets`, as many of them as Qhull gets through in its share of the time. `None` without sets.
///
/// Qhull: from the call with the points in its own layout to the least offset, its freeing of memory
/// left out. Engine: `quality` with an evaluator that is reused. Batch: `qualities_of_sevens`.
pub fn compare(sets: &[Vec<Wrench>], options: &CStr, effort: Effort) -> Option<Comparison> {
    let silence = Silence::new();
    let mut inputs: Vec<Vec<f64>> = sets.iter().map(|set| points(set)).collect();
    // The fastest of a few, lest one interruption decides how many sets there are.
    let tries = inputs.iter_mut().take(4);
    let least = tries
        .map(|input| qhull_time(&silence, options, input))
        .reduce(f64::min)?;
    let affordable = (effort.qhull.as_secs_f64() / least) as usize;
    let count = affordable.clamp(*SETS.start(), *SETS.end()).min(sets.len());
    let (sets, inputs) = (&sets[..count], &mut inputs[..count]);

    let mut evaluator = Evaluator::new();
    let margins = sets.iter().filter_map(|set| evaluator.quality(set).ok());
    let margins: Vec<_> = margins.collect();
    let closures = margins.iter().filter(|margin| margin.is_force_closure());
    let closures = closures.count();
    let facets = margins.iter().map(|margin| margin.facets).sum::<usize>() as f64 / count as f64;

    let sevens: Vec<[Wrench; 7]> = sets
        .iter()
        .filter_map(|set| set.as_slice().try_into().ok())
        .collect();
    let (mut engine, mut batch, mut qhull) = (Vec::new(), Vec::new(), Vec::new());
    let mut margins = Vec::with_capacity(count);
    for _ in 0..effort.rounds {
        engine.push(per_set(count, effort.engine, || {
            for set in sets {
                black_box(evaluator.quality(black_box(set)).is_ok());
            }
        }));
        if !sevens.is_empty() {
            batch.push(per_set(count, effort.engine, || {
                margins.clear();
                evaluator.qualities_of_sevens(black_box(&sevens), &mut margins);
                black_box(&margins);
            }));
        }
        let total: f64 = inputs
            .iter_mut()
            .map(|input| qhull_time(&silence, options, input))
            .sum();
        qhull.push(total / count as f64);
    }
    Some(Comparison {
        sets: count,
        closures,
        facets,
        engine: timing(engine)?,
        batch: timing(batch),
        qhull: timing(qhull)?,
    })
}

/// Seconds that Qhull takes for one set, or to find it flat.
fn qhull_time(silence: &Silence, options: &CStr, points: &mut [f64]) -> f64 {
    let start = Instant::now();
    let hull = silence.hull(points, options);
    black_box(hull.as_ref().map_or(0.0, |hull| hull.margin()));
    start.elapsed().as_secs_f64()
}

/// Seconds per set of `pass`, which does all `count` of them, repeated for about `share`.
fn per_set(count: usize, share: Duration, mut pass: impl FnMut()) -> f64 {
    let start = Instant::now();
    let mut passes = 0;
    while passes == 0 || start.elapsed() < share {
        pass();
        passes += 1;
    }
    start.elapsed().as_secs_f64() / (passes * count) as f64
}

fn timing(mut rounds: Vec<f64>) -> Option<Timing> {
    rounds.sort_by(f64::total_cmp);
    let median = *rounds.get(rounds.len() / 2)?;
    let spread = (rounds.last()? - rounds.first()?) / median;
    Some(Timing { median, spread })
}
