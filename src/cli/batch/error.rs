//! Why a batch stops before its end.

use std::io;

/// Why a batch stops before its end.
#[derive(Debug)]
pub enum BatchError {
    Interrupted,
    /// The server refuses this client, or is out of reach; the reason in words.
    Refused(String),
    /// A file in the folder of the results cannot be written.
    Unwritable(io::Error),
}
