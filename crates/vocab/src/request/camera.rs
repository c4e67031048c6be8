//! Requests about the camera and the target that it follows.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use strum::VariantNames;

use crate::image::{PixelBox, PixelPoint};
use crate::law::LawId;
use crate::time::Timestamp;

/// A request about the camera and the target that it follows.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema, VariantNames)]
#[serde(tag = "kind", rename_all = "kebab-case", deny_unknown_fields)]
#[strum(serialize_all = "kebab-case")]
pub enum CameraRequest {
    /// Track what this box contained in the video frame on which it was drawn. Replaces an earlier selection
    /// at any time. The track is brought up to the newest frame, and then has to be confirmed. The answer
    /// comes when the track has been confirmed (accepted) or could not be confirmed (refused), or when
    /// another selection comes (superseded).
    Select(DrawnSelection),
    /// Track the content of this box of the next video frame, without a confirmation.
    SelectNext(PixelBox),
    /// Propose the object at this point. Nothing that is followed changes. A tap within the proposed box
    /// takes it, as a selection of it; so does `engage` while nothing is followed. The answer says what is
    /// proposed, or why nothing is (refused); where the tap takes a proposal, it is that of the selection.
    Propose(Tap),
    /// Show the candidates, the objects on the water that may be the wanted one, also while a target is
    /// followed, or no longer. While nothing is followed they are shown anyway.
    Candidates {
        /// Whether they are shown.
        shown: bool,
    },
    /// Select the candidate of this number, as by a box around it.
    TakeCandidate {
        /// The number, from 1.
        number: u32,
    },
    /// "Not that one": forget the present track, do not take that object again, and search for the selected
    /// target.
    Reject,
    /// Forget the target and follow nothing.
    Deselect,
    /// Turn the camera slowly, or zoom, while this is renewed, at least every 250 ms. While engaged it may
    /// zoom only.
    Nudge(Nudge),
    /// Turn the camera slowly to find the target that was lost: the last bearing first, then a bounded sweep.
    /// A search ends when the target is found, and after a minute.
    Search,
    /// Turn the camera by itself to measure its axes.
    Calibrate {
        /// How.
        motions: TestMotions,
    },
    /// State by how much the vehicle is turned about the vertical, and with it the tether twisted.
    NetYaw {
        /// Degrees, positive to the right.
        degrees: f64,
    },
    /// Keep the target's size in the picture by the zoom while engaged, or no longer. A zoom by hand ends it.
    KeepSize {
        /// Whether the size is kept.
        keep: bool,
    },
    /// Change the camera law; while not engaged only.
    Law {
        /// The law.
        law: LawId,
    },
    /// Let the pilot move the camera. After a stop, only `engage` allows motion again.
    Engage,
    /// Continue tracking with the camera at rest. This also ends a stop, without allowing motion.
    Disengage,
}

/// The motions of a calibration, axis after axis, to and fro.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum TestMotions {
    /// Long and often: they tell dead times and lag, too.
    Axes,
    /// Shorter and fewer: they tell how fast the camera turns.
    Speed,
}

impl CameraRequest {
    /// Whether the request selects a target.
    pub const fn is_selection(&self) -> bool {
        matches!(self, Self::Select(_) | Self::SelectNext(_))
    }
}

/// A selection, and the video frame on which it was drawn.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct DrawnSelection {
    /// The box, pixels of the displayed picture.
    pub bounds: PixelBox,
    /// Time of capture of the video frame.
    pub captured_ns: Timestamp,
}

/// A tap on a video frame.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Tap {
    /// The point, pixels of the displayed picture.
    pub at: PixelPoint,
    /// Time of capture of the video frame, at most 1.5 s old.
    pub captured_ns: Timestamp,
    /// Whether what is proposed is taken at once.
    #[serde(default)]
    pub take: bool,
}

/// A slow turn of the camera by hand, or a zoom, in shares of the nudge rates.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Nudge {
    /// -1 to 1, positive to the right.
    pub pan: f64,
    /// -1 to 1, positive upwards.
    pub tilt: f64,
    /// -1 to 1, positive to a closer view.
    #[serde(default)]
    pub zoom: f64,
}
