//! Meshes: a row of each owner, and the file that all of them share.

use std::io::{self, Read, Seek};
use std::time::Duration;

use async_trait::async_trait;
use sqlx::postgres::{PgConnection, PgRow};
use sqlx::{FromRow, Row};

use super::connections::within;
use super::{PIECE_BYTES, Postgres, jobs};
use crate::store::microseconds;
use crate::store::rows::{KeptRow, MeshRow, mesh_columns};
use crate::store::{
    Deletion, Kept, MAX_PAGE, Meshes, NewJob, NewMesh, Owner, Received, Refusal, StoreError,
    Upload, cursor, damaged,
};
use crate::wire::{JobRecord, MeshId, MeshOptions, MeshPage, MeshRecord, Units};

/// Longest that the keeping of one mesh file may take.
const KEEPING_TIME: Duration = Duration::from_secs(120);

#[async_trait]
impl Meshes for Postgres {
    async fn begin_upload(&self) -> Result<Upload, StoreError> {
        // Without a name: nothing is left of it whatever becomes of this process.
        let file = tokio::task::spawn_blocking(tempfile::tempfile).await;
        let file = file.map_err(io::Error::other)??;
        let received = self.metrics.upload_bytes.clone();
        Ok(Upload::into_file(file, None, received))
    }

    async fn mesh(&self, owner: &Owner, id: &MeshId) -> Result<Option<MeshRecord>, StoreError> {
        let row: Option<MeshRow> = sqlx::query_as(concat!(
            "SELECT ",
            mesh_columns!(),
            " FROM meshes WHERE owner = $1 AND id = $2"
        ))
        .bind(owner.as_str())
        .bind(id.as_str())
        .fetch_optional(&self.reads)
        .await?;
        row.map(TryInto::try_into).transpose()
    }

    async fn kept(&self, owner: &Owner, id: &MeshId) -> Result<Option<Kept>, StoreError> {
        let row: Option<KeptRow> = sqlx::query_as(
            "SELECT candidates, units, used_at FROM meshes WHERE owner = $1 AND id = $2",
        )
        .bind(owner.as_str())
        .bind(id.as_str())
        .fetch_optional(&self.reads)
        .await?;
        row.map(TryInto::try_into).transpose()
    }

    async fn touch(
        &self,
        owner: &Owner,
        id: &MeshId,
        _kept: &Kept,
        every: Duration,
    ) -> Result<(), StoreError> {
        // Only the database knows what time it is there.
        sqlx::query(
            "UPDATE meshes SET used_at = now_us() \
             WHERE owner = $1 AND id = $2 AND used_at < now_us() - $3",
        )
        .bind(owner.as_str())
        .bind(id.as_str())
        .bind(microseconds(every))
        .execute(&self.writes)
        .await?;
        Ok(())
    }

    async fn mesh_bytes(&self, owner: &Owner) -> Result<u64, StoreError> {
        let sum: i64 = sqlx::query_scalar(
            "SELECT coalesce(sum(bytes), 0)::bigint FROM meshes WHERE owner = $1",
        )
        .bind(owner.as_str())
        .fetch_one(&self.reads)
        .await?;
        Ok(sum as u64)
    }

    async fn meshes(
        &self,
        owner: &Owner,
        cursor: Option<&str>,
        limit: u32,
    ) -> Result<Option<MeshPage>, StoreError> {
        const LIST: &str = "meshes";
        let before = match cursor {
            None => i64::MAX,
            Some(cursor) => match cursor::decode(LIST, cursor).map(str::parse) {
                Some(Ok(seq)) => seq,
                _ => return Ok(None),
            },
        };
        let limit = limit.clamp(1, MAX_PAGE) as usize;
        let rows = sqlx::query(concat!(
            "SELECT seq, ",
            mesh_columns!(),
            " FROM meshes WHERE seq < $1 AND owner = $3 ORDER BY seq DESC LIMIT $2"
        ))
        .bind(before)
        .bind(limit as i64 + 1)
        .bind(owner.as_str())
        .fetch_all(&self.reads)
        .await?;
        let record = |row: &PgRow| Ok((row.try_get("seq")?, MeshRow::from_row(row)?.try_into()?));
        let meshes: Vec<(i64, MeshRecord)> =
            rows.iter().map(record).collect::<Result<_, StoreError>>()?;
        let (meshes, next_cursor) = cursor::page(LIST, meshes, limit, |(seq, _)| seq.to_string());
        let meshes = meshes.into_iter().map(|(_, mesh)| mesh).collect();
        Ok(Some(MeshPage {
            meshes,
            next_cursor,
        }))
    }

