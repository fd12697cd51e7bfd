//! Permits of which no owner can take them all.

use std::collections::HashMap;
use std::sync::Arc;

use parking_lot::Mutex;

use crate::store::Owner;

/// A number of permits. No key may hold more than half of them, so that nobody keeps out the others.
#[derive(Debug, Clone)]
pub struct OwnerLimits {
    permits: usize,
    held: Arc<Mutex<HashMap<Owner, usize>>>,
}

/// A permit, free again when it is dropped.
#[derive(Debug)]
pub struct Permit {
    owner: Owner,
    limits: OwnerLimits,
}

impl OwnerLimits {
    /// All permits are free.
    pub fn new(permits: usize) -> Self {
        Self {
            permits,
            held: Arc::default(),
        }
    }

    /// Returns a permit for an owner, if there is one.
    pub fn acquire(&self, owner: &Owner) -> Option<Permit> {
        let mut held = self.held.lock();
        let own = held.get(owner).copied().unwrap_or_default();
        let most = match owner.is_anonymous() {
            true => self.permits,
            false => self.permits.div_ceil(2),
        };
        if own >= most || held.values().sum::<usize>() >= self.permits {
            return None;
        }
        held.insert(owner.clone(), own + 1);
        Some(Permit {
            owner: owner.clone(),
            limits: self.clone(),
        })
    }
}

impl Drop for Permit {
    fn drop(&mut self) {
        let held = &self.limits.held;
        let mut held = held.lock();
        if let Some(own) = held.get_mut(&self.owner) {
            *own -= 1;
            if *own == 0 {
                held.remove(&self.owner);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_owner_keeps_out_the_others() {
        let limits = OwnerLimits::new(4);
        let (a, b) = (Owner::of_key("a"), Owner::of_key("b"));
        let mut of_a: Vec<_> = (0..2).map(|_| limits.acquire(&a).unwrap()).collect();
        assert!(limits.acquire(&a).is_none());
        let of_b: Vec<_> = (0..2).map(|_| limits.acquire(&b).unwrap()).collect();
        assert!(limits.acquire(&Owner::of_key("c")).is_none());
        of_a.pop();
        assert!(limits.acquire(&a).is_some());
        drop((of_a, of_b));
        let all: Vec<_> = (0..4)
            .map(|_| limits.acquire(&Owner::ANONYMOUS).unwrap())
            .collect();
        assert!(limits.acquire(&Owner::ANONYMOUS).is_none());
        drop(all);
        assert!(limits.held.lock().is_empty());
    }
}
