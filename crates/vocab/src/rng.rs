//! A small pseudo-random generator for tests and simulations: SplitMix64 (Steele, Lea and Flood, 2014).
//!
//! Equal seeds give equal sequences on every machine. The generator is not suitable for cryptography.

/// SplitMix64 with a state of 64 bits. Every seed gives a full period of 2^64 numbers.
///
/// ```
/// use barrelman_vocab::rng::SplitMix64;
///
/// let mut rng = SplitMix64::new(1);
/// let share = rng.uniform();
/// assert!((0.0..1.0).contains(&share));
/// assert_eq!(SplitMix64::new(1).uniform(), share);
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct SplitMix64 {
    state: u64,
}

impl SplitMix64 {
    /// A generator with this seed.
    pub const fn new(seed: u64) -> Self {
        Self { state: seed }
    }

    /// The next number, uniform over all 64-bit integers.
    pub const fn next_u64(&mut self) -> u64 {
        self.state = self.state.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.state;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    /// The next number, uniform in [0, 1): the upper 53 bits of [`Self::next_u64`].
    pub const fn uniform(&mut self) -> f64 {
        (self.next_u64() >> 11) as f64 / (1_u64 << 53) as f64
    }
}
