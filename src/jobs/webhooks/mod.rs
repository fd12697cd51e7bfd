//! Webhooks: a POST at the end of a job, to the URL that its client gave.
//!
//! A client can make the server send requests, which is an attack in itself (server-side request forgery). So the
//! operator lists the hosts that may be called; `hosts` has the list and the rules for URLs, `address` the rules for
//! what a name may resolve to, and `post` connects only to an address that was checked. `signature` proves to the
//! receiver who sent the message.
//!
//! The store has an outbox, filled in the statement that ends a job, so that no end is lost and none is announced that
//! did not happen. `sender` empties it: each message is delivered at least once, with growing pauses between the
//! attempts while the receiver does not accept it, and is given up after the last one.

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

/// Which receivers are called and how. By default none.
#[derive(Debug, Clone, Default)]
pub struct Options {
    /// The hosts that may be called; if there are none, webhooks are off.
    pub hosts: AllowedHosts,
    /// Hosts whose addresses need not be public.
    pub private_hosts: PrivateHosts,
    /// The secrets that sign messages.
    pub secrets: Secrets,
    /// Pauses between attempts; a delivery is given up after the last one.
    pub retries: Vec<Duration>,
}

impl Options {
    /// Refuses hosts without a secret, and secrets that cannot be used. Without hosts the rest is ignored.
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
             know who sends",
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
