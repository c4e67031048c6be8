//! The pilot's inputs as stored, and the conversion from and to [`Input`].

use barrelman_pilot::{Detections, Input};
use barrelman_vocab::video::{Capture, ColourEncoding};
use barrelman_vocab::{OperatorRequest, PictureSize, Telemetry, Track, VideoFrame, VideoNumber};

/// An input of the pilot as stored: the fingerprint stands for a video frame.
#[derive(Debug, Clone, PartialEq)]
pub enum RecordedInput {
    /// A video frame.
    Frame(FrameFingerprint),
    /// A localisation measured elsewhere.
    Localisation(Track),
    /// A report of the camera's vehicle.
    Telemetry(Telemetry),
    /// A report of the vessel.
    VesselTelemetry(Telemetry),
    /// What a detector found.
    Detections(Box<Detections>),
    /// A request of the operator.
    Request(OperatorRequest),
    /// The passing of time.
    Tick,
}

impl RecordedInput {
    /// Converts an input of a run with one video. Reads the whole luma plane of a video frame.
    pub fn from_input(input: &Input<'_>) -> Self {
        let of_first = |frame| Self::Frame(FrameFingerprint::from_frame(VideoNumber::First, frame));
        Self::from_frameless(input).unwrap_or_else(of_first)
    }

    /// Converts an input other than a video frame, at negligible cost.
    ///
    /// # Errors
    /// The video frame, where the input is one: the caller decides where to compute its fingerprint.
    pub fn from_frameless<'a>(input: &Input<'a>) -> Result<Self, &'a VideoFrame> {
        match *input {
            Input::Frame(frame) => Err(frame),
            Input::Localisation(track) => Ok(Self::Localisation(track)),
            Input::Telemetry(telemetry) => Ok(Self::Telemetry(telemetry)),
            Input::VesselTelemetry(telemetry) => Ok(Self::VesselTelemetry(telemetry)),
            Input::Detections(detections) => Ok(Self::Detections(Box::new(detections.clone()))),
            Input::Request(request) => Ok(Self::Request(request)),
            Input::Tick => Ok(Self::Tick),
        }
    }

    /// The operator's request; `None` for other inputs.
    pub const fn request(&self) -> Option<&OperatorRequest> {
        match self {
            Self::Request(request) => Some(request),
            Self::Frame(_)
            | Self::Localisation(_)
            | Self::Telemetry(_)
            | Self::VesselTelemetry(_)
            | Self::Detections(_)
            | Self::Tick => None,
        }
    }

    /// Converts back to an input; `frame_of` supplies the video frame of a fingerprint.
    ///
    /// # Errors
    /// The error of `frame_of`.
    pub fn to_input<'a, E>(
        &'a self,
        frame_of: impl FnOnce(&FrameFingerprint) -> Result<&'a VideoFrame, E>,
    ) -> Result<Input<'a>, E> {
        Ok(match self {
            Self::Frame(fingerprint) => Input::Frame(frame_of(fingerprint)?),
            Self::Localisation(track) => Input::Localisation(*track),
            Self::Telemetry(telemetry) => Input::Telemetry(*telemetry),
            Self::VesselTelemetry(telemetry) => Input::VesselTelemetry(*telemetry),
            Self::Detections(detections) => Input::Detections(detections),
            Self::Request(request) => Input::Request(*request),
            Self::Tick => Input::Tick,
        })
    }
}

/// Identifies a video frame among those of a recording.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct FrameFingerprint {
    /// The video that the frame belongs to.
    pub video: VideoNumber,
    /// Running number of the decoded frame of that video.
    pub sequence: u64,
    /// Time of capture, and its quality.
    pub capture: Capture,
    /// Size of the picture.
    pub size: PictureSize,
    /// Colour encoding of the samples.
    pub colour: ColourEncoding,
    /// XXH3-64 of the luma plane, rows tightly packed.
    pub luma_hash: u64,
}

impl FrameFingerprint {
    /// The fingerprint of a frame of a video. Reads the whole luma plane once.
    pub fn from_frame(video: VideoNumber, frame: &VideoFrame) -> Self {
        let luma = &frame.picture.samples()[..frame.picture.size().area()];
        Self {
            video,
            sequence: frame.sequence,
            capture: frame.capture,
            size: frame.picture.size(),
            colour: frame.picture.colour(),
            luma_hash: xxhash_rust::xxh3::xxh3_64(luma),
        }
    }
}
