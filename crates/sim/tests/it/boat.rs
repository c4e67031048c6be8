//! The boat against the table its parameters come from, and the limits of a jet.

use barrelman_sim::boat::{HelmCommand, JetBoat, Steering, throttle_for_speed};
use barrelman_sim::sea::{Sea, SeaState, Wind};
use barrelman_vocab::Angle;

const TICKS_PER_S: u64 = 120;

fn glassy() -> Sea {
    let wind = Wind { speed_mps: 0.0, towards: Angle::ZERO };
    Sea::new(SeaState::new(0).expect("a state"), wind, 1)
}

/// Speed ahead (mean over the last 5 s) and turn rate after 40 s with this throttle. `rudder: None` holds the
/// course.
fn steady(throttle: f64, rudder: Option<f64>) -> (f64, f64) {
    let sea = glassy();
    let mut boat = JetBoat::at_rest((0.0, 0.0), Angle::ZERO);
    let (mut speed, mut turn) = (0.0, 0.0);
    for tick in 0..40 * TICKS_PER_S {
        let held = -3.0 * boat.pose().heading.radians() - 0.8 * boat.turn_rad_per_s();
        let rudder = rudder.unwrap_or(held.clamp(-1.0, 1.0));
        boat.advance(HelmCommand { throttle, rudder }, &sea, (0.0, 0.0), tick);
        if tick >= 35 * TICKS_PER_S {
            speed += boat.speed_ahead_mps() / (5 * TICKS_PER_S) as f64;
            turn += boat.turn_rad_per_s() / (5 * TICKS_PER_S) as f64;
        }
    }
    (speed, turn)
}

#[test]
fn straight_ahead_it_reaches_the_speeds_of_the_table() {
    for (throttle, expected) in
        [(0.15, 0.35), (0.25, 0.76), (0.40, 1.41), (0.60, 2.29), (0.80, 4.12), (1.0, 9.05)]
    {
        let (speed, turn) = steady(throttle, None);
        // Small waves move the boat to and fro. The table has 9.54 m/s at full throttle without air drag,
        // which is 1.5 N there.
        assert!(
            (speed - expected).abs() < 0.03 + 0.04 * expected,
            "{throttle}: {speed}, expected {expected}"
        );
        assert!(turn.abs() < 0.01, "{throttle}: {turn}");
    }
}

#[test]
fn with_the_nozzle_hard_over_it_turns_as_the_table_says() {
    for (throttle, speed, turn) in
        [(0.25, 0.58, 0.26), (0.40, 0.93, 0.54), (0.60, 1.26, 0.96), (1.0, 1.70, 1.85)]
    {
        let (found_speed, found_turn) = steady(throttle, Some(1.0));
        assert!(
            (found_turn - turn).abs() < 0.07 * turn + 0.02,
            "{throttle}: {found_turn} rad/s, expected {turn}"
        );
        // The table gives the speed over ground, which is partly sideways.
        assert!(
            found_speed < speed + 0.05 && found_speed > 0.8 * speed,
            "{throttle}: {found_speed}, {speed}"
        );
    }
}

#[test]
fn a_boat_that_coasts_does_not_answer_its_helm() {
    let sea = glassy();
    let mut boat = JetBoat::at_rest((0.0, 0.0), Angle::ZERO);
    for tick in 0..10 * TICKS_PER_S {
        boat.advance(HelmCommand { throttle: 0.4, rudder: 0.0 }, &sea, (0.0, 0.0), tick);
    }
    let before = boat.pose().heading.radians();
    for tick in 10 * TICKS_PER_S..13 * TICKS_PER_S {
        boat.advance(HelmCommand { throttle: 0.0, rudder: 1.0 }, &sea, (0.0, 0.0), tick);
    }
    let turned = boat.pose().heading.radians() - before;
    // The jet still pushes for a quarter of a second while the throttle closes.
    assert!(turned.abs() < 0.12, "{turned} rad");
    assert!(boat.speed_ahead_mps() > 0.3, "it still runs: {}", boat.speed_ahead_mps());
}

