//! Scenes: sequences of inputs for a pilot.

use core::time::Duration;
use std::collections::VecDeque;
use std::sync::{Arc, Mutex};

use barrelman_pilot::{Input, LawSettings, Mode, Outcome, Pilot, PilotSettings};
use barrelman_vision::{Explanation, SelectionError, SelectionReport, Tracker};
use barrelman_vocab::telemetry::{LinkState, Report};
use barrelman_vocab::video::{Capture, CaptureQuality, ColourEncoding};
use barrelman_vocab::{
    AngularRate, CameraCommand, CameraRequest, ImagePoint, Localisation, MotionPrior, OperatorRequest,
    Picture, PictureSize, PixelBox, StopCause, Telemetry, Timestamp, Track, VehicleProfile, VideoFrame,
};

pub(crate) const PICTURE: PictureSize = PictureSize::new(640, 480);

/// A point inside the region of a 640x480 picture (192 x 120 px).
pub(crate) const INSIDE: ImagePoint = ImagePoint { x: 20.0, y: -10.0 };
pub(crate) const RIGHT: ImagePoint = ImagePoint { x: 250.0, y: 30.0 };
pub(crate) const LEFT: ImagePoint = ImagePoint { x: -250.0, y: 30.0 };
pub(crate) const TOP: ImagePoint = ImagePoint { x: 30.0, y: 200.0 };
pub(crate) const BOTTOM: ImagePoint = ImagePoint { x: 30.0, y: -200.0 };

const RATE: AngularRate = AngularRate::from_radians_per_second(0.3);
const BACK: AngularRate = AngularRate::from_radians_per_second(-0.3);
pub(crate) const REST: CameraCommand = CameraCommand::REST;
pub(crate) const PAN_RIGHT: CameraCommand = CameraCommand::turning(RATE, AngularRate::ZERO);
pub(crate) const PAN_LEFT: CameraCommand = CameraCommand::turning(BACK, AngularRate::ZERO);
pub(crate) const TILT_UP: CameraCommand = CameraCommand::turning(AngularRate::ZERO, RATE);
pub(crate) const TILT_DOWN: CameraCommand = CameraCommand::turning(AngularRate::ZERO, BACK);

/// The nominal age of a localisation, and the largest fresh age: 200 ms + 300 ms for the Fotokite Pro.
pub(crate) const LATENCY_MS: u64 = 200;
pub(crate) const FRESH_MS: u64 = 500;
/// How long a rate lasts after the last fresh localisation.
pub(crate) const COAST_MS: u64 = 250;

/// One input of a pilot.
#[derive(Debug, Clone, Copy)]
pub(crate) enum SceneInput {
    /// The target was measured there, at the nominal age.
    Seen(ImagePoint),
    /// The target was measured there, with an age in milliseconds.
    SeenLate(ImagePoint, u64),
    /// The target is predicted there.
    Coasts(ImagePoint),
    /// The target is lost.
    Lost,
    /// An observation without a selection.
    Unseeded,
    /// Telemetry of the vehicle.
    Reports,
    Tick,
    Select,
    Engage,
    Disengage,
    Stop(StopCause),
}

/// A time with room for a latency before it.
pub(crate) fn at(ms: u64) -> Timestamp {
    Timestamp::from_nanos((10_000 + ms) * 1_000_000)
}

pub(crate) fn seen(point: ImagePoint, captured: Timestamp) -> Localisation {
    let centre = point.in_pixels(PICTURE);
    let bounds = PixelBox { u: centre.u - 10.0, v: centre.v - 5.0, w: 20.0, h: 10.0 };
    Localisation { captured, picture: PICTURE, centre, bounds, shape: None, heading: None, confidence: 0.9 }
}

impl SceneInput {
    /// The corresponding input at `now`.
    pub(crate) fn input(self, now: Timestamp) -> Input<'static> {
        let ago = |ms: u64| now.minus(Duration::from_millis(ms));
        match self {
            Self::Seen(point) => Self::SeenLate(point, LATENCY_MS).input(now),
            Self::SeenLate(point, age_ms) => Input::Localisation(Track::Tracking(seen(point, ago(age_ms)))),
            Self::Coasts(point) => Input::Localisation(Track::Coasting(seen(point, ago(LATENCY_MS)))),
            Self::Lost => Input::Localisation(Track::Lost { since: ago(LATENCY_MS), confidence: 0.1 }),
            Self::Unseeded => Input::Localisation(Track::Unseeded),
            Self::Reports => Input::Telemetry(Telemetry { at: now, report: Report::Link(LinkState::Up) }),
            Self::Tick => Input::Tick,
            Self::Select => {
                Input::Request(OperatorRequest::Camera(CameraRequest::SelectNext(PICTURE.bounds())))
            }
            Self::Engage => Input::Request(OperatorRequest::Camera(CameraRequest::Engage)),
            Self::Disengage => Input::Request(OperatorRequest::Camera(CameraRequest::Disengage)),
            Self::Stop(cause) => Input::Request(OperatorRequest::Stop(cause)),
        }
    }
}

