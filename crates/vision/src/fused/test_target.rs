//! A target for the unit tests of the fused tracker.

use std::sync::Arc;

use barrelman_vocab::video::{Capture, CaptureQuality};
use barrelman_vocab::{Picture, PixelBox, Timestamp, VideoFrame};

use super::config::FusedConfig;
use super::target::Target;
use super::workspace::Workspace;
use crate::refinement::RefinementWeights;
use crate::test_picture::painted;

/// A picture of red paint on blue water.
pub(super) fn red_on_blue(size: (u32, u32), is_red: impl Fn(usize, usize) -> bool) -> Picture {
    painted(size, |column, row| if is_red(column, row) { [90, 90, 240] } else { [80, 190, 100] })
}

/// The target that is selected in a picture.
pub(super) fn selected(
    config: &FusedConfig,
    picture: Picture,
    selection: PixelBox,
) -> (Workspace, Target, VideoFrame) {
    let mut workspace = Workspace::new(config, RefinementWeights::built_in());
    let capture = Capture { at: Timestamp::from_nanos(0), quality: CaptureQuality::Sensor };
    let frame = VideoFrame { sequence: 0, capture, picture: Arc::new(picture) };
    let (target, _, _) = workspace.learn_selection(config, &frame, selection);
    (workspace, target, frame)
}
