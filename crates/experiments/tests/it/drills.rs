//! Drills in lock step: without a clock, in small pictures.

use barrelman_experiments::drill::{DrillJudge, DrillPlan, DrillResult};
use barrelman_experiments::drive::{Drive, DriveObserver, DriveSetup};
use barrelman_experiments::law_choice::LawChoice;
use barrelman_experiments::render_threads::RenderThreads;
use barrelman_experiments::tracker_choice::TrackerName;
use barrelman_experiments::world_url::WorldUrl;
use barrelman_pilot::{Input, Outcome};
use barrelman_sim::Truth;
use barrelman_trial::campaign::StepObserver;
use barrelman_trial::target_in_picture::TargetInPicture;
use barrelman_vocab::{
    CameraRequest, DrillName, OperatorRequest, PictureSize, StopCause, Timestamp, VehicleRates,
    VesselCommand, VesselRequest,
};

const STOP: OperatorRequest = OperatorRequest::Stop(StopCause::Operator);
const ENGAGE: OperatorRequest = OperatorRequest::Camera(CameraRequest::Engage);

struct Nobody;

impl StepObserver for Nobody {
    fn on_step(&mut self, _: Timestamp, _: &Input<'_>, _: &Outcome, _: VehicleRates) {}
    fn on_truth(&mut self, _: &Truth, _: Option<&TargetInPicture>) {}
}

impl DriveObserver for Nobody {}

/// The result of a drill; `act` says what a person asks for before a tick.
fn result(
    name: DrillName,
    mut act: impl FnMut(&DrillJudge, &Drive<'_>) -> Option<OperatorRequest>,
) -> DrillResult {
    let plan = DrillPlan::of(name);
    let url = WorldUrl { size: Some(PictureSize::new(192, 108)), ..WorldUrl::new(plan.scenario) };
    let setup = DriveSetup::new(url, TrackerName::Camshift, LawChoice::OPTIMAL, false).unwrap();
    let setup = DriveSetup { hands_on: !plan.begins_engaged, ..setup };
    let threads = RenderThreads::new().unwrap();
    let mut drive = Drive::new(&setup, &threads).unwrap().with_log();
    let mut judge = DrillJudge::new(name, 1);
    while !judge.is_over() {
        assert!(drive.world().now().as_secs_f64() < 200.0, "{name:?} has an end");
        if let Some(request) = act(&judge, &drive) {
            judge.on_request(&request);
            drive.request(request, &mut Nobody);
        }
        drive.tick(&mut Nobody);
        judge.after_tick(&drive);
    }
    let result = judge.result(&drive, &setup).unwrap();
    assert!(judge.state(Some(result.clone())).left_s == 0.0);
    result
}

#[test]
fn a_person_who_does_nothing_passes_no_drill() {
    for (name, sentence) in [
        (DrillName::KeepInView, "% of the time; wanted: 90 %."),
        (DrillName::SelectInGlare, "The boat was not followed within 15 s."),
        (DrillName::FindTheBoat, "The boat was not followed within 30 s."),
        (DrillName::StopOnAlarm, "STOP was not pressed within 10 s of the alarm."),
    ] {
        let result = result(name, |_, _| None);
        assert!(!result.passed && result.sentence.ends_with(sentence), "{name:?}: {result:?}");
        assert_eq!(result.person.moves, 0, "{name:?}");
        for law in [result.schema, result.default_law] {
            assert!(law.in_picture > 0.9, "the laws keep the boat of {name:?}: {result:?}");
        }
    }
}

#[test]
fn the_hand_is_practised_by_hand() {
    let mut is_engaged = false;
    let result =
        result(DrillName::KeepInView, |_, _| (!std::mem::replace(&mut is_engaged, true)).then_some(ENGAGE));
    assert!(!result.passed && result.sentence.contains("by hand"), "{result:?}");
}

#[test]
fn a_stop_counts_from_the_alarm_on() {
    let stopped = result(DrillName::StopOnAlarm, |judge, _| judge.state(None).alarm.then_some(STOP));
    assert!(stopped.passed && stopped.sentence.contains("0.0 s after the alarm"), "{stopped:?}");
    let early = result(DrillName::StopOnAlarm, |judge, _| judge.has_begun().then_some(STOP));
    assert!(!early.passed && early.sentence.contains("before the alarm"), "{early:?}");
}

#[test]
fn a_boat_that_is_driven_ahead_is_steered_as_it_was_for_the_laws() {
    let ahead = OperatorRequest::Vessel(VesselRequest::Steer(VesselCommand { throttle: 1.0, rudder: 0.0 }));
    let result =
        result(DrillName::ReachAPerson, |_, drive| drive.world().tick().is_multiple_of(30).then_some(ahead));
    let by_helmsman = self::result(DrillName::ReachAPerson, |_, _| None);
    assert_ne!(result.schema, by_helmsman.schema, "the boat took another way");
    assert!(!by_helmsman.sentence.is_empty());
}
