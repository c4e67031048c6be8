//! The run loop with scripted events and time, and a link in memory: no test waits.

use std::cell::{Cell, RefCell};
use std::collections::VecDeque;
use std::sync::Arc;
use std::sync::mpsc::RecvTimeoutError;
use std::time::Duration;

use barrelman_console_server::operator::{Gateway, SessionRequest};
use barrelman_console_server::snapshot::{LinkStatus, Publisher, RecordingState};
use barrelman_host::latest::Latest;
use barrelman_pilot::{CommandPath, Input, Mode, Pilot};
use barrelman_station::link::{LinkReport, VehicleLink};
use barrelman_station::live::event::{Event, EventSource, QuitCause};
use barrelman_station::live::run_loop::{LiveStep, LiveStepObserver, RunEnd, RunLoop};
use barrelman_station::live::status_line::{StatusLine, StatusOutput};
use barrelman_station::live::tracked_video::{LatestFrame, TrackedVideo};
use barrelman_video::{VideoError, VideoState};
use barrelman_vocab::telemetry::{ControlState, LinkState, Report};
use barrelman_vocab::{
    CameraRequest, HoldCause, Lens, Note, NoteRequest, OperatorRequest, PictureSize, StopCause, Telemetry,
    Timestamp, VehicleProfile, VehicleRates, VideoNumber,
};

use crate::live_scenes::{REFUSED, SELECTION, at, frame, pilot};

/// How long rates last after a fresh video frame, ms: `coast_motion` of the Fotokite Pro.
const COAST_MS: u64 = 250;
const SELECT: OperatorRequest = OperatorRequest::Camera(CameraRequest::SelectNext(SELECTION));
const ENGAGE: OperatorRequest = OperatorRequest::Camera(CameraRequest::Engage);

/// What arrives at a time of the test.
enum Arrival {
    /// A video frame, with its event.
    Frame,
    /// Any other event.
    Event(Event),
    /// A request of the operator, through the gateway.
    Request(OperatorRequest),
    /// A moment that somebody marks with this text.
    Note(&'static str),
    /// The end of all threads.
    Gone,
}

use Arrival::{Frame, Gone};

fn event(event: Event) -> Arrival {
    Arrival::Event(event)
}

fn quit() -> Arrival {
    event(Event::Quit(QuitCause::Key))
}

/// Scripted events: the time advances to the next event, or to the end of the wait.
struct Script {
    gateway: Arc<Gateway>,
    now: Timestamp,
    arrivals: VecDeque<(u64, Arrival)>,
    latest: Arc<LatestFrame>,
    frames: u64,
}

impl EventSource for Script {
    fn now(&self) -> Timestamp {
        self.now
    }

    fn next_event(&mut self, wait: Duration) -> Result<Event, RecvTimeoutError> {
        let until = self.now.plus(wait);
        let Some((ms, arrival)) = self.arrivals.pop_front_if(|(ms, _)| at(*ms) <= until) else {
            assert!(!self.arrivals.is_empty(), "the run should have ended by {:?}", self.now);
            self.now = until;
            return Err(RecvTimeoutError::Timeout);
        };
        self.now = self.now.max(at(ms));
        match arrival {
            Frame => {
                self.latest.put((VideoNumber::First, frame(self.frames, self.now)));
                self.frames += 1;
                Ok(Event::Frame)
            }
            Arrival::Event(event) => Ok(event),
            Arrival::Request(request) => {
                self.gateway.submit_logged(request);
                Ok(Event::Operator)
            }
            Arrival::Note(text) => {
                let note = Note { text: text.to_owned().try_into().unwrap() };
                drop(self.gateway.submit(SessionRequest::Note(NoteRequest::Note(note))));
                Ok(Event::Operator)
            }
            Gone => Err(RecvTimeoutError::Disconnected),
        }
    }
}

/// A link that remembers what it was asked to do.
#[derive(Default)]
struct MemoryLink {
    sent: RefCell<Vec<(VehicleRates, Option<Timestamp>)>>,
    takes_of_control: Cell<usize>,
}

impl VehicleLink for MemoryLink {
    fn send(&self, rates: VehicleRates, renew_by: Option<Timestamp>) {
        self.sent.borrow_mut().push((rates, renew_by));
    }

