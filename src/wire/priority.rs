//! Which jobs go first.

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

/// The class of a job in the queue. `interactive` jobs go first, but while both wait every fourth turn is a
/// `batch` job's, so that neither class waits for ever.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum Priority {
    /// Someone waits for it.
    #[default]
    Interactive,
    /// One of many that nobody waits for.
    Batch,
}

impl Priority {
    pub const ALL: [Self; 2] = [Self::Interactive, Self::Batch];

    /// The name in JSON.
    pub fn name(self) -> &'static str {
        match self {
            Self::Interactive => "interactive",
            Self::Batch => "batch",
        }
    }

    /// The class of that name.
    pub fn named(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|class| class.name() == name)
    }

    /// The class that is not this one.
    pub fn other(self) -> Self {
        match self {
            Self::Interactive => Self::Batch,
            Self::Batch => Self::Interactive,
        }
    }
}
