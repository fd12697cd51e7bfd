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
    Candidates = 7,
    Scatter = 16,
}

/// A stream of random numbers.
pub(super) struct Stream(Pcg64);

/// Trials after which a loop that goes on by chance is left; the chance of as many is below 2⁻¹⁰⁰.
const TRIALS: u32 = 512;

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
        self.unit() < probability
    }

    /// A multiple of 2⁻⁵³ from 0 to below 1.
    pub(super) fn unit(&mut self) -> f64 {
        (self.0.next_u64() >> 11) as f64 / (1_u64 << 53) as f64
    }

    /// A number of the normal distribution with mean 0 and standard deviation 1 (Karney 2016,
    /// "Sampling exactly from the normal distribution", algorithm N).
    ///
    /// Drawn are a whole part k with probability in proportion to exp(−k²/2), a fraction x and a sign; then
    /// (k, x) is kept with probability exp(−k·x − x²/2). Every such probability is met by comparing uniform
    /// numbers, so no logarithm or root takes part, whose last bit machines differ in. Some ten uniform
    /// numbers.
    pub(super) fn normal(&mut self) -> f64 {
        for _ in 0..TRIALS {
            let whole = (0..TRIALS).take_while(|_| self.survives(0.5)).count();
            if !(0..whole * whole.saturating_sub(1)).all(|_| self.survives(0.5)) {
                continue;
            }
            let fraction = self.unit();
            if (0..whole).all(|_| self.survives(fraction))
                && self.survives(fraction * fraction / 2.0)
            {
                let size = whole as f64 + fraction;
                return if self.chance(0.5) { -size } else { size };
            }
        }
        0.0
    }

    /// `true` with probability exp(−x), for x from 0 to 1 (von Neumann 1951): the run of uniform numbers
    /// that fall from x on is of even length so often.
    fn survives(&mut self, x: f64) -> bool {
        let mut last = x;
        for length in 0..TRIALS {
            let next = self.unit();
            if next >= last {
                return length % 2 == 0;
            }
            last = next;
        }
        false
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
    fn normal_numbers_are_normal() {
        let mut stream = Stream::new(11, Purpose::Scatter, 0);
        let numbers: Vec<f64> = (0..200_000).map(|_| stream.normal()).collect();
        let mean = |f: fn(f64) -> f64| numbers.iter().map(|x| f(*x)).sum::<f64>() / 200_000.0;
        // Moments 0, 1, 0 and 3, each within five standard errors.
        for (moment, expected, error) in [
            (mean(|x| x), 0.0, 1.0),
            (mean(|x| x * x), 1.0, 1.5),
            (mean(|x| x.powi(3)), 0.0, 4.0),
            (mean(|x| x.powi(4)), 3.0, 10.0),
        ] {
            assert!((moment - expected).abs() < 5.0 * error / 200_000_f64.sqrt());
        }
        // Shares beyond 1, 2 and 3 standard deviations.
        for (limit, share) in [(1.0, 0.317_311), (2.0, 0.045_500), (3.0, 0.002_700)] {
            let beyond = numbers.iter().filter(|x| x.abs() > limit).count() as f64 / 200_000.0;
            let error = f64::sqrt(share * (1.0 - share) / 200_000.0);
            assert!((beyond - share).abs() < 5.0 * error, "{limit} {beyond}");
        }
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
