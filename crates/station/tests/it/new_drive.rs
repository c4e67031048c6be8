//! Requests about the simulated world, to a run with one and to a run without.

use std::cell::RefCell;
use std::sync::Arc;
use std::sync::mpsc::RecvTimeoutError;
use std::time::Duration;

use barrelman_console_server::operator::{Answer, Gateway, SessionRequest};
use barrelman_console_server::snapshot::{LinkStatus, Publisher, RecordingState, WorldState};
use barrelman_experiments::world_url::WorldUrl;
use barrelman_host::latest::Latest;
use barrelman_pilot::Input;
use barrelman_station::link::vessel_link::VesselLink;
use barrelman_station::live::event::{Event, EventSource, QuitCause};
use barrelman_station::live::run_loop::{LiveStep, LiveStepObserver, RunLoop};
use barrelman_station::live::status_line::{StatusLine, StatusOutput};
use barrelman_station::live::tracked_video::TrackedVideo;
use barrelman_station::simulated_source::{LiveWorld, WorldSwitch};
use barrelman_vocab::{
    CameraRequest, NewDrive, OperatorRequest, StopCause, Timestamp, VehicleProfile, VesselOrder,
    VesselRequest, WorldRequest,
};

use crate::live_scenes::{at, pilot};

/// Takes the requests that wait, and quits.
struct OneTurn;

impl EventSource for OneTurn {
    fn now(&self) -> Timestamp {
        at(1_000)
    }

    fn next_event(&mut self, _wait: Duration) -> Result<Event, RecvTimeoutError> {
        Ok(Event::Quit(QuitCause::Key))
    }
}

struct NoStatus;

impl StatusOutput for NoStatus {
    fn show(&self, _line: String) {}
}

struct NoBoat;

impl VesselLink for NoBoat {
    fn send(&self, _order: VesselOrder, _renew_by: Option<Timestamp>) {}
}

/// The requests that the pilot received.
#[derive(Default)]
struct Recorded(RefCell<Vec<OperatorRequest>>);

impl LiveStepObserver for &Recorded {
    fn on_step(&mut self, step: &LiveStep<'_>) {
        if let Input::Request(request) = step.input {
            self.0.borrow_mut().push(request);
        }
    }
}

/// What a run made of a request.
struct Run {
    answer: Answer,
    recorded: Vec<OperatorRequest>,
    world: Option<WorldState>,
    events: Vec<String>,
}

fn run(worlds: Option<WorldSwitch>, has_boat: bool, request: WorldRequest) -> Run {
    let profile = VehicleProfile::fotokite_pro();
    let gateway = Arc::new(Gateway::new(|| {}));
    let publisher = Publisher::new(&profile, LinkStatus::DryRun, RecordingState::Off);
    let (snapshots, events) = (publisher.subscribe(), publisher.events());
    let mut answer = gateway.submit(SessionRequest::World(request));
    let (recorded, boat) = (Recorded::default(), NoBoat);
    RunLoop {
        pilot: pilot(),
        profile,
        events: &mut OneTurn,
        gateway,
        publisher,
        latest: Arc::new(Latest::default()),
        tracked: TrackedVideo::default(),
        second_field_of_view: None,
        link: None,
        boat: has_boat.then_some(&boat as &dyn VesselLink),
        worlds,
        recorder: Some(Box::new(&recorded)),
        status: StatusLine::new(Duration::from_millis(100)),
        status_output: Box::new(NoStatus),
        ends_on_refused_selection: false,
        observers: Vec::new(),
    }
    .run(&[CameraRequest::Engage.into()]);
    let world = snapshots.borrow().world.clone();
    let mut recorded = recorded.0.into_inner();
    assert_eq!(recorded.remove(0), CameraRequest::Engage.into());
    assert_eq!(recorded.pop(), Some(OperatorRequest::Stop(StopCause::Ending)));
    let texts = events.subscribe().0.into_iter().map(|entry| entry.text);
    Run { answer: answer.try_recv().unwrap(), recorded, world, events: texts.collect() }
}

fn switch() -> Option<WorldSwitch> {
    Some(LiveWorld::load(&WorldUrl::new("rescue")).unwrap().switch().unwrap())
}

fn new_drive(scenario: &str) -> WorldRequest {
    WorldRequest::NewDrive(NewDrive { scenario: scenario.to_owned(), seed: 4 })
}

#[track_caller]
fn check_refused(worlds: Option<WorldSwitch>, request: WorldRequest, reason: &str) {
    let run = run(worlds, true, request);
    let Answer::Refused(given) = &run.answer else { panic!("{:?}", run.answer) };
    assert!(given.contains(reason), "{given}");
    assert_eq!(run.recorded, [], "the camera is not stopped");
    assert_eq!(run.world, None);
}

#[test]
fn a_new_drive_stops_the_camera_first_and_then_forgets_target_and_marks() {
    let run = run(switch(), true, new_drive("open"));
    assert_eq!(run.answer, Answer::ACCEPTED);
    let expected: [OperatorRequest; 4] = [
        OperatorRequest::Stop(StopCause::Operator),
        CameraRequest::Deselect.into(),
        VesselRequest::UnmarkAll.into(),
        VesselRequest::ReleaseVessel.into(),
    ];
    assert_eq!(run.recorded, expected);
    assert_eq!(run.world, Some(WorldState { scenario: "open".to_owned(), seed: 4, boat: None }));
    let text = "new drive: open, seed 4: the camera is disengaged, and nothing is marked";
    assert!(run.events.iter().any(|event| event == text), "{:?}", run.events);
}

#[test]
fn without_a_boat_there_are_no_marks_to_forget() {
    let run = run(switch(), false, new_drive("open"));
    assert_eq!(run.recorded.len(), 2, "{:?}", run.recorded);
}

#[test]
fn what_cannot_begin_is_refused_and_stops_nothing() {
    check_refused(None, new_drive("open"), "the world is not simulated: a new drive begins in");
    check_refused(switch(), new_drive("nowhere"), "there is no scenario \"nowhere\": use one of lab1,");
    check_refused(switch(), new_drive("/tmp/mine.toml"), "there is no scenario");
    for request in [WorldRequest::Pause, WorldRequest::Resume] {
        check_refused(switch(), request.clone(), "the time of a run cannot be paused");
        check_refused(None, request, "the time of a run cannot be paused");
    }
}
