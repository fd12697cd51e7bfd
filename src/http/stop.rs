//! The last steps of a process that stops.

use std::time::{Duration, Instant};

use tokio::task::JoinHandle;

use crate::jobs::Service;

/// The longest wait for requests under way, while new ones are still answered.
const LAST_REQUESTS: Duration = Duration::from_secs(6);
/// The longest wait for the store.
const LAST_STATEMENTS: Duration = Duration::from_secs(3);

/// Waits until no request is under way.
pub async fn wait_for_requests(service: &Service) {
    let in_flight = &service.metrics().http.in_flight;
    let deadline = Instant::now() + LAST_REQUESTS;
    while in_flight.get() > 0 && Instant::now() < deadline {
        tokio::time::sleep(Duration::from_millis(5)).await;
    }
}

/// Waits for the server to end.
pub async fn join_server(server: JoinHandle<()>) {
    if server.await.is_err() {
        tracing::error!("the server ended by a panic");
    }
}

/// Closes the store once it is idle.
pub async fn close_store(service: &Service) {
    if tokio::time::timeout(LAST_STATEMENTS, service.close())
        .await
        .is_err()
    {
        tracing::warn!("the store was still busy at the end");
    }
}
