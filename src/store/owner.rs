//! The owners of meshes, jobs and batches.

/// The sender of a mesh or a job: the id of an API key, or the anonymous owner where keys are off. The things of one
/// owner do not exist for another.
#[derive(Debug, Clone, PartialEq, Eq, Hash, Default)]
pub struct Owner(String);

impl Owner {
    /// The owner of everything that is sent without a key.
    pub const ANONYMOUS: Self = Self(String::new());

    /// The owner that a key stands for.
    pub fn of_key(id: &str) -> Self {
        Self(id.to_owned())
    }

    pub fn as_str(&self) -> &str {
        &self.0
    }

    /// Returns whether this is the owner of what is sent without a key.
    pub fn is_anonymous(&self) -> bool {
        self.0.is_empty()
    }
}