#[test]
fn astern_it_goes_backwards() {
    let (speed, _) = steady(-1.0, Some(0.0));
    assert!((-3.0..-0.8).contains(&speed), "{speed}");
}

#[test]
fn the_throttle_for_a_speed_gives_that_speed() {
    for speed in [0.5, 1.0, 1.9, 4.0] {
        let (found, _) = steady(throttle_for_speed(speed), None);
        assert!((found - speed).abs() < 0.03 + 0.04 * speed, "{speed}: {found}");
    }
}

#[test]
fn it_rides_rougher_seas_more_than_smooth_ones() {
    let rms = |state: u8| {
        let sea = SeaState::new(state).expect("a state");
        let sea = Sea::new(sea, Wind { speed_mps: sea.wind_mps(), towards: Angle::ZERO }, 3);
        let mut boat = JetBoat::at_rest((0.0, 0.0), Angle::from_degrees(180.0));
        let (mut heave, mut pitch, ticks) = (0.0, 0.0, 120 * TICKS_PER_S);
        for tick in 0..ticks {
            boat.advance(HelmCommand::default(), &sea, (0.0, 0.0), tick);
            let pose = boat.pose();
            heave += pose.position.z * pose.position.z / ticks as f64;
            pitch += pose.pitch.degrees() * pose.pitch.degrees() / ticks as f64;
        }
        (heave.sqrt(), pitch.sqrt())
    };
    let all: Vec<(f64, f64)> = (0..=4).map(rms).collect();
    for pair in all.windows(2) {
        assert!(pair[1].0 > pair[0].0, "{all:?}");
    }
    let (heave, pitch) = all[3];
    assert!((0.12..0.33).contains(&heave), "the table has 0.22 m in state 3: {heave}");
    assert!((2.5..9.0).contains(&pitch), "the table has 5.1 degrees: {pitch}");
}

/// Change of the heading, radians, of a boat that had way on, in four seconds without thrust and with full
/// rudder.
fn turned_while_coasting(steering: Steering) -> f64 {
    let sea = glassy();
    let mut boat = JetBoat::at_rest((0.0, 0.0), Angle::ZERO).with_steering(steering);
    for tick in 0..10 * TICKS_PER_S {
        let rudder = -3.0 * boat.pose().heading.radians() - 0.8 * boat.turn_rad_per_s();
        boat.advance(HelmCommand { throttle: 0.5, rudder }, &sea, (0.0, 0.0), tick);
    }
    // The thrust has gone before the rudder is laid.
    for tick in 10 * TICKS_PER_S..12 * TICKS_PER_S {
        boat.advance(HelmCommand::default(), &sea, (0.0, 0.0), tick);
    }
    let before = boat.pose().heading.radians();
    for tick in 12 * TICKS_PER_S..16 * TICKS_PER_S {
        boat.advance(HelmCommand { throttle: 0.0, rudder: 1.0 }, &sea, (0.0, 0.0), tick);
    }
    boat.pose().heading.radians() - before
}

#[test]
fn a_rudder_steers_a_coasting_boat_and_a_jet_does_not() {
    let (jet, rudder) = (turned_while_coasting(Steering::Jet), turned_while_coasting(Steering::JetAndRudder));
    assert!(jet.abs() < 0.1, "the jet alone turned the boat by {jet} rad");
    assert!(rudder > 0.3, "the rudder turned the boat by {rudder} rad only");
}

#[test]
fn a_current_carries_a_boat_at_rest() {
    let current = (0.35, -0.2);
    let sea = glassy().with_current(current);
    let mut boat = JetBoat::at_rest((0.0, 0.0), Angle::from_degrees(30.0));
    for tick in 0..60 * TICKS_PER_S {
        boat.advance(HelmCommand::default(), &sea, (0.0, 0.0), tick);
    }
    let (x, y) = boat.velocity_over_ground();
    assert!((x - current.0).abs() < 0.05 && (y - current.1).abs() < 0.05, "{x}, {y}");
}
