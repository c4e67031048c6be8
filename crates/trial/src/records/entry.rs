//! What a recording is a sequence of.

use core::time::Duration;

use barrelman_control::Percept;
use barrelman_pilot::{Advice, Mode, Outcome};
use barrelman_sim::Truth;
use barrelman_vocab::video::{Capture, ColourEncoding};
use barrelman_vocab::{
    Angle, CameraCommand, EncodedUnit, ImagePoint, OperatorRequest, PictureSize, Telemetry, Timestamp, Track,
    VehicleRates, VideoFrame,
};

/// One entry.
#[derive(Debug, Clone, PartialEq)]
pub enum Entry {
    /// What ran, with which settings, on which clock. The first entry.
    Start(RecordingStart),
    /// A piece of video, as received.
    Unit(EncodedUnit),
    /// An input of the pilot.
    Input {
        /// Running number of the step, from 0.
        step: u64,
        /// The `now` of the step.
        now: Timestamp,
        /// The input.
        input: RecordedInput,
    },
    /// What came of a step.
    Outcome(RecordedOutcome),
    /// What is true of a simulated world as a picture is taken.
    Truth(RecordedTruth),
}

/// What ran, with which settings, on which clock.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct RecordingStart {
    /// Version of the program.
    pub program_version: String,
    /// `CLOCK_MONOTONIC` at the program's start, nanoseconds.
    pub monotonic_ns: u64,
    /// Unix time at the program's start, nanoseconds.
    pub unix_ns: u64,
    /// The full effective configuration, TOML.
    pub configuration: String,
    /// Where the video came from, without passwords.
    pub video: String,
    /// Where the commands went; empty for a dry run.
    pub link: String,
    /// Whether the video was live, which tells a decoder in which order to show it.
    pub live_video: bool,
}

/// An input of the pilot, as stored: a video frame by what tells it from others.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum RecordedInput {
    /// A video frame.
    Frame(FrameStamp),
    /// A localisation measured elsewhere.
    Localisation(Track),
    /// A report of the vehicle.
    Telemetry(Telemetry),
    /// A request of the operator.
    Request(OperatorRequest),
    /// The passing of time.
    Tick,
}

/// What tells a video frame from others.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct FrameStamp {
    /// Running number of the decoded frame.
    pub sequence: u64,
    /// When it was taken.
    pub capture: Capture,
    /// Its size.
    pub size: PictureSize,
    /// How its samples stand for colours.
    pub colour: ColourEncoding,
    /// XXH3-64 of its luma plane, rows tightly packed.
    pub luma_hash: u64,
}

impl FrameStamp {
    /// The stamp of a frame. Reads the whole luma plane once.
    pub fn of(frame: &VideoFrame) -> Self {
        let luma = &frame.picture.samples()[..frame.picture.size().area()];
        Self {
            sequence: frame.sequence,
            capture: frame.capture,
            size: frame.picture.size(),
            colour: frame.picture.colour(),
            luma_hash: xxhash_rust::xxh3::xxh3_64(luma),
        }
    }
}

/// What is true of a simulated world as a picture is taken, as stored. Places and angles are those of
/// [`barrelman_sim::pose`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RecordedTruth {
    /// The world's tick.
    pub tick: u64,
    /// Its time.
    pub at: Timestamp,
    /// Where the target is, metres: x, y.
    pub target_m: (f64, f64),
    /// Where its bow points.
    pub heading: Angle,
    /// Where the camera is, metres: x, y, z.
    pub camera_m: (f64, f64, f64),
    /// Its pan.
    pub pan: Angle,
    /// Its tilt.
    pub tilt: Angle,
    /// Where the target is in the picture, also where that is beyond its border.
    pub image: ImagePoint,
    /// Whether it is within the picture.
    pub in_picture: bool,
    /// From the camera to the target, metres.
    pub range_m: f64,
}

impl From<&Truth> for RecordedTruth {
    fn from(truth: &Truth) -> Self {
        let (camera, target) = (truth.camera, truth.target);
        Self {
            tick: truth.tick,
            at: truth.at,
            target_m: (target.position.x, target.position.y),
            heading: target.heading,
            camera_m: (camera.position.x, camera.position.y, camera.position.z),
            pan: camera.pan,
            tilt: camera.tilt,
            image: truth.image,
            in_picture: truth.in_picture,
            range_m: truth.range_m,
        }
    }
}

/// What came of a step, as stored.
#[derive(Debug, Clone, PartialEq)]
pub struct RecordedOutcome {
    /// Running number of the step, as of its input.
    pub step: u64,
    /// The `now` of the step.
    pub at: Timestamp,
    /// The mode.
    pub mode: Mode,
    /// The track.
    pub track: Track,
    /// Age of what was seen in this step.
    pub age: Option<Duration>,
    /// What the newest localisation means to the law.
    pub percept: Option<Percept>,
    /// What the law asks for.
    pub advice: Option<Advice>,
    /// The command in force, inside.
    pub command: CameraCommand,
    /// The same in the vehicle's own signs, as handed to the link.
    pub rates: VehicleRates,
    /// When the pilot was to be stepped again.
    pub wake_at: Option<Timestamp>,
    /// What the operator was told; empty where nothing.
    pub notice: String,
}

impl RecordedOutcome {
    /// An outcome with its number and what was made of its command at the door.
    pub fn new(step: u64, outcome: &Outcome, rates: VehicleRates) -> Self {
        Self {
            step,
            at: outcome.at,
            mode: outcome.mode,
            track: outcome.track,
            age: outcome.age,
            percept: outcome.percept,
            advice: outcome.advice,
            command: outcome.command,
            rates,
            wake_at: outcome.wake_at,
            notice: outcome.notice.as_ref().map(ToString::to_string).unwrap_or_default(),
        }
    }
}