    fn take_control(&self) {
        self.takes_of_control.update(|takes| takes + 1);
    }
}

/// A step as its time and input, with the mode that it led to.
type SeenStep = (u64, String, Mode);

/// Remembers the steps of a run.
#[derive(Default)]
struct MemoryObserver(RefCell<Vec<SeenStep>>, RefCell<Vec<(u64, String)>>);

impl LiveStepObserver for &MemoryObserver {
    fn on_step(&mut self, step: &LiveStep<'_>) {
        let input = match step.input {
            Input::Frame(frame) => format!("frame {}", frame.sequence),
            Input::Localisation(_) => "localisation".to_owned(),
            Input::Telemetry(_) => "telemetry".to_owned(),
            Input::VesselTelemetry(_) => "vessel telemetry".to_owned(),
            Input::Detections(detections) => format!("{} detections", detections.found.len()),
            Input::Request(request) => format!("{request:?}"),
            Input::Tick => "tick".to_owned(),
        };
        let mut steps = self.0.borrow_mut();
        assert_eq!(step.index, steps.len() as u64, "steps are numbered in order");
        steps.push((step.outcome.at.as_nanos() / 1_000_000, input, step.outcome.mode));
    }

    fn on_note(&mut self, at: Timestamp, note: &Note) {
        self.1.borrow_mut().push((at.as_nanos() / 1_000_000, note.text.as_str().to_owned()));
    }
}

#[derive(Default)]
struct MemoryStatus(RefCell<Vec<String>>);

impl StatusOutput for &MemoryStatus {
    fn show(&self, line: String) {
        self.0.borrow_mut().push(line);
    }
}

/// What a run did.
struct Run {
    end: RunEnd,
    sent: Vec<(VehicleRates, Option<Timestamp>)>,
    takes_of_control: usize,
    recorded: Vec<SeenStep>,
    overlaid: Vec<SeenStep>,
    notes: Vec<(u64, String)>,
    lines: Vec<String>,
}

impl Run {
    /// The last step: its input and its mode.
    fn last(&self) -> (&str, Mode) {
        let (_, input, mode) = self.recorded.last().unwrap();
        (input, *mode)
    }

