//! The settings of the store.

use std::path::PathBuf;

use clap::Args;

use crate::jobs::Location;

/// The store: a folder that one server owns, or a database that many processes share.
#[derive(Debug, Clone, Args)]
pub struct Store {
    /// Folder of the database and the meshes, created if necessary
    #[arg(
        long,
        env = "GRASPD_DATA_DIR",
        value_name = "FOLDER",
        default_value = "./graspd-data",
        global = true
    )]
    pub data_dir: PathBuf,

    /// Keep everything in this PostgreSQL database, which other servers and workers may share, instead of a folder:
    /// postgres://USER:PASSWORD@HOST:PORT/DATABASE. Set it in the environment: other users can see flags
    #[arg(
        long,
        env = "GRASPD_STORE",
        value_name = "URL",
        hide_env_values = true,
        global = true
    )]
    pub store: Option<String>,
}

impl Store {
    /// Returns the location of the store.
    pub fn location(&self) -> Location {
        match &self.store {
            Some(url) => Location::Database(url.clone()),
            None => Location::Folder(self.data_dir.clone()),
        }
    }
}
