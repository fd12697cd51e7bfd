//! API keys: created and revoked by the operator, checked with every request.

use std::io;

use async_trait::async_trait;
use jiff::Timestamp;
use sha2::{Digest, Sha256};
use subtle::ConstantTimeEq;

use super::{Owner, StoreError};

/// How every key begins, so that people and scanners of secrets recognise one.
const PREFIX: &str = "graspd";

/// What is known of a key; not the key itself, of which only a hash is kept.
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
    /// The one time that it is seen.
    pub text: String,
}

/// Who may come in.
#[async_trait]
pub trait Access {
    /// The owner that a key stands for; `None` when it is not one, has expired or was revoked.
    async fn owner_of(&self, key: &str) -> Result<Option<Owner>, StoreError>;

    /// Whether the key that an owner stands for is still good; always for whoever sends without one.
    async fn is_good(&self, owner: &Owner) -> Result<bool, StoreError>;

    /// Whether there is any key that is good now.
    async fn has_keys(&self) -> Result<bool, StoreError>;
}

/// The API keys of a store, as its operator manages them, beside servers that use it or not.
#[async_trait]
pub trait Keys {
    /// Makes a key that is good until `expires_at`, at once for a server that runs.
    async fn create(&self, name: &str, expires_at: Option<Timestamp>)
    -> Result<NewKey, StoreError>;

    /// All keys, oldest first.
    async fn list(&self) -> Result<Vec<KeyRecord>, StoreError>;

    /// Cancels the jobs of a key that wait, and marks those that run so that they end as cancelled. Returns how
    /// many there were.
    async fn cancel_jobs(&self, id: &str) -> Result<u64, StoreError>;

    /// Makes a key worthless, at once for a server that runs. Says whether there is such a key. What was
    /// sent with it stays until it expires.
    async fn revoke(&self, id: &str) -> Result<bool, StoreError>;
}

/// A key as its holder writes it.
pub(super) struct Presented<'a> {
    pub id: &'a str,
    secret: &'a str,
}

impl<'a> Presented<'a> {
    /// `None` for what is not written as a key.
    pub fn parse(key: &'a str) -> Option<Self> {
        let mut pieces = key.split('_');
        let (prefix, id, secret) = (pieces.next()?, pieces.next()?, pieces.next()?);
        (prefix == PREFIX && pieces.next().is_none()).then_some(Self { id, secret })
    }

    /// Whether this is the key of which `kept` is the hash; takes the same time however much of it is right.
    pub fn is(&self, kept: &[u8]) -> bool {
        hash(self.secret).ct_eq(kept).into()
    }
}

/// The parts of a key that nobody has yet.
pub(super) struct Fresh {
    pub id: String,
    secret: String,
}

impl Fresh {
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

/// So many random bytes in hexadecimal digits.
fn random<const BYTES: usize>() -> Result<String, StoreError> {
    let mut bytes = [0; BYTES];
    getrandom::fill(&mut bytes).map_err(|fault| StoreError::File(io::Error::other(fault)))?;
    Ok(bytes.iter().map(|byte| format!("{byte:02x}")).collect())
}