pub(crate) fn settings() -> PilotSettings {
    PilotSettings { profile: VehicleProfile::fotokite_pro(), law: LawSettings::MotorSchema }
}

/// A pilot that receives localisations and no frames.
pub(crate) fn localisation_pilot() -> Pilot {
    Pilot::new(settings(), Box::new(Scripted::default()))
}

/// Runs a pilot through a scene and returns every outcome.
pub(crate) fn outcomes(scene: &[(u64, SceneInput)]) -> Vec<Outcome> {
    let mut pilot = localisation_pilot();
    scene.iter().map(|(ms, input)| pilot.step(input.input(at(*ms)), at(*ms))).collect()
}

/// Runs a pilot through a scene and checks mode and command of the last outcome.
#[track_caller]
pub(crate) fn check(scene: &[(u64, SceneInput)], mode: Mode, command: CameraCommand) {
    let outcomes = outcomes(scene);
    let last = outcomes.last().unwrap();
    assert_eq!((last.mode, last.command), (mode, command), "{scene:?}");
}

/// A tracker with predefined answers.
#[derive(Debug, Default)]
pub(crate) struct Scripted {
    /// Answers for tracked frames.
    pub(crate) tracks: VecDeque<Answer>,
    /// Answers for selections; `None` refuses.
    pub(crate) selections: VecDeque<Option<ImagePoint>>,
    /// The motion priors that the tracker received, one per frame.
    pub(crate) priors: Arc<Mutex<Vec<Option<MotionPrior>>>>,
    /// Whether the boat may go bow first, as the tracker was told last.
    pub(crate) is_bow_first: Arc<Mutex<Option<bool>>>,
}

/// The answer of a scripted tracker to a frame.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Answer {
    Tracking(ImagePoint),
    /// Tracking, with a confidence of 0.6.
    Doubtful(ImagePoint),
    Coasting(ImagePoint),
    Lost,
    Unseeded,
}

impl Answer {
    pub(crate) fn track(self, captured: Timestamp) -> Track {
        match self {
            Self::Tracking(point) => Track::Tracking(seen(point, captured)),
            Self::Doubtful(point) => {
                Track::Tracking(Localisation { confidence: 0.6, ..seen(point, captured) })
            }
            Self::Coasting(point) => Track::Coasting(seen(point, captured)),
            Self::Lost => Track::Lost { since: captured, confidence: 0.0 },
            Self::Unseeded => Track::Unseeded,
        }
    }
}

pub(crate) fn refusal(selection: PixelBox) -> SelectionError {
    SelectionError::Empty { selection, picture: PICTURE }
}

pub(crate) fn report(localisation: Localisation) -> SelectionReport {
    SelectionReport {
        used: localisation.bounds,
        is_clipped: false,
        is_refined: false,
        coloured_share: 1.0,
        surroundings_probability: 0.0,
        localisation,
    }
}

impl Tracker for Scripted {
    fn select(&mut self, frame: &VideoFrame, selection: PixelBox) -> Result<SelectionReport, SelectionError> {
        let point = self.selections.pop_front().flatten().ok_or_else(|| refusal(selection))?;
        Ok(report(seen(point, frame.capture.at)))
    }

    fn track(&mut self, frame: &VideoFrame, prior: Option<&MotionPrior>) -> Track {
        self.priors.lock().unwrap().push(prior.copied());
        self.tracks.pop_front().map_or(Track::Unseeded, |answer| answer.track(frame.capture.at))
    }

    fn set_bow_first(&mut self, may_be: bool) {
        *self.is_bow_first.lock().unwrap() = Some(may_be);
    }

    fn forget(&mut self) {
        self.tracks.clear();
    }

    fn reject(&mut self) -> bool {
        true
    }

    fn explain(&self, _: &mut Explanation) {}
}

/// A frame with this time of capture. Its picture is not used.
pub(crate) fn frame(sequence: u64, captured: Timestamp) -> VideoFrame {
    let picture = Picture::black(PictureSize::new(2, 2), ColourEncoding::JPEG);
    let capture = Capture { at: captured, quality: CaptureQuality::Sensor };
    VideoFrame { sequence, capture, picture: Arc::new(picture) }
}
