//! The service as its clients see it: real server, real sockets.

mod analyses;
mod common;
mod constraints;
mod evaluations;
mod framing;
mod jobs;
mod meshes;
mod paper;
mod refusals;
mod restart;
mod service;
mod trials;