    async fn has_mesh_file(&self, id: &MeshId) -> Result<bool, StoreError> {
        Ok(sqlx::query_scalar(
            "SELECT EXISTS (SELECT 1 FROM meshes JOIN pieces USING (digest) WHERE id = $1)",
        )
        .bind(id.as_str())
        .fetch_one(&self.reads)
        .await?)
    }

    async fn mesh_file(
        &self,
        owner: &Owner,
        id: &MeshId,
    ) -> Result<Option<(MeshOptions, Vec<u8>)>, StoreError> {
        let Some(mesh) = self.mesh(owner, id).await? else {
            return Ok(None);
        };
        let mut bytes = Vec::with_capacity(usize::try_from(mesh.bytes).unwrap_or(0));
        for number in 0_i64.. {
            let piece: Option<Vec<u8>> = sqlx::query_scalar(
                "SELECT data FROM pieces JOIN meshes USING (digest) \
                 WHERE owner = $1 AND id = $2 AND number = $3",
            )
            .bind(owner.as_str())
            .bind(id.as_str())
            .bind(number)
            .fetch_optional(&self.reads)
            .await?;
            match piece {
                Some(piece) => bytes.extend(piece),
                None => break,
            }
        }
        // Forgotten while it was read, or damaged.
        let is_whole = bytes.len() as u64 == mesh.bytes;
        Ok(is_whole.then(|| (mesh.options(), bytes)))
    }

    async fn add_mesh(
        &self,
        received: Received,
        mesh: &NewMesh,
    ) -> Result<Result<(MeshRecord, bool), Refusal>, StoreError> {
        within(KEEPING_TIME, async {
            let mut transaction = self.writes.begin().await?;
            let id = received.mesh_id(mesh.format, mesh.units, mesh.scale);
            let Some(is_new) = insert(received, mesh, &id, &mut transaction).await? else {
                transaction.rollback().await?;
                return Ok(Err(Refusal::RoomUsed));
            };
            transaction.commit().await?;
            let record = self.mesh(&mesh.owner, &id).await?;
            let record = record.ok_or_else(|| damaged("a mesh just written is gone"))?;
            Ok(Ok((record, is_new)))
        })
        .await
    }

    async fn add_mesh_and_job(
        &self,
        received: Received,
        mesh: &NewMesh,
        job: &NewJob,
    ) -> Result<Result<JobRecord, Refusal>, StoreError> {
        within(KEEPING_TIME, async {
            let mut transaction = self.writes.begin().await?;
            let id = received.mesh_id(mesh.format, mesh.units, mesh.scale);
            let outcome = match insert(received, mesh, &id, &mut transaction).await? {
                None => Err(Refusal::RoomUsed),
                Some(_) => jobs::insert_exactly(job, &id, &mut transaction).await?,
            };
            match outcome {
                Ok(_) => transaction.commit().await?,
                Err(_) => transaction.rollback().await?,
            }
            Ok(outcome)
        })
        .await
    }

    async fn delete_mesh(&self, owner: &Owner, id: &MeshId) -> Result<Deletion, StoreError> {
        within(KEEPING_TIME, async {
            let mut transaction = self.writes.begin().await?;
            // Waits for whoever is submitting a job on it, so that the next statement sees that job.
            let known: Option<i64> = sqlx::query_scalar(
                "SELECT seq FROM meshes WHERE owner = $1 AND id = $2 FOR UPDATE",
            )
            .bind(owner.as_str())
            .bind(id.as_str())
            .fetch_optional(&mut *transaction)
            .await?;
            if known.is_none() {
                transaction.rollback().await?;
                return Ok(Deletion::NotFound);
            }
            let digest: Option<Vec<u8>> = sqlx::query_scalar(
                "DELETE FROM meshes WHERE owner = $1 AND id = $2 AND NOT EXISTS (SELECT 1 FROM jobs \
                 WHERE owner = $1 AND mesh_id = $2 AND state IN ('queued', 'running')) \
                 RETURNING digest",
            )
            .bind(owner.as_str())
            .bind(id.as_str())
            .fetch_optional(&mut *transaction)
            .await?;
            let Some(digest) = digest else {
                transaction.rollback().await?;
                return Ok(Deletion::InUse);
            };
            transaction.commit().await?;
            // The mesh is forgotten whatever becomes of its file, which the next sweep removes.
            if let Err(error) = self.drop_files(&[digest]).await {
                tracing::warn!(mesh = %id, %error, "a file that nobody has any more stays for a while");
            }
            Ok(Deletion::Done)
        })
        .await
    }
}