    /// Times and inputs of the recorded steps.
    fn inputs(&self) -> Vec<(u64, &str)> {
        self.recorded.iter().map(|(ms, input, _)| (*ms, input.as_str())).collect()
    }
}

/// Runs the loop, from 1 s on, on events with their times in milliseconds.
fn run(requests: &[OperatorRequest], arrivals: impl IntoIterator<Item = (u64, Arrival)>) -> Run {
    run_with(requests, arrivals, true)
}

fn run_with(
    requests: &[OperatorRequest],
    arrivals: impl IntoIterator<Item = (u64, Arrival)>,
    ends_on_refused_selection: bool,
) -> Run {
    run_pilot(pilot(), requests, arrivals, ends_on_refused_selection)
}

fn run_pilot(
    pilot: Pilot,
    requests: &[OperatorRequest],
    arrivals: impl IntoIterator<Item = (u64, Arrival)>,
    ends_on_refused_selection: bool,
) -> Run {
    run_vehicle(VehicleProfile::fotokite_pro(), pilot, requests, arrivals, ends_on_refused_selection)
}

fn run_vehicle(
    profile: VehicleProfile,
    pilot: Pilot,
    requests: &[OperatorRequest],
    arrivals: impl IntoIterator<Item = (u64, Arrival)>,
    ends_on_refused_selection: bool,
) -> Run {
    let latest = Arc::new(Latest::default());
    let gateway = Arc::new(Gateway::new(|| {}));
    let publisher = Publisher::new(&profile, LinkStatus::Link(LinkState::Opening), RecordingState::Off);
    let mut script = Script {
        gateway: Arc::clone(&gateway),
        now: at(1_000),
        arrivals: arrivals.into_iter().collect(),
        latest: Arc::clone(&latest),
        frames: 0,
    };
    let (link, recorder, overlay) =
        (MemoryLink::default(), MemoryObserver::default(), MemoryObserver::default());
    let status = MemoryStatus::default();
    let end = RunLoop {
        pilot,
        profile,
        events: &mut script,
        gateway,
        publisher,
        latest,
        tracked: TrackedVideo::default(),
        second_field_of_view: None,
        link: Some(&link),
        boat: None,
        worlds: None,
        recorder: Some(Box::new(&recorder)),
        status: StatusLine::new(Duration::from_millis(100)),
        status_output: Box::new(&status),
        ends_on_refused_selection,
        observers: vec![Box::new(&overlay)],
    }
    .run(requests);
    Run {
        end,
        takes_of_control: link.takes_of_control.get(),
        sent: link.sent.into_inner(),
        recorded: recorder.0.into_inner(),
        notes: recorder.1.into_inner(),
        overlaid: overlay.0.into_inner(),
        lines: status.0.into_inner(),
    }
}

/// The rates that a frame with the target on the right leads to.
fn moving() -> VehicleRates {
    let run = run(&[SELECT, ENGAGE], [(1_100, Frame), (1_110, quit())]);
    let rates = run.sent[2].0;
    assert!(!rates.is_rest());
    rates
}

#[test]
fn a_frame_is_stepped_and_its_rates_are_sent_with_their_time_to_live() {
    let run = run(&[SELECT, ENGAGE], [(1_100, Frame), (1_200, Frame), (1_210, quit())]);
    let profile = VehicleProfile::fotokite_pro();
    assert_eq!(profile.from_vehicle(run.sent[2].0).pan, profile.motor_schema_rates.pan, "to the right");
    let frames = &run.sent[2..4];
    assert_eq!(frames, [1_100, 1_200].map(|ms| (moving(), Some(at(ms + COAST_MS)))));
    assert_eq!(run.recorded.len(), run.sent.len(), "each step is sent and recorded");
    assert_eq!(run.overlaid, run.recorded, "the annotated video sees the same steps");
    assert_eq!(run.recorded[3], (1_200, "frame 1".to_owned(), Mode::Servoing));
}

#[test]
fn requests_are_stepped_before_the_first_event() {
    let run = run(&[SELECT, ENGAGE], [(1_000, quit())]);
    let inputs = run.inputs();
    assert_eq!(inputs[..2], [(1_000, &*format!("{SELECT:?}")), (1_000, "Camera(Engage)")]);
}

#[test]
fn the_operators_engage_takes_the_control_back_and_the_one_of_the_start_does_not() {
    assert_eq!(run(&[SELECT, ENGAGE], [(1_100, Frame), (1_200, quit())]).takes_of_control, 0);
    let asked = run(&[SELECT, ENGAGE], [(1_100, Frame), (1_150, Arrival::Request(ENGAGE)), (1_200, quit())]);
    assert_eq!(asked.takes_of_control, 1);
}

#[test]
fn a_lens_of_another_aspect_ratio_ends_the_run_at_the_first_picture() {
    let size = frame(0, at(0)).picture.size();
    let end = |picture: PictureSize| {
        let mut profile = VehicleProfile::fotokite_pro();
        profile.camera.lens = Some(Lens::pinhole(picture, 330.0));
        run_vehicle(profile, pilot(), &[], [(1_100, Frame), (1_200, quit())], true).end
    };
    assert!(matches!(end(PictureSize::new(2 * size.width, 2 * size.height)), RunEnd::Requested(_)));
    match end(PictureSize::new(size.width, 2 * size.height)) {
        RunEnd::Failed(why) => assert!(why.contains("camera.lens is calibrated for"), "{why}"),
        other => panic!("{other:?}"),
    }
}

#[test]
fn a_stop_request_is_sent_as_rest_at_once() {
    let stop = OperatorRequest::Stop(StopCause::Operator);
    let arrivals = [(1_100, Frame), (1_150, Arrival::Request(stop)), (1_200, Frame), (1_201, quit())];
    let run = run(&[SELECT, ENGAGE], arrivals);
    assert_eq!(run.sent[2].0, moving());
    assert_eq!(run.recorded[3], (1_150, "Stop(Operator)".to_owned(), Mode::Stopped(StopCause::Operator)));
    assert!(run.sent[3..].iter().all(|(rates, _)| rates.is_rest()), "also after the next frame");
}

#[test]
fn a_stop_that_is_in_force_already_is_not_recorded_again() {
    let stop = OperatorRequest::Stop(StopCause::Operator);
    let stops = (0..50).map(|k| (1_150 + k, Arrival::Request(stop)));
    let again = [(1_300, Arrival::Request(ENGAGE)), (1_310, Arrival::Request(stop)), (1_320, quit())];
    let run = run(&[SELECT, ENGAGE], [(1_100, Frame)].into_iter().chain(stops).chain(again));
    let recorded = run.inputs().into_iter().filter(|(_, input)| *input == "Stop(Operator)");
    let times: Vec<u64> = recorded.map(|(ms, _)| ms).collect();
    assert_eq!(times, [1_150, 1_310], "the first one, and the first one after an engagement");
}

#[test]
fn each_end_of_a_run_sends_a_stop_last() {
    let failed = |reason: &str| (StopCause::Fault, RunEnd::Failed(reason.to_owned()));
    let requested = |reason: &str| (StopCause::Ending, RunEnd::Requested(reason.to_owned()));
    let panicked = |thread: &str| event(Event::ThreadPanicked { thread: thread.to_owned() });
    let broken = VideoError::Provided { reason: "no such video".to_owned() };
    for (arrival, (cause, end)) in [
        (
            event(Event::Video(VideoNumber::First, VideoState::Ended)),
            (StopCause::VideoEnded, RunEnd::VideoEnded),
        ),
        (event(Event::Video(VideoNumber::First, VideoState::Failed(broken))), failed("no such video")),
        (quit(), requested("q was pressed")),
        (event(Event::Quit(QuitCause::Signal("SIGTERM"))), requested("SIGTERM was received")),
        (event(Event::Quit(QuitCause::OutputClosed)), requested("the output was closed")),
        (panicked("recorder"), failed("the recorder thread panicked")),
        (panicked("video"), failed("the video thread panicked")),
        (event(Event::Link(LinkReport::Panicked)), failed("the link thread panicked")),
        (Gone, failed("every source has gone")),
    ] {
        let run = run(&[SELECT, ENGAGE], [(1_100, Frame), (1_150, arrival)]);
        assert_eq!(run.end, end);
        assert_eq!(run.last(), (&*format!("Stop({cause:?})"), Mode::Stopped(cause)), "{end:?}");
        let [.., before, last] = run.sent[..] else { panic!("{:?}", run.sent) };
        assert_eq!(before.0, moving(), "the camera moves until then: {end:?}");
        assert_eq!(last, (VehicleRates::REST, None), "{end:?}");
    }
}

#[test]
fn a_refused_selection_ends_the_run_where_it_cannot_be_made_again() {
    let refused = [OperatorRequest::Camera(CameraRequest::SelectNext(REFUSED)), ENGAGE];
    let run = run(&refused, [(1_100, Frame), (1_200, Frame)]);
    assert!(matches!(&run.end, RunEnd::Failed(reason) if reason.contains("width")), "{:?}", run.end);
    assert_eq!(run.last(), ("Stop(Fault)", Mode::Stopped(StopCause::Fault)));
    assert_eq!(run.overlaid.len(), 4, "the second frame is not processed");
}

#[test]
fn a_refused_selection_can_be_made_again_elsewhere() {
    let refused = [OperatorRequest::Camera(CameraRequest::SelectNext(REFUSED)), ENGAGE];
    let arrivals = [(1_100, Frame), (1_150, Arrival::Request(SELECT)), (1_200, Frame), (1_210, quit())];
    let run = run_with(&refused, arrivals, false);
    assert_eq!(run.end, RunEnd::Requested("q was pressed".to_owned()));
    assert!(run.recorded.iter().any(|(_, input, mode)| input == "frame 1" && *mode == Mode::Servoing));
}

#[test]
fn a_marked_moment_is_recorded_with_its_time_and_is_no_step() {
    let arrivals = [(1_100, Frame), (1_150, Arrival::Note("smoke")), (1_210, quit())];
    let (marked, unmarked) = (run(&[SELECT], arrivals), run(&[SELECT], [(1_100, Frame), (1_210, quit())]));
    assert_eq!(marked.notes, [(1_150, "smoke".to_owned())]);
    assert_eq!(marked.recorded, unmarked.recorded);
    let failure = event(Event::RecordingFailed { reason: "disk full".to_owned() });
    let run = run(&[], [(1_100, failure), (1_150, Arrival::Note("smoke")), (1_210, quit())]);
    assert_eq!(run.notes, [], "nothing is recorded");
}

#[test]
fn a_failed_recording_raises_an_alarm_and_the_run_goes_on_without_it() {
    let failure = event(Event::RecordingFailed { reason: "disk full".to_owned() });
    let run = run(&[SELECT, ENGAGE], [(1_100, Frame), (1_150, failure), (1_200, Frame), (1_400, quit())]);
    assert_eq!(run.end, RunEnd::Requested("q was pressed".to_owned()));
    assert_eq!(run.recorded.len(), 3, "nothing is recorded after the failure");
    assert_eq!(run.sent[3].0, moving(), "the camera is moved as before");
    assert!(run.lines.last().unwrap().contains("ALARM: recording failed: disk full |"), "{:?}", run.lines);
}

#[test]
fn ticks_come_when_the_pilots_deadline_is_due() {
    let run = run(&[SELECT, ENGAGE], [(1_100, Frame), (3_000, quit())]);
    let silent = Mode::Holding(HoldCause::VideoSilent);
    assert_eq!(
        run.recorded[3..],
        [
            (1_100 + COAST_MS, "tick".to_owned(), silent),
            (3_000, "Stop(Ending)".to_owned(), Mode::Stopped(StopCause::Ending))
        ],
        "one tick at the deadline, and none without a deadline"
    );
    assert_eq!(run.sent[3], (VehicleRates::REST, None));
}

#[test]
fn an_event_without_a_frame_in_the_slot_makes_no_step() {
    let run = run(&[], [(1_100, event(Event::Frame)), (1_200, quit())]);
    assert_eq!(run.inputs(), [(1_200, "Stop(Ending)")]);
}

#[test]
fn losses_of_video_and_link_are_survived() {
    let lost = || event(Event::Video(VideoNumber::First, VideoState::Lost { reason: "time-out".to_owned() }));
    let run = run(
        &[SELECT, ENGAGE],
        [
            (1_050, event(Event::Video(VideoNumber::First, VideoState::Connecting))),
            (1_060, lost()),
            (1_070, event(Event::Video(VideoNumber::First, VideoState::Up))),
            (1_100, Frame),
            (
                1_120,
                event(Event::Link(LinkReport::Lost {
                    reason: "unplugged".to_owned(),
                    may_be_turning: false,
                })),
            ),
            (1_130, lost()),
            (1_140, lost()),
            (1_200, Frame),
            (1_210, quit()),
        ],
    );
    assert_eq!(run.end, RunEnd::Requested("q was pressed".to_owned()));
    assert_eq!(run.sent[3].0, moving());
}

#[test]
fn the_links_state_is_stepped_and_shown() {
    let up = Telemetry { at: at(1_050), report: Report::Link(LinkState::Up) };
    let run = run(&[], [(1_050, event(Event::Link(LinkReport::Telemetry(up)))), (1_300, quit())]);
    assert_eq!(run.inputs()[0], (1_050, "telemetry"));
    assert!(run.lines[0].contains("| link opening |"), "{:?}", run.lines);
    assert!(run.lines.last().unwrap().contains("| link up |"), "{:?}", run.lines);
}

#[test]
fn rates_are_sent_while_the_vehicle_takes_commands_only() {
    let report = |ms, report| {
        let telemetry = Telemetry { at: at(ms), report };
        (ms, event(Event::Link(LinkReport::Telemetry(telemetry))))
    };
    let ground = |ms, control| {
        report(ms, Report::Ground { control, uptime_s: ms as f64 * 1e-3, battery_v: 12.0, tether_m: 1.0 })
    };
    let arrivals = [
        (1_100, Frame),
        report(1_150, Report::Link(LinkState::Up)),
        ground(1_160, ControlState::Ours),
        (1_200, Frame),
        report(1_250, Report::Link(LinkState::Opening)),
        (1_300, Frame),
        report(1_350, Report::Link(LinkState::Up)),
        ground(1_360, ControlState::Ours),
        (1_400, Frame),
        ground(1_450, ControlState::Elsewhere),
        ground(1_460, ControlState::Ours),
        (1_500, Frame),
        (1_550, Arrival::Request(ENGAGE)),
        (1_600, Frame),
        (1_610, quit()),
    ];
    let run = run_pilot(pilot().commanding(CommandPath::Link), &[SELECT, ENGAGE], arrivals, true);
    let frames = run.recorded.iter().zip(&run.sent).filter(|((_, input, _), _)| input.starts_with("frame"));
    let sent: Vec<(Mode, VehicleRates)> = frames.map(|((_, _, mode), (rates, _))| (*mode, *rates)).collect();
    let down = (Mode::Holding(HoldCause::LinkDown), VehicleRates::REST);
    let following = (Mode::Servoing, moving());
    let taken = (Mode::Stopped(StopCause::ControlLost), VehicleRates::REST);
    assert_eq!(sent, [down, following, down, following, taken, following]);
    let at_1350 = run.recorded.iter().position(|(ms, ..)| *ms == 1_350).unwrap();
    assert_eq!(run.recorded[at_1350].2, Mode::Servoing, "the link is back");
    assert!(run.sent[at_1350].0.is_rest(), "but the camera moves with the next frame only");
}
