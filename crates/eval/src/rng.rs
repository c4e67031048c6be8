//! A seeded pseudorandom generator: the same name and number give the same sequence.

/// SplitMix64: Steele, Lea and Flood, Fast splittable pseudorandom number generators (2014).
#[derive(Debug, Clone)]
pub(crate) struct Rng(u64);

impl Rng {
    /// A generator seeded by a name and a number, such as a clip's name and the index of a sequence.
    pub(crate) fn from_name(name: &str, number: u64) -> Self {
        let mut rng = Self(number);
        for byte in name.bytes() {
            rng.0 = rng.next_u64() ^ u64::from(byte);
        }
        rng
    }

    fn next_u64(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        z ^ (z >> 31)
    }

    /// A uniform deviate in [low, high).
    pub(crate) fn uniform(&mut self, low: f64, high: f64) -> f64 {
        // 53 bits fill the mantissa: 0 inclusive to 1 exclusive.
        let unit = (self.next_u64() >> 11) as f64 / (1_u64 << 53) as f64;
        low + (high - low) * unit
    }

    /// An approximately normal deviate with mean 0 and variance 1: the sum of twelve uniform deviates less 6.
    pub(crate) fn approximately_normal(&mut self) -> f64 {
        (0..12).map(|_| self.uniform(0.0, 1.0)).sum::<f64>() - 6.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_seed_gives_the_published_numbers() {
        let mut rng = Rng(1_234_567);
        // From the reference implementation by Vigna.
        assert_eq!([rng.next_u64(), rng.next_u64()], [6_457_827_717_110_365_317, 3_203_168_211_198_807_973]);
    }

    #[test]
    fn names_and_numbers_give_different_sequences() {
        let first = |name, number| Rng::from_name(name, number).next_u64();
        assert_ne!(first("a", 0), first("b", 0));
        assert_ne!(first("a", 0), first("a", 1));
        assert_eq!(first("a", 1), first("a", 1));
    }

    #[test]
    fn numbers_stay_between_their_limits() {
        let mut rng = Rng(3);
        let numbers: Vec<f64> = (0..1000).map(|_| rng.uniform(-2.0, 2.0)).collect();
        assert!(numbers.iter().all(|number| (-2.0..2.0).contains(number)));
        let mean = numbers.iter().sum::<f64>() / 1000.0;
        // The standard deviation of the mean is 4 / sqrt(12 * 1000) = 0.037.
        assert!(mean.abs() < 0.15, "{mean}");
    }
}
