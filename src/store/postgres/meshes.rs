//! Meshes: a row of each owner, and the file that all of them share.
//!
//! A row refers to its file, so that nobody can remove a file while a row is being added, or add a row while its file
//! is being removed. A file without a row, which a process leaves that dies in between, goes with the next sweep.

use std::io::{self, Read, Seek};
use std::time::Duration;

use async_trait::async_trait;

use super::connections::{Transaction, within};
use super::{PIECE_BYTES, Postgres, jobs};
use crate::store::common::meshes::{KeptMesh, MeshEngine};
use crate::store::microseconds;
use crate::store::{
    Deletion, MeshSummary, NewJob, NewMesh, Owner, Received, Refusal, StoreError, Upload, damaged,
};
use crate::wire::{MeshId, MeshRecord, Units};

/// Longest time that storing a mesh file may take.
const KEEPING_TIME: Duration = Duration::from_secs(120);

#[async_trait]
impl MeshEngine for Postgres {
    async fn new_upload(&self) -> Result<Upload, StoreError> {
        // Without a name: nothing is left of it whatever becomes of this process.
        let file = tokio::task::spawn_blocking(tempfile::tempfile).await;
        let file = file.map_err(io::Error::other)??;
        let received = self.metrics.upload_bytes.clone();
        Ok(Upload::into_file(file, None, received))
    }

    async fn note_use(
        &self,
        owner: &Owner,
        _mesh: &MeshSummary,
        id: &MeshId,
        every: Duration,
    ) -> Result<(), StoreError> {
        // Only the database knows what time it is there.
        let statement = sqlx::query(
            "UPDATE meshes SET used_at = now_us() \
             WHERE owner = $1 AND id = $2 AND used_at < now_us() - $3",
        )
        .bind(owner.as_str())
        .bind(id.as_str())
        .bind(microseconds(every));
        self.writes.run(statement).await?;
        Ok(())
    }

    async fn has_file(&self, id: &MeshId) -> Result<bool, StoreError> {
        let statement = sqlx::query(
            "SELECT EXISTS (SELECT 1 FROM meshes JOIN pieces USING (digest) WHERE id = $1)",
        );
        let (exists,) = self.reads.run(statement.bind(id.as_str())).await?.one()?;
        Ok(exists)
    }

    async fn file_of(
        &self,
        owner: &Owner,
        mesh: &MeshRecord,
    ) -> Result<Option<Vec<u8>>, StoreError> {
        let mut bytes = Vec::with_capacity(usize::try_from(mesh.bytes).unwrap_or(0));
        for number in 0_i64.. {
            let statement = sqlx::query(
                "SELECT data FROM pieces JOIN meshes USING (digest) \
                 WHERE owner = $1 AND id = $2 AND number = $3",
            )
            .bind(owner.as_str())
            .bind(mesh.id.as_str())
            .bind(number);
            let piece: Option<(Vec<u8>,)> = self.reads.run(statement).await?.first()?;
            match piece {
                Some((piece,)) => bytes.extend(piece),
                None => break,
            }
        }
        // It was forgotten while it was read, or it is damaged.
        let is_whole = bytes.len() as u64 == mesh.bytes;
        Ok(is_whole.then_some(bytes))
    }

    async fn keep_mesh(
        &self,
        received: Received,
        mesh: &NewMesh,
        id: &MeshId,
        job: Option<&NewJob>,
    ) -> Result<Result<KeptMesh, Refusal>, StoreError> {
        within(KEEPING_TIME, async {
            let mut transaction = self.writes.begin().await?;
            let outcome = insert(received, mesh, id, job, &mut transaction).await?;
            transaction.end(outcome.is_ok()).await?;
            Ok(outcome)
        })
        .await
    }

    async fn remove_mesh(&self, owner: &Owner, id: &MeshId) -> Result<Deletion, StoreError> {
        within(KEEPING_TIME, async {
            let mut transaction = self.writes.begin().await?;
            // Waits for whoever is submitting a job on it, so that the next statement sees that job.
            let lock =
                sqlx::query("SELECT seq FROM meshes WHERE owner = $1 AND id = $2 FOR UPDATE");
            let lock = lock.bind(owner.as_str()).bind(id.as_str());
            if !transaction.run(lock).await?.has_rows() {
                transaction.end(false).await?;
                return Ok(Deletion::NotFound);
            }
            let remove = sqlx::query(
                "DELETE FROM meshes WHERE owner = $1 AND id = $2 AND NOT EXISTS (SELECT 1 FROM jobs \
                 WHERE owner = $1 AND mesh_id = $2 AND state IN ('queued', 'running')) \
                 RETURNING digest",
            );
            let remove = remove.bind(owner.as_str()).bind(id.as_str());
            let removed: Option<(Vec<u8>,)> = transaction.run(remove).await?.first()?;
            transaction.end(removed.is_some()).await?;
            let Some((digest,)) = removed else {
                return Ok(Deletion::InUse);
            };
            // The mesh is forgotten whatever becomes of its file, which the next sweep removes.
            if let Err(error) = self.remove_unowned_file(&digest).await {
                tracing::warn!(mesh = %id, %error, "a file that nobody has any more stays for a while");
            }
            Ok(Deletion::Done)
        })
        .await
    }
}

