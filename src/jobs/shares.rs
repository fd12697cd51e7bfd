//! Places that owners share.

use std::collections::HashMap;
use std::sync::{Arc, Mutex, PoisonError};

use crate::store::Owner;

/// A number of places, of which no owner of a key may have more than half, so that none keeps out the others.
#[derive(Debug, Clone)]
pub struct Shares {
    places: usize,
    taken: Arc<Mutex<HashMap<Owner, usize>>>,
}

/// One place, free again once it is dropped.
#[derive(Debug)]
pub struct Place {
    owner: Owner,
    shares: Shares,
}

impl Shares {
    pub fn new(places: usize) -> Self {
        Self {
            places,
            taken: Arc::default(),
        }
    }

    /// A place for an owner, if there is one.
    pub fn take(&self, owner: &Owner) -> Option<Place> {
        let mut taken = self.taken.lock().unwrap_or_else(PoisonError::into_inner);
        let own = taken.get(owner).copied().unwrap_or_default();
        let most = match owner.is_anonymous() {
            true => self.places,
            false => self.places.div_ceil(2),
        };
        if own >= most || taken.values().sum::<usize>() >= self.places {
            return None;
        }
        taken.insert(owner.clone(), own + 1);
        Some(Place {
            owner: owner.clone(),
            shares: self.clone(),
        })
    }
}

impl Drop for Place {
    fn drop(&mut self) {
        let taken = &self.shares.taken;
        let mut taken = taken.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(own) = taken.get_mut(&self.owner) {
            *own -= 1;
            if *own == 0 {
                taken.remove(&self.owner);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_owner_keeps_out_the_others() {
        let shares = Shares::new(4);
        let (a, b) = (Owner::of_key("a"), Owner::of_key("b"));
        let mut of_a: Vec<_> = (0..2).map(|_| shares.take(&a).unwrap()).collect();
        assert!(shares.take(&a).is_none());
        let of_b: Vec<_> = (0..2).map(|_| shares.take(&b).unwrap()).collect();
        assert!(shares.take(&Owner::of_key("c")).is_none());
        of_a.pop();
        assert!(shares.take(&a).is_some());
        drop((of_a, of_b));
        let all: Vec<_> = (0..4)
            .map(|_| shares.take(&Owner::ANONYMOUS).unwrap())
            .collect();
        assert!(shares.take(&Owner::ANONYMOUS).is_none());
        drop(all);
        assert!(shares.taken.lock().unwrap().is_empty());
    }
}
