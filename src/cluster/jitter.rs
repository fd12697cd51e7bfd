//! Pauses of random length.

use std::ops::Range;
use std::time::Duration;

/// Returns a pause of a random multiple of `pause` within `factors`, so that processes that started or failed together
/// do not return to the store or to a receiver at the same moment.
pub fn jittered(pause: Duration, factors: Range<f64>) -> Duration {
    let random = f64::from(uuid::Uuid::new_v4().as_u128() as u32) / f64::from(u32::MAX);
    pause.mul_f64(factors.start + random * (factors.end - factors.start))
}
