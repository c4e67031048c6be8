//! Pseudo-random numbers for tests and simulations: SplitMix64 (Steele, Lea and Flood, 2014).
//!
//! Equal seeds give equal numbers on every machine. The numbers are not suitable for cryptography.
//! [`SplitMix64`] is a sequence; [`hash`] gives any number of a stream on its own.

/// The usual increment of the state: an odd multiple of the golden ratio's fractional part.
const GOLDEN: u64 = 0x9e37_79b9_7f4a_7c15;
/// The increment of the state within a stream.
const STREAM_INCREMENT: u64 = 0xd1b5_4a32_d192_ed03;

/// A sequence of 2^64 numbers.
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
    increment: u64,
}

impl SplitMix64 {
    /// The generator of the published sequence of this seed.
    pub const fn new(seed: u64) -> Self {
        Self { state: seed, increment: GOLDEN }
    }

    /// The generator of a stream of this seed: the numbers that [`hash`] gives for the indices from 1 on.
    pub const fn of_stream(seed: u64, stream: u64) -> Self {
        Self { state: start_of_stream(seed, stream), increment: STREAM_INCREMENT }
    }

    /// The next number, uniform over all 64-bit integers.
    #[inline]
    pub const fn next_u64(&mut self) -> u64 {
        self.state = self.state.wrapping_add(self.increment);
        mix(self.state)
    }

    /// The next number, uniform in [0, 1).
    #[inline]
    pub const fn uniform(&mut self) -> f64 {
        to_unit(self.next_u64())
    }

    /// The next number, uniform in [low, high).
    pub const fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.uniform()
    }

    /// An approximately normal number with mean 0 and variance 1: the sum of twelve uniform numbers less 6.
    pub fn approximately_normal(&mut self) -> f64 {
        (0..12).map(|_| self.uniform()).sum::<f64>() - 6.0
    }
}

/// The number of a stream with this index, uniform over all 64-bit integers. Seed, stream and index alone
/// decide about the number, so that numbers can be had in any order.
#[inline]
pub const fn hash(seed: u64, stream: u64, index: u64) -> u64 {
    mix(start_of_stream(seed, stream).wrapping_add(index.wrapping_mul(STREAM_INCREMENT)))
}

/// A number that is uniform in [0, 1), of one that is uniform over all 64-bit integers: its upper 53 bits.
#[inline]
pub const fn to_unit(bits: u64) -> f64 {
    (bits >> 11) as f64 / (1_u64 << 53) as f64
}

const fn start_of_stream(seed: u64, stream: u64) -> u64 {
    seed.wrapping_add(stream.wrapping_mul(GOLDEN))
}

/// The finaliser of SplitMix64.
#[inline]
const fn mix(mut z: u64) -> u64 {
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ (z >> 31)
}
