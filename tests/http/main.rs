//! The service as its clients see it: real server, real sockets.

mod analyses;
mod common;
mod constraints;
mod evaluations;
mod framing;
mod intake;
mod jobs;
mod malformed;
mod meshes;
mod paper;
mod preview;
mod receiver;
mod refusals;
mod restart;
mod service;
mod trials;
mod webhooks;
