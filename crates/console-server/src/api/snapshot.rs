//! The state after the newest step, as the page and programs see it.

use barrelman_experiments::drill::DrillState;
use schemars::JsonSchema;
use serde::Serialize;

use super::place::{PlaceStatus, WaterOnEarthStatus};
use super::track::TrackStatus;
use super::vessel::VesselStatus;
use crate::snapshot::{DriveState, WorldState};
use barrelman_vocab::{LawId, MarkKind, VideoNumber};

/// The rates of the camera's axes.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, JsonSchema)]
pub struct AxisRates {
    /// rad/s, positive to the right.
    pub pan: f64,
    /// rad/s, positive upwards.
    pub tilt: f64,
    /// The change of the focal length's logarithm in a second, positive to a closer view.
    pub zoom: f64,
}

/// The camera's zoom.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, JsonSchema)]
pub struct ZoomStatus {
    /// The present focal length over that of the widest view.
    pub ratio: f64,
    /// Whether the zoom keeps the size of what is followed while engaged.
    pub keeps_size: bool,
}

/// The state after the newest step: the body of `/api/v1/status`.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct StatusSnapshot {
    /// Steps of the pilot so far.
    pub step: u64,
    /// Time of the newest step.
    pub at_ns: u64,
    /// Grows with each step, and in a live run every 0.2 s where there is none: a program in which it rests
    /// hangs. (A demo that is paused rests, too.)
    pub beat: u64,
    /// The pilot's mode.
    pub mode: ModeStatus,
    /// The track.
    pub track: TrackStatus,
    /// The object that is proposed at a tap; nothing follows it yet. `null`: none.
    pub proposal: Option<ProposalStatus>,
    /// The objects that may be the wanted one, while nothing is followed or on demand.
    pub candidates: Vec<CandidateStatus>,
    /// Whether they are shown also while a target is followed.
    pub candidates_on_demand: bool,
    /// The region in the newest picture; `null` before the first.
    pub region: Option<RegionStatus>,
    /// The percept of the newest localisation.
    pub percept: Option<PerceptStatus>,
    /// What the law advises, whether or not the camera may move.
    pub advice: Option<AxisRates>,
    /// The command in force.
    pub command: AxisRates,
    /// Yaw rate handed to the link, in the vehicle's own sign.
    pub yaw_rate: f64,
    /// Pitch rate handed to the link, in the vehicle's own sign.
    pub pitch_rate: f64,
    /// The camera's zoom; `null`: the camera does not zoom, or has not told whether it does.
    pub zoom: Option<ZoomStatus>,
    /// By how much the vehicle is turned about the vertical, degrees, positive to the right: the twist of the
    /// tether.
    pub net_yaw_deg: f64,
    /// Why a search would be refused now; `null`: it can be asked for.
    pub search_refusal: Option<String>,
    /// The law in force; `null` before the first step.
    pub law: Option<LawId>,
    /// The video.
    pub video: VideoStatus,
    /// The other video; `null`: there is one.
    pub other_video: Option<OtherVideoStatus>,
    /// Where the followed boat is on the water; `null`: nothing is followed, or height or tilt of the camera
    /// are not known.
    pub boat: Option<BoatStatus>,
    /// Whether latitude and longitude of places on the water can be known: `known`; `no-position`: the
    /// vehicle reports no position; `no-heading`: it does not report the direction of the camera from north.
    pub earth: &'static str,
    /// Where the water lies on Earth, of which `water_m` and `boat_m` are points; `null`: `earth` says why.
    pub water_on_earth: Option<WaterOnEarthStatus>,
    /// The boat that is commanded, with the marks; `null`: no boat is commanded by this program.
    pub vessel: Option<VesselStatus>,
    /// The link to the vehicle.
    pub link: LinkStatus,
    /// The recording.
    pub recording: RecordingStatus,
    /// The camera's work so far, and that of the paper's schema beside it.
    pub work: CameraWork,
    /// Alarms in force, by their keys: `stale-video`, `no-video`, `link-down`, `camera-may-turn`,
    /// `camera-turns`, `boat-link-down`, `boat-may-move`, `boat-moves`, `control-lost`, `end-stop`,
    /// `emergency`, `battery-low`, `recording-failed`, `console-lost`, `track-lost`, `net-yaw`,
    /// `net-yaw-limit`, `drill`.
    pub alarms: Vec<&'static str>,
    /// How many presses of Stop have been taken so far; a press is acknowledged when this reaches its number.
    pub stops_taken: u64,
    /// The simulated world; `null`: the world is not simulated.
    pub world: Option<WorldState>,
    /// The drill that goes on in a demo; `null`: none.
    pub drill: Option<DrillState>,
    /// The boat and the time of a demo; `null` in a live run.
    pub drive: Option<DriveState>,
}