impl Postgres {
    /// Removes a file that no owner has any more.
    pub(super) async fn remove_unowned_file(&self, digest: &[u8]) -> Result<(), StoreError> {
        let statement = sqlx::query(
            "DELETE FROM files WHERE digest = $1 \
             AND NOT EXISTS (SELECT 1 FROM meshes WHERE meshes.digest = $1)",
        );
        match self.writes.run(statement.bind(digest)).await {
            Ok(_) => Ok(()),
            // Somebody sent it again at this moment.
            Err(error) if is_referenced(&error) => Ok(()),
            Err(error) => Err(error.into()),
        }
    }
}

/// Keeps a file, the row of mesh `id`, which may be there already, and a job on it where one is given.
async fn insert(
    received: Received,
    mesh: &NewMesh,
    id: &MeshId,
    job: Option<&NewJob>,
    transaction: &mut Transaction,
) -> Result<Result<KeptMesh, Refusal>, StoreError> {
    let owner = mesh.owner.as_str();
    let known = sqlx::query("SELECT 1 FROM meshes WHERE owner = $1 AND id = $2");
    let known = known.bind(owner).bind(id.as_str());
    let is_new = !transaction.run(known).await?.has_rows();
    if is_new && !has_room(mesh, received.bytes, transaction).await? {
        return Ok(Err(Refusal::OwnerStorageFull));
    }
    let (digest, bytes) = (received.digest, received.bytes);
    insert_file(received, transaction).await?;
    let statement = sqlx::query(
        "INSERT INTO meshes (id, digest, format, bytes, candidates, file_name, created_at, used_at, \
         report, units, scale, owner) \
         VALUES ($1, $2, $3, $4, $5, $6, now_us(), now_us(), $7, $8, $9, $10) \
         ON CONFLICT (owner, id) DO UPDATE SET used_at = excluded.used_at",
    )
    .bind(id.as_str())
    .bind(&digest[..])
    .bind(mesh.format.name())
    .bind(bytes as i64)
    .bind(mesh.report.candidates as i64)
    .bind(mesh.file_name.as_deref())
    .bind(serde_json::to_string(&mesh.report).map_err(damaged)?)
    .bind(mesh.units.map(Units::name))
    .bind(mesh.scale)
    .bind(owner);
    transaction.run(statement).await?;
    let Some(job) = job else {
        return Ok(Ok(KeptMesh { is_new, job: None }));
    };
    let job = jobs::insert(job, id, transaction).await?;
    Ok(job.map(|job| KeptMesh {
        is_new,
        job: Some(job),
    }))
}

/// Whether the owner of a mesh has room for these bytes.
async fn has_room(
    mesh: &NewMesh,
    bytes: u64,
    transaction: &mut Transaction,
) -> Result<bool, StoreError> {
    if mesh.max_owner_bytes.is_none() {
        return Ok(true);
    }
    let owner = mesh.owner.as_str();
    // One upload of an owner after the other, so that each counts those before it.
    let lock = sqlx::query("SELECT pg_advisory_xact_lock(hashtextextended($1, 0))");
    transaction
        .run(lock.bind(format!("room of {owner}")))
        .await?;
    let count = sqlx::query("SELECT coalesce(sum(bytes), 0)::bigint FROM meshes WHERE owner = $1");
    let (used,) = transaction.run(count.bind(owner)).await?.one::<(i64,)>()?;
    Ok(mesh.fits(used as u64, bytes))
}

/// Keeps a file in pieces, unless it is there.
async fn insert_file(
    mut received: Received,
    transaction: &mut Transaction,
) -> Result<(), StoreError> {
    let digest = received.digest;
    // Takes the row of a file that is there, so that nobody removes it before the transaction ends.
    let take = sqlx::query(
        "INSERT INTO files (digest, bytes) VALUES ($1, $2) \
         ON CONFLICT (digest) DO UPDATE SET bytes = excluded.bytes",
    );
    let take = take.bind(&digest[..]).bind(received.bytes as i64);
    transaction.run(take).await?;
    // Asked only now: whoever removed the file while this waited for its row took the pieces along.
    let pieces = sqlx::query("SELECT EXISTS (SELECT 1 FROM pieces WHERE digest = $1)");
    let answer = transaction.run(pieces.bind(&digest[..])).await?;
    let (is_there,) = answer.one()?;
    if is_there {
        return Ok(());
    }
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
        let insert = sqlx::query("INSERT INTO pieces (digest, number, data) VALUES ($1, $2, $3)");
        let insert = insert.bind(&digest[..]).bind(number).bind(piece);
        transaction.run(insert).await?;
    }
    Ok(())
}

fn is_referenced(error: &sqlx::Error) -> bool {
    error
        .as_database_error()
        .is_some_and(|error| error.is_foreign_key_violation())
}
