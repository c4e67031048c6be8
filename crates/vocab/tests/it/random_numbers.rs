//! The pseudo-random generator against published numbers.

use barrelman_vocab::rng::{SplitMix64, hash};

#[test]
fn the_sequence_is_that_of_the_reference_program() {
    // The output of Vigna's reference program (splitmix64.c) for the seed 1234567.
    let mut rng = SplitMix64::new(1_234_567);
    let expected = [
        6_457_827_717_110_365_317,
        3_203_168_211_198_807_973,
        9_817_491_932_198_370_423,
        4_593_380_528_125_082_431,
        16_408_922_859_458_223_821,
    ];
    for number in expected {
        assert_eq!(rng.next_u64(), number);
    }
}

#[test]
fn uniform_numbers_lie_in_the_unit_interval_and_average_to_its_middle() {
    let mut rng = SplitMix64::new(3);
    let mut sum = 0.0;
    for _ in 0..10_000 {
        let number = rng.uniform();
        assert!((0.0..1.0).contains(&number), "{number}");
        sum += number;
    }
    // Standard deviation of the mean: 1/sqrt(12 * 10,000) = 0.0029.
    assert!((sum / 10_000.0 - 0.5).abs() < 0.01, "{sum}");
}

#[test]
fn numbers_between_two_bounds_average_to_their_middle() {
    let mut rng = SplitMix64::new(3);
    let numbers: Vec<f64> = (0..1000).map(|_| rng.between(-2.0, 2.0)).collect();
    assert!(numbers.iter().all(|number| (-2.0..2.0).contains(number)));
    let mean = numbers.iter().sum::<f64>() / 1000.0;
    // The standard deviation of the mean is 4 / sqrt(12 * 1000) = 0.037.
    assert!(mean.abs() < 0.15, "{mean}");
}

#[test]
fn a_stream_is_the_hash_of_its_indices() {
    let mut rng = SplitMix64::of_stream(7, 3);
    for index in 1..100 {
        assert_eq!(rng.next_u64(), hash(7, 3, index));
    }
    assert_ne!(hash(7, 3, 1), hash(7, 4, 1));
}
