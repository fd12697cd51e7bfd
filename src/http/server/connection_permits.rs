//! Permits for connections: a number of them in all, and no more than a share for one network.

use std::collections::HashMap;
use std::net::IpAddr;
use std::sync::Arc;

use parking_lot::Mutex;
use tokio::sync::{OwnedSemaphorePermit, Semaphore};

use crate::http::layers::client::client_network;

/// Bounds the connections that are open at a time.
#[derive(Debug, Clone)]
pub struct ConnectionPermits {
    all: Arc<Semaphore>,
    /// The most permits of one network: three quarters of all, so that the rest is left for others.
    share: usize,
    held: Arc<Mutex<HashMap<IpAddr, usize>>>,
}

/// A permit for one connection, given back when it is dropped.
#[derive(Debug)]
pub struct ConnectionPermit {
    _permit: OwnedSemaphorePermit,
    held: Arc<Mutex<HashMap<IpAddr, usize>>>,
    address: IpAddr,
}

impl ConnectionPermits {
    /// `count` permits.
    pub fn new(count: usize) -> Self {
        Self {
            all: Arc::new(Semaphore::new(count)),
            share: (count * 3 / 4).max(1),
            held: Arc::default(),
        }
    }

    /// Waits until a permit is free, whoever it will be for.
    pub async fn acquire(&self) -> OwnedSemaphorePermit {
        match Arc::clone(&self.all).acquire_owned().await {
            Ok(permit) => permit,
            // The semaphore is never closed.
            Err(_) => std::future::pending().await,
        }
    }

    /// Gives a free permit to the network of `address`, unless that has its share already.
    pub fn assign(
        &self,
        permit: OwnedSemaphorePermit,
        address: IpAddr,
    ) -> Option<ConnectionPermit> {
        let address = client_network(address);
        let mut held = self.held.lock();
        let count = held.entry(address).or_default();
        if *count >= self.share {
            return None;
        }
        *count += 1;
        Some(ConnectionPermit {
            _permit: permit,
            held: Arc::clone(&self.held),
            address,
        })
    }
}

impl Drop for ConnectionPermit {
    fn drop(&mut self) {
        let mut held = self.held.lock();
        if let Some(count) = held.get_mut(&self.address) {
            *count -= 1;
            if *count == 0 {
                held.remove(&self.address);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    async fn take(permits: &ConnectionPermits, address: &str) -> Option<ConnectionPermit> {
        let permit = permits.acquire().await;
        permits.assign(permit, address.parse().unwrap())
    }

    #[tokio::test]
    async fn one_address_gets_three_quarters_and_the_rest_stays_free() {
        let permits = ConnectionPermits::new(8);
        let mut first = Vec::new();
        for _ in 0..6 {
            first.push(take(&permits, "192.0.2.1").await.expect("a permit"));
        }
        assert!(take(&permits, "192.0.2.1").await.is_none());
        assert!(take(&permits, "::ffff:192.0.2.1").await.is_none());
        let second = take(&permits, "2001:db8::1").await.expect("a permit");
        let _third = take(&permits, "192.0.2.3").await.expect("a permit");
        // All are taken now; one more has to wait.
        assert_eq!(permits.all.available_permits(), 0);
        drop(second);
        first.pop();
        assert!(take(&permits, "192.0.2.1").await.is_some());
        drop(first);
        assert_eq!(permits.held.lock().len(), 1);
    }
}
