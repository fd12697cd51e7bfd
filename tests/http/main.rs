//! The service as its clients see it: real server, real sockets.

mod access;
mod analyses;
mod backup;
mod cancelling;
mod common;
mod connections;
mod constraints;
mod disk;
mod doctor;
mod evaluations;
mod events;
mod framing;
mod intake;
mod jobs;
mod logs;
mod long_poll;
mod malformed;
mod meshes;
mod metrics;
#[cfg(feature = "otel")]
mod otel;
mod paper;
mod preview;
mod process;
mod raw;
mod ready;
mod receiver;
mod refusals;
mod restart;
mod scripted;
mod service;
mod solids;
mod stopping;
mod submissions;
mod trials;
mod webhooks;
