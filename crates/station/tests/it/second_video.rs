//! A run with two videos: which one the pilot sees, and what a change does.

use std::cell::RefCell;
use std::collections::VecDeque;
use std::sync::Arc;
use std::sync::mpsc::RecvTimeoutError;
use std::time::Duration;

use barrelman_console_server::operator::{Answer, Gateway, SessionRequest};
use barrelman_console_server::snapshot::{LinkStatus, Publisher, RecordingState};
use barrelman_host::latest::Latest;
use barrelman_pilot::Input;
use barrelman_station::live::event::{Event, EventSource, QuitCause};
use barrelman_station::live::run_loop::{LiveStep, LiveStepObserver, RunEnd, RunLoop};
use barrelman_station::live::status_line::{StatusLine, StatusOutput};
use barrelman_station::live::tracked_video::{LatestFrame, TrackedVideo};
use barrelman_video::VideoState;
use barrelman_vocab::telemetry::Report;
use barrelman_vocab::{
    Angle, CameraRequest, OperatorRequest, Timestamp, VehicleProfile, VideoNumber, VideoRequest,
};
use tokio::sync::oneshot;

use crate::live_scenes::{SELECTION, at, frame, pilot};

use VideoNumber::{First, Second};

enum Turn {
    /// A frame of this video is in the slot.
    Frame(VideoNumber),
    Video(VideoNumber, VideoState),
    Request(SessionRequest),
}

fn track(video: VideoNumber) -> Turn {
    Turn::Request(SessionRequest::Video(VideoRequest::TrackVideo { video }))
}

fn ask(request: CameraRequest) -> Turn {
    Turn::Request(SessionRequest::Pilot(request.into()))
}

/// Takes 40 ms for each turn, and quits after the last.
struct Script {
    gateway: Arc<Gateway>,
    latest: Arc<LatestFrame>,
    turns: VecDeque<Turn>,
    now: Timestamp,
    frames: u64,
    answers: Vec<oneshot::Receiver<Answer>>,
}

impl EventSource for Script {
    fn now(&self) -> Timestamp {
        self.now
    }

    fn next_event(&mut self, _wait: Duration) -> Result<Event, RecvTimeoutError> {
        self.now = self.now.plus(Duration::from_millis(40));
        Ok(match self.turns.pop_front() {
            None => Event::Quit(QuitCause::Key),
            Some(Turn::Frame(number)) => {
                self.latest.put((number, frame(self.frames, self.now)));
                self.frames += 1;
                Event::Frame
            }
            Some(Turn::Video(number, state)) => Event::Video(number, state),
            Some(Turn::Request(request)) => {
                self.answers.push(self.gateway.submit(request));
                Event::Operator
            }
        })
    }
}

struct NoStatus;

impl StatusOutput for NoStatus {
    fn show(&self, _line: String) {}
}

/// The steps of a run in words.
#[derive(Default)]
struct Steps(RefCell<Vec<String>>);

impl LiveStepObserver for &Steps {
    fn on_step(&mut self, step: &LiveStep<'_>) {
        let text = match step.input {
            Input::Frame(_) => format!("{:?} frame", step.video),
            Input::Request(OperatorRequest::Camera(request)) => format!("{request:?}"),
            Input::Telemetry(telemetry) => match telemetry.report {
                Report::OtherVideo(Some(angle)) => format!("another camera, {:.0} deg", angle.degrees()),
                Report::OtherVideo(None) => "the first camera".to_owned(),
                other => format!("{other:?}"),
            },
            _ => return,
        };
        self.0.borrow_mut().push(text);
    }
}

struct Run {
    end: RunEnd,
    steps: Vec<String>,
    answers: Vec<Answer>,
    tracked: VideoNumber,
}