/// The pilot's mode.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, JsonSchema)]
pub struct ModeStatus {
    /// `idle`, `servoing`, `holding`, `nudging`, `searching`, `calibrating` or `stopped`.
    pub name: &'static str,
    /// Of holding: `no-selection`, `track-lost`, `coasting`, `doubted`, `video-stale`, `video-silent`,
    /// `confirming`, `dry-run`, `link-down`, `no-control`, `emergency`, `landing`; of stopped: `operator`,
    /// `ending`, `video-ended`, `fault`, `control-lost`, `vehicle-restarted`, `emergency`, `landing`,
    /// `battery-low`, `vehicle-silent`, `exchanged`, `suspended`, `pan-opposed`, `tilt-opposed`; otherwise
    /// `null`.
    pub cause: Option<&'static str>,
    /// Whether the pilot is engaged (servoing or holding).
    pub engaged: bool,
}

/// An object that is proposed.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, JsonSchema)]
pub struct ProposalStatus {
    /// Left, top, width, height, pixels.
    #[serde(rename = "box")]
    pub bounds: [f64; 4],
    /// Time of capture of the video frame that the box belongs to.
    pub captured_ns: u64,
}

/// An object that may be the wanted one: whatever stands out from the water, or a detector finds.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct CandidateStatus {
    /// The number by which it is taken, from 1.
    pub number: u32,
    /// Left, top, width, height, pixels.
    #[serde(rename = "box")]
    pub bounds: [f64; 4],
    /// Time of capture of the video frame that the box belongs to.
    pub captured_ns: u64,
    /// What a detector says the object is; null: nothing.
    pub class: Option<String>,
    /// The detector's score, 0 to 1.
    pub score: Option<f64>,
    /// The mark that is proposed here; null: none.
    pub mark: Option<MarkKind>,
}

/// The region in which the camera rests.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, JsonSchema)]
pub struct RegionStatus {
    /// Horizontal semi-axis of the ellipse around the picture's centre, pixels.
    pub a_px: f64,
    /// Vertical semi-axis, pixels.
    pub b_px: f64,
}

/// The percept.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, JsonSchema)]
pub struct PerceptStatus {
    /// To the right of the picture's centre, pixels.
    pub x: f64,
    /// Above the picture's centre, pixels.
    pub y: f64,
    /// P; above 1 outside of the region.
    pub p: f64,
    /// `right`, `top`, `left`, `bottom`; `null` inside the region.
    pub sector: Option<&'static str>,
}

/// The video.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct VideoStatus {
    /// Which of the videos this is: `first` or `second`.
    pub number: VideoNumber,
    /// `connecting`, `up`, `lost` or `ended`.
    pub state: &'static str,
    /// Why the video was lost; of video that is up: that it is late, or that the camera's clock is wrong.
    pub reason: Option<String>,
    /// Width and height of the displayed picture, pixels.
    pub size: Option<[u32; 2]>,
    /// Time of capture of the newest video frame that the pilot processed.
    pub captured_ns: Option<u64>,
    /// Age of that frame when the pilot had processed it, milliseconds.
    pub age_ms: Option<f64>,
    /// Frames a second.
    pub fps: f64,
    /// Median time from the moment when the loop takes a frame until the rates are handed to the link, over
    /// the last 60 frames, milliseconds; `null` in a demo.
    pub step_ms: Option<f64>,
    /// Video frames that were replaced by newer ones before the pilot took them.
    pub dropped: u64,
    /// The codec in which the video can be sent as it comes; `null`: only as JPEG.
    pub codec: Option<EncodedVideo>,
}

/// The video that the pilot does not see.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, JsonSchema)]
pub struct OtherVideoStatus {
    /// Which of the videos this is: `first` or `second`.
    pub number: VideoNumber,
    /// `connecting`, `up`, `lost` or `ended`.
    pub state: &'static str,
    /// Why the video was lost; of video that is up: that it is late, or that the camera's clock is wrong.
    pub reason: Option<String>,
    /// The codec in which the video can be sent as it comes; `null`: only as JPEG.
    pub codec: Option<EncodedVideo>,
}

