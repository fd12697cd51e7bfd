//! Servers and workers of the real binary on one PostgreSQL database, killed, frozen and cut off from it:
//! whatever is acknowledged is kept, and each job ends with exactly one result.
//!
//! `make fleet` runs the long form. GRASPD_FLEET_JOBS is the number of jobs of the great disorder,
//! GRASPD_FOLLOWERS that of the clients who follow jobs, GRASPD_CHAOS_SEED what a run that failed said its seed
//! was.

mod batches;
#[path = "../chaos/client.rs"]
mod client;
#[path = "../chaos/dice.rs"]
mod dice;
mod disorder;
mod ends;
mod fleet;
mod following;
mod history;
mod lease;
#[path = "../chaos/ledger.rs"]
mod ledger;
#[path = "../chaos/load.rs"]
mod load;
mod member;
#[path = "../chaos/oracle.rs"]
mod oracle;
#[path = "../support/outage.rs"]
mod outage;
#[path = "../support/postgres.rs"]
#[allow(dead_code, reason = "other tests use the rest")]
mod postgres;
#[path = "../http/process.rs"]
#[allow(dead_code, reason = "the tests of one server use the rest")]
mod process;
mod sharing;
#[path = "../http/stream.rs"]
mod stream;
mod turns;
#[path = "../chaos/verdict.rs"]
mod verdict;

/// A number from the environment.
fn setting(name: &str, default: u64) -> u64 {
    std::env::var(name).map_or(default, |text| {
        text.parse()
            .unwrap_or_else(|_| panic!("{name}={text} is no number"))
    })
}
