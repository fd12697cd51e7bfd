//! A data directory that is examined without a change, whether a server runs on it or not.

use std::collections::BTreeSet;
use std::fs::{self, File};
use std::io::{self, Read};
use std::path::Path;
use std::time::Duration;

use sha2::{Digest, Sha256};
use sqlx::sqlite::{SqliteConnectOptions, SqliteConnection, SqliteRow};
use sqlx::{ConnectOptions, Row};

use super::files::Files;
use super::lock::{database_file, is_in_use};
use super::migrations;
use crate::store::common::rows::{self, mesh_id};
use crate::store::{StoreError, damaged, uploads};
use crate::wire::{MeshId, Units};
use graspd_mesh_io::MeshFormat;

/// Longest wait for a lock on the database.
const PATIENCE: Duration = Duration::from_secs(5);

/// A data directory, or a backup of one, that is only read.
pub struct Survey {
    pub connection: SqliteConnection,
    files: Files,
}

/// The columns of a mesh that its file is checked against.
#[derive(Debug, Clone)]
pub struct MeshRow {
    pub id: MeshId,
    format: MeshFormat,
    units: Option<Units>,
    scale: f64,
}

/// Rows and files of meshes that do not belong together.
#[derive(Debug, Default)]
pub struct Unpaired {
    pub rows_without_file: Vec<MeshId>,
    pub files_without_row: Vec<MeshId>,
}

impl Survey {
    /// Opens the database in `data` for reading.
    pub async fn open(data: &Path) -> Result<Self, StoreError> {
        let file = database_file(data);
        fs::metadata(&file)?;
        let log = fs::metadata(data.join("graspd.db-wal")).map_or(0, |log| log.len());
        let options = SqliteConnectOptions::new()
            .filename(file)
            .read_only(true)
            .busy_timeout(PATIENCE)
            // Else SQLite would leave an index of the write-ahead log behind.
            .immutable(log == 0 && !is_in_use(data)?);
        Ok(Self {
            connection: options.connect().await?,
            files: Files::at(data),
        })
    }

    /// Returns the version of the SQLite library.
    pub async fn sqlite_version(&mut self) -> Result<String, StoreError> {
        Ok(sqlx::query_scalar("SELECT sqlite_version()")
            .fetch_one(&mut self.connection)
            .await?)
    }

    /// Returns the version of the tables; 0 when there are none.
    pub async fn schema_version(&mut self) -> Result<i64, StoreError> {
        Ok(migrations::version(&mut self.connection).await?)
    }

    /// Returns the faults that SQLite finds in the database; `deep` compares the indices with the tables too, which
    /// takes several times as long.
    pub async fn faults(&mut self, deep: bool) -> Result<Vec<String>, StoreError> {
        let statement = match deep {
            true => "PRAGMA integrity_check(20)",
            false => "PRAGMA quick_check(20)",
        };
        let mut lines: Vec<String> = sqlx::query_scalar(statement)
            .fetch_all(&mut self.connection)
            .await?;
        lines.retain(|line| line != "ok");
        Ok(lines)
    }

    /// Returns the meshes, each once.
    pub async fn meshes(&mut self) -> Result<Vec<MeshRow>, StoreError> {
        let rows = sqlx::query("SELECT DISTINCT id, format, units, scale FROM meshes ORDER BY id")
            .fetch_all(&mut self.connection)
            .await?;
        rows.iter().map(mesh_row).collect()
    }

    /// Returns how many jobs there are.
    pub async fn jobs(&mut self) -> Result<u64, StoreError> {
        let count: i64 = sqlx::query_scalar("SELECT count(*) FROM jobs")
            .fetch_one(&mut self.connection)
            .await?;
        Ok(count as u64)
    }

    /// Returns when the newest job was submitted, in microseconds since 1970.
    pub async fn newest_job(&mut self) -> Result<Option<i64>, StoreError> {
        Ok(
            sqlx::query_scalar("SELECT created_at FROM jobs ORDER BY id DESC LIMIT 1")
                .fetch_optional(&mut self.connection)
                .await?,
        )
    }

    /// Returns the rows of meshes without a file, and the files without a row. While a server runs, a mesh that comes or
    /// goes at that moment may be among them.
    pub async fn unpaired(&mut self) -> Result<Unpaired, StoreError> {
        let files: BTreeSet<MeshId> = self.files.list()?.into_iter().collect();
        let rows = self.meshes().await?.into_iter().map(|mesh| mesh.id);
        let rows: BTreeSet<MeshId> = rows.collect();
        Ok(Unpaired {
            rows_without_file: rows.difference(&files).cloned().collect(),
            files_without_row: files.difference(&rows).cloned().collect(),
        })
    }

    /// Returns the meshes whose file is missing or is not what was uploaded. Reads all files.
    pub async fn damaged_meshes(&mut self) -> Result<Vec<String>, StoreError> {
        let mut faults = Vec::new();
        for mesh in self.meshes().await? {
            match digest(&self.files.path(&mesh.id)) {
                Ok(digest) if mesh.is(&digest) => {}
                Ok(_) => faults.push(format!("the file of mesh {} is damaged", mesh.id)),
                Err(error) => faults.push(format!("the file of mesh {}: {error}", mesh.id)),
            }
        }
        Ok(faults)
    }
}

impl MeshRow {
    /// Returns whether a file with this hash is the file of this mesh.
    fn is(&self, digest: &[u8; 32]) -> bool {
        uploads::mesh_id(digest, self.format, self.units, self.scale) == self.id
    }
}

fn mesh_row(row: &SqliteRow) -> Result<MeshRow, StoreError> {
    let (id, format): (&str, &str) = (row.try_get("id")?, row.try_get("format")?);
    Ok(MeshRow {
        id: mesh_id(id)?,
        format: MeshFormat::from_name(format).ok_or_else(|| damaged("mesh format"))?,
        units: rows::units(row.try_get("units")?)?,
        scale: row.try_get("scale")?,
    })
}

fn digest(path: &Path) -> io::Result<[u8; 32]> {
    let mut file = File::open(path)?;
    let mut hasher = Sha256::new();
    let mut piece = vec![0; 64 * 1024];
    loop {
        match file.read(&mut piece)? {
            0 => return Ok(hasher.finalize().into()),
            length => hasher.update(&piece[..length]),
        }
    }
}