/// A codec in which video can be sent as it comes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum EncodedVideo {
    /// H.264.
    H264,
    /// H.265.
    H265,
}

/// Where the boat is on the water, seen from the point below the camera.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, JsonSchema)]
pub struct BoatStatus {
    /// Distance over the water, metres.
    pub distance_m: f64,
    /// Standard deviation of the distance, metres.
    pub std_dev_m: f64,
    /// Direction from the camera's axis, degrees, positive to the right.
    pub direction_deg: f64,
    /// Where the boat is on Earth; `null`: not known (`earth` says why).
    pub on_earth: Option<PlaceStatus>,
}

/// Position of the vehicle on Earth.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, JsonSchema)]
pub struct PositionStatus {
    /// Latitude, degrees, positive to the north.
    pub latitude_deg: f64,
    /// Longitude, degrees, positive to the east.
    pub longitude_deg: f64,
    /// Direction of the vehicle's nose from north, degrees, positive to the east; `null`: not known.
    pub heading_deg: Option<f64>,
}

/// The link to the vehicle.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct LinkStatus {
    /// `dry-run`, `simulated`, `opening`, `starting`, `up`, `silent`, `closing` or `closed`.
    pub state: &'static str,
    /// Whether the vehicle accepts commands from this program.
    pub in_control: Option<bool>,
    /// What a vehicle that answers commands says to them: `accepted`, `queued`, `other-client`,
    /// `flight-state`, `not-ready`, `fault`, `no-camera`, `token-refused`, `unusable` or `unanswered`;
    /// `null`: the vehicle does not answer commands.
    pub acceptance: Option<&'static str>,
    /// Battery voltage, volts.
    pub battery_v: Option<f64>,
    /// Elevation of the camera, degrees, positive above the horizon.
    pub tilt_deg: Option<f64>,
    /// Height of the vehicle above the place of its start, metres.
    pub altitude_m: Option<f64>,
    /// Position of the vehicle on Earth (WGS 84); `null`: it reports none.
    pub position: Option<PositionStatus>,
    /// `idle`, `flying`, `landing`, `emergency` or `other`.
    pub flight: Option<&'static str>,
    /// The gimbal device that is moved, of a MAVLink gimbal.
    pub gimbal: Option<String>,
    /// The camera that zooms, of a MAVLink gimbal: its address, vendor and model.
    pub camera: Option<String>,
    /// The vehicle's own video: the stream of a Sigma, or the media profile of an ONVIF camera with its
    /// source.
    pub stream: Option<String>,
}

/// The recording.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct RecordingStatus {
    /// `off`, `recording` or `failed`.
    pub state: &'static str,
    /// The file.
    pub path: Option<String>,
    /// Why the recording failed.
    pub reason: Option<String>,
}

/// The camera's work.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, JsonSchema)]
pub struct CameraWork {
    /// The camera's own.
    pub camera: WorkFigures,
    /// What the paper's motor schema would have done; `null` where the schema is the law.
    pub schema: Option<WorkFigures>,
    /// P as the schema would have kept it.
    pub schema_p: Option<f64>,
}

/// Figures of a camera's work since the first engage.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, JsonSchema)]
pub struct WorkFigures {
    /// Starts of a command from rest.
    pub moves: u64,
    /// Integral of the absolute rates of both axes, rad.
    pub travel_rad: f64,
    /// Share of the time at rest, 0 to 1.
    pub rest_share: f64,
    /// The time, seconds.
    pub seconds: f64,
}

/// Who controls.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize, JsonSchema)]
pub struct ControlSeat {
    /// Number of who is in control; `null`: nobody.
    pub holder: Option<u64>,
    /// Whether the page in control is connected; `false` in the seconds after it was lost.
    pub holder_connected: bool,
    /// Numbers of all connected pages, and that of the programs.
    pub clients: Vec<u64>,
    /// Numbers of those that ask for the control.
    pub asking: Vec<u64>,
    /// Number of the programs without a socket, which are one client together; `null`: none has asked for the
    /// control or taken it in the last 3 s.
    pub program: Option<u64>,
}
