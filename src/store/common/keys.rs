//! API keys.

use async_trait::async_trait;
use jiff::Timestamp;

use super::Engine;
use super::rows::KeyRow;
use super::statement::Statement;
use crate::store::keys::{GeneratedKey, PresentedKey};
use crate::store::{Access, KeyRecord, Keys, NewKey, Owner, StoreError, timestamp};

/// The operations on keys that each engine implements itself, for the checks of requests.
#[async_trait]
pub trait AccessEngine: Engine {
    /// Returns the hash of the key with this id, if it is good now.
    async fn hash_of(&self, id: &str) -> Result<Option<Vec<u8>>, StoreError>;

    /// Whether any key is good now.
    async fn has_any_key(&self) -> Result<bool, StoreError>;
}

/// The operations on keys that each engine implements itself, for the operator.
#[async_trait]
pub trait KeyEngine: Engine {
    /// Writes down the hash of a key, and returns when.
    async fn insert_key(
        &self,
        id: &str,
        hash: &[u8],
        name: &str,
        expires_at: Option<i64>,
    ) -> Result<i64, StoreError>;

    /// Ends the jobs of an owner that wait, and marks those that run. Returns how many there were.
    async fn cancel_jobs_of(&self, owner: &str) -> Result<u64, StoreError>;

    /// Writes down that a key is worthless from now on. Returns how many there were.
    async fn revoke_key(&self, id: &str) -> Result<u64, StoreError>;
}

#[async_trait]
impl<E: AccessEngine> Access for E {
    async fn owner_of(&self, key: &str) -> Result<Option<Owner>, StoreError> {
        let Some(key) = PresentedKey::parse(key) else {
            return Ok(None);
        };
        let hash = self.hash_of(key.id).await?;
        let is_right = hash.is_some_and(|hash| key.is(&hash));
        Ok(is_right.then(|| Owner::of_key(key.id)))
    }

    async fn is_valid(&self, owner: &Owner) -> Result<bool, StoreError> {
        Ok(owner.is_anonymous() || self.hash_of(owner.as_str()).await?.is_some())
    }

    async fn has_keys(&self) -> Result<bool, StoreError> {
        self.has_any_key().await
    }
}

#[async_trait]
impl<E: KeyEngine> Keys for E {
    async fn create(
        &self,
        name: &str,
        expires_at: Option<Timestamp>,
    ) -> Result<NewKey, StoreError> {
        let key = GeneratedKey::draw()?;
        let expiry = expires_at.map(Timestamp::as_microsecond);
        let created_at = self.insert_key(&key.id, &key.hash(), name, expiry).await?;
        Ok(key.into_key(name, timestamp(created_at)?, expires_at))
    }

    async fn list(&self) -> Result<Vec<KeyRecord>, StoreError> {
        let statement = Statement::new(
            "SELECT id, name, created_at, expires_at, revoked_at FROM keys ORDER BY created_at, id",
        );
        let rows: Vec<KeyRow> = self.read(statement).await?;
        rows.into_iter().map(TryInto::try_into).collect()
    }

    async fn cancel_jobs(&self, id: &str) -> Result<u64, StoreError> {
        self.cancel_jobs_of(id).await
    }

    async fn revoke(&self, id: &str) -> Result<bool, StoreError> {
        Ok(self.revoke_key(id).await? > 0)
    }
}