/// A run with two videos, of which the second shows 40 degrees.
fn run(turns: impl IntoIterator<Item = Turn>) -> Run {
    let profile = VehicleProfile::fotokite_pro();
    let gateway = Arc::new(Gateway::new(|| {}));
    let mut publisher = Publisher::new(&profile, LinkStatus::DryRun, RecordingState::Off);
    publisher.add_second_video();
    let latest = Arc::new(Latest::default());
    let mut script = Script {
        gateway: Arc::clone(&gateway),
        latest: Arc::clone(&latest),
        turns: turns.into_iter().collect(),
        now: at(1_000),
        frames: 0,
        answers: Vec::new(),
    };
    let (steps, tracked) = (Steps::default(), TrackedVideo::default());
    let end = RunLoop {
        pilot: pilot(),
        profile,
        events: &mut script,
        gateway,
        publisher,
        latest,
        tracked: tracked.clone(),
        second_field_of_view: Some(Angle::from_degrees(40.0)),
        link: None,
        boat: None,
        worlds: None,
        recorder: Some(Box::new(&steps)),
        status: StatusLine::new(Duration::from_millis(100)),
        status_output: Box::new(NoStatus),
        ends_on_refused_selection: false,
        observers: Vec::new(),
    }
    .run(&[]);
    let answers = script.answers.into_iter().map(|mut answer| answer.try_recv().unwrap()).collect();
    Run { end, steps: steps.0.into_inner(), answers, tracked: tracked.number() }
}

fn up(number: VideoNumber) -> Turn {
    Turn::Video(number, VideoState::Up)
}

#[track_caller]
fn check_refused(turns: impl IntoIterator<Item = Turn>, reason: &str) {
    let run = run(turns);
    let Some(Answer::Refused(given)) = run.answers.last() else { panic!("{:?}", run.answers) };
    assert!(given.contains(reason), "{given}");
    assert_eq!(run.tracked, First);
}

#[test]
fn a_change_ends_the_selection_tells_the_field_of_view_and_leaves_frames_of_the_other_video_out() {
    let run = run([
        up(First),
        up(Second),
        ask(CameraRequest::SelectNext(SELECTION)),
        Turn::Frame(First),
        Turn::Frame(Second),
        track(Second),
        Turn::Frame(First),
        Turn::Frame(Second),
        track(Second),
        track(First),
        Turn::Frame(First),
    ]);
    let selected = format!("{:?}", CameraRequest::SelectNext(SELECTION));
    let expected = [
        &selected,
        "First frame",
        "Deselect",
        "another camera, 40 deg",
        "Second frame",
        "Deselect",
        "the first camera",
        "First frame",
    ];
    assert_eq!(run.steps, expected, "the second change to the same video changes nothing");
    assert!(run.answers.iter().all(|answer| *answer == Answer::ACCEPTED), "{:?}", run.answers);
}

#[test]
fn the_video_is_changed_at_rest_alone_and_to_one_with_a_picture() {
    let select = [ask(CameraRequest::SelectNext(SELECTION)), Turn::Frame(First)];
    let engaged = [up(Second)].into_iter().chain(select).chain([ask(CameraRequest::Engage)]);
    check_refused(engaged.chain([track(Second)]), "disengage, then change the video");
    check_refused([track(Second)], "video 2 has no picture");
    let lost = VideoState::Lost { reason: "time-out".to_owned() };
    check_refused([up(Second), Turn::Video(Second, lost), track(Second)], "video 2 has no picture");
}

#[test]
fn the_end_of_the_tracked_video_ends_the_run_and_that_of_the_other_does_not() {
    let ended = |number| Turn::Video(number, VideoState::Ended);
    assert_eq!(run([up(First), up(Second), ended(First)]).end, RunEnd::VideoEnded);
    let goes_on = run([up(First), up(Second), ended(Second), Turn::Frame(First)]);
    assert!(matches!(goes_on.end, RunEnd::Requested(_)) && goes_on.steps == ["First frame"]);
    let changed = run([up(First), up(Second), track(Second), ended(First), Turn::Frame(Second)]);
    assert!(matches!(changed.end, RunEnd::Requested(_)), "{:?}", changed.end);
    assert_eq!(run([up(First), up(Second), track(Second), ended(Second)]).end, RunEnd::VideoEnded);
}
