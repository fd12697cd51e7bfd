//! Random numbers that are the same on every machine, thread count and release.
//!
//! PCG XSL RR 128/64 (rand_pcg's `Pcg64`) with everything drawn from it spelled out here, so that
//! no library's choice of sampling method can change a published result. Streams are split by
//! purpose and index, never by thread.

use rand::Rng;
use rand_pcg::Pcg64;

/// What a stream is used for.
#[derive(Debug, Clone, Copy)]
pub(super) enum Purpose {
    InitialGrasp = 1,
    Population = 2,
    Offspring = 3,
    Climb = 4,
    Local = 5,
    Sample = 6,
}

/// A stream of random numbers.
pub(super) struct Stream(Pcg64);

impl Stream {
    /// The stream of `seed` for one purpose and index, unrelated to all others.
    pub(super) fn new(seed: u64, purpose: Purpose, index: u64) -> Self {
        let mut state = seed;
        let mut next = |salt: u64| {
            state = mix(state ^ salt);
            u128::from(state)
        };
        let high = next(purpose as u64);
        let low = next(index);
        let stream = next(0x9e37_79b9_7f4a_7c15) << 64 | next(0xd1b5_4a32_d192_ed03);
        Self(Pcg64::new(high << 64 | low, stream))
    }

    /// A whole number in `0..n`; `n` must be positive. The bias is below n/2⁶⁴.
    pub(super) fn below(&mut self, n: usize) -> usize {
        let wide = u128::from(self.0.next_u64()) * n as u128;
        (wide >> 64) as usize
    }

    /// `true` with the given probability.
    pub(super) fn chance(&mut self, probability: f64) -> bool {
        let unit = (self.0.next_u64() >> 11) as f64 / (1_u64 << 53) as f64;
        unit < probability
    }

    /// `m` distinct numbers below `n`, ascending, every subset equally likely (Floyd's method).
    pub(super) fn subset(&mut self, n: usize, m: usize) -> Vec<u32> {
        let mut chosen = Vec::with_capacity(m);
        for last in n - m..n {
            let pick = self.below(last + 1) as u32;
            let pick = if chosen.contains(&pick) {
                last as u32
            } else {
                pick
            };
            chosen.push(pick);
        }
        chosen.sort_unstable();
        chosen
    }

    pub(super) fn shuffle<T>(&mut self, items: &mut [T]) {
        for i in (1..items.len()).rev() {
            items.swap(i, self.below(i + 1));
        }
    }
}

/// SplitMix64's finaliser: a bijection in which every input bit reaches every output bit.
fn mix(value: u64) -> u64 {
    let mut z = value.wrapping_add(0x9e37_79b9_7f4a_7c15);
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ (z >> 31)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn streams_differ_by_seed_purpose_and_index_and_repeat() {
        let first = |seed, purpose, index| Stream::new(seed, purpose, index).0.next_u64();
        let base = first(1, Purpose::Population, 0);
        assert_eq!(base, first(1, Purpose::Population, 0));
        assert_ne!(base, first(2, Purpose::Population, 0));
        assert_ne!(base, first(1, Purpose::Offspring, 0));
        assert_ne!(base, first(1, Purpose::Population, 1));
    }

    #[test]
    fn the_numbers_of_a_seed_never_change() {
        let mut stream = Stream::new(7, Purpose::InitialGrasp, 0);
        assert_eq!(stream.subset(1000, 5), [342, 816, 840, 892, 951]);
    }

    #[test]
    fn subsets_are_distinct_ascending_and_even() {
        let mut stream = Stream::new(3, Purpose::Population, 0);
        let mut counts = [0_u32; 10];
        for _ in 0..10_000 {
            let subset = stream.subset(10, 3);
            assert!(subset.windows(2).all(|w| w[0] < w[1]));
            subset.iter().for_each(|&i| counts[i as usize] += 1);
        }
        assert!(
            counts.iter().all(|c| (2800..3200).contains(c)),
            "{counts:?}"
        );
        assert_eq!(stream.subset(4, 4), [0, 1, 2, 3]);
    }
}
