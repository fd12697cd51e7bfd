//! Mesh files: received into `uploads/`, kept in `meshes/` under the hash of their content.

use std::fs::{self, File};
use std::io;
use std::path::{Path, PathBuf};

use prometheus_client::metrics::counter::Counter;
use tempfile::TempPath;

use crate::store::uploads::Upload;
use crate::wire::MeshId;

/// The two folders of mesh files.
#[derive(Debug, Clone)]
pub struct Files {
    meshes: PathBuf,
    uploads: PathBuf,
}

impl Files {
    /// The folders in `data`, whether they are there or not.
    pub fn at(data: &Path) -> Self {
        Self {
            meshes: data.join("meshes"),
            uploads: data.join("uploads"),
        }
    }

    /// Creates the folders in `data` where they are missing.
    pub fn open(data: &Path) -> io::Result<Self> {
        let files = Self::at(data);
        fs::create_dir_all(&files.meshes)?;
        fs::create_dir_all(&files.uploads)?;
        sync_folder(data)?;
        Ok(files)
    }

    /// An empty file to receive into; `received` counts its bytes.
    pub fn begin_upload(&self, received: Counter) -> io::Result<Upload> {
        let (file, path) = tempfile::NamedTempFile::new_in(&self.uploads)?.into_parts();
        Ok(Upload::into_file(file, Some(path), received))
    }

    /// A folder on the file system that all of this is on.
    pub fn folder(&self) -> &Path {
        &self.uploads
    }

    /// Where the file of a mesh is kept.
    pub fn path(&self, id: &MeshId) -> PathBuf {
        self.meshes.join(id.as_str())
    }

    /// Makes a received file the file of mesh `id`: all or nothing, and safe from a power cut
    /// once this returns. Blocks.
    pub fn publish(&self, received: TempPath, id: &MeshId) -> io::Result<()> {
        // Before the rename, or a power cut could leave the name with half the content.
        File::open(&received)?.sync_all()?;
        received
            .persist(self.path(id))
            .map_err(|refused| refused.error)?;
        sync_folder(&self.meshes)
    }

    /// Removes the file of a mesh, if it is there. Blocks.
    pub fn remove(&self, id: &MeshId) -> io::Result<()> {
        match fs::remove_file(self.path(id)) {
            Err(error) if error.kind() != io::ErrorKind::NotFound => Err(error),
            _ => Ok(()),
        }
    }

    /// Removes every file in `uploads/`: none is anyone's at start.
    pub fn clear_uploads(&self) -> io::Result<()> {
        for entry in fs::read_dir(&self.uploads)? {
            let entry = entry?;
            // A folder is none of ours.
            if entry.file_type()?.is_dir() {
                continue;
            }
            let path = entry.path();
            fs::remove_file(&path).map_err(|error| {
                io::Error::new(error.kind(), format!("{}: {error}", path.display()))
            })?;
        }
        Ok(())
    }

    /// The meshes that have a file. Names that are not ids are none of ours and are left alone.
    pub fn list(&self) -> io::Result<Vec<MeshId>> {
        let mut ids = Vec::new();
        for entry in fs::read_dir(&self.meshes)? {
            ids.extend(entry?.file_name().to_str().and_then(MeshId::parse));
        }
        Ok(ids)
    }
}

/// Makes the names in a folder safe from a power cut.
pub fn sync_folder(folder: &Path) -> io::Result<()> {
    File::open(folder)?.sync_all()
}
