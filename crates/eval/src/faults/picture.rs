//! What a picture shows, as the tracker would report it.

use std::collections::VecDeque;

use barrelman_vocab::{ImagePoint, Localisation, PictureSize, PixelBox, Timestamp, Track};

use super::fault::{self, Fault, FaultKind};

pub(super) const PICTURE: PictureSize = PictureSize::new(640, 360);
/// Half the picture's width over the tangent of half its angle of view, pixels.
const FOCAL_PX: f64 = 330.0;

/// Interval between two pictures, ms.
pub(super) const FRAME_MS: u64 = 33;
/// From the capture of a picture to its arrival, ms.
const LATENCY_MS: u64 = 120;
/// Added to it while the video is late, ms.
const LATE_MS: u64 = 700;

/// The bearing of a boat that swings to and fro before the camera, radians to the right of where it was at first.
pub(super) fn boat_bearing_rad(phase: f64, at_ms: u64) -> f64 {
    0.9 * (0.55 * at_ms as f64 / 1000.0 + phase).sin() - 0.9 * phase.sin()
}

/// From the capture of a picture to its arrival with these faults, ms.
pub(super) fn latency_ms(faults: &[Fault], at_ms: u64) -> u64 {
    let is_late = fault::active(faults, FaultKind::VideoLate, at_ms).is_some();
    if is_late { LATENCY_MS + LATE_MS } else { LATENCY_MS }
}

/// A picture on its way to the program.
#[derive(Debug, Clone, Copy)]
pub(super) struct Underway {
    pub(super) captured_ms: u64,
    pub(super) due_ms: u64,
    pub(super) picture: SeenPicture,
}

/// Takes the pictures that have arrived. Returns the newest.
pub(super) fn take_newest(pictures: &mut VecDeque<Underway>, at_ms: u64) -> Option<Underway> {
    let mut newest = None;
    while let Some(underway) = pictures.pop_front_if(|underway| underway.due_ms <= at_ms) {
        newest = Some(underway);
    }
    newest
}

/// What a picture shows, and when it was captured.
#[derive(Debug, Clone, Copy)]
pub(super) struct SeenPicture {
    pub(super) captured: Timestamp,
    /// To the right of the picture's centre, radians; `None`: the target is not found.
    pub(super) bearing_rad: Option<f64>,
    pub(super) is_coasting: bool,
}

impl SeenPicture {
    /// The track, with the time since when the boat has been lost where it is.
    pub(super) fn track(self, lost_since: Timestamp) -> Track {
        let lost = Track::Lost { since: lost_since, confidence: 0.1 };
        let Some(x) = self.bearing_rad.map(|bearing| FOCAL_PX * bearing.tan()) else { return lost };
        if x.abs() > f64::from(PICTURE.width) / 2.0 {
            return lost;
        }
        let centre = ImagePoint { x, y: 20.0 }.in_pixels(PICTURE);
        let localisation = Localisation {
            captured: self.captured,
            picture: PICTURE,
            centre,
            bounds: PixelBox { u: centre.u - 20.0, v: centre.v - 8.0, w: 40.0, h: 16.0 },
            shape: None,
            heading: None,
            confidence: 0.9,
        };
        if self.is_coasting { Track::Coasting(localisation) } else { Track::Tracking(localisation) }
    }
}
