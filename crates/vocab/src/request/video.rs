//! Requests about the choice between two videos.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use strum::VariantNames;

use crate::videos::VideoNumber;

/// A request about the videos of a run. Refused where there is one video.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema, VariantNames)]
#[serde(tag = "kind", rename_all = "kebab-case", deny_unknown_fields)]
#[strum(serialize_all = "kebab-case")]
pub enum VideoRequest {
    /// Look for the boat in this video from now on. The selection ends. Refused while the camera is engaged.
    TrackVideo {
        /// The video.
        video: VideoNumber,
    },
}
