//! A target for the unit tests of the fused tracker.

use std::sync::Arc;

use barrelman_vocab::video::{Capture, CaptureQuality};
use barrelman_vocab::{Picture, PixelBox, Timestamp, VideoFrame};

use super::config::FusedConfig;
use super::follower::Follower;
use super::observation::Observation;
use crate::features::PatchPose;
use crate::peak::Peak;
use crate::probability_view::ColourContrast;
use crate::refinement::RefinementWeights;
use crate::test_picture::painted;

/// A picture of red paint on blue water.
pub(super) fn red_on_blue(size: (u32, u32), is_red: impl Fn(usize, usize) -> bool) -> Picture {
    painted(size, |column, row| if is_red(column, row) { [90, 90, 240] } else { [80, 190, 100] })
}

/// A follower of the target that is selected in a picture, with the frame.
pub(super) fn selected(picture: Picture, selection: PixelBox) -> (Follower, VideoFrame) {
    let mut follower = Follower::new(&FusedConfig::default(), RefinementWeights::built_in());
    let capture = Capture { at: Timestamp::from_nanos(0), quality: CaptureQuality::Sensor };
    let frame = VideoFrame { sequence: 0, capture, picture: Arc::new(picture) };
    follower.select(&frame, selection);
    (follower, frame)
}

/// An observation at a place, pixels, with the usual colour and response.
pub(super) fn observation_at(centre: (f32, f32)) -> Observation {
    Observation {
        pose: PatchPose { centre, step: 1.0, angle: 0.0 },
        centre,
        peak: Peak::default(),
        contrast: ColourContrast { inside: 0.8, ring: 0.0 },
        relative_height: 1.0,
        relative_contrast: Some(1.0),
        evidence: 12.0,
    }
}
