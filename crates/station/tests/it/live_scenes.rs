//! Pilots, frames and steps for the tests of live runs.

use std::sync::Arc;
use std::time::Duration;

use barrelman_pilot::{LawSettings, Pilot, PilotSettings};
use barrelman_vision::{Explanation, SelectionError, SelectionReport, Tracker};
use barrelman_vocab::video::{Capture, CaptureQuality, ColourEncoding};
use barrelman_vocab::{
    ImagePoint, Localisation, MotionPrior, Picture, PictureSize, PixelBox, Timestamp, Track, VehicleProfile,
    VideoFrame,
};

pub(crate) const PICTURE: PictureSize = PictureSize::new(640, 480);
pub(crate) const SELECTION: PixelBox = PixelBox { u: 300.0, v: 200.0, w: 40.0, h: 40.0 };
/// A selection that [`FixedTracker`] refuses.
pub(crate) const REFUSED: PixelBox = PixelBox { u: 0.0, v: 0.0, w: 0.0, h: 0.0 };

/// Outside the region, to the right: the camera must pan.
const TARGET: ImagePoint = ImagePoint { x: 250.0, y: 30.0 };

pub(crate) fn at(ms: u64) -> Timestamp {
    Timestamp::from_nanos(ms * 1_000_000)
}

/// A localisation of the target on the right.
pub(crate) fn localisation(captured: Timestamp) -> Localisation {
    let centre = TARGET.in_pixels(PICTURE);
    let bounds = PixelBox { u: centre.u - 10.0, v: centre.v - 5.0, w: 20.0, h: 10.0 };
    Localisation { captured, picture: PICTURE, centre, bounds, shape: None, heading: None, confidence: 0.9 }
}

/// Sees its target at the same place in every video frame, from the first selection on.
#[derive(Default)]
struct FixedTracker {
    has_target: bool,
}

impl Tracker for FixedTracker {
    fn select(&mut self, frame: &VideoFrame, selection: PixelBox) -> Result<SelectionReport, SelectionError> {
        if selection == REFUSED {
            return Err(SelectionError::Empty { selection, picture: PICTURE });
        }
        self.has_target = true;
        let localisation = localisation(frame.capture.at);
        Ok(SelectionReport {
            used: selection,
            is_clipped: false,
            is_refined: false,
            coloured_share: 1.0,
            surroundings_probability: 0.0,
            localisation,
        })
    }

    fn track(&mut self, frame: &VideoFrame, _: Option<&MotionPrior>) -> Track {
        if self.has_target { Track::Tracking(localisation(frame.capture.at)) } else { Track::Unseeded }
    }

    fn forget(&mut self) {
        self.has_target = false;
    }

    fn reject(&mut self) -> bool {
        std::mem::take(&mut self.has_target)
    }

    fn explain(&self, _: &mut Explanation) {}
}

/// A pilot of a Fotokite Pro with the motor schema, whose target stays on the right.
pub(crate) fn pilot() -> Pilot {
    let settings = PilotSettings { profile: VehicleProfile::fotokite_pro(), law: LawSettings::MotorSchema };
    Pilot::new(settings, Box::new(FixedTracker::default()))
}

/// A small video frame that arrives at `now` after the nominal latency of 200 ms.
pub(crate) fn frame(sequence: u64, now: Timestamp) -> VideoFrame {
    let picture = Picture::black(PictureSize::new(2, 2), ColourEncoding::JPEG);
    let capture = Capture { at: now.minus(Duration::from_millis(200)), quality: CaptureQuality::Sensor };
    VideoFrame { sequence, capture, picture: Arc::new(picture) }
}
