//! Decisions that a seed repeats.

/// A generator of random numbers (Steele, Lea & Flood 2014).
#[derive(Debug, Clone)]
pub struct SplitMix64(u64);

impl SplitMix64 {
    pub fn new(seed: u64) -> Self {
        Self(seed)
    }

    /// Seeded with `GRASPD_CHAOS_SEED`, or else with the clock; prints the seed.
    pub fn seeded() -> Self {
        let clock = std::time::UNIX_EPOCH.elapsed().expect("a clock past 1970");
        let seed = crate::environment::number("GRASPD_CHAOS_SEED", clock.as_nanos() as u64);
        println!("GRASPD_CHAOS_SEED={seed}");
        Self(seed)
    }

    pub fn next_u64(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    /// A number below `end`.
    pub fn below(&mut self, end: usize) -> usize {
        (self.next_u64() % end as u64) as usize
    }
}
