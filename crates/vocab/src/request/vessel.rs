//! Requests about the vessel.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use strum::{IntoStaticStr, VariantNames};

use crate::image::PixelPoint;
use crate::time::Timestamp;
use crate::vessel::VesselCommand;

/// A request about the vessel.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema, VariantNames)]
#[serde(tag = "kind", rename_all = "kebab-case", deny_unknown_fields)]
#[strum(serialize_all = "kebab-case")]
pub enum VesselRequest {
    /// Mark a point in a video frame. The first place or person is the destination; a further one replaces a
    /// place.
    Mark(DrawnMark),
    /// Move a mark to where the marked object is now. The mark of a person then drifts on as it was moved.
    MoveMark(MovedMark),
    /// Remove a mark.
    Unmark {
        /// Its number.
        id: u32,
    },
    /// Remove all marks.
    UnmarkAll,
    /// The next place or person becomes the destination.
    NextMark,
    /// Let the vessel go to the destination on its own. In the console, only a page on a socket can; when the
    /// page is gone, the vessel is stopped.
    Guide,
    /// Let the vessel go to the mark `home` on its own. In the console, as `guide`.
    GoHome,
    /// Steer the vessel by hand for half a second unless this is renewed; neutral lets go. In the console, as
    /// `guide`.
    Steer(VesselCommand),
    /// Stop the vessel alone.
    StopVessel {
        /// Who stops it.
        #[serde(default)]
        by: VesselStopper,
    },
    /// Command the vessel no more: another program or a person may steer it. In the demo, the scenario's
    /// helmsman does.
    ReleaseVessel,
}

/// A mark, and the video frame on which it was set.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct DrawnMark {
    /// What is marked.
    pub mark: MarkKind,
    /// The point, pixels of the displayed picture.
    pub at: PixelPoint,
    /// Time of capture of the video frame, at most 1.5 s old.
    pub captured_ns: Timestamp,
}

/// A mark that is moved, and the video frame on which it was.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct MovedMark {
    /// Number of the mark.
    pub id: u32,
    /// The point, pixels of the displayed picture.
    pub at: PixelPoint,
    /// Time of capture of the video frame, at most 1.5 s old.
    pub captured_ns: Timestamp,
}

/// What is marked.
#[derive(
    Debug,
    Clone,
    Copy,
    PartialEq,
    Eq,
    PartialOrd,
    Ord,
    Hash,
    Serialize,
    Deserialize,
    JsonSchema,
    IntoStaticStr,
)]
#[serde(rename_all = "kebab-case")]
#[strum(serialize_all = "kebab-case")]
pub enum MarkKind {
    /// A place: the vessel goes there and stays.
    Place,
    /// A person: the vessel stops before the stand-off if the person is the destination, and keeps away
    /// otherwise.
    Person,
    /// A point to pass on the way to the destination.
    WayPoint,
    /// The centre of an area of 5 m that the vessel must not enter.
    Forbidden,
    /// The place that the vessel comes back to.
    Home,
}

impl MarkKind {
    /// The name in the API, in files and on figures.
    pub fn key(self) -> &'static str {
        self.into()
    }
}

/// Who stops the vessel alone.
#[derive(
    Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Default, Serialize, Deserialize, JsonSchema,
)]
#[serde(rename_all = "kebab-case")]
pub enum VesselStopper {
    /// The operator.
    #[default]
    Operator,
    /// The console that was in control is gone.
    ConsoleLost,
}
