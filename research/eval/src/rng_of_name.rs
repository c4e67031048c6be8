//! Random numbers by name: the same name and number give the same sequence.

use barrelman_vocab::rng::SplitMix64;

/// A generator seeded by a name and a number, such as a clip's name and the index of a sequence.
pub(crate) fn rng_of_name(name: &str, number: u64) -> SplitMix64 {
    let mut generator = SplitMix64::new(number);
    for byte in name.bytes() {
        generator = SplitMix64::new(generator.next_u64() ^ u64::from(byte));
    }
    generator
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_and_numbers_give_different_sequences() {
        let first = |name, number| rng_of_name(name, number).next_u64();
        assert_ne!(first("a", 0), first("b", 0));
        assert_ne!(first("a", 0), first("a", 1));
        assert_eq!(first("a", 1), first("a", 1));
    }
}
