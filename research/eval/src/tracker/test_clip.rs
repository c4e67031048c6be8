//! A clip for tests.

use std::sync::Arc;

use barrelman_vocab::video::{Capture, CaptureQuality, ColourEncoding};
use barrelman_vocab::{Picture, PictureSize, PixelBox, Timestamp, VideoFrame};

use super::clips::Clip;
use super::scoring::Label;

const SIZE: PictureSize = PictureSize::new(1280, 720);

/// Fifty frames at 10 Hz. The target, lighter than the rest, drifts to the right. Every fifth frame is
/// labelled.
pub(crate) fn test_clip() -> Clip {
    let target = |frame: usize| PixelBox { u: 560.0 + 2.0 * frame as f64, v: 300.0, w: 60.0, h: 80.0 };
    let frame = |index: usize| {
        let mut picture = Picture::black(SIZE, ColourEncoding::JPEG);
        let bounds = target(index);
        let [y, _, _] = picture.planes_mut();
        for row in 300..380 {
            y[row * 1280 + bounds.u as usize..][..60].fill(180);
        }
        let capture =
            Capture { at: Timestamp::from_secs_f64(index as f64 / 10.0), quality: CaptureQuality::Sender };
        VideoFrame { sequence: index as u64, capture, picture: Arc::new(picture) }
    };
    Clip {
        name: "test".to_owned(),
        frames: (0..50).map(frame).collect(),
        labels: (0..50).map(|index| (index % 5 == 0).then(|| Label::Visible(target(index)))).collect(),
        start: 0,
        selection: target(0),
    }
}
