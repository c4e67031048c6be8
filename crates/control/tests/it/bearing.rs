//! The bearing filter: consistency of its variance, and its behaviour in special cases.

use barrelman_control::{BearingFilter, BearingNoise};
use barrelman_vocab::Timestamp;
use barrelman_vocab::rng::SplitMix64;

const NOISE: BearingNoise = BearingNoise {
    rate_std_dev: 0.14,
    rate_time_constant_s: 1.1,
    measurement_std_dev: 0.004,
    max_sway_std_dev: 0.0,
    sway_time_constant_s: 2.0,
};

/// A normally distributed random number (Box-Muller).
fn gauss(rng: &mut SplitMix64) -> f64 {
    // In (0, 1], so that the logarithm is finite.
    let mut unit = || 1.0 - rng.uniform();
    libm::sqrt(-2.0 * libm::log(unit())) * libm::cos(core::f64::consts::TAU * unit())
}

fn direction_at(azimuth: f64, elevation: f64) -> [f64; 3] {
    let (sin_a, cos_a) = libm::sincos(azimuth);
    let (sin_e, cos_e) = libm::sincos(elevation);
    [cos_e * sin_a, cos_e * cos_a, sin_e]
}

/// Mean squared error of the predicted azimuth, divided by the filter's variance. The target is near the
/// horizon, its rate and sway match the filter's noise parameters, and a share of the pictures, `step_s`
/// apart, shows it.
fn normalised_error(noise: BearingNoise, sway: f64, step_s: f64, seen_share: f64) -> f64 {
    const FINE: usize = 8;
    let mut rng = SplitMix64::new(7);
    let mut filter = BearingFilter::new(noise);
    let (mut angle, mut rate) = (0.0, 0.0);
    let mut swung = [0.0; 2];
    let (mut sum, mut count) = (0.0, 0.0);
    for k in 1..40_000_u64 {
        for _ in 0..FINE {
            let dt = step_s / FINE as f64;
            let decay = libm::exp(-dt / NOISE.rate_time_constant_s);
            angle += dt * rate;
            rate = decay * rate + NOISE.rate_std_dev * libm::sqrt(1.0 - decay * decay) * gauss(&mut rng);
            let decay = libm::exp(-dt / noise.sway_time_constant_s);
            for swung in &mut swung {
                *swung = decay * *swung + sway * libm::sqrt(1.0 - decay * decay) * gauss(&mut rng);
            }
        }
        let now = Timestamp::from_secs_f64(k as f64 * step_s);
        if let Some((last, bearing)) = filter.estimate().copied().filter(|_| k > 300) {
            let expected = filter.predict(&bearing, now.since(last).as_secs_f64());
            let [across, along, _] = expected.apparent_direction();
            let azimuth = libm::atan2(across, along);
            let off = libm::remainder(azimuth - angle - swung[0], core::f64::consts::TAU);
            sum += off * off / expected.variance();
            count += 1.0;
        }
        let shown = (gauss(&mut rng) > 0.0) || seen_share >= 1.0;
        if shown {
            let off = [0, 1].map(|k| swung[k] + noise.measurement_std_dev * gauss(&mut rng));
            let measured = direction_at(angle + off[0], off[1]);
            filter.update(measured, now);
        }
    }
    sum / count
}

#[test]
fn its_variance_is_honest_at_any_rate_of_pictures_and_through_gaps() {
    for (step_s, seen_share) in [(1.0 / 60.0, 1.0), (1.0 / 30.0, 1.0), (0.1, 1.0), (1.0 / 30.0, 0.5)] {
        let normalised_error = normalised_error(NOISE, 0.0, step_s, seen_share);
        assert!(
            (0.85..1.15).contains(&normalised_error),
            "every {step_s} s, seen {seen_share}: {normalised_error}"
        );
    }
}

#[test]
fn the_same_picture_again_tells_nothing() {
    let mut filter = BearingFilter::new(NOISE);
    let at = Timestamp::from_secs_f64(1.0);
    filter.update(direction_at(0.1, -0.4), at);
    let before = filter.estimate().copied();
    filter.update(direction_at(0.3, -0.4), at);
    filter.update(direction_at(0.3, -0.4), Timestamp::from_secs_f64(0.9));
    filter.update([f64::NAN; 3], Timestamp::from_secs_f64(1.1));
    assert_eq!(filter.estimate().copied(), before);
}

#[test]
fn a_target_may_pass_right_below() {
    let mut filter = BearingFilter::new(NOISE);
    // From ahead at 60 degrees below the horizon through the vertical to behind, at 0.15 rad/s.
    for k in 0..300 {
        let t = f64::from(k) / 30.0;
        let down = 1.05 + 0.15 * t;
        filter.update(direction_at(0.0, -down), Timestamp::from_secs_f64(t));
        if k > 60 {
            let (_, bearing) = filter.estimate().unwrap();
            assert!((bearing.angular_speed() - 0.15).abs() < 0.01, "at {t} s: {}", bearing.angular_speed());
        }
    }
}

#[test]
fn it_learns_how_much_the_kite_sways() {
    let noise = BearingNoise { max_sway_std_dev: 0.12, ..NOISE };
    for sway in [0.0, 0.02, 0.06] {
        let normalised_error = normalised_error(noise, sway, 1.0 / 30.0, 1.0);
        assert!((0.85..1.25).contains(&normalised_error), "a sway of {sway} rad: {normalised_error}");
    }
}

#[test]
fn sway_is_hardly_taken_for_the_targets_own_motion() {
    let noise = BearingNoise { max_sway_std_dev: 0.12, ..NOISE };
    let speed = |noise: BearingNoise| {
        let mut filter = BearingFilter::new(noise);
        let (mut rng, mut swung, mut sum) = (SplitMix64::new(3), [0.0; 2], 0.0);
        for k in 0..3000_u64 {
            let decay = libm::exp(-1.0 / 30.0 / noise.sway_time_constant_s);
            for swung in &mut swung {
                *swung = decay * *swung + 0.06 * libm::sqrt(1.0 - decay * decay) * gauss(&mut rng);
            }
            filter.update(direction_at(swung[0], swung[1] - 0.4), Timestamp::from_secs_f64(k as f64 / 30.0));
            if k > 300 {
                sum += filter.estimate().unwrap().1.angular_speed();
            }
        }
        sum / 2700.0
    };
    let (with_sway, without_sway) = (speed(noise), speed(NOISE));
    assert!(
        with_sway < 0.5 * without_sway,
        "speed of a resting target: {with_sway} rad/s, without a sway model {without_sway}"
    );
}
