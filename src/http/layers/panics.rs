//! A panic while a request is handled becomes a 500 for that request alone.

use std::any::Any;

use axum::response::{IntoResponse, Response};
use tower_http::catch_panic::CatchPanicLayer;

use crate::http::response::error::Error;

/// Marks the response to a request whose handling panicked, so that it can be counted.
#[derive(Debug, Clone, Copy)]
pub struct Panicked;

/// The type of the layer that [`catch`] returns.
pub type CatchPanic = CatchPanicLayer<fn(Box<dyn Any + Send>) -> Response>;

/// Catches panics and answers with a problem; what the panic said goes to the log alone.
pub fn catch() -> CatchPanic {
    CatchPanicLayer::custom(respond)
}

fn respond(cause: Box<dyn Any + Send>) -> Response {
    let message = cause
        .downcast_ref::<String>()
        .map(String::as_str)
        .or_else(|| cause.downcast_ref::<&str>().copied())
        .unwrap_or("no message");
    let mut response = Error::internal(format_args!("panic: {message}")).into_response();
    response.extensions_mut().insert(Panicked);
    response
}
