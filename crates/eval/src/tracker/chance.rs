//! Chance that can be repeated: numbers that follow from a seed.

/// Steele, Lea and Flood's SplitMix64 (Fast splittable pseudorandom number generators, 2014).
#[derive(Debug, Clone)]
pub(crate) struct Chance(u64);

impl Chance {
    /// The numbers of this name and number.
    pub(crate) fn named(name: &str, number: u64) -> Self {
        let mut chance = Self(number);
        for byte in name.bytes() {
            chance.0 = chance.next() ^ u64::from(byte);
        }
        chance
    }

    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        z ^ (z >> 31)
    }

    /// A number between these two, all equally likely.
    pub(crate) fn between(&mut self, low: f64, high: f64) -> f64 {
        // 53 bits fill the mantissa: 0 inclusive to 1 exclusive.
        let unit = (self.next() >> 11) as f64 / (1_u64 << 53) as f64;
        low + (high - low) * unit
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_seed_gives_the_published_numbers() {
        let mut chance = Chance(1_234_567);
        // From the reference implementation by Vigna.
        assert_eq!([chance.next(), chance.next()], [6_457_827_717_110_365_317, 3_203_168_211_198_807_973]);
    }

    #[test]
    fn names_and_numbers_give_different_chances() {
        let first = |name, number| Chance::named(name, number).next();
        assert_ne!(first("a", 0), first("b", 0));
        assert_ne!(first("a", 0), first("a", 1));
        assert_eq!(first("a", 1), first("a", 1));
    }

    #[test]
    fn numbers_stay_between_their_limits() {
        let mut chance = Chance(3);
        let numbers: Vec<f64> = (0..1000).map(|_| chance.between(-2.0, 2.0)).collect();
        assert!(numbers.iter().all(|number| (-2.0..2.0).contains(number)));
        let mean = numbers.iter().sum::<f64>() / 1000.0;
        // The standard deviation of the mean is 4 / sqrt(12 * 1000) = 0.037.
        assert!(mean.abs() < 0.15, "{mean}");
    }
}
