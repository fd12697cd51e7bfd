//! HTTP: from a socket to a handler, and back.
//!
//! # The way of a request
//!
//! | # | where | what it does | why there |
//! |---|---|---|---|
//! | 1 | `server` | accepts the connection, bounds connections in all and per network, gives up on peers that are too slow | costs must be bounded before a byte is parsed |
//! | 2 | `layers/cors` | answers preflight requests, marks responses for other origins | outermost: preflight requests carry no key, and a page must be able to read errors as well |
//! | 3 | `layers/request_metrics` | counts and times | sees every request, and the final status |
//! | 4 | `layers/panics` | turns a panic into a 500 | for panics in the layers below |
//! | 5 | `layers/request_log` | gives the request an id and a span, logs the outcome | everything below logs under that id |
//! | 6 | `request/lingering` | makes the body one that is read on after an early answer | above every layer that may refuse |
//! | 7 | `layers/browser_policy` | adds security headers to the response | refusals need them too |
//! | 8 | `layers/head_limits` | refuses a head that is too long or malformed | before any handler reads it |
//! | 9 | `response/framework` | turns axum's own errors into problems | outside the router, which answers 404 and 405 itself |
//! | 10 | `layers/panics` | turns a panic into a 500 | inside the log and the headers, so that this answer has both |
//! | 11 | `router` | finds the route | |
//! | 12 | `layers/auth` | identifies the caller, counts against the rate limit | on known routes alone, in front of all that serve someone's data |
//! | 13 | `layers/accept_json` | refuses a client that does not accept JSON | before the handler changes anything |
//! | 14 | handler | extracts query, headers and body (`request/`), calls [`crate::jobs::Service`], answers (`response/`) | |
//!
//! The response passes the same layers in the opposite order.
//!
//! # Where things are
//!
//! | folder | subject |
//! |---|---|
//! | `jobs/`, `batches/`, `evaluations.rs`, `meshes/`, `system/` | handlers by resource |
//! | `exports/` | pictures and files of other formats, one route for each row of [`crate::export::EXPORTS`] |
//! | `request/`, `response/` | what is read of a request; JSON, files and problems |
//! | `openapi/` | the OpenAPI document |
//! | `application.rs`, `worker.rs` | the processes: from settings to a listening socket, until they stop |

mod app;
mod application;
mod batches;
mod evaluations;
mod exports;
mod jobs;
mod layers;
mod meshes;
mod openapi;
mod options;
mod request;
mod response;
mod router;
mod server;
mod stop;
mod system;
mod worker;

pub use application::Application;
pub use layers::cors::layer as cors_layer;
pub use options::requires_keys;
pub use router::openapi_json;
pub use server::files_needed;
pub use worker::WorkerApplication;
