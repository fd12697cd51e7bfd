//! The service as its clients see it: real server, real sockets.

mod access;
mod analyses;
mod binary;
mod cancelling;
mod common;
mod connections;
mod constraints;
mod evaluations;
mod events;
mod framing;
mod intake;
mod jobs;
mod long_poll;
mod malformed;
mod meshes;
mod paper;
mod preview;
mod raw;
mod refusals;
mod restart;
mod scripted;
mod service;
mod solids;
mod stopping;
mod submissions;
mod trials;
