//! What a picture shows, as the tracker would report it.

use barrelman_vocab::{ImagePoint, Localisation, PictureSize, PixelBox, Timestamp, Track};

pub(super) const PICTURE: PictureSize = PictureSize::new(640, 360);
/// Half the picture's width over the tangent of half its angle of view, pixels.
const FOCAL_PX: f64 = 330.0;

/// Interval between two pictures, ms.
pub(super) const FRAME_MS: u64 = 33;
/// The bearing of a boat that swings to and fro before the camera, radians to the right of where it was at
/// first.
pub(super) fn boat_bearing_rad(phase: f64, at_ms: u64) -> f64 {
    0.9 * (0.55 * at_ms as f64 / 1000.0 + phase).sin() - 0.9 * phase.sin()
}

/// What a picture shows.
#[derive(Debug, Clone, Copy)]
pub(super) struct SeenPicture {
    /// To the right of the picture's centre, radians; `None`: the target is not found.
    pub(super) bearing_rad: Option<f64>,
    pub(super) is_coasting: bool,
}

impl SeenPicture {
    /// The track of the picture with this time of capture, with the time since when the boat has been lost
    /// where it is.
    pub(super) fn track(self, captured: Timestamp, lost_since: Option<Timestamp>) -> Track {
        let lost = Track::Lost { since: lost_since.unwrap_or(captured), confidence: 0.1 };
        let Some(x) = self.bearing_rad.map(|bearing| FOCAL_PX * bearing.tan()) else { return lost };
        if x.abs() > f64::from(PICTURE.width) / 2.0 {
            return lost;
        }
        let centre = ImagePoint { x, y: 20.0 }.in_pixels(PICTURE);
        let localisation = Localisation {
            captured,
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
