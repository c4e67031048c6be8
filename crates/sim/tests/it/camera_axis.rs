//! Dead times, lag and end stops of a camera axis.

use barrelman_sim::tick::{TICK_S, TICKS_PER_SECOND};
use barrelman_sim::{AxisPlant, CameraAxis};
use barrelman_vocab::{Angle, AngularRate};

fn plant() -> AxisPlant {
    AxisPlant {
        start_dead_time_s: 0.25,
        stop_dead_time_s: 0.5,
        lag_s: 0.1,
        max_rate: AngularRate::from_radians_per_second(0.3),
        end_stops: Some((Angle::from_radians(-0.5), Angle::from_radians(0.5))),
        imperfections: barrelman_sim::camera_axis::AxisImperfections::default(),
    }
}

fn rate(rad_per_s: f64) -> AngularRate {
    AngularRate::from_radians_per_second(rad_per_s)
}

/// Runs an axis through commands (seconds, rad/s) up to `until_s` and returns it.
fn run(commands: &[(f64, f64)], until_s: f64) -> CameraAxis {
    let mut axis = CameraAxis::at_rest(plant(), Angle::ZERO);
    for tick in 0..(until_s * f64::from(TICKS_PER_SECOND)) as u64 {
        for (_, value) in commands.iter().filter(|(at, _)| (at / TICK_S).round() as u64 == tick) {
            axis.command(rate(*value), tick);
        }
        axis.advance(tick);
    }
    axis
}

#[test]
fn nothing_moves_before_the_dead_time_is_over() {
    assert!(run(&[(0.0, 0.2)], 0.25).rate().is_zero());
    assert!(run(&[(0.0, 0.2)], 0.30).rate().radians_per_second() > 0.05);
}

#[test]
fn the_rate_follows_with_its_lag() {
    // One time constant after the dead time: 63.2 % of the way.
    let after_one_lag = run(&[(0.0, 0.2)], 0.25 + 0.1).rate().radians_per_second();
    assert!((after_one_lag / 0.2 - 0.632).abs() < 0.02, "{after_one_lag}");
}

#[test]
fn a_stop_has_a_dead_time_of_its_own() {
    let just_before = run(&[(0.0, 0.2), (1.0, 0.0)], 1.49).rate().radians_per_second();
    assert!((just_before - 0.2).abs() < 0.001, "{just_before}");
    let after = run(&[(0.0, 0.2), (1.0, 0.0)], 2.1).rate().radians_per_second();
    assert!(after < 0.002, "{after}");
}

#[test]
fn a_later_command_overrules_one_that_has_not_taken_effect() {
    // The stop would take effect at 1.5 s, the new start already at 1.35 s.
    let rate = run(&[(0.0, 0.2), (1.0, 0.0), (1.1, -0.2)], 2.5).rate().radians_per_second();
    assert!((rate + 0.2).abs() < 0.002, "{rate}");
}

#[test]
fn the_limit_and_the_end_stop_hold() {
    let moving = run(&[(0.0, 5.0)], 1.0);
    assert!((moving.rate().radians_per_second() - 0.3).abs() < 0.001);
    let stopped = run(&[(0.0, 5.0)], 4.0);
    assert_eq!((stopped.angle().radians(), stopped.rate().radians_per_second()), (0.5, 0.0));
}
