//! The cost of a job for the database and for this process.

use std::fmt::Write as _;

use procfs::process::{Process, Stat, all_processes};
use testkit::postgres::Cluster;

/// Connections to this database, that of the question apart.
pub const CONNECTIONS: &str =
    "SELECT count(*) - 1 FROM pg_stat_activity WHERE datname = current_database()";

/// Statements of the service that have been carried out.
const STATEMENTS: &str = "SELECT coalesce(sum(calls), 0) FROM pg_stat_statements
    WHERE query NOT LIKE '%pg_stat_%' AND query NOT IN ('BEGIN', 'COMMIT')";
/// The most expensive of them: calls, mean milliseconds, rows a call and the first words.
const EXPENSIVE: &str = "SELECT calls, round(mean_exec_time::numeric, 3), round(rows::numeric / calls, 1),
    left(regexp_replace(query, '\\s+', ' ', 'g'), 100)
    FROM pg_stat_statements WHERE query NOT LIKE '%pg_stat_%' ORDER BY total_exec_time DESC LIMIT 12";
const TRANSACTIONS: &str =
    "SELECT xact_commit FROM pg_stat_database WHERE datname = current_database()";

/// Bytes written to the write-ahead log, and bytes of the database on disk.
const LOG: &str = "SELECT pg_current_wal_lsn() - '0/0'";
const SIZE: &str = "SELECT pg_database_size(current_database())";

/// A measurement that goes on.
pub struct Meter<'a> {
    cluster: &'a Cluster,
    database: &'a str,
    transactions: f64,
    log: f64,
    size: f64,
    /// Milliseconds of processor time that had been taken before: by the cluster, by this process.
    taken: (f64, f64),
}

/// The cost divided by the number of jobs.
pub struct Cost {
    pub database_ms: f64,
    pub graspd_ms: f64,
    pub transactions: f64,
    pub statements: f64,
    pub log_bytes: f64,
    pub disk_bytes: f64,
    /// The most expensive statements, a Markdown row each.
    pub table: String,
}

impl<'a> Meter<'a> {
    pub fn start(cluster: &'a Cluster, database: &'a str) -> Self {
        cluster.ask(database, "SELECT pg_stat_statements_reset()");
        Self {
            cluster,
            database,
            transactions: count(&cluster.ask(database, TRANSACTIONS)),
            log: count(&cluster.ask(database, LOG)),
            size: count(&cluster.ask(database, SIZE)),
            taken: taken(cluster),
        }
    }

    pub fn stop(self, jobs: usize) -> Cost {
        let taken = taken(self.cluster);
        let ask = |sql| self.cluster.ask(self.database, sql);
        let jobs = jobs as f64;
        let mut table = String::new();
        for line in ask(EXPENSIVE).lines() {
            let mut columns = line.splitn(4, '|');
            let mut next = || columns.next().unwrap_or_default();
            let (calls, mean, rows, query) = (next(), next(), next(), next());
            let query = query.replace('|', "\\|");
            let calls = count(calls) / jobs;
            let _ = writeln!(table, "| `{query}` | {calls:.3} | {mean} | {rows} |");
        }
        Cost {
            database_ms: (taken.0 - self.taken.0) / jobs,
            graspd_ms: (taken.1 - self.taken.1) / jobs,
            transactions: (count(&ask(TRANSACTIONS)) - self.transactions) / jobs,
            statements: count(&ask(STATEMENTS)) / jobs,
            log_bytes: (count(&ask(LOG)) - self.log) / jobs,
            disk_bytes: (count(&ask(SIZE)) - self.size) / jobs,
            table,
        }
    }
}

fn count(text: &str) -> f64 {
    text.parse()
        .unwrap_or_else(|_| panic!("{text:?} is no number"))
}

/// Milliseconds of processor time that the processes of the cluster have taken, those that have ended included,
/// and that this process has.
fn taken(cluster: &Cluster) -> (f64, f64) {
    let tick = 1e3 / procfs::ticks_per_second() as f64;
    let own = |stat: &Stat| (stat.utime + stat.stime) as f64 * tick;
    let parent = cluster.process().expect("a server") as i32;
    let parent = Process::new(parent)
        .and_then(|process| process.stat())
        .expect("its state");
    let ended = (parent.cutime + parent.cstime) as f64 * tick;
    let children = all_processes().expect("processes").filter_map(|process| {
        let stat = process.ok()?.stat().ok()?;
        (stat.ppid == parent.pid).then(|| own(&stat))
    });
    let cluster = own(&parent) + ended + children.sum::<f64>();
    let this = Process::myself().and_then(|process| process.stat());
    (cluster, own(&this.expect("the state of this process")))
}
