//! Quantiles of times.

use std::time::Duration;

/// A row of the table: name, count, median, 99th percentile and maximum in milliseconds, and a note.
pub fn row(what: &str, mut times: Vec<Duration>, note: &str) {
    times.sort();
    let at = |share: f64| {
        let last = times.len().saturating_sub(1) as f64;
        let time = times.get((last * share).round() as usize);
        time.map_or_else(
            || "–".to_owned(),
            |time| format!("{:.2}", time.as_secs_f64() * 1e3),
        )
    };
    println!(
        "| {what} | {} | {} | {} | {} | {note} |",
        times.len(),
        at(0.5),
        at(0.99),
        at(1.0)
    );
}
