//! The entries of a recording.

use core::time::Duration;

use barrelman_control::Percept;
use barrelman_control::water::earth::place_on_earth;
use barrelman_pilot::vessel::Mark;
use barrelman_pilot::{Advice, CommandPath, Mode, Outcome, VesselMode};
use barrelman_sim::Truth;
use barrelman_vocab::earth::GeoPoint;
use barrelman_vocab::{
    Angle, CameraCommand, EncodedUnit, ImagePoint, MarkKind, Note, Timestamp, Track, VehicleRates,
    VesselCommand, VesselOrder, VideoNumber, Videos, WaterPoint,
};

use super::recorded_input::RecordedInput;
use crate::target_in_picture::TargetInPicture;

/// An entry of a recording.
#[derive(Debug, Clone, PartialEq)]
pub enum Entry {
    /// Program, configuration and clocks of the run. The first entry.
    Start(RecordingStart),
    /// A unit of a video, as received.
    Unit(VideoNumber, EncodedUnit),
    /// An input of the pilot.
    Input {
        /// Running number of the step, from 0.
        step: u64,
        /// Time of the step.
        now: Timestamp,
        /// The input.
        input: RecordedInput,
    },
    /// The outcome of a step.
    Outcome(RecordedOutcome),
    /// The truth of a simulated world at the capture of a picture.
    Truth(RecordedTruth),
    /// A moment that somebody marked.
    Note {
        /// When.
        at: Timestamp,
        /// The note.
        note: Note,
    },
}

/// Where a video came from.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct RecordedVideo {
    /// The address, without passwords.
    pub address: String,
    /// Whether the video was live: a live decoder returns pictures at once, that of a file in the order of
    /// display.
    pub is_live: bool,
}

impl RecordedVideo {
    /// The videos of a run with one.
    pub fn only(address: impl Into<String>, is_live: bool) -> Videos<Self> {
        Videos::one(Self { address: address.into(), is_live })
    }
}

/// Program, configuration and clocks of a run.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct RecordingStart {
    /// Version of the program and hash of its executable, as `0.1.0+5c1f0a9be2d47f60`.
    pub program: String,
    /// `CLOCK_MONOTONIC` at the program's start, nanoseconds.
    pub monotonic_ns: u64,
    /// Unix time at the program's start, nanoseconds.
    pub unix_ns: u64,
    /// The full effective configuration, TOML.
    pub configuration: String,
    /// The video or videos.
    pub videos: Videos<RecordedVideo>,
    /// URL of the link; empty for a dry run.
    pub link: String,
    /// Where the pilot's commands went.
    pub command_path: CommandPath,
    /// The simulated trial that the recording shows; `None` for other recordings.
    pub trial: Option<SimulatedTrial>,
}

impl RecordingStart {
    /// Whether the recording is of a simulated trial, as far as its address tells.
    pub fn is_simulated_trial(&self) -> bool {
        self.videos.first.address.starts_with("sim:") && !self.videos.first.is_live
    }
}

/// What it takes to run a simulated trial again.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct SimulatedTrial {
    /// The seed.
    pub seed: u64,
    /// The settings of its campaign, as in a campaign's file: JSON.
    pub settings: String,
    /// The text of the scenario's file, TOML.
    pub scenario: String,
}

/// The truth of a simulated world at the capture of a picture, as stored. Positions and angles as in
/// [`barrelman_sim::pose`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RecordedTruth {
    /// Tick of the world.
    pub tick: u64,
    /// Time of capture.
    pub at: Timestamp,
    /// Position of the target, m: x, y.
    pub target_m: (f64, f64),
    /// Heading of the target.
    pub target_heading: Angle,
    /// Position of the camera, m: x, y, z.
    pub camera_m: (f64, f64, f64),
    /// Pan of the camera.
    pub camera_pan: Angle,
    /// Tilt of the camera.
    pub camera_tilt: Angle,
    /// Position of the target in the picture, also beyond the picture's border.
    pub target_position: ImagePoint,
    /// Whether the target is within the picture.
    pub in_picture: bool,
    /// Distance from the camera to the target, m.
    pub range_m: f64,
    /// What the picture shows of the target; `None` where no picture was rendered.
    pub target: Option<TargetInPicture>,
}

impl RecordedTruth {
    /// The stored form of a truth.
    pub fn new(truth: &Truth, target: Option<&TargetInPicture>) -> Self {
        let (camera, body) = (truth.camera, truth.target);
        Self {
            tick: truth.tick,
            at: truth.at,
            target_m: (body.position.x, body.position.y),
            target_heading: body.heading,
            camera_m: (camera.position.x, camera.position.y, camera.position.z),
            camera_pan: camera.pan,
            camera_tilt: camera.tilt,
            target_position: truth.image,
            in_picture: truth.in_picture,
            range_m: truth.range_m,
            target: target.copied(),
        }
    }
}