impl Postgres {
    /// Removes those of these files that are nobody's.
    pub(super) async fn drop_files(&self, digests: &[Vec<u8>]) -> Result<(), StoreError> {
        for digest in digests {
            let dropped = sqlx::query(
                "DELETE FROM files WHERE digest = $1 \
                 AND NOT EXISTS (SELECT 1 FROM meshes WHERE meshes.digest = $1)",
            )
            .bind(digest)
            .execute(&self.writes)
            .await;
            match dropped {
                Ok(_) => {}
                // Somebody sent it again at this moment.
                Err(error) if is_referenced(&error) => {}
                Err(error) => return Err(error.into()),
            }
        }
        Ok(())
    }
}

/// Keeps a file and the row of mesh `id`, which may be there already. Says whether the row is new; `None` when its
/// owner has no room for it.
async fn insert(
    mut received: Received,
    mesh: &NewMesh,
    id: &MeshId,
    connection: &mut PgConnection,
) -> Result<Option<bool>, StoreError> {
    let owner = mesh.owner.as_str();
    let known: bool =
        sqlx::query_scalar("SELECT EXISTS (SELECT 1 FROM meshes WHERE owner = $1 AND id = $2)")
            .bind(owner)
            .bind(id.as_str())
            .fetch_one(&mut *connection)
            .await?;
    if let Some(room) = mesh.room
        && !known
    {
        // One upload of an owner after the other, so that each counts those before it.
        sqlx::query("SELECT pg_advisory_xact_lock(hashtextextended($1, 0))")
            .bind(format!("room of {owner}"))
            .execute(&mut *connection)
            .await?;
        let used: i64 = sqlx::query_scalar(
            "SELECT coalesce(sum(bytes), 0)::bigint FROM meshes WHERE owner = $1",
        )
        .bind(owner)
        .fetch_one(&mut *connection)
        .await?;
        if (used as u64).saturating_add(received.bytes) > room {
            return Ok(None);
        }
    }
    // Takes the row of a file that is there, so that nobody removes it before this ends.
    sqlx::query(
        "INSERT INTO files (digest, bytes) VALUES ($1, $2) \
         ON CONFLICT (digest) DO UPDATE SET bytes = excluded.bytes",
    )
    .bind(&received.digest[..])
    .bind(received.bytes as i64)
    .execute(&mut *connection)
    .await?;
    // Asked only now: whoever removed the file while this waited for its row took the pieces along.
    let is_there: bool =
        sqlx::query_scalar("SELECT EXISTS (SELECT 1 FROM pieces WHERE digest = $1)")
            .bind(&received.digest[..])
            .fetch_one(&mut *connection)
            .await?;
    if !is_there {
        let digest = received.digest;
        received.file.rewind()?;
        for number in 0_i64.. {
            let read = tokio::task::spawn_blocking(move || {
                let mut piece = Vec::with_capacity(PIECE_BYTES);
                let mut file = received.file;
                (&mut file)
                    .take(PIECE_BYTES as u64)
                    .read_to_end(&mut piece)?;
                received.file = file;
                Ok::<_, io::Error>((received, piece))
            });
            let piece;
            (received, piece) = read.await.map_err(io::Error::other)??;
            if piece.is_empty() {
                break;
            }
            sqlx::query("INSERT INTO pieces (digest, number, data) VALUES ($1, $2, $3)")
                .bind(&digest[..])
                .bind(number)
                .bind(piece)
                .execute(&mut *connection)
                .await?;
        }
    }
    sqlx::query(
        "INSERT INTO meshes (id, digest, format, bytes, candidates, file_name, created_at, used_at, \
         report, units, scale, owner) \
         VALUES ($1, $2, $3, $4, $5, $6, now_us(), now_us(), $7, $8, $9, $10) \
         ON CONFLICT (owner, id) DO UPDATE SET used_at = excluded.used_at",
    )
    .bind(id.as_str())
    .bind(&received.digest[..])
    .bind(mesh.format.name())
    .bind(received.bytes as i64)
    .bind(mesh.report.candidates as i64)
    .bind(mesh.file_name.as_deref())
    .bind(serde_json::to_string(&mesh.report).map_err(damaged)?)
    .bind(mesh.units.map(Units::name))
    .bind(mesh.scale)
    .bind(owner)
    .execute(connection)
    .await?;
    Ok(Some(!known))
}

fn is_referenced(error: &sqlx::Error) -> bool {
    error
        .as_database_error()
        .is_some_and(|error| error.is_foreign_key_violation())
}
