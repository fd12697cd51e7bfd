//! Servers and workers of the real binary on one PostgreSQL database, killed, frozen and cut off from it:
//! whatever is acknowledged is kept, and each job ends with exactly one result.
//!
//! `make fleet` runs the long form. GRASPD_FLEET_JOBS is the number of jobs of the great disorder,
//! GRASPD_FOLLOWERS that of the clients who follow jobs, GRASPD_CHAOS_SEED what a run that failed said its seed
//! was.

mod batches;
mod disorder;
mod ends;
mod fleet;
mod following;
mod history;
mod lease;
mod member;
mod sharing;
mod turns;
