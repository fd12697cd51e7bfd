//! Mesh files on their way in: received into a file, hashed as they come.

use std::fs::File;
use std::io::{self, Read, Seek};

use prometheus_client::metrics::counter::Counter;
use sha2::{Digest, Sha256};
use tempfile::TempPath;
use tokio::io::AsyncWriteExt;

use super::StoreError;
use crate::wire::{MeshId, MeshOptions, Units};
use graspd_mesh_io::MeshFormat;

/// A file on its way in, hashed as it comes. Dropping it removes it.
#[derive(Debug)]
pub struct Upload {
    file: tokio::fs::File,
    path: Option<TempPath>,
    hasher: Sha256,
    bytes: u64,
    received: Counter,
}

impl Upload {
    /// An upload into `file`, which is empty and is removed with `path` or, without one, by itself; `received`
    /// counts its bytes.
    pub(super) fn into_file(file: File, path: Option<TempPath>, received: Counter) -> Self {
        Self {
            file: tokio::fs::File::from_std(file),
            path,
            hasher: Sha256::new(),
            bytes: 0,
            received,
        }
    }

    /// Appends `chunk`.
    pub async fn write(&mut self, chunk: &[u8]) -> Result<(), StoreError> {
        self.file.write_all(chunk).await?;
        self.hasher.update(chunk);
        self.bytes += chunk.len() as u64;
        self.received.inc_by(chunk.len() as u64);
        Ok(())
    }

    /// Returns how many bytes have been written so far.
    pub fn bytes(&self) -> u64 {
        self.bytes
    }

    /// Ends the upload. The file is not safe from a power cut yet.
    pub async fn finish(mut self) -> Result<Received, StoreError> {
        self.file.flush().await?;
        Ok(Received {
            file: self.file.into_std().await,
            path: self.path,
            digest: self.hasher.finalize().into(),
            bytes: self.bytes,
        })
    }
}

/// A file that has come in whole. Dropping it removes it.
#[derive(Debug)]
pub struct Received {
    pub(super) file: File,
    /// The path of the file, unless it has no name.
    pub(super) path: Option<TempPath>,
    pub(super) digest: [u8; 32],
    pub bytes: u64,
}

impl Received {
    /// Returns the bytes of the file. Blocks.
    pub fn read(&mut self) -> io::Result<Vec<u8>> {
        self.file.rewind()?;
        let mut bytes = Vec::with_capacity(usize::try_from(self.bytes).unwrap_or(0));
        self.file.read_to_end(&mut bytes)?;
        Ok(bytes)
    }

    /// Returns a hash of these bytes in this unit and scale.
    pub fn fingerprint(&self, options: &MeshOptions) -> [u8; 32] {
        // A name or type that says the format may differ between two sendings of the same file.
        let MeshOptions {
            format: _,
            units,
            scale,
        } = options;
        Sha256::new()
            .chain_update(self.digest)
            .chain_update(units.map_or("", Units::name))
            .chain_update(scale.to_le_bytes())
            .finalize()
            .into()
    }

    /// Returns the id of the mesh that these bytes are when read as `format`, in this unit and scaled.
    pub fn mesh_id(&self, format: MeshFormat, units: Option<Units>, scale: f64) -> MeshId {
        mesh_id(&self.digest, format, units, scale)
    }
}

/// Returns the id of the mesh that bytes with this hash are when read as `format`, in this unit and scaled.
pub fn mesh_id(digest: &[u8; 32], format: MeshFormat, units: Option<Units>, scale: f64) -> MeshId {
    let mut hasher = Sha256::new();
    hasher.update(digest);
    hasher.update(format.name());
    if units.is_some() || scale != 1.0 {
        hasher.update(units.map_or("", Units::name));
        hasher.update(scale.to_le_bytes());
    }
    MeshId::of_hash(&hasher.finalize().into())
}
