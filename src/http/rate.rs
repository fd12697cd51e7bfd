//! How often someone may do something.

use std::num::NonZeroU32;
use std::sync::atomic::{AtomicU32, Ordering};

use axum::http::{HeaderName, HeaderValue};
use governor::clock::{Clock, DefaultClock};
use governor::middleware::StateInformationMiddleware;
use governor::state::keyed::DashMapStateStore;
use governor::{Quota, RateLimiter};

use super::access::Client;

/// How a client stands.
pub const RATE_LIMIT: HeaderName = HeaderName::from_static("ratelimit");
const RATE_LIMIT_POLICY: HeaderName = HeaderName::from_static("ratelimit-policy");

/// After so many takings those who have been quiet for long are forgotten.
const TIDY_EVERY: u32 = 4096;

/// So many times a minute for each client, all at once or one after the other (GCRA).
pub struct Rate {
    name: &'static str,
    per_minute: NonZeroU32,
    limiter:
        RateLimiter<Client, DashMapStateStore<Client>, DefaultClock, StateInformationMiddleware>,
    takings: AtomicU32,
}

/// How a client stands with a rate or a quota, as headers tell it (RateLimit header draft).
#[derive(Debug, Clone, Copy)]
pub struct Standing {
    pub name: &'static str,
    pub limit: u64,
    pub left: u64,
    /// Length of the window, for a rate, in seconds.
    pub window_s: Option<u64>,
    /// Until more is left, in seconds.
    pub reset_s: u64,
}

impl Rate {
    /// `name` tells this rate from others.
    pub fn new(name: &'static str, per_minute: NonZeroU32) -> Self {
        Self {
            name,
            per_minute,
            limiter: RateLimiter::dashmap(Quota::per_minute(per_minute)).with_middleware(),
            takings: AtomicU32::new(0),
        }
    }

    /// Counts one more; `Err` when that is one too many.
    pub fn take(&self, client: &Client) -> Result<Standing, Standing> {
        if self.takings.fetch_add(1, Ordering::Relaxed) % TIDY_EVERY == TIDY_EVERY - 1 {
            self.limiter.retain_recent();
        }
        let limit = u64::from(self.per_minute.get());
        let standing = |left: u64, reset_s: u64| Standing {
            name: self.name,
            limit,
            left,
            window_s: Some(60),
            reset_s,
        };
        match self.limiter.check_key(client) {
            Ok(state) => {
                let left = u64::from(state.remaining_burst_capacity());
                Ok(standing(
                    left,
                    ((limit - left.min(limit)) * 60).div_ceil(limit),
                ))
            }
            Err(until) => {
                let wait = until.wait_time_from(DefaultClock::default().now());
                Err(standing(0, wait.as_secs_f64().ceil().max(1.0) as u64))
            }
        }
    }
}

impl Standing {
    /// It in the headers of an answer.
    pub fn headers(&self) -> impl Iterator<Item = (HeaderName, HeaderValue)> + use<> {
        let Self {
            name,
            limit,
            left,
            window_s,
            reset_s,
        } = self;
        let window = window_s.map_or(String::new(), |window| format!(";w={window}"));
        let lines = [
            (RATE_LIMIT_POLICY, format!("\"{name}\";q={limit}{window}")),
            (RATE_LIMIT, format!("\"{name}\";r={left};t={reset_s}")),
        ];
        lines
            .into_iter()
            .filter_map(|(header, line)| Some((header, HeaderValue::try_from(line).ok()?)))
    }
}
