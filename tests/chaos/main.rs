//! The real binary under load, killed, stopped, ended and with its clock moved: whatever is
//! acknowledged is kept, and each job ends with exactly one result.
//!
//! `make chaos` runs the long form. GRASPD_KILLS is the number of kills, GRASPD_TERMS that of
//! orderly ends, GRASPD_CHAOS_SEED what a run that failed said its seed was.

mod clock;
mod ends;
mod folder;
mod kills;
mod server;

/// The time in which something has to happen, `seconds` as promised. The short form of these tests runs beside
/// others, on machines that are busy, and allows more.
fn promised(seconds: u64) -> std::time::Duration {
    let is_long = ["GRASPD_KILLS", "GRASPD_TERMS"].map(std::env::var_os);
    let factor = if is_long.iter().any(Option::is_some) {
        1
    } else {
        5
    };
    std::time::Duration::from_secs(factor * seconds)
}
