//! The service as its clients see it: real server, real sockets.

mod analyses;
mod binary;
mod common;
mod connections;
mod constraints;
mod evaluations;
mod framing;
mod intake;
mod jobs;
mod malformed;
mod meshes;
mod paper;
mod preview;
mod raw;
mod refusals;
mod restart;
mod service;
mod solids;
mod stopping;
mod trials;
