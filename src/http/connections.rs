//! Places for connections: so many in all, and no more than a share of them for one address.

use std::collections::HashMap;
use std::net::{IpAddr, Ipv6Addr};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use tokio::sync::{OwnedSemaphorePermit, Semaphore};

/// Bounds the connections that are open at a time.
#[derive(Debug, Clone)]
pub struct Places {
    all: Arc<Semaphore>,
    /// Most places of one address: three quarters of all, so that the rest is left for others.
    share: usize,
    held: Arc<Mutex<HashMap<IpAddr, usize>>>,
}

/// A place that is given back when it is dropped.
#[derive(Debug)]
pub struct Place {
    _permit: OwnedSemaphorePermit,
    held: Arc<Mutex<HashMap<IpAddr, usize>>>,
    address: IpAddr,
}

impl Places {
    /// `count` places.
    pub fn new(count: usize) -> Self {
        Self {
            all: Arc::new(Semaphore::new(count)),
            share: (count * 3 / 4).max(1),
            held: Arc::default(),
        }
    }

    /// Waits until a place is free, whoever it will be for.
    pub async fn free(&self) -> OwnedSemaphorePermit {
        match Arc::clone(&self.all).acquire_owned().await {
            Ok(permit) => permit,
            // Nobody closes it.
            Err(_) => std::future::pending().await,
        }
    }

    /// Gives a free place to `address`, unless it has its share already.
    pub fn take(&self, permit: OwnedSemaphorePermit, address: IpAddr) -> Option<Place> {
        let address = household(address);
        let mut held = lock(&self.held);
        let count = held.entry(address).or_default();
        if *count >= self.share {
            return None;
        }
        *count += 1;
        Some(Place {
            _permit: permit,
            held: Arc::clone(&self.held),
            address,
        })
    }
}

impl Drop for Place {
    fn drop(&mut self) {
        let mut held = lock(&self.held);
        if let Some(count) = held.get_mut(&self.address) {
            *count -= 1;
            if *count == 0 {
                held.remove(&self.address);
            }
        }
    }
}

fn lock(held: &Mutex<HashMap<IpAddr, usize>>) -> MutexGuard<'_, HashMap<IpAddr, usize>> {
    held.lock().unwrap_or_else(PoisonError::into_inner)
}

/// What counts as one address: an IPv6 subscriber has a whole /64 to connect from.
pub fn household(address: IpAddr) -> IpAddr {
    match address.to_canonical() {
        IpAddr::V6(address) => {
            let network = address.to_bits() >> 64 << 64;
            IpAddr::V6(Ipv6Addr::from_bits(network))
        }
        address => address,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    async fn take(places: &Places, address: &str) -> Option<Place> {
        let permit = places.free().await;
        places.take(permit, address.parse().unwrap())
    }

    #[tokio::test]
    async fn one_address_gets_three_quarters_and_the_rest_stays_free() {
        let places = Places::new(8);
        let mut first = Vec::new();
        for _ in 0..6 {
            first.push(take(&places, "192.0.2.1").await.expect("a place"));
        }
        assert!(take(&places, "192.0.2.1").await.is_none());
        assert!(take(&places, "::ffff:192.0.2.1").await.is_none());
        let second = take(&places, "2001:db8::1").await.expect("a place");
        let _third = take(&places, "192.0.2.3").await.expect("a place");
        // All are taken now; one more has to wait.
        assert_eq!(places.all.available_permits(), 0);
        drop(second);
        first.pop();
        assert!(take(&places, "192.0.2.1").await.is_some());
        drop(first);
        assert_eq!(lock(&places.held).len(), 1);
    }

    #[test]
    fn neighbours_in_one_ipv6_network_share() {
        let at = |text: &str| household(text.parse().unwrap());
        assert_eq!(at("2001:db8:0:1::1"), at("2001:db8:0:1:ffff::2"));
        assert_ne!(at("2001:db8:0:1::1"), at("2001:db8:0:2::1"));
        assert_ne!(at("192.0.2.1"), at("192.0.2.2"));
    }
}
