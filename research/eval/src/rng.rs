//! Pseudorandom deviates from named, seeded sequences: the same name and number give the same sequence.

use barrelman_vocab::rng::SplitMix64;

/// A generator.
#[derive(Debug, Clone)]
pub(crate) struct Rng(SplitMix64);

impl Rng {
    /// A generator seeded by a name and a number, such as a clip's name and the index of a sequence.
    pub(crate) fn from_name(name: &str, number: u64) -> Self {
        let mut generator = SplitMix64::new(number);
        for byte in name.bytes() {
            generator = SplitMix64::new(generator.next_u64() ^ u64::from(byte));
        }
        Self(generator)
    }

    /// A uniform deviate in [low, high).
    pub(crate) fn uniform(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.0.uniform()
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
    fn names_and_numbers_give_different_sequences() {
        let first = |name, number| Rng::from_name(name, number).0.next_u64();
        assert_ne!(first("a", 0), first("b", 0));
        assert_ne!(first("a", 0), first("a", 1));
        assert_eq!(first("a", 1), first("a", 1));
    }

    #[test]
    fn numbers_stay_between_their_limits() {
        let mut rng = Rng(SplitMix64::new(3));
        let numbers: Vec<f64> = (0..1000).map(|_| rng.uniform(-2.0, 2.0)).collect();
        assert!(numbers.iter().all(|number| (-2.0..2.0).contains(number)));
        let mean = numbers.iter().sum::<f64>() / 1000.0;
        // The standard deviation of the mean is 4 / sqrt(12 * 1000) = 0.037.
        assert!(mean.abs() < 0.15, "{mean}");
    }
}
