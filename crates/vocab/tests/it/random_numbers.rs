//! The pseudo-random generator against published numbers.

use barrelman_vocab::rng::SplitMix64;

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
