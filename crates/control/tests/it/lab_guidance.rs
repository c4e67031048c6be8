//! The laboratory's guidance law, against a table of its published rules.

use barrelman_control::guidance::{LabBranch, LabInput, LabLaw, LabSettings};
use barrelman_vocab::{PixelPoint, Timestamp, VesselCommand};

const STEP_NS: u64 = 133_333_334;

/// A law whose boat has come to (600, 300) on a straight course, degrees clockwise from image right, in 50
/// positions of 2 px each.
fn law_on_course(settings: LabSettings, course_deg: f64) -> (LabLaw, u64) {
    let mut law = LabLaw::new(settings);
    let (sin, cos) = libm::sincos(course_deg.to_radians());
    for step in 0..49_u64 {
        let back = 2.0 * (49 - step) as f64;
        let boat = PixelPoint { u: 600.0 - back * cos, v: 300.0 - back * sin };
        // A target far away, so that no step ends at it.
        step_at(&mut law, step, boat, PixelPoint { u: 6000.0, v: 300.0 });
    }
    (law, 49)
}

fn step_at(law: &mut LabLaw, step: u64, boat: PixelPoint, target: PixelPoint) -> (VesselCommand, LabBranch) {
    let now = Timestamp::from_nanos(step * STEP_NS);
    law.step(&LabInput { now, boat: Some(boat), target: Some(target) })
}

/// The step at (600, 300) on a course, with a target at a bearing (degrees clockwise from image right) and a
/// distance.
fn check(
    settings: LabSettings,
    (course_deg, bearing_deg, distance_px): (f64, f64, f64),
    (throttle, rudder): (f64, f64),
    branch: LabBranch,
) {
    let (mut law, step) = law_on_course(settings, course_deg);
    let (sin, cos) = libm::sincos(bearing_deg.to_radians());
    let target = PixelPoint { u: 600.0 + distance_px * cos, v: 300.0 + distance_px * sin };
    let (command, found) = step_at(&mut law, step, PixelPoint { u: 600.0, v: 300.0 }, target);
    let what = format!("course {course_deg}, bearing {bearing_deg}, distance {distance_px}: {command:?}");
    assert_eq!(found, branch, "{what}");
    assert!((command.throttle - throttle).abs() < 1e-9 && (command.rudder - rudder).abs() < 1e-9, "{what}");
}

#[test]
fn each_branch_and_both_wraps_follow_the_published_rules() {
    use LabBranch::{Cruising, Reached, Turning};
    let paper = |at, expected, branch| check(LabSettings::PAPER, at, expected, branch);
    // Straight ahead, and proportional to both sides up to 30 degrees.
    paper((0.0, 0.0, 400.0), (0.6, 0.0), Cruising);
    paper((0.0, 10.0, 400.0), (0.6, 0.2), Cruising);
    paper((0.0, -10.0, 400.0), (0.6, -0.2), Cruising);
    paper((0.0, 29.9, 400.0), (0.6, 0.598), Cruising);
    paper((0.0, -29.9, 400.0), (0.6, -0.598), Cruising);
    // Turns from 30 degrees on.
    paper((0.0, 30.1, 400.0), (0.3, 1.0), Turning);
    paper((0.0, -30.1, 400.0), (0.3, -1.0), Turning);
    paper((0.0, 179.0, 400.0), (0.3, 1.0), Turning);
    paper((0.0, -179.0, 400.0), (0.3, -1.0), Turning);
    // The error wraps at 180 degrees, both ways, in turns and in proportional steering.
    paper((170.0, -170.0, 400.0), (0.6, 0.4), Cruising);
    paper((-170.0, 170.0, 400.0), (0.6, -0.4), Cruising);
    paper((100.0, -120.0, 400.0), (0.3, 1.0), Turning);
    paper((-100.0, 120.0, 400.0), (0.3, -1.0), Turning);
    // Slowing within 90 px, in both branches; reached within 30 px, whatever the error.
    paper((0.0, 0.0, 90.1), (0.6, 0.0), Cruising);
    paper((0.0, 0.0, 45.0), (0.3, 0.0), Cruising);
    paper((0.0, 90.0, 45.0), (0.15, 1.0), Turning);
    paper((0.0, 0.0, 30.1), (0.6 * 30.1 / 90.0, 0.0), Cruising);
    paper((0.0, 0.0, 29.9), (0.0, 0.0), Reached);
    paper((0.0, 120.0, 29.9), (0.0, 0.0), Reached);
}

#[test]
fn an_unknown_heading_gets_the_boat_moving() {
    let mut law = LabLaw::new(LabSettings::PAPER);
    let target = PixelPoint { u: 900.0, v: 100.0 };
    for step in 0..49_u64 {
        let boat = PixelPoint { u: 300.0 + 2.0 * step as f64, v: 500.0 };
        let (command, branch) = step_at(&mut law, step, boat, target);
        assert_eq!((command.throttle, command.rudder, branch), (0.2, 0.0, LabBranch::UnknownHeading));
    }
    let (_, branch) = step_at(&mut law, 49, PixelPoint { u: 398.0, v: 500.0 }, target);
    assert_eq!(branch, LabBranch::Turning, "with 50 positions there is a heading");
}

#[test]
fn without_boat_or_target_the_vessel_is_neutral_at_once() {
    let (mut law, step) = law_on_course(LabSettings::PAPER, 0.0);
    let now = Timestamp::from_nanos(step * STEP_NS - 1_000_000);
    let (boat, target) = (Some(PixelPoint { u: 600.0, v: 300.0 }), Some(PixelPoint { u: 900.0, v: 300.0 }));
    for (boat, target) in [(None, target), (boat, None), (None, None)] {
        let answer = law.step(&LabInput { now, boat, target });
        assert_eq!(answer, (VesselCommand::NEUTRAL, LabBranch::Idle));
    }
}

#[test]
fn the_command_stays_between_two_steps_of_its_rate() {
    let (mut law, step) = law_on_course(LabSettings::PAPER, 0.0);
    let boat = PixelPoint { u: 600.0, v: 300.0 };
    let (first, _) = step_at(&mut law, step, boat, PixelPoint { u: 900.0, v: 300.0 });
    let soon = Timestamp::from_nanos(step * STEP_NS + 66_666_667);
    let beside = PixelPoint { u: 600.0, v: 900.0 };
    let (second, _) = law.step(&LabInput { now: soon, boat: Some(boat), target: Some(beside) });
    assert_eq!(first, second);
    let (third, branch) = step_at(&mut law, step + 1, boat, beside);
    assert_eq!((third.rudder, branch), (1.0, LabBranch::Turning));
}
