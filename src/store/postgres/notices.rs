//! Notices over LISTEN and NOTIFY.

use std::time::Duration;

use async_trait::async_trait;
use serde::{Deserialize, Serialize};
use sqlx::postgres::{PgListener, PgPoolOptions};
use tokio::time::timeout;

use super::Postgres;
use crate::store::{Audience, Listener, Notice, Notices, StoreError, damaged};

/// The channels that workers and servers listen to.
const TO_WORKERS: &str = "graspd_workers";
const TO_SERVERS: &str = "graspd_servers";
/// Most bytes that a message may have; the database takes a few more.
const MAX_BYTES: usize = 7_800;
/// The silence after which a connection is checked, and how long this may take.
const SILENCE: Duration = Duration::from_secs(5);
const PATIENCE: Duration = Duration::from_secs(3);

/// A message, as it is sent.
#[derive(Serialize, Deserialize)]
struct Message {
    /// The process that sends it.
    from: u32,
    /// Notices that this program does not know are skipped.
    notices: Vec<serde_json::Value>,
}

#[async_trait]
impl Notices for Postgres {
    async fn notify(&self, notices: &[Notice]) -> Result<(), StoreError> {
        let (mut channels, mut messages) = (Vec::new(), Vec::new());
        for channel in [TO_WORKERS, TO_SERVERS] {
            let addressed = notices
                .iter()
                .filter(|notice| channel_of(notice) == channel);
            for message in self.messages(addressed)? {
                channels.push(channel);
                messages.push(message);
            }
        }
        if messages.is_empty() {
            return Ok(());
        }
        // Without a wait for the disk: what a crash loses has been received, or is found in the store.
        let statement = sqlx::query(
            "SELECT pg_notify(channel, message), set_config('synchronous_commit', 'off', true) \
             FROM unnest($1::text[], $2::text[]) AS sent (channel, message)",
        );
        let statement = statement.bind(channels).bind(messages);
        self.urgent.run(statement).await?;
        Ok(())
    }

    async fn listen(&self, audience: Audience) -> Result<Option<Box<dyn Listener>>, StoreError> {
        let pool = PgPoolOptions::new()
            .max_connections(1)
            .acquire_timeout(PATIENCE)
            .connect_lazy_with(self.options.clone());
        let mut listener = PgListener::connect_with(&pool).await?;
        listener.eager_reconnect(false);
        let channels = [
            (audience.workers, TO_WORKERS),
            (audience.servers, TO_SERVERS),
        ];
        let channels = channels
            .into_iter()
            .filter_map(|(wanted, name)| wanted.then_some(name));
        match timeout(PATIENCE, listener.listen_all(channels)).await {
            Ok(listening) => listening?,
            Err(slow) => return Err(std::io::Error::from(slow).into()),
        }
        Ok(Some(Box::new(NotifyListener {
            listener,
            own: self.sender,
        })))
    }
}

impl Postgres {
    /// Returns notices as messages that are not too long.
    fn messages<'n>(
        &self,
        notices: impl Iterator<Item = &'n Notice>,
    ) -> Result<Vec<String>, StoreError> {
        let mut messages = Vec::new();
        let mut gathered = Vec::new();
        let mut bytes = 0;
        let close = |gathered: &mut Vec<serde_json::Value>| {
            let notices = std::mem::take(gathered);
            let from = self.sender;
            serde_json::to_string(&Message { from, notices }).map_err(damaged)
        };
        for notice in notices.flat_map(split) {
            let value = serde_json::to_value(&notice).map_err(damaged)?;
            let length = value.to_string().len() + 1;
            if length + 64 > MAX_BYTES {
                continue;
            }
            if bytes + length + 64 > MAX_BYTES {
                messages.push(close(&mut gathered)?);
                bytes = 0;
            }
            gathered.push(value);
            bytes += length;
        }
        if !gathered.is_empty() {
            messages.push(close(&mut gathered)?);
        }
        Ok(messages)
    }
}

/// Splits a notice into several that each fit into a message.
fn split(notice: &Notice) -> Vec<Notice> {
    /// So many ids certainly fit.
    const IDS: usize = 150;
    let pieces = |jobs: &[_], make: fn(Vec<_>) -> Notice| {
        jobs.chunks(IDS).map(|piece| make(piece.to_vec())).collect()
    };
    match notice {
        Notice::Stopped(jobs) => pieces(jobs, Notice::Stopped),
        Notice::Followed(jobs) => pieces(jobs, Notice::Followed),
        Notice::Changed(jobs) => pieces(jobs, Notice::Changed),
        Notice::Progress {
            job,
            revision,
            progress,
        } => {
            let mut progress = progress.clone();
            // Some 200 bytes each: where they do not fit, the rest is still worth sending.
            if progress
                .best_contacts
                .as_ref()
                .is_some_and(|contacts| contacts.len() > 32)
            {
                progress.best_contacts = None;
            }
            vec![Notice::Progress {
                job: *job,
                revision: *revision,
                progress,
            }]
        }
        Notice::Queued => vec![Notice::Queued],
    }
}

fn channel_of(notice: &Notice) -> &'static str {
    match notice {
        Notice::Queued | Notice::Stopped(_) | Notice::Followed(_) => TO_WORKERS,
        Notice::Changed(_) | Notice::Progress { .. } => TO_SERVERS,
    }
}

/// A connection that receives notices.
struct NotifyListener {
    listener: PgListener,
    /// The sender of the notices of this process.
    own: u32,
}

#[async_trait]
impl Listener for NotifyListener {
    async fn receive(&mut self) -> Result<Vec<Notice>, StoreError> {
        loop {
            let notification = match timeout(SILENCE, self.listener.try_recv()).await {
                Ok(Ok(Some(notification))) => notification,
                Ok(Ok(None)) => return Err(broken()),
                Ok(Err(error)) => return Err(error.into()),
                // Nothing was sent, or the connection is dead.
                Err(_) => {
                    let ping = sqlx::query("SELECT 1").execute(&mut self.listener);
                    match timeout(PATIENCE, ping).await {
                        Ok(answer) => {
                            answer?;
                        }
                        Err(_) => return Err(broken()),
                    }
                    continue;
                }
            };
            let Ok(message) = serde_json::from_str::<Message>(notification.payload()) else {
                continue;
            };
            if message.from != self.own {
                let known = message.notices.into_iter();
                return Ok(known
                    .filter_map(|notice| serde_json::from_value(notice).ok())
                    .collect());
            }
        }
    }
}

fn broken() -> StoreError {
    std::io::Error::from(std::io::ErrorKind::ConnectionReset).into()
}
