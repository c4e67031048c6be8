//! The simulated program of a boat: the real pilot on the truth, with its second actuator, and the console's
//! watch.

use core::time::Duration;

use std::sync::{Arc, Mutex, PoisonError};

use barrelman_link::RequestedCommand;
use barrelman_link::guard::message::ToGuard;
use barrelman_pilot::vessel::{GuidanceLaw, Mark};
use barrelman_pilot::{
    CommandPath, Input, LawSettings, Notice, Pilot, PilotSettings, Refusal, VesselMode, VesselSettings,
};
use barrelman_vocab::acceptance::Acceptance;
use barrelman_vocab::telemetry::{LinkState, Report};
use barrelman_vocab::video::{Capture, CaptureQuality, ColourEncoding, Picture};
use barrelman_vocab::{
    Angle, DrawnMark, FailSafe, HoldCause, MarkKind, OperatorRequest, PixelPoint, StopCause, Telemetry,
    Timestamp, Track, VehicleProfile, VesselOrder, VesselProfile, VesselRequest, VesselStopper, VideoFrame,
};

use super::super::link_end::{LinkEnd, LinkEvent};
use super::super::mutant::Mutant;
use super::super::picture::PICTURE;
use super::super::video_path::Arrived;
use super::console::Console;
use super::oracle::{VesselOracle, VideoArrival};
use super::person_picture::person_picture;
use super::truth_tracker::{Truth, TruthTracker};

/// A point of the water, to the right of the boat.
const MARK: PixelPoint = PixelPoint { u: 480.0, v: 330.0 };
/// One so far away that a boat can keep way.
const FAR_MARK: PixelPoint = PixelPoint { u: 330.0, v: 90.0 };
/// From the capture of the newest video frame to a mark on it.
const MARK_AGE: Duration = Duration::from_millis(150);
/// The camera's height and tilt.
const HEIGHT_M: f64 = 15.0;
const TILT: Angle = Angle::from_degrees(-40.0);

/// The program.
pub(super) struct VesselProgram {
    pilot: Pilot,
    profile: VehicleProfile,
    mutant: Mutant,
    wake_at: Option<Timestamp>,
    mode: VesselMode,
    pan_rad_per_s: f64,
    truth: Truth,
    /// The pixels of every video frame: only the tracker of a mark reads them.
    pixels: Arc<Picture>,
    frames: u64,
    mark: (MarkKind, PixelPoint),
    /// Whether the boat was guided to a mark that a tracker held.
    pub(super) went_to_held_mark: bool,
    pub(super) console: Console,
    /// The program's end of the link to the boat.
    pub(super) end: LinkEnd<VesselOrder>,
}

impl VesselProgram {
    /// The program of this boat. Its mark is a place, or a person, whom a tracker holds.
    pub(super) fn new(vessel: VesselProfile, guidance: GuidanceLaw, marks: MarkKind, mutant: Mutant) -> Self {
        let mark = if vessel.fail_safe == FailSafe::Neutral { MARK } else { FAR_MARK };
        let pixels = match marks {
            MarkKind::Person => person_picture(PICTURE, mark),
            MarkKind::Place | MarkKind::WayPoint | MarkKind::Forbidden | MarkKind::Home => {
                Picture::black(PICTURE, ColourEncoding::JPEG)
            }
        };
        let truth = Truth::new(Mutex::new(None));
        let tracker = Box::new(TruthTracker::new(Arc::clone(&truth)));
        let profile = VehicleProfile::fotokite_pro();
        let settings = PilotSettings { profile: profile.clone(), law: LawSettings::MotorSchema };
        let settings_of_vessel = VesselSettings { profile: vessel, guidance, path: CommandPath::Link };
        Self {
            pilot: Pilot::new(settings, tracker).keeping_frames().with_vessel(settings_of_vessel),
            profile,
            mutant,
            wake_at: None,
            mode: VesselMode::Released,
            pan_rad_per_s: 0.0,
            truth,
            pixels: Arc::new(pixels),
            frames: 0,
            mark: (marks, mark),
            went_to_held_mark: false,
            console: Console::new(),
            end: LinkEnd::new(RequestedCommand { command: VesselOrder::Released, renew_by: None }),
        }
    }

    /// The camera's rate, to the right.
    pub(super) const fn pan_rad_per_s(&self) -> f64 {
        self.pan_rad_per_s
    }

