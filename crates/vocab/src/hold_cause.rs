//! Why an engaged camera rests.

use strum::{IntoStaticStr, VariantArray};

use crate::named::Named;

/// The reason why an engaged pilot rests the camera: for want of something to follow, or of a camera that may
/// move.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, IntoStaticStr, VariantArray)]
#[strum(serialize_all = "kebab-case")]
pub enum HoldCause {
    /// Nothing was selected yet.
    NoSelection,
    /// The track is lost.
    TrackLost,
    /// The track has been coasting for too long.
    Coasting,
    /// A detector does not see the boat where the tracker found it again.
    Doubted,
    /// The video frames are too old.
    VideoStale,
    /// No video frames arrive.
    VideoSilent,
    /// A selection waits for its confirmation.
    Confirming,
    /// There is no link: a dry run shows advice only.
    DryRun,
    /// The link is not up: commands do not reach the vehicle.
    LinkDown,
    /// The vehicle does not accept commands from this program.
    NoControl,
    /// The vehicle reports an emergency.
    Emergency,
    /// The vehicle lands.
    Landing,
}

impl Named for HoldCause {
    fn text(self) -> &'static str {
        match self {
            Self::NoSelection => "nothing selected",
            Self::TrackLost => "boat lost",
            Self::Coasting => "boat hidden",
            Self::Doubted => "boat doubted by the detector",
            Self::VideoStale => "video delayed",
            Self::VideoSilent => "no video",
            Self::Confirming => "confirming the selection",
            Self::DryRun => "dry run, nothing is sent",
            Self::LinkDown => "link not up",
            Self::NoControl => "vehicle takes no commands",
            Self::Emergency => "vehicle emergency",
            Self::Landing => "vehicle lands",
        }
    }
}
