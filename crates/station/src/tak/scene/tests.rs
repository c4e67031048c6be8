use barrelman_console_server::snapshot::{BoatOnWater, VehiclePosition};
use barrelman_control::guidance::GuidanceState;
use barrelman_control::guidance::input::Progress;
use barrelman_pilot::vessel::{Guidance, GuidanceBasis};
use barrelman_vocab::earth::WaterOnEarth;
use barrelman_vocab::{Localisation, PictureSize, PixelBox, WaterPoint};

use super::*;

fn at(ms: u64) -> Timestamp {
    Timestamp::from_nanos(ms * 1_000_000)
}

fn geo(latitude: f64, longitude: f64) -> GeoPoint {
    GeoPoint { latitude: Angle::from_degrees(latitude), longitude: Angle::from_degrees(longitude) }
}

/// The camera is at 54 north, 10 east, and its water frame's y points east.
fn frame() -> WaterOnEarth {
    WaterOnEarth { origin: geo(54.0, 10.0), ahead: Angle::from_degrees(90.0) }
}

fn tracking(captured: Timestamp) -> Track {
    let bounds = PixelBox { u: 300.0, v: 230.0, w: 40.0, h: 20.0 };
    let (picture, centre) = (PictureSize::new(640, 480), bounds.centre());
    Track::Tracking(Localisation {
        captured,
        picture,
        centre,
        bounds,
        shape: None,
        heading: None,
        confidence: 0.75,
    })
}

/// The outcome of a step at 10 s.
fn outcome(track: Track, earth: Result<WaterOnEarth, NotOnEarth>) -> Outcome {
    Outcome { track, earth, ..Outcome::idle(at(10_000)) }
}

/// A snapshot of that outcome, in which the boat was sighted 40 m away, and the vehicle last told a position.
fn snapshot(outcome: Outcome) -> Snapshot {
    let sighting = BoatOnWater {
        distance_m: 40.0,
        std_dev_m: 1.5,
        direction: Angle::ZERO,
        on_earth: outcome.earth.is_ok().then(|| geo(54.0, 10.001)),
    };
    let mut snapshot = Snapshot { boat: Some(sighting), outcome: Some(outcome), ..Snapshot::default() };
    let GeoPoint { latitude, longitude } = frame().origin;
    snapshot.vehicle.position = Some(VehiclePosition { latitude, longitude, heading: None });
    snapshot.vehicle.altitude_m = Some(12.0);
    snapshot
}

fn subjects(snapshot: &Snapshot, now_ms: u64) -> Vec<Subject> {
    located(snapshot, at(now_ms)).into_iter().map(|located| located.subject).collect()
}

const CAMERA: Subject = Subject::Camera { height_m: Some(12.0) };

#[test]
fn camera_and_boat_are_where_the_program_has_them() {
    let found = located(&snapshot(outcome(tracking(at(9_800)), Ok(frame()))), at(10_100));
    let [camera, boat] = found[..] else { panic!("{found:?}") };
    assert_eq!((camera.subject, camera.place, camera.std_dev_m), (CAMERA, geo(54.0, 10.0), None));
    assert_eq!((boat.subject, boat.place, boat.std_dev_m), (Subject::Boat, geo(54.0, 10.001), Some(1.5)));
    assert_eq!(
        (camera.at, boat.at),
        (at(10_000), at(9_800)),
        "the boat was there when the picture was taken"
    );
    assert_eq!(boat.motion, Motion::default());
}

#[test]
fn without_latitude_and_longitude_there_is_nothing() {
    let without = |earth| snapshot(outcome(tracking(at(9_900)), earth));
    assert_eq!(subjects(&without(Err(NotOnEarth::NoPosition)), 10_000), []);
    assert_eq!(
        subjects(&without(Err(NotOnEarth::NoHeading)), 10_000),
        [CAMERA],
        "its own place needs no heading"
    );
    assert_eq!(subjects(&Snapshot::default(), 10_000), []);
}

#[test]
fn what_is_not_known_any_more_is_not_sent() {
    let seen = snapshot(outcome(tracking(at(9_000)), Ok(frame())));
    assert_eq!(subjects(&seen, 10_500), [CAMERA, Subject::Boat]);
    assert_eq!(subjects(&seen, 11_500), [CAMERA], "the picture of the boat is too old");
    assert_eq!(subjects(&seen, 12_500), [], "the loop makes no steps");
    let lost = Track::Lost { since: at(9_900), confidence: 0.1 };
    assert_eq!(subjects(&snapshot(outcome(lost, Ok(frame()))), 10_000), [CAMERA]);
}

#[test]
fn what_may_be_another_object_is_no_boat() {
    let seen = outcome(tracking(at(9_900)), Ok(frame()));
    let doubted = Outcome { is_doubted: true, ..seen.clone() };
    let unconfirmed = Outcome { is_confirming: true, ..seen.clone() };
    assert_eq!(subjects(&snapshot(seen), 10_000), [CAMERA, Subject::Boat]);
    for outcome in [doubted, unconfirmed] {
        assert_eq!(subjects(&snapshot(outcome), 10_000), [CAMERA]);
    }
}

#[test]
fn a_guided_boat_has_speed_and_course() {
    let mut guided = outcome(tracking(at(9_900)), Ok(frame()));
    let progress = Progress {
        boat: WaterPoint { x: 0.0, y: 65.0 },
        speed_m_per_s: 2.5,
        course: Some(Angle::from_degrees(-100.0)),
        distance_m: 10.0,
        cross_track_m: 0.0,
        leg: 0,
    };
    let guidance =
        |progress| Guidance { basis: GuidanceBasis::Water, state: GuidanceState::UnderWay, progress };
    guided.vessel.guidance = Some(guidance(Some(progress)));
    let mut snapshot = snapshot(guided);
    let found = located(&snapshot, at(10_000));
    let boat = found.iter().find(|located| located.subject == Subject::Boat).unwrap();
    assert_eq!(boat.motion.speed_m_per_s, Some(2.5));
    assert!((boat.motion.course.unwrap().degrees() + 10.0).abs() < 1e-9, "{:?}", boat.motion);
    snapshot.boat = None;
    assert_eq!(subjects(&snapshot, 10_000), [CAMERA], "a place whose error is not known is not sent");
}
