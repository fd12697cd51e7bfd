//! graspd plans force-closure grasps on triangle meshes.
//!
//! The planner is the crate `graspd_core`, the readers of mesh files are `graspd_mesh_io`; this one is the service around
//! them. Each part may use what stands above it and nothing below:
//!
//! | part | what it is | what it never does |
//! |---|---|---|
//! | [`wire`] | the JSON that enters and leaves: planning request, result, progress, mesh report, problem | HTTP, storage |
//! | [`run`] | one planning run as the outside sees it: request in, result out, with clock and time limit | HTTP, storage |
//! | [`picture`] | what a mesh looks like: PNG, and SVG with the figures of its report | files, HTTP |
//! | [`export`] | meshes and grasps in the formats of other programs | files, HTTP |
//! | [`host`] | what the system says of this process and its disks | anything to either |
//! | [`metrics`] | what is counted and measured, for Prometheus | deciding by it |
//! | `otel` | spans on their way to a collector, with the feature of that name | logging |
//! | [`store`] | what outlives the process: in a folder, or in a database that many share | deciding what a job may do next |
//! | [`cluster`] | how processes that share a store work together: leases, notices, recovery | planning, SQL |
//! | [`jobs`] | the life of a job: submit, queue, run on the bounded pool, cancel, recover | HTTP, SQL |
//! | [`http`] | routes, extraction, problem responses, OpenAPI | SQL, planning |
//! | [`cli`] | the commands of the binary | anything a library user would miss |

#![forbid(unsafe_code)]

pub mod cli;
pub mod cluster;
pub mod config;
pub mod export;
pub mod host;
pub mod http;
pub mod jobs;
pub mod metrics;
#[cfg(feature = "otel")]
pub mod otel;
pub mod picture;
pub mod run;
pub mod store;
pub mod wire;