    /// The run loop: the console's watch, what the link reports, and the pilot's deadline.
    pub(super) fn advance(&mut self, oracle: &mut VesselOracle, now: Timestamp) {
        let moves = matches!(
            self.mode,
            VesselMode::ByHand | VesselMode::Guided | VesselMode::Holding(_) | VesselMode::KeepingWay(_)
        );
        let is_left = self.console.is_left(now) && self.mutant != Mutant::NoConsoleTimeOut;
        if moves && is_left {
            self.request(
                OperatorRequest::Vessel(VesselRequest::StopVessel { by: VesselStopper::ConsoleLost }),
                now,
            );
        }
        while let Some(event) = self.end.next_event(now) {
            match event {
                LinkEvent::Telemetry(telemetry) => self.on_telemetry(telemetry, oracle, now),
                LinkEvent::Suspended => self.on_suspension(oracle, now),
            }
        }
        if self.wake_at.is_some_and(|at| at <= now) {
            self.step(Input::Tick, now);
        }
    }

    pub(super) fn on_suspension(&mut self, oracle: &mut VesselOracle, now: Timestamp) {
        oracle.withdraw();
        self.request(OperatorRequest::Stop(StopCause::Suspended), now);
    }

    /// What takes another Go, or a helm that is let go and pressed again, judged apart from the pilot: a boat
    /// that fell silent, a link that is lost, and a boat that does not take commands any more.
    fn on_telemetry(&mut self, telemetry: Telemetry, oracle: &mut VesselOracle, now: Timestamp) {
        match telemetry.report {
            Report::Link(LinkState::Silent) => oracle.withdraw(),
            Report::Link(LinkState::Up) => {}
            Report::Link(_) => {
                oracle.end_way();
                oracle.withdraw_helm();
            }
            Report::Acceptance(Acceptance::Accepted) => {}
            Report::Acceptance(_) => oracle.withdraw(),
            _ => {}
        }
        self.step(Input::VesselTelemetry(telemetry), now);
    }

    /// What the camera's vehicle reports of height and tilt.
    pub(super) fn report_height(&mut self, now: Timestamp) {
        for report in [Report::CameraTilt(TILT), Report::CameraHeight(HEIGHT_M)] {
            self.step(Input::Telemetry(Telemetry { at: now, report }), now);
        }
    }

    /// A picture has arrived.
    pub(super) fn see(&mut self, arrived: Arrived, now: Timestamp) -> VideoArrival {
        let Arrived { captured, delay, picture } = arrived;
        *self.truth.lock().unwrap_or_else(PoisonError::into_inner) = Some(picture);
        let frame = VideoFrame {
            sequence: self.frames,
            capture: Capture { at: captured, quality: CaptureQuality::Sensor },
            picture: Arc::clone(&self.pixels),
        };
        self.frames += 1;
        self.step(Input::Frame(&frame), now);
        let track = picture.track(captured, None);
        VideoArrival {
            is_fresh: delay <= self.profile.video_latency + self.profile.stale_after,
            is_boat_found: matches!(track, Track::Tracking(_)),
        }
    }

    /// Marks a place on a video frame. Returns whether it is marked.
    pub(super) fn mark(&mut self, now: Timestamp) -> bool {
        let (mark, at) = self.mark;
        let drawn = DrawnMark { mark, at, captured_ns: now.minus(MARK_AGE) };
        matches!(
            self.request(OperatorRequest::Vessel(VesselRequest::Mark(drawn)), now),
            Some(Notice::Marked(..))
        )
    }

    /// The operator presses Go. A boat that another commander steers is asked for.
    pub(super) fn go(&mut self, now: Timestamp) {
        self.console.commands_vessel(now);
        let notice = self.request(OperatorRequest::Vessel(VesselRequest::Guide), now);
        if matches!(
            notice,
            Some(Notice::RequestRefused(
                Refusal::NoVesselMotion(HoldCause::NoControl) | Refusal::NotAccepted(_)
            ))
        ) {
            self.end.take_control();
        }
    }

    /// A request of the operator.
    pub(super) fn request(&mut self, request: OperatorRequest, now: Timestamp) -> Option<Notice> {
        if matches!(request, OperatorRequest::Vessel(VesselRequest::Steer(_))) {
            self.console.commands_vessel(now);
        }
        self.step(Input::Request(request), now)
    }

    fn step(&mut self, input: Input<'_>, now: Timestamp) -> Option<Notice> {
        let outcome = self.pilot.step(input, now);
        self.wake_at = outcome.next_step_at();
        self.pan_rad_per_s = outcome.command.pan.radians_per_second();
        self.mode = outcome.vessel.mode;
        self.went_to_held_mark |= self.mode == VesselMode::Guided
            && !outcome.vessel.command.is_neutral()
            && outcome.vessel.marks.iter().any(Mark::is_held);
        let command = match outcome.vessel.is_commanded() {
            true => VesselOrder::Commanded(outcome.vessel.command),
            false => VesselOrder::Released,
        };
        self.end.request(RequestedCommand { command, renew_by: outcome.vessel.renew_by }, now);
        outcome.notice
    }

    /// Ends the link in order.
    pub(super) fn close(&mut self, now: Timestamp) {
        self.request(OperatorRequest::Stop(StopCause::Ending), now);
        self.end.outbox.push_back(ToGuard::Close);
    }
}
