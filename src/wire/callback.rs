//! The callback of a job: its URL, what became of it, and the message.

use jiff::Timestamp;
use serde::Serialize;
use utoipa::ToSchema;

use super::JobRecord;

/// Most bytes of a callback URL.
pub const MAX_URL_BYTES: usize = 2048;

/// What became of the callback of a job.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, ToSchema)]
pub struct CallbackRecord {
    /// Where the server posts the end of the job.
    #[schema(format = "uri")]
    pub url: String,
    pub state: CallbackState,
    /// How often it was tried.
    pub attempts: u32,
    /// Why the last attempt failed.
    #[schema(nullable = false)]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub last_error: Option<String>,
    #[schema(value_type = String, format = DateTime, nullable = false)]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub last_attempt_at: Option<Timestamp>,
    /// While pending, once the job has ended.
    #[schema(value_type = String, format = DateTime, nullable = false)]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub next_attempt_at: Option<Timestamp>,
}

/// Where a callback is: `pending → delivered | failed`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum CallbackState {
    /// The job has not ended, or the receiver has not taken the message yet.
    Pending,
    Delivered,
    /// Given up.
    Failed,
}

impl CallbackState {
    const ALL: [Self; 3] = [Self::Pending, Self::Delivered, Self::Failed];

    /// The name in JSON.
    pub fn name(self) -> &'static str {
        match self {
            Self::Pending => "pending",
            Self::Delivered => "delivered",
            Self::Failed => "failed",
        }
    }

    /// The state that has this name.
    pub fn named(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|state| state.name() == name)
    }
}

/// What is posted to a callback URL (Standard Webhooks) when the job has ended. The same job always
/// has the same message, under the same `webhook-id`.
#[derive(Debug, Serialize, ToSchema)]
pub struct WebhookEvent {
    /// `job.succeeded`, `job.failed` or `job.cancelled`.
    #[serde(rename = "type")]
    kind: String,
    /// When the job ended.
    #[schema(value_type = String, format = DateTime)]
    timestamp: Timestamp,
    data: WebhookData,
}

/// A job without its result, and where that is.
#[derive(Debug, Serialize, ToSchema)]
struct WebhookData {
    #[serde(flatten)]
    job: JobRecord,
    /// Path of the result on the server, if there is one.
    #[schema(nullable = false)]
    #[serde(skip_serializing_if = "Option::is_none")]
    result_url: Option<String>,
}

impl WebhookEvent {
    /// The message about a job that has ended.
    pub fn new(job: JobRecord, has_result: bool) -> Self {
        Self {
            kind: format!("job.{}", job.state.name()),
            timestamp: job.finished_at.unwrap_or(job.created_at),
            data: WebhookData {
                result_url: has_result.then(|| format!("/jobs/{}/result", job.id)),
                job: JobRecord {
                    mesh_report: None,
                    result: None,
                    ..job
                },
            },
        }
    }
}
