//! Findings about a database that many processes share.

use std::time::Duration;

use jiff::Timestamp;

use super::Finding;
use crate::store::postgres::Survey;

/// A longer round trip makes the store slow.
const SLOW: Duration = Duration::from_millis(20);
/// Clocks that differ by more confuse people who read logs; nothing else depends on them.
const SKEW_MICROSECONDS: i64 = 5_000_000;
/// Number of connections that a server and a few workers use.
const CONNECTIONS: i64 = 20;

/// Examines the database and its tables.
pub async fn findings(url: &str) -> Vec<Finding> {
    match Survey::of(url).await {
        Ok(survey) => vec![
            Finding::ok("database", format_args!("PostgreSQL {}", survey.version)),
            tables(&survey),
            connections(&survey),
            round_trip(&survey),
            clock(&survey),
        ],
        Err(fault) => vec![Finding::wrong(
            "database",
            fault,
            "correct --store, or start the database and allow this machine to connect",
        )],
    }
}

fn tables(survey: &Survey) -> Finding {
    let check = "tables";
    let known = survey.known;
    match survey.schema {
        None => Finding::ok(check, "none yet; the first start creates them"),
        Some(_) if survey.oldest > known => Finding::wrong(
            check,
            format_args!(
                "they work with version {} and later, and this program knows {known}",
                survey.oldest
            ),
            "use a later graspd",
        ),
        Some(found) if found > known => Finding::ok(
            check,
            format_args!("version {found}, of a later graspd; this one, {known}, works with it"),
        ),
        Some(found) if found < known => Finding::ok(
            check,
            format_args!("version {found}; the next start migrates them to {known}"),
        ),
        Some(found) => Finding::ok(check, format_args!("version {found}")),
    }
}

fn connections(survey: &Survey) -> Finding {
    let (check, open, most) = ("connections", survey.connections, survey.max_connections);
    let detail = format!("{open} of {most} are open");
    match most - open < CONNECTIONS {
        true => Finding::warning(check, detail, "raise max_connections of the database"),
        false => Finding::ok(check, detail),
    }
}

fn round_trip(survey: &Survey) -> Finding {
    let (check, time) = ("round trip", survey.round_trip);
    match time > SLOW {
        true => Finding::warning(
            check,
            format_args!("{time:.1?}"),
            "move the database closer: every job makes three round trips",
        ),
        false => Finding::ok(check, format_args!("{time:.1?}")),
    }
}

fn clock(survey: &Survey) -> Finding {
    let check = "clock of the database";
    let apart = survey.now - Timestamp::now().as_microsecond();
    let detail = format!("{:+.3} s from the clock here", apart as f64 / 1e6);
    match apart.abs() > SKEW_MICROSECONDS {
        true => Finding::warning(
            check,
            detail,
            "synchronise both clocks with NTP; leases use that of the database alone",
        ),
        false => Finding::ok(check, detail),
    }
}
