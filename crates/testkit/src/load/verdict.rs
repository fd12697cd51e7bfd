//! Checks of every job after the clients have stopped.

use std::collections::{BTreeMap, HashMap, HashSet};
use std::time::{Duration, Instant};

use reqwest::Method;
use serde_json::Value;

use super::client::Body;
use super::ledger::{Job, lives};
use super::oracle::timeless;
use super::{Load, expect};

/// Longest time to wait for the last jobs.
const LAST_JOBS: Duration = Duration::from_secs(120);

/// Checks, against the running server, that every job is as it must be; `max_attempt` is the last
/// attempt that a job may have needed. Answers what became of them, in words.
pub async fn check_jobs(load: &Load, max_attempt: u64) -> String {
    let jobs: Vec<(String, Job)> = load.ledger.jobs().clone().into_iter().collect();
    let end = Instant::now() + LAST_JOBS;
    let mut ends: BTreeMap<String, usize> = BTreeMap::new();
    for (id, job) in &jobs {
        match check_job(load, id, job, max_attempt, end).await {
            Ok(ended) => *ends.entry(ended).or_default() += 1,
            Err(fault) => load.ledger.fault(format!("job {id}: {fault}")),
        }
    }
    if let Err(fault) = check_keys(load, &jobs).await {
        load.ledger.fault(fault);
    }
    let faults = load.ledger.faults();
    assert!(faults.is_empty(), "{} faults: {faults:#?}", faults.len());
    // Else all of it would hold for a server that does nothing.
    let succeeded = ends.iter().filter(|(end, _)| end.starts_with("succeeded"));
    let succeeded: usize = succeeded.map(|(_, count)| count).sum();
    assert!(2 * succeeded > jobs.len(), "few jobs succeed: {ends:?}");
    format!("{} jobs {ends:?}", jobs.len())
}

async fn check_job(
    load: &Load,
    id: &str,
    job: &Job,
    max_attempt: u64,
    end: Instant,
) -> Result<String, String> {
    let path = format!("/jobs/{id}");
    let view = loop {
        let had_ended = load.ledger.has_ended(id);
        let answer = load.caller.call(Method::GET, &path, &Body::Nothing).await?;
        if job.delete_asked && answer.status == 404 {
            return Ok("deleted".to_owned());
        }
        if job.deleted {
            return Err(format!("deleted, and yet {}", answer.body));
        }
        expect(&answer, &[200])?;
        load.ledger.saw(id, had_ended, &answer.body);
        if !lives(&answer.body) {
            break answer.body;
        }
        if Instant::now() > end {
            return Err(format!("never ends: {}", answer.body));
        }
        tokio::time::sleep(Duration::from_millis(50)).await;
    };
    if view["label"] != job.key.as_str() {
        return Err(format!("another label than {}: {view}", job.key));
    }
    let attempt = view["attempt"].as_u64().unwrap_or(u64::MAX);
    if attempt > max_attempt {
        return Err(format!("attempt {attempt} of {max_attempt}: {view}"));
    }
    let order = &load.orders[job.order];
    let state = view["state"].as_str().unwrap_or_default();
    let is_right = match state {
        "succeeded" => timeless(view["result"].clone()) == order.result,
        "cancelled" => job.cancel_asked,
        "failed" => attempt == 3 && view["problem"]["type"] == "/problems/interrupted",
        _ => false,
    };
    match is_right {
        true => Ok(format!("{state} at attempt {attempt}")),
        false => Err(format!("must not end so: {view}; calm: {}", order.result)),
    }
}

/// Every job that the server has was submitted by a client, and each key once.
async fn check_keys(load: &Load, known: &[(String, Job)]) -> Result<(), String> {
    let by_id: HashMap<&str, &Job> = known.iter().map(|(id, job)| (id.as_str(), job)).collect();
    let mut keys: HashMap<String, usize> = HashMap::new();
    let mut cursor = String::new();
    let mut listed = HashSet::new();
    loop {
        let path = format!("/jobs?limit=500{cursor}");
        let page = load.caller.call(Method::GET, &path, &Body::Nothing).await?;
        expect(&page, &[200])?;
        for job in page.body["jobs"].as_array().into_iter().flatten() {
            let id = job["id"].as_str().unwrap_or_default().to_owned();
            *keys.entry(job["label"].to_string()).or_default() += 1;
            if !by_id.contains_key(id.as_str()) {
                return Err(format!("a second job under one key: {job}"));
            }
            if !listed.insert(id) {
                return Err(format!("listed twice: {job}"));
            }
        }
        match &page.body["next_cursor"] {
            Value::String(next) => cursor = format!("&cursor={next}"),
            _ => break,
        }
    }
    if let Some(lost) = known
        .iter()
        .find(|(id, job)| !job.delete_asked && !listed.contains(id))
    {
        return Err(format!("a job is not listed: {lost:?}"));
    }
    match keys.iter().find(|(_, count)| **count > 1) {
        Some((key, count)) => Err(format!("{count} jobs under the key {key}")),
        None => Ok(()),
    }
}
