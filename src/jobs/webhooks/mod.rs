//! Webhooks: the end of a job, told to the URL that its sender gave.
//!
//! A client can make the server send requests, so the operator says where to: `hosts` has the
//! list and the rules for URLs, `address` those for what names resolve to, `post` sends one
//! message, `signature` lets the receiver know where it comes from. `sender` delivers what the
//! outbox of the store holds: at least once, with growing pauses while a receiver does not take it.

mod address;
mod hosts;
mod post;
mod sender;
mod signature;
#[cfg(test)]
mod tests;

use std::time::Duration;

pub use hosts::{AllowedHosts, PrivateHosts};
pub use sender::Sender;
pub use signature::{SecretText, Secrets};

/// Pauses before the second attempt, the third, and so on: 46 hours in all.
const RETRIES_S: [u64; 9] = [
    5,
    30,
    2 * 60,
    10 * 60,
    3600,
    3 * 3600,
    6 * 3600,
    12 * 3600,
    24 * 3600,
];

/// Where webhooks may go and how. By default nowhere.
#[derive(Debug, Clone, Default)]
pub struct Options {
    /// Where callbacks may go; if nowhere, webhooks are off.
    pub hosts: AllowedHosts,
    /// Hosts whose addresses need not be public.
    pub private_hosts: PrivateHosts,
    /// What messages are signed with.
    pub secrets: Secrets,
    /// Pauses between attempts; a delivery is given up when there is none left.
    pub retries: Vec<Duration>,
}

impl Options {
    /// Refuses hosts without a secret, and secrets that cannot be used. Without hosts nothing else
    /// matters.
    pub fn new(
        hosts: AllowedHosts,
        private_hosts: PrivateHosts,
        secret: Option<&SecretText>,
    ) -> Result<Self, String> {
        if hosts.is_empty() {
            return Ok(Self::default());
        }
        let secret = secret.ok_or(
            "--webhook-hosts needs --webhook-secret or GRASPD_WEBHOOK_SECRET, so that receivers \
             can tell who sends",
        )?;
        let secrets = Secrets::parse(secret).map_err(|why| format!("--webhook-secret: {why}"))?;
        Ok(Self {
            hosts,
            private_hosts,
            secrets,
            retries: RETRIES_S.map(Duration::from_secs).to_vec(),
        })
    }
}
