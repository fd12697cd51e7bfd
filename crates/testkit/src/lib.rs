//! What several test programs share.

pub mod files;
pub mod stl;
