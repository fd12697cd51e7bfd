//! The measurements.

use std::collections::{BTreeMap, HashSet};
use std::future::Future;
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::{Duration, Instant};

use tokio::task::JoinSet;

use crate::api::{Api, json_of};
use crate::times::row;

/// Jobs whose end is awaited at the same time.
const ABREAST: usize = 16;
/// Jobs of the soak of which one has a mesh of its own.
const JOBS_PER_MESH: usize = 100;

/// End-to-end time of tiny jobs, one after the other, less the time that they were planned for.
pub async fn overhead(api: &Api, count: usize) {
    for wait in [false, true] {
        let mut times = Vec::new();
        for seed in 0..count {
            let begun = Instant::now();
            let job = api.accepted(&api.tiny(seed)).await;
            let view = api.ended(&job, wait).await;
            let took = begun.elapsed();
            let planned = view["result"]["elapsed_s"].as_f64();
            let planned = planned.unwrap_or_else(|| panic!("{view}"));
            times.push(took.saturating_sub(Duration::from_secs_f64(planned)));
        }
        let how = if wait { "?wait=" } else { "polling each 2 ms" };
        row(&format!("overhead of a job, {how}"), times, "one client");
    }
}

/// Calls while `count` jobs wait, and while they come.
pub async fn queue(api: &Api, count: usize) {
    // They keep the workers busy.
    for seed in 0..4 {
        api.accepted(&api.endless(seed)).await;
    }
    let request = api.tiny(1);
    let mut times = Vec::new();
    for _ in 0..count {
        times.push(timed(api.accepted(&request)).await.0);
    }
    row("submit", times, &format!("until {count} jobs wait"));
    let list = json_of(api.get("/jobs?limit=50").await).await;
    let newest = list["jobs"][0]["id"].as_str().expect("a job").to_owned();
    let one = format!("/jobs/{newest}");
    for (what, path) in [
        ("list of 50", "/jobs?limit=50"),
        ("list of 50 queued", "/jobs?state=queued&limit=50"),
        ("read", &one),
        ("health", "/healthz"),
        ("readiness", "/readyz"),
    ] {
        let mut times = Vec::new();
        for _ in 0..1000 {
            let (took, answer) = timed(api.get(path)).await;
            assert!(answer.status().is_success(), "{path}: {}", answer.status());
            times.push(took);
        }
        row(what, times, &format!("while {count} jobs wait"));
    }
}

/// Many clients that submit under few keys: each key must have one job.
pub async fn keys(api: &Api, clients: usize, submissions: usize, keys: usize) {
    let next = Arc::new(AtomicUsize::new(0));
    let mut all = JoinSet::new();
    for _ in 0..clients {
        let (api, next) = (api.clone(), Arc::clone(&next));
        all.spawn(async move {
            let mut times = Vec::new();
            let mut jobs = HashSet::new();
            let mut statuses = BTreeMap::new();
            loop {
                let number = next.fetch_add(1, Ordering::Relaxed);
                if number >= submissions {
                    return (times, jobs, statuses);
                }
                let key = number % keys;
                let text = format!("load-{key}");
                let request = api.tiny(key);
                let (took, answer) = timed(api.submit(&request, Some(&text))).await;
                let answer = answer.expect("an answer");
                times.push(took);
                *statuses.entry(answer.status().as_u16()).or_insert(0) += 1;
                if let Some(place) = answer.headers().get("location") {
                    jobs.insert(place.to_str().expect("a path").to_owned());
                }
            }
        });
    }
    let (mut times, mut jobs) = (Vec::new(), HashSet::new());
    let mut statuses: BTreeMap<u16, usize> = BTreeMap::new();
    while let Some(client) = all.join_next().await {
        let (more, theirs, answered) = client.expect("a client");
        times.extend(more);
        jobs.extend(theirs);
        for (status, count) in answered {
            *statuses.entry(status).or_default() += count;
        }
    }
    let note = format!("{keys} keys: {} jobs; answers {statuses:?}", jobs.len());
    row(&format!("submit, {clients} clients"), times, &note);
}

/// The time from the cancellation of a job to its end, at random moments of its life.
pub async fn cancels(api: &Api, count: usize) {
    let mut all = JoinSet::new();
    let mut times = Vec::new();
    for number in 0..count {
        if all.len() >= ABREAST
            && let Some(ended) = all.join_next().await
        {
            times.push(ended.expect("a client"));
        }
        let api = api.clone();
        // Spread over half a second, without a pattern that the server could fall in step with.
        let pause = Duration::from_millis((number * 7919 % 500) as u64);
        all.spawn(async move {
            let job = api.accepted(&api.endless(number)).await;
            tokio::time::sleep(pause).await;
            let begun = Instant::now();
            api.cancel(&job).await;
            let view = api.ended(&job, false).await;
            assert_eq!(view["state"], "cancelled", "{view}");
            begun.elapsed()
        });
    }
    while let Some(ended) = all.join_next().await {
        times.push(ended.expect("a client"));
    }
    row("cancel to end", times, &format!("{ABREAST} jobs at a time"));
}

/// Submits `rate` tiny jobs a second, for `seconds`, and uploads a mesh for every hundredth.
pub async fn soak(api: &Api, seconds: usize, rate: usize) {
    let mut ticks = tokio::time::interval(Duration::from_secs_f64(1.0 / rate.max(1) as f64));
    let mut under_way = JoinSet::new();
    let (mut times, mut refused) = (Vec::new(), 0);
    let mut tally = |outcome: (Duration, bool)| match outcome {
        (took, true) => times.push(took),
        (_, false) => refused += 1,
    };
    for seed in 0..seconds * rate {
        ticks.tick().await;
        if under_way.len() >= 256
            && let Some(ended) = under_way.join_next().await
        {
            tally(ended.expect("a client"));
        }
        while let Some(ended) = under_way.try_join_next() {
            tally(ended.expect("a client"));
        }
        let mut api = api.clone();
        under_way.spawn(async move {
            if seed % JOBS_PER_MESH == 0 {
                api = api.with_mesh((seed / JOBS_PER_MESH) as u32 + 1).await;
            }
            let request = api.tiny(seed);
            let (took, answer) = timed(api.submit(&request, None)).await;
            (took, answer.is_ok_and(|answer| answer.status() == 202))
        });
    }
    while let Some(ended) = under_way.join_next().await {
        tally(ended.expect("a client"));
    }
    row(
        "submit in the soak",
        times,
        &format!("{rate} a second, {refused} not accepted"),
    );
}

async fn timed<T>(work: impl Future<Output = T>) -> (Duration, T) {
    let begun = Instant::now();
    let outcome = work.await;
    (begun.elapsed(), outcome)
}
