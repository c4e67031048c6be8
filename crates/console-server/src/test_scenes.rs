//! Outcomes, localisations and video frames for unit tests.

use std::sync::Arc;

use barrelman_pilot::Outcome;
use barrelman_vocab::video::{Capture, CaptureQuality, ColourEncoding};
use barrelman_vocab::{
    AngularRate, CameraCommand, Localisation, Picture, PictureSize, PixelBox, Timestamp, VideoFrame,
};

pub(crate) const PICTURE: PictureSize = PictureSize::new(640, 480);

pub(crate) fn at(ms: u64) -> Timestamp {
    Timestamp::from_nanos(ms * 1_000_000)
}

/// The outcome of a step of a pilot that follows nothing.
pub(crate) fn idle(at: Timestamp) -> Outcome {
    Outcome::idle(at)
}

/// A target of 40 x 20 pixels with its centre at (320, 240).
pub(crate) fn localisation(captured: Timestamp) -> Localisation {
    let bounds = PixelBox { u: 300.0, v: 230.0, w: 40.0, h: 20.0 };
    let centre = bounds.centre();
    Localisation { captured, picture: PICTURE, centre, bounds, shape: None, heading: None, confidence: 0.75 }
}

/// A command in rad/s.
pub(crate) fn command(pan: f64, tilt: f64) -> CameraCommand {
    let rate = AngularRate::from_radians_per_second;
    CameraCommand::turning(rate(pan), rate(tilt))
}

/// A black video frame that was captured at this time.
pub(crate) fn frame(sequence: u64, captured: Timestamp) -> VideoFrame {
    let capture = Capture { at: captured, quality: CaptureQuality::Sensor };
    VideoFrame { sequence, capture, picture: Arc::new(Picture::black(PICTURE, ColourEncoding::JPEG)) }
}
