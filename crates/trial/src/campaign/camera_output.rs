//! What the camera of a simulated trial sends to the pilot.

use barrelman_vocab::Localisation;

use super::frame_source::CapturedFrame;
use crate::target_in_picture::TargetInPicture;

/// What the camera sends to the pilot: a measured localisation, or a video frame.
#[derive(Clone)]
pub(super) enum CameraOutput {
    Localisation(Option<Localisation>),
    Frame(Box<CapturedFrame>),
}

impl CameraOutput {
    /// What a video frame shows of the target.
    pub(super) fn target(&self) -> Option<&TargetInPicture> {
        match self {
            Self::Localisation(_) => None,
            Self::Frame(captured) => Some(&captured.target),
        }
    }

    /// This output with the content of an earlier one; the time of capture stays.
    pub(super) fn with_content_of(self, earlier: &Self) -> Self {
        match (self, earlier) {
            (Self::Localisation(now), Self::Localisation(then)) => Self::Localisation(then.map(|then| {
                let captured = now.map_or(then.captured, |now| now.captured);
                Localisation { captured, ..then }
            })),
            (Self::Frame(mut now), Self::Frame(then)) => {
                now.frame.picture = then.frame.picture.clone();
                now.target = then.target;
                Self::Frame(now)
            }
            (now, _) => now,
        }
    }
}
