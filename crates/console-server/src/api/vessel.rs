//! The boat that is commanded, as the page and programs see it.

use schemars::JsonSchema;
use serde::Serialize;

use super::place::PlaceStatus;
use super::track::TrackStatus;

/// The boat that is commanded.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct VesselStatus {
    /// `released` (not commanded), `neutral`, `by-hand`, `guided`, `holding` or `stopped`.
    pub mode: &'static str,
    /// The mode in words, with the reason of holding and stopping, and whether the boat keeps way while it
    /// holds.
    pub text: String,
    /// The throttle in force, -1 (astern) to 1 (ahead).
    pub throttle: f64,
    /// The rudder in force, -1 (left) to 1 (right).
    pub rudder: f64,
    /// The state of the boat's link: `simulated`, `opening`, `starting`, `up`, `silent`, `closing` or
    /// `closed`.
    pub link: &'static str,
    /// What the guidance steers by: `water`, or `picture` where height or tilt of the camera are not known;
    /// `null`: no destination yet.
    pub basis: Option<&'static str>,
    /// Whether another Go is asked for: it was refused just now, as the boat would go in the picture, which
    /// keeps out of no circles. A second Go within 5 s is accepted.
    pub go_again: bool,
    /// What the boat said last in words, for half a minute; `null`: nothing. ASCII of at most 120 characters,
    /// of the vehicle's choice.
    pub says: Option<String>,
    /// What the guidance is doing: `getting-way`, `under-way`, `avoiding`, `blocked`, `holding`,
    /// `standing-off`, `no-fix` or `no-destination`.
    pub guidance: Option<&'static str>,
    /// Where the boat is on its way; `null` without distances.
    pub progress: Option<ProgressStatus>,
    /// The marks, oldest first.
    pub marks: Vec<MarkStatus>,
    /// What the camera sees of the water: the corners of the picture, metres to the right and ahead of the
    /// point below the camera; `null` without distances.
    pub footprint: Option<Vec<[f64; 2]>>,
}

/// Where the boat is on its way.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, JsonSchema)]
pub struct ProgressStatus {
    /// The boat, metres to the right and ahead of the point below the camera.
    pub boat_m: [f64; 2],
    /// The boat on Earth; `null`: not known (`earth` of the snapshot says why).
    pub on_earth: Option<PlaceStatus>,
    /// Speed over ground, m/s.
    pub speed_m_per_s: f64,
    /// Course, degrees, 0 ahead, positive to the right; `null`: not known.
    pub course_deg: Option<f64>,
    /// Distance to the destination, metres.
    pub distance_m: f64,
    /// Distance from the line, metres, positive to the right of it.
    pub cross_track_m: f64,
}

/// A mark.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct MarkStatus {
    /// Number of the mark.
    pub id: u32,
    /// `place`, `person`, `way-point`, `forbidden` or `home`.
    pub kind: &'static str,
    /// Whether the mark is the destination.
    pub destination: bool,
    /// Pixel in the newest picture, also beyond its border; `null`: behind the camera.
    pub at: Option<[f64; 2]>,
    /// The circle that the boat keeps out of, with the uncertainty of its centre, as pixels; empty without a
    /// circle, or where distances are not known.
    pub ring: Vec<[f64; 2]>,
    /// Where the mark is, metres to the right and ahead of the point below the camera; `null` without
    /// distances.
    pub water_m: Option<[f64; 2]>,
    /// Where the mark is on Earth; `null`: not known (`earth` of the snapshot says why).
    pub on_earth: Option<PlaceStatus>,
    /// Standard deviation of the place, metres.
    pub std_dev_m: Option<f64>,
    /// Radius of the circle without the uncertainty, metres; 0 without a circle.
    pub radius_m: f64,
    /// What the tracker of the mark answers; `null`: the mark is not held.
    pub held: Option<TrackStatus>,
}
