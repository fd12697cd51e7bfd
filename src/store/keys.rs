//! API keys: created and revoked by the operator, checked with every request.

use std::io;

use async_trait::async_trait;
use jiff::Timestamp;
use sha2::{Digest, Sha256};
use subtle::ConstantTimeEq;

use super::{Owner, StoreError};

/// What every key begins with, so that people and secret scanners recognise one.
const PREFIX: &str = "graspd";

/// A key as the store has it: without the secret, of which only a hash is kept.
#[derive(Debug, Clone, serde::Serialize)]
pub struct KeyRecord {
    pub id: String,
    pub name: String,
    pub created_at: Timestamp,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub expires_at: Option<Timestamp>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub revoked_at: Option<Timestamp>,
}

/// A new key: `graspd_ID_SECRET`.
#[derive(Debug)]
pub struct NewKey {
    pub record: KeyRecord,
    /// The key itself, which is shown this one time.
    pub text: String,
}

/// The keys as requests are checked against them.
#[async_trait]
pub trait Access {
    /// Returns the owner that a key stands for; `None` when it is unknown, has expired or was revoked.
    async fn owner_of(&self, key: &str) -> Result<Option<Owner>, StoreError>;

    /// Returns whether the key of an owner is still good; always true of the anonymous owner.
    async fn is_valid(&self, owner: &Owner) -> Result<bool, StoreError>;

    /// Returns whether any key is good now.
    async fn has_keys(&self) -> Result<bool, StoreError>;
}

/// The keys as the operator manages them, whether a server runs or not.
#[async_trait]
pub trait Keys {
    /// Makes a key that is good until `expires_at`, at once for a server that runs.
    async fn create(&self, name: &str, expires_at: Option<Timestamp>)
    -> Result<NewKey, StoreError>;

    /// Returns all keys, oldest first.
    async fn list(&self) -> Result<Vec<KeyRecord>, StoreError>;

    /// Cancels the jobs of a key that wait, and marks those that run so that they end as cancelled. Returns how
    /// many there were.
    async fn cancel_jobs(&self, id: &str) -> Result<u64, StoreError>;

    /// Makes a key worthless, at once for a server that runs. Returns whether there is such a key. Everything that
    /// was sent with it stays until it expires.
    async fn revoke(&self, id: &str) -> Result<bool, StoreError>;
}

/// A key as its holder writes it.
pub(super) struct PresentedKey<'a> {
    pub id: &'a str,
    secret: &'a str,
}

impl<'a> PresentedKey<'a> {
    /// `None` for what is not written as a key.
    pub fn parse(key: &'a str) -> Option<Self> {
        let mut pieces = key.split('_');
        let (prefix, id, secret) = (pieces.next()?, pieces.next()?, pieces.next()?);
        (prefix == PREFIX && pieces.next().is_none()).then_some(Self { id, secret })
    }

    /// Returns whether `kept` is the hash of this key, in a time that does not depend on how much of it is right.
    pub fn is(&self, kept: &[u8]) -> bool {
        hash(self.secret).ct_eq(kept).into()
    }
}

/// A key that was just drawn, before its hash is kept.
pub(super) struct GeneratedKey {
    pub id: String,
    secret: String,
}

impl GeneratedKey {
    pub fn draw() -> Result<Self, StoreError> {
        let (id, secret) = (random::<6>()?, random::<32>()?);
        Ok(Self { id, secret })
    }

    pub fn hash(&self) -> [u8; 32] {
        hash(&self.secret)
    }

    /// The key, once its hash is kept.
    pub fn into_key(
        self,
        name: &str,
        created_at: Timestamp,
        expires_at: Option<Timestamp>,
    ) -> NewKey {
        let Self { id, secret } = self;
        NewKey {
            text: format!("{PREFIX}_{id}_{secret}"),
            record: KeyRecord {
                id,
                name: name.to_owned(),
                created_at,
                expires_at,
                revoked_at: None,
            },
        }
    }
}

fn hash(secret: &str) -> [u8; 32] {
    Sha256::digest(secret).into()
}

/// Returns so many random bytes in hexadecimal digits.
fn random<const BYTES: usize>() -> Result<String, StoreError> {
    let mut bytes = [0; BYTES];
    getrandom::fill(&mut bytes).map_err(|fault| StoreError::File(io::Error::other(fault)))?;
    Ok(bytes.iter().map(|byte| format!("{byte:02x}")).collect())
}
