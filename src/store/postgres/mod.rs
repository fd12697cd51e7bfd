//! A store in PostgreSQL that many servers and workers share: rows, mesh files and results.
//!
//! All times are by the clock of the database. Every change is one guarded statement or a transaction of a few;
//! none lasts as long as a job, and none waits for a client. Statements that change a lease name its token. No
//! statement is waited for longer than some seconds, and a connection that did not answer is closed: the next
//! one finds out whether the database is back.
//!
//! Versions N and N−1 of this program work side by side: migrations only add, the table `compatibility` says
//! which program is too old, and `jobs.format` keeps a worker from what it cannot read.

mod batches;
mod connections;
mod health;
mod jobs;
mod keys;
mod leases;
mod meshes;
mod notices;
mod open;
mod retention;
mod submissions;
mod survey;
#[cfg(test)]
mod tests;
mod webhooks;

use crate::metrics::StoreMetrics;
use connections::Connections;

pub use open::Sizes;
pub use survey::Survey;

/// A store in a database. Clones share connections.
#[derive(Debug, Clone)]
pub struct Postgres {
    /// For what clients and workers ask.
    reads: Connections,
    writes: Connections,
    /// For leases and notices, which must not wait in line behind the rest.
    pulse: Connections,
    /// How to connect, for listeners.
    options: sqlx::postgres::PgConnectOptions,
    /// Tells the notices of this process from those of others.
    sender: u32,
    metrics: StoreMetrics,
}

/// Bytes of one piece of a mesh file or result.
const PIECE_BYTES: usize = 1 << 20;
