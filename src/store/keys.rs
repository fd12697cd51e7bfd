//! API keys: created and revoked by the operator, checked with every request.

use std::io;

use jiff::Timestamp;
use sha2::{Digest, Sha256};
use sqlx::Row;
use sqlx::sqlite::{SqlitePool, SqliteRow};
use subtle::ConstantTimeEq;

use super::jobs::cancel;
use super::{Owner, Store, StoreError, damaged, now, timestamp};

/// How every key begins, so that people and scanners of secrets recognise one.
const PREFIX: &str = "graspd";

/// Whether a key is good at ?1.
macro_rules! good {
    () => {
        "revoked_at IS NULL AND (expires_at IS NULL OR expires_at > ?1)"
    };
}

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

/// The API keys of a data directory, which a server may be using at the same time.
#[derive(Debug, Clone)]
pub struct Keys {
    pool: SqlitePool,
}

impl Keys {
    pub(super) fn new(pool: SqlitePool) -> Self {
        Self { pool }
    }

    /// Makes a key that is good until `expires_at`, at once for a server that runs.
    pub async fn create(
        &self,
        name: &str,
        expires_at: Option<Timestamp>,
    ) -> Result<NewKey, StoreError> {
        let (id, secret) = (random::<6>()?, random::<32>()?);
        let created_at = now();
        sqlx::query(
            "INSERT INTO keys (id, name, hash, created_at, expires_at) VALUES (?1, ?2, ?3, ?4, ?5)",
        )
        .bind(&id)
        .bind(name)
        .bind(&hash(&secret)[..])
        .bind(created_at)
        .bind(expires_at.map(Timestamp::as_microsecond))
        .execute(&self.pool)
        .await?;
        Ok(NewKey {
            text: format!("{PREFIX}_{id}_{secret}"),
            record: KeyRecord {
                id,
                name: name.to_owned(),
                created_at: timestamp(created_at)?,
                expires_at,
                revoked_at: None,
            },
        })
    }

    /// All keys, oldest first.
    pub async fn list(&self) -> Result<Vec<KeyRecord>, StoreError> {
        let rows = sqlx::query(
            "SELECT id, name, created_at, expires_at, revoked_at FROM keys ORDER BY created_at, id",
        );
        let rows = rows.fetch_all(&self.pool).await?;
        rows.iter().map(record).collect()
    }

    /// Cancels the jobs of a key that wait, and marks those that run so that they end as cancelled. Returns how
    /// many there were.
    pub async fn cancel_jobs(&self, id: &str) -> Result<u64, StoreError> {
        let done = sqlx::query(concat!(
            cancel!(),
            "WHERE owner = ?1 AND state IN ('queued', 'running')"
        ))
        .bind(id)
        .bind(now())
        .execute(&self.pool)
        .await?;
        Ok(done.rows_affected())
    }

    /// Makes a key worthless, at once for a server that runs. Says whether there is such a key. What was
    /// sent with it stays until it expires.
    pub async fn revoke(&self, id: &str) -> Result<bool, StoreError> {
        let done =
            sqlx::query("UPDATE keys SET revoked_at = coalesce(revoked_at, ?2) WHERE id = ?1")
                .bind(id)
                .bind(now())
                .execute(&self.pool)
                .await?;
        Ok(done.rows_affected() > 0)
    }
}

impl Store {
    /// The owner that a key stands for; `None` when it is not one, has expired or was revoked.
    pub async fn owner_of(&self, key: &str) -> Result<Option<Owner>, StoreError> {
        let Some((id, secret)) = parts(key) else {
            return Ok(None);
        };
        let kept: Option<Vec<u8>> =
            sqlx::query_scalar(concat!("SELECT hash FROM keys WHERE id = ?2 AND ", good!()))
                .bind(now())
                .bind(id)
                .fetch_optional(&self.readers)
                .await?;
        // In constant time, so that answers do not tell how much of a hash was right.
        let right = kept.is_some_and(|kept| hash(secret).ct_eq(&kept[..]).into());
        Ok(right.then(|| Owner::of_key(id)))
    }

    /// Whether the key that an owner stands for is still good; always for whoever sends without one.
    pub async fn is_good(&self, owner: &Owner) -> Result<bool, StoreError> {
        if owner.is_anonymous() {
            return Ok(true);
        }
        Ok(sqlx::query_scalar(concat!(
            "SELECT EXISTS (SELECT 1 FROM keys WHERE id = ?2 AND ",
            good!(),
            ")"
        ))
        .bind(now())
        .bind(owner.as_str())
        .fetch_one(&self.readers)
        .await?)
    }

    /// Whether there is any key that is good now.
    pub async fn has_keys(&self) -> Result<bool, StoreError> {
        Ok(sqlx::query_scalar(concat!(
            "SELECT EXISTS (SELECT 1 FROM keys WHERE ",
            good!(),
            ")"
        ))
        .bind(now())
        .fetch_one(&self.readers)
        .await?)
    }
}

/// Id and secret of what is written as a key.
fn parts(key: &str) -> Option<(&str, &str)> {
    let mut pieces = key.split('_');
    let (prefix, id, secret) = (pieces.next()?, pieces.next()?, pieces.next()?);
    (prefix == PREFIX && pieces.next().is_none()).then_some((id, secret))
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

fn record(row: &SqliteRow) -> Result<KeyRecord, StoreError> {
    let optional = |name: &str| -> Result<Option<Timestamp>, StoreError> {
        let at: Option<i64> = row.try_get(name)?;
        at.map(timestamp).transpose()
    };
    Ok(KeyRecord {
        id: row.try_get("id").map_err(damaged)?,
        name: row.try_get("name").map_err(damaged)?,
        created_at: timestamp(row.try_get("created_at")?)?,
        expires_at: optional("expires_at")?,
        revoked_at: optional("revoked_at")?,
    })
}
