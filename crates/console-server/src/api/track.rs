//! A track: of the boat, or of the person under a mark.

use schemars::JsonSchema;
use serde::Serialize;

/// The track.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, JsonSchema)]
pub struct TrackStatus {
    /// `unseeded`, `tracking`, `coasting` or `lost`.
    pub state: &'static str,
    /// Whether a selection waits for its confirmation.
    pub confirming: bool,
    /// Whether a detector contradicts that what was found again is the boat.
    pub doubted: bool,
    /// Time of capture of the localisation.
    pub captured_ns: Option<u64>,
    /// Left, top, width, height of the target, pixels.
    #[serde(rename = "box")]
    pub bounds: Option<[f64; 4]>,
    /// The target's centre, pixels.
    pub centre: Option<[f64; 2]>,
    /// Full lengths of the major and minor axes, pixels.
    pub axes: Option<[f64; 2]>,
    /// Direction of the major axis, degrees in [0, 180).
    pub axis_deg: Option<f64>,
    /// Direction of the bow, degrees in [0, 360).
    pub heading_deg: Option<f64>,
    /// The tracker's confidence, 0 to 1.
    pub confidence: Option<f64>,
    /// For how long the track has been lost, seconds.
    pub lost_s: Option<f64>,
}
