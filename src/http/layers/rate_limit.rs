//! Rate limits: how many times a minute each client may do something.

use std::num::NonZeroU32;
use std::sync::atomic::{AtomicU32, Ordering};

use axum::http::{HeaderName, HeaderValue};
use governor::clock::{Clock, DefaultClock};
use governor::middleware::StateInformationMiddleware;
use governor::state::keyed::DashMapStateStore;
use governor::{Quota, RateLimiter};

use super::client::Client;

/// The header that says how much of a limit is left (RateLimit header draft).
pub const RATE_LIMIT: HeaderName = HeaderName::from_static("ratelimit");
const RATE_LIMIT_POLICY: HeaderName = HeaderName::from_static("ratelimit-policy");

/// After this many counts, clients whose limit is whole again are forgotten.
const FORGET_EVERY: u32 = 4096;

/// A number of times a minute for each client, in one burst or spread out (GCRA).
pub struct RateLimit {
    name: &'static str,
    per_minute: NonZeroU32,
    limiter:
        RateLimiter<Client, DashMapStateStore<Client>, DefaultClock, StateInformationMiddleware>,
    counts: AtomicU32,
}

/// How much of a rate limit or a quota a client has left, as the RateLimit headers say it.
#[derive(Debug, Clone, Copy)]
pub struct RateLimitState {
    /// The name of the limit, and the type of the problem when it is used up.
    pub name: &'static str,
    pub limit: u64,
    pub left: u64,
    /// The length of the window in seconds; a quota has none.
    pub window_s: Option<u64>,
    /// Seconds until more is left.
    pub reset_s: u64,
}

impl RateLimit {
    /// `name` distinguishes this limit from others in the headers.
    pub fn new(name: &'static str, per_minute: NonZeroU32) -> Self {
        Self {
            name,
            per_minute,
            limiter: RateLimiter::dashmap(Quota::per_minute(per_minute)).with_middleware(),
            counts: AtomicU32::new(0),
        }
    }

    /// Counts one more time; `Err` when that is one too many.
    pub fn count(&self, client: &Client) -> Result<RateLimitState, RateLimitState> {
        if self.counts.fetch_add(1, Ordering::Relaxed) % FORGET_EVERY == FORGET_EVERY - 1 {
            self.limiter.retain_recent();
        }
        let limit = u64::from(self.per_minute.get());
        let state = |left: u64, reset_s: u64| RateLimitState {
            name: self.name,
            limit,
            left,
            window_s: Some(60),
            reset_s,
        };
        match self.limiter.check_key(client) {
            Ok(after) => {
                let left = u64::from(after.remaining_burst_capacity());
                let used = limit - left.min(limit);
                Ok(state(left, (used * 60).div_ceil(limit)))
            }
            Err(until) => {
                let wait = until.wait_time_from(DefaultClock::default().now());
                Err(state(0, wait.as_secs_f64().ceil().max(1.0) as u64))
            }
        }
    }
}

impl RateLimitState {
    /// The RateLimit headers of a response.
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