/// The outcome of a step, as stored.
#[derive(Debug, Clone, PartialEq)]
pub struct RecordedOutcome {
    /// Running number of the step, equal to that of its input.
    pub step: u64,
    /// Time of the step.
    pub at: Timestamp,
    /// Mode of the pilot.
    pub mode: Mode,
    /// The track.
    pub track: Track,
    /// Age of the localisation or video frame of this step; `None` for other inputs.
    pub age: Option<Duration>,
    /// Percept of the newest localisation.
    pub percept: Option<Percept>,
    /// Command that the law asks for, whether or not the camera may move.
    pub advice: Option<Advice>,
    /// Command in force.
    pub command: CameraCommand,
    /// The command in the vehicle's own signs and limits, as sent to the link.
    pub rates: VehicleRates,
    /// Time by which the pilot must be stepped again.
    pub wake_at: Option<Timestamp>,
    /// The vessel's part; `None` without a vessel.
    pub vessel: Option<Box<RecordedVessel>>,
    /// Notice to the operator; empty without one.
    pub notice: String,
}

/// The vessel's part of an outcome, as stored.
#[derive(Debug, Clone, PartialEq)]
pub struct RecordedVessel {
    /// The mode in words.
    pub mode: String,
    /// Command in force.
    pub command: VesselCommand,
    /// Time by which the pilot renews the command.
    pub renew_by: Option<Timestamp>,
    /// Where the boat is on its way; `None` without distances.
    pub progress: Option<RecordedProgress>,
    /// Number of the mark that is the destination, and where it is on the water.
    pub destination: Option<(u32, Option<WaterPoint>)>,
    /// The marks that are on the water.
    pub marks: Vec<RecordedMark>,
    /// Corners of what the picture shows of the water, from the near left one clockwise as seen from above;
    /// `None` where height or tilt are not known.
    pub view: Option<[WaterPoint; 4]>,
    /// The boat on its way; `None` where the vehicle does not report its position and the direction of its
    /// camera from north.
    pub boat_on_earth: Option<GeoPoint>,
}

/// A mark on the water, as stored.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RecordedMark {
    /// Number of the mark.
    pub id: u32,
    /// What is there.
    pub kind: MarkKind,
    /// Where it is at the time of the step.
    pub at: WaterPoint,
    /// Radius of the circle that the boat keeps out of, metres, without the uncertainty; 0: none.
    pub radius_m: f64,
    /// Standard deviation of each coordinate, metres.
    pub std_dev_m: f64,
    /// Where it is on Earth, where that is known.
    pub on_earth: Option<GeoPoint>,
    /// What its tracker answers; `None`: the mark is not held.
    pub held: Option<Track>,
}

/// Where a boat is on its way, as stored.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RecordedProgress {
    /// The boat on the water.
    pub boat: WaterPoint,
    /// Speed over ground, m/s.
    pub speed_m_per_s: f64,
    /// Course, 0 ahead, positive to the right, radians; `None` while unknown.
    pub course_rad: Option<f64>,
    /// Distance to the destination, metres.
    pub distance_m: f64,
    /// Distance from the line, metres, positive to the right of it.
    pub cross_track_m: f64,
}

impl RecordedVessel {
    /// What was asked of the boat.
    pub fn order(&self) -> VesselOrder {
        if self.mode == VesselMode::Released.to_string() {
            VesselOrder::Released
        } else {
            VesselOrder::Commanded(self.command)
        }
    }

    /// The stored form of the vessel's part of an outcome.
    fn new(outcome: &Outcome) -> Option<Self> {
        let (vessel, now) = (&outcome.vessel, outcome.at);
        if vessel.mode == VesselMode::Absent {
            return None;
        }
        let on_earth = |point| place_on_earth(&outcome.earth.ok()?, point);
        let progress = vessel.guidance.and_then(|guidance| guidance.progress);
        Some(Self {
            mode: vessel.mode.to_string(),
            command: vessel.command,
            renew_by: vessel.renew_by,
            progress: progress.map(|progress| RecordedProgress {
                boat: progress.boat,
                speed_m_per_s: progress.speed_m_per_s,
                course_rad: progress.course.map(Angle::radians),
                distance_m: progress.distance_m,
                cross_track_m: progress.cross_track_m,
            }),
            destination: vessel.marks.destination().map(|mark| (mark.id, mark.point(now))),
            marks: vessel.marks.iter().filter_map(|mark| RecordedMark::new(mark, outcome)).collect(),
            view: vessel.frame_view.and_then(|view| view.water_corners()),
            boat_on_earth: progress.and_then(|progress| on_earth(progress.boat)),
        })
    }
}

impl RecordedMark {
    /// The stored form of a mark at the time of the step; `None` where it is not on the water.
    fn new(mark: &Mark, outcome: &Outcome) -> Option<Self> {
        let (vessel, now) = (&outcome.vessel, outcome.at);
        let at = mark.point(now)?;
        let is_destination = vessel.marks.destination().is_some_and(|destination| destination.id == mark.id);
        Some(Self {
            id: mark.id,
            kind: mark.kind,
            at,
            radius_m: mark.radius_m(&vessel.profile, is_destination),
            std_dev_m: mark.std_dev_m(now)?,
            on_earth: outcome.earth.ok().and_then(|frame| place_on_earth(&frame, at)),
            held: mark.held,
        })
    }
}

impl RecordedOutcome {
    /// An outcome with its step number and the rates that were sent for its command.
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
            vessel: RecordedVessel::new(outcome).map(Box::new),
            notice: outcome.notice.as_ref().map(ToString::to_string).unwrap_or_default(),
        }
    }
}
