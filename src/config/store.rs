//! Where everything is kept.

use std::path::PathBuf;

use clap::Args;

use crate::jobs::Location;

/// A folder of this process alone, or a database that many share.
#[derive(Debug, Clone, Args)]
pub struct Store {
    /// Folder of the database and the meshes; created when missing
    #[arg(
        long,
        env = "GRASPD_DATA_DIR",
        value_name = "FOLDER",
        default_value = "./graspd-data",
        global = true
    )]
    pub data_dir: PathBuf,

    /// Keep everything in this PostgreSQL database, which other servers and workers may share, instead of a folder:
    /// postgres://USER:PASSWORD@HOST:PORT/DATABASE. Give it in the environment: others can see flags
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
    /// Where it is.
    pub fn location(&self) -> Location {
        match &self.store {
            Some(url) => Location::Database(url.clone()),
            None => Location::Folder(self.data_dir.clone()),
        }
    }
}
