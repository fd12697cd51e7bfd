//! graspd plans force-closure grasps on triangle meshes.
//!
//! The map, from the inside out. Each part may use what stands above it and nothing below:
//!
//! | part | what it is | what it never does |
//! |---|---|---|
//! | [`core`] | mesh, contact, wrench, quality, search, plan: the mathematics | I/O, clocks, JSON, threads of its own beyond rayon's current pool |
//! | [`wire`] | the JSON that enters and leaves: planning request, result, progress, mesh report, problem | HTTP, storage |
//! | [`run`] | one planning run as the outside sees it: request in, result out, with clock and time limit | HTTP, storage |
//! | [`picture`] | what a mesh looks like: PNG, and SVG with the figures of its report | files, HTTP |
//! | [`export`] | meshes and grasps in the formats of other programs | files, HTTP |
//! | [`host`] | what the system says of this process and its disks | anything to either |
//! | [`metrics`] | what is counted and measured, for Prometheus | deciding by it |
//! | `otel` | spans on their way to a collector, with the feature of that name | logging |
//! | [`store`] | what outlives the process: in a folder, or in a database that many share | deciding what a job may do next |
//! | [`jobs`] | the life of a job: submit, queue, run on the bounded pool, cancel, recover | HTTP, SQL |
//! | [`http`] | routes, extraction, problem responses, OpenAPI | SQL, planning |
//! | [`cli`] | the commands of the binary | anything a library user would miss |
//!
//! `cargo check --lib --no-default-features` builds `core` alone.

#![forbid(unsafe_code)]

pub mod core;

#[cfg(feature = "server")]
pub mod cli;
#[cfg(feature = "server")]
pub mod config;
#[cfg(feature = "server")]
pub mod export;
#[cfg(feature = "server")]
pub mod host;
#[cfg(feature = "server")]
pub mod http;
#[cfg(feature = "server")]
pub mod jobs;
#[cfg(feature = "server")]
pub mod metrics;
#[cfg(feature = "otel")]
pub mod otel;
#[cfg(feature = "server")]
pub mod picture;
#[cfg(feature = "server")]
pub mod run;
#[cfg(feature = "server")]
pub mod store;
#[cfg(feature = "server")]
pub mod wire;
