//! Faults that stop a batch.

use std::io;

/// Why a batch stops before its end.
#[derive(Debug)]
pub enum BatchError {
    Interrupted,
    /// The server refuses this client or cannot be reached; contains the reason as text.
    Refused(String),
    /// A file in the folder of the results cannot be written.
    Unwritable(io::Error),
}
