//! Findings about the machine: clock, address, processors, memory, files.

use std::io;
use std::time::{Duration, Instant};

use jiff::Timestamp;
use jiff::tz::TimeZone;
use tokio::io::{AsyncReadExt, AsyncWriteExt};
use tokio::net::{TcpListener, TcpStream};

use super::Finding;
use crate::config::Config;
use crate::host;
use crate::http::files_needed;

/// How long to wait for the answer of a server.
const PATIENCE: Duration = Duration::from_secs(3);
/// Most bytes of its answer that are read.
const MAX_ANSWER: u64 = 64 * 1024;
/// For how long the wall clock and the steady clock are compared, and how far they may drift apart in that time.
const COMPARED: Duration = Duration::from_millis(200);
const DRIFT: Duration = Duration::from_millis(50);
/// Years in which this program is plausibly running.
const YEARS: std::ops::Range<i16> = 2025..2100;

/// Runs all checks of the machine.
pub async fn findings(config: &Config) -> Vec<Finding> {
    vec![
        clock().await,
        address(&config.listen).await,
        processors(config),
        memory(config),
        files(config.max_connections),
    ]
}

async fn clock() -> Finding {
    let (wall, steady) = (Timestamp::now(), Instant::now());
    tokio::time::sleep(COMPARED).await;
    let wall = Timestamp::now().duration_since(wall);
    let steady = steady.elapsed();
    let now = Timestamp::now();
    let apart = (wall.as_secs_f64() - steady.as_secs_f64()).abs();
    let advice = "set the clock, and synchronise it with NTP";
    if !YEARS.contains(&now.to_zoned(TimeZone::UTC).year()) {
        Finding::wrong("clock", now, advice)
    } else if apart > DRIFT.as_secs_f64() {
        Finding::wrong(
            "clock",
            format_args!("it jumps: {apart:.3} s in {COMPARED:?}"),
            advice,
        )
    } else {
        Finding::ok("clock", now)
    }
}

async fn address(listen: &str) -> Finding {
    let check = "address";
    let fault = match TcpListener::bind(listen).await {
        Ok(_) => return Finding::ok(check, format_args!("{listen} is free")),
        Err(fault) => fault,
    };
    if fault.kind() != io::ErrorKind::AddrInUse {
        return Finding::wrong(
            check,
            format_args!("{listen}: {fault}"),
            "give --listen an address of this machine and a port that the user may bind",
        );
    }
    let answer = tokio::time::timeout(PATIENCE, ask(listen)).await;
    match answer {
        Ok(Ok(answer)) if answer.is_from_graspd() && answer.status == 200 => Finding::ok(
            check,
            format_args!("a graspd answers at {listen} and is ready"),
        ),
        Ok(Ok(answer)) if answer.is_from_graspd() => Finding::wrong(
            check,
            format_args!("the graspd at {listen} is not ready: {}", answer.detail()),
            "follow its advice; its log has details",
        ),
        _ => Finding::wrong(
            check,
            format_args!("{listen} is in use by another program, or by a graspd that hangs"),
            "stop it, or give --listen another port",
        ),
    }
}

struct Answer {
    status: u16,
    body: serde_json::Value,
}

impl Answer {
    /// Recognises graspd by its health status or its problem types, which no other program sends.
    fn is_from_graspd(&self) -> bool {
        let is_healthy = self.body["status"] == "ok";
        let kind = self.body["type"].as_str().unwrap_or_default();
        is_healthy || kind.starts_with("/problems/")
    }

    fn detail(&self) -> &str {
        self.body["detail"].as_str().unwrap_or("no reason given")
    }
}

async fn ask(listen: &str) -> io::Result<Answer> {
    let mut stream = TcpStream::connect(listen).await?;
    let request = "GET /readyz HTTP/1.0\r\nHost: localhost\r\nConnection: close\r\n\r\n";
    stream.write_all(request.as_bytes()).await?;
    let mut answer = String::new();
    stream.take(MAX_ANSWER).read_to_string(&mut answer).await?;
    let (head, body) = answer.split_once("\r\n\r\n").unwrap_or_default();
    let status = head
        .split(' ')
        .nth(1)
        .and_then(|status| status.parse().ok());
    Ok(Answer {
        status: status.unwrap_or_default(),
        body: serde_json::from_str(body).unwrap_or_default(),
    })
}

fn processors(config: &Config) -> Finding {
    let processors = std::thread::available_parallelism().map_or(1, |count| count.get());
    let (workers, threads) = (config.planning.workers, config.planning.job_threads());
    let detail = format!("{processors}; {workers} workers with {threads} threads each");
    match workers.saturating_mul(threads) > processors {
        true => Finding::warning(
            "processors",
            detail,
            "lower --workers or --threads-per-job: more threads than processors slow each other down",
        ),
        false => Finding::ok("processors", detail),
    }
}

fn memory(config: &Config) -> Finding {
    let check = "memory";
    let known = host::memory_available().zip(host::memory_total());
    let Some(((available, total), limit)) = known.zip(config.planning.memory_limit()) else {
        return Finding::ok(check, "this system does not report its memory");
    };
    let mesh = config.planning.max_mesh_memory;
    let detail = format!(
        "{} of {} MiB available; the server may take {} MiB, one mesh {} MiB while it is read",
        available >> 20,
        total >> 20,
        limit >> 20,
        mesh >> 20
    );
    if limit > total {
        let advice =
            "lower --max-memory: the system would kill the server before it stops a run itself";
        Finding::warning(check, detail, advice)
    } else if mesh > limit {
        let advice = "lower --max-mesh-memory or raise --max-memory: one mesh may stop other runs";
        Finding::warning(check, detail, advice)
    } else if mesh > available {
        let advice = "lower --max-mesh-memory, or the system may kill the server";
        Finding::warning(check, detail, advice)
    } else {
        Finding::ok(check, detail)
    }
}

fn files(max_connections: usize) -> Finding {
    let check = "open files";
    let needed = files_needed(max_connections);
    match host::open_file_limit() {
        Some(limit) if limit < needed => Finding::warning(
            check,
            format_args!("{limit} of {needed} needed for --max-connections"),
            "raise the limit before the server starts, or lower --max-connections",
        ),
        Some(limit) => Finding::ok(check, limit),
        None => Finding::ok(check, "no limit"),
    }
}
