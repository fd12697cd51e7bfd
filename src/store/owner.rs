//! Whose something is.

/// Who sent a mesh or a job: the id of an API key, or nobody where keys are off. What belongs to one owner
/// does not exist for another.
#[derive(Debug, Clone, PartialEq, Eq, Hash, Default)]
pub struct Owner(String);

impl Owner {
    /// Whoever sends without a key.
    pub const ANONYMOUS: Self = Self(String::new());

    /// The owner that a key stands for.
    pub fn of_key(id: &str) -> Self {
        Self(id.to_owned())
    }

    pub fn as_str(&self) -> &str {
        &self.0
    }

    /// Whether this is whoever sends without a key.
    pub fn is_anonymous(&self) -> bool {
        self.0.is_empty()
    }
}
