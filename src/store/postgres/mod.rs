//! A store in PostgreSQL that many servers and workers share: rows, mesh files and results.
//!
//! # Who may write, and when
//!
//! - Any process may write at any moment. Each change is one guarded statement, or a transaction of a few. None lasts as
//!   long as a job, and none waits for a client.
//! - A worker holds a job by a lease, which it renews. Every statement about a running job names the token of the lease
//!   and the attempt, and changes nothing once the job is in other hands. Whoever looks for work passes over rows
//!   that another session is taking (`SKIP LOCKED`) instead of waiting for them.
//! - A statement locks several running jobs only to renew their leases. All others lock one, so that no two wait for
//!   each other.
//! - Bounds on the queue are counted without a lock while they are far off, and one after the other under an advisory
//!   lock once they are near. Bounds on the room of an owner are counted under an advisory lock of that owner.
//! - A row of a mesh refers to its file, which keeps a file that one owner forgets while another sends it. Submitting a
//!   job locks the row of its mesh (`FOR KEY SHARE`) against its deletion.
//! - Leases and notices have a connection of their own, so that they do not wait in line behind the rest.
//!
//! # What survives
//!
//! - What a call acknowledges is on stable storage: each session sets `synchronous_commit = on`, whatever the database is
//!   set to. Renewals and notices alone do without, since nothing is promised by them.
//! - A process that dies leaves leases that run out, transactions that the server rolls back, and perhaps a file without
//!   a row, which the next sweep removes.
//! - All times are by the clock of the database, the one clock that all processes share.
//! - No statement is waited for longer than some seconds. A connection that did not answer is closed; the next one finds
//!   out whether the database is back.
//!
//! # Two versions side by side
//!
//! Versions N and N−1 of this program work on the same tables: migrations only add, the table `compatibility` says
//! which program is too old, and `jobs.format` keeps a worker from what it cannot read.

mod batches;
mod connections;
mod health;
mod jobs;
mod keys;
mod leases;
mod meshes;
mod migrations;
mod notices;
mod open;
mod retention;
mod submissions;
mod survey;
#[cfg(test)]
mod tests;
mod webhooks;

use super::StoreError;
use super::common::{self, Engine, Record};
use crate::metrics::StoreMetrics;
use connections::Connections;

pub use open::PoolSizes;
pub use survey::Survey;

/// A store in a database. Clones share connections.
#[derive(Debug, Clone)]
pub struct Postgres {
    reads: Connections,
    writes: Connections,
    /// For leases and notices.
    urgent: Connections,
    /// How to connect, for listeners.
    options: sqlx::postgres::PgConnectOptions,
    /// Marks the notices of this process, which it does not listen to itself.
    sender: u32,
    metrics: StoreMetrics,
}

impl Engine for Postgres {
    const IN_LIST: (&'static str, &'static str) = (" = ANY(", ")");

    async fn read<T: Record>(
        &self,
        statement: common::statement::Statement,
    ) -> Result<Vec<T>, StoreError> {
        self.reads.run(statement.for_postgres()).await?.all()
    }

    async fn change(&self, statement: common::statement::Statement) -> Result<u64, StoreError> {
        let statement = statement.for_postgres();
        Ok(self.writes.run(statement).await?.changed())
    }
}

/// A statement with its parameters.
type Statement<'q> = sqlx::query::Query<'q, sqlx::Postgres, sqlx::postgres::PgArguments>;

/// Bytes of one piece of a mesh file or result.
const PIECE_BYTES: usize = 1 << 20;
