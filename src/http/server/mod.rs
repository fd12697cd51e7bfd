//! The server below the routes: sockets, connections, and how many of them there may be.

mod connection_permits;
mod listener;
mod socket;

pub use listener::{files_needed, listen, raise_file_limit, serve};
