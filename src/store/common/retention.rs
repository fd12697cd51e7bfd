//! Deletion of expired data: the parts of a sweep that both engines do alike.

use super::statement::Statement;
use super::{Engine, one};
use crate::store::retention::BATCH;
use crate::store::{Owner, StoreError};

/// Whether a job or a batch of this id was here and has expired.
pub async fn has_expired(
    engine: &impl Engine,
    owner: &Owner,
    id: String,
) -> Result<bool, StoreError> {
    let statement =
        Statement::new("SELECT EXISTS (SELECT 1 FROM expired WHERE id = $1 AND owner = $2)");
    let (expired,): (bool,) = one(engine, statement.bind(id).bind(owner.as_str())).await?;
    Ok(expired)
}

/// Repeats a deletion of [`BATCH`] rows at most, which returns how many there were, until it finds fewer. Returns
/// their sum.
pub async fn repeat<F>(delete: impl Fn() -> F) -> Result<u64, StoreError>
where
    F: Future<Output = Result<u64, StoreError>>,
{
    let mut removed = 0;
    loop {
        let rows = delete().await?;
        removed += rows;
        if rows < u64::from(BATCH) {
            return Ok(removed);
        }
    }
}
