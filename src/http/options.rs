//! The settings of a process as options of the service.

use std::net::SocketAddr;

use crate::config::{Auth, Config, Period, Planning};
use crate::jobs::{Location, Options, PlanningOptions, Quota, Role, webhooks};

/// How often a job is started at most when the process dies while it runs.
const MAX_ATTEMPTS: u32 = 3;

/// Returns the options of a server.
///
/// # Errors
/// Says which setting cannot be used.
pub fn server_options(config: &Config) -> Result<Options, String> {
    let planning = &config.planning;
    if planning.workers == 0 && config.store.store.is_none() {
        return Err("--workers 0 plans nothing where no other process can: give it a worker, or a database that \
                    workers share in --store"
            .to_owned());
    }
    Ok(Options {
        queue_capacity: config.queue_capacity.try_into().unwrap_or(u32::MAX),
        quota: Quota {
            queued: Some(config.max_queued_per_key.try_into().unwrap_or(u32::MAX)),
            mesh_bytes: Some(config.max_mesh_bytes_per_key),
        },
        retention: match config.retention {
            Period::For(time) => Some(time),
            Period::Forever => None,
        },
        // Clients that wait for news must never keep out those that submit work.
        followers: (config.max_connections / 4).max(1),
        webhooks: webhooks::Options::new(
            config.webhook_hosts.clone(),
            config.webhook_private_hosts.clone(),
            config.webhook_secret.as_ref(),
        )?,
        min_free_disk: config.min_free_disk,
        ..planning_options(config.store.location(), Role::Server, planning)
    })
}

/// Returns the options of a process that plans, without bounds on clients and without webhooks.
pub fn planning_options(store: Location, role: Role, planning: &Planning) -> Options {
    Options {
        store,
        role,
        planning: PlanningOptions {
            workers: planning.workers,
            threads_per_job: planning.job_threads(),
            max_attempts: MAX_ATTEMPTS,
            max_memory: planning.memory_limit(),
            drain: planning.drain,
        },
        queue_capacity: u32::MAX,
        quota: Quota::default(),
        retention: None,
        ingest: planning.ingest_limits(),
        followers: 1,
        min_free_disk: 0,
        webhooks: webhooks::Options::default(),
    }
}

/// Whether API keys are required on `address`.
///
/// # Errors
/// Refuses an address that other machines can reach unless the settings say whether keys are on.
pub fn requires_keys(config: &Config, address: SocketAddr) -> Result<bool, String> {
    match config.auth {
        Some(auth) => Ok(auth == Auth::Keys),
        None if address.ip().to_canonical().is_loopback() => Ok(false),
        None => Err(format!(
            "{} can be reached from other machines: say --auth keys and make a key with graspd keys create, or \
             --auth off if anyone who can connect may use it",
            config.listen
        )),
    }
}
