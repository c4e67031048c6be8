//! The kite in the wind, and the wind itself.

use barrelman_sim::kite::Kite;
use barrelman_sim::sea::Wind;
use barrelman_sim::wind::TurbulentWind;
use barrelman_vocab::Angle;

const TICKS: u64 = 120 * 1200;

#[test]
fn turbulence_has_the_deviation_of_its_model() {
    let mean = Wind { speed_mps: 5.0, towards: Angle::ZERO };
    let (mut along, mut up) = (0.0, 0.0);
    // The time constant is 13 s; the mean is over ten winds of 20 minutes.
    for seed in 0..10 {
        let mut wind = TurbulentWind::new(mean, 10.0, 0.0, seed);
        for tick in 0..TICKS {
            wind.advance(tick);
            let (x, _, z) = wind.turbulence();
            along += x * x / (10 * TICKS) as f64;
            up += z * z / (10 * TICKS) as f64;
        }
    }
    let (along, up) = (along.sqrt(), up.sqrt());
    assert!((0.85..1.05).contains(&along), "0.94 m/s at 10 m in 5 m/s: {along}");
    assert!((0.45..0.55).contains(&up), "0.5 m/s: {up}");
}

#[test]
fn the_kite_sways_by_two_decimetres_in_a_wind_of_5_mps_and_not_at_all_in_none() {
    let sway = |speed_mps: f64, gustiness: f64| {
        let mean = Wind { speed_mps, towards: Angle::from_degrees(30.0) };
        let wind = TurbulentWind::new(mean, 10.0, gustiness, 5);
        let mut kite = Kite::new(10.0, wind, mean.towards, 5);
        let mut square = 0.0;
        for tick in 0..TICKS {
            kite.advance(tick, false);
            let off = kite.displacement();
            square += off.dot(off) / TICKS as f64;
        }
        square.sqrt()
    };
    assert_eq!(sway(0.0, 1.0), 0.0);
    let usual = sway(5.0, 0.0);
    assert!((0.12..0.40).contains(&usual), "{usual} m");
    assert!(sway(5.0, 2.0) > usual, "gusts throw it about");
}

#[test]
fn a_commanded_yaw_drifts_and_a_resting_one_only_wanders() {
    let drift = |commanded: bool| {
        let mean = Wind { speed_mps: 0.0, towards: Angle::ZERO };
        let mut kite = Kite::new(10.0, TurbulentWind::new(mean, 10.0, 0.0, 2), mean.towards, 2);
        for tick in 0..120 * 60 {
            kite.advance(tick, commanded);
        }
        kite.attitude_offset(Angle::ZERO).0.degrees()
    };
    let off = (drift(true) - drift(false)).abs();
    assert!((off - 12.0).abs() < 0.1, "0.2 degrees per second for a minute: {off}");
}

#[test]
fn a_gust_blows_on_where_the_count_of_ticks_begins_anew() {
    let mean = Wind { speed_mps: 8.0, towards: Angle::ZERO };
    for seed in 0..200 {
        let mut wind = TurbulentWind::new(mean, 5.5, 1.0, seed);
        let mut before = None;
        // As when a kite settles before a trial: high tick numbers first, then those of the trial.
        for tick in (1 << 40..(1 << 40) + 1200).chain(0..600) {
            wind.advance(tick);
            let (along, ..) = wind.turbulence();
            if let Some(before) = before.replace(along) {
                let step: f64 = along - before;
                assert!(step.abs() < 1.0, "seed {seed}, tick {tick}: the wind leaps by {step} m/s");
            }
        }
    }
}
