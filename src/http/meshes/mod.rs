//! Meshes: upload, list, read, export, delete. Their pictures are rows of the table of exports.

pub mod file;
pub mod records;
pub mod upload;
