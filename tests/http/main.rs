//! The service as its clients see it: real server, real sockets.

mod analyses;
mod backup;
mod common;
mod constraints;
mod disk;
mod doctor;
mod evaluations;
mod framing;
mod intake;
mod jobs;
mod logs;
mod malformed;
mod meshes;
mod metrics;
#[cfg(feature = "otel")]
mod otel;
mod paper;
mod preview;
mod process;
mod ready;
mod refusals;
mod restart;
mod service;
mod trials;
