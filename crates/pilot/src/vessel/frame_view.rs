//! What the camera of one video frame sees: pixels to lines of sight, and to points on the water where height and tilt are
//! known.

use barrelman_control::CameraModel;
use barrelman_control::guidance::input::BoatFix;
use barrelman_control::water::WaterView;
use barrelman_vocab::{
    Angle, CameraAboveWater, Lens, Localisation, PictureSize, PixelPoint, SightingNoise, Timestamp, WaterFix,
    WaterPoint,
};

/// Standard deviations of what a point on the water is computed from, common errors apart: those of height and attitude
/// move boat and marks together.
const NOISE: SightingNoise = SightingNoise {
    pixel_px: 3.0,
    height_m: 0.0,
    pan: Angle::ZERO,
    tilt: Angle::from_degrees(0.3),
    roll: Angle::from_degrees(0.3),
};
/// Standard deviation of a bow that the tracker sees.
const HEADING_STD_DEV: Angle = Angle::from_degrees(15.0);
/// The bow's direction on the water is taken over this many pixels.
const BOW_PX: f64 = 8.0;

/// The camera of one video frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FrameView {
    /// Lines of sight; points on the water only where `sees_water`.
    pub view: WaterView,
    /// Whether height and tilt are known.
    pub sees_water: bool,
}

impl FrameView {
    /// The camera at the time of capture of a video frame; `None` for the height: height or tilt are not known, and only
    /// lines of sight mean anything.
    pub fn new(
        camera: &CameraModel,
        captured: Timestamp,
        picture: PictureSize,
        height_m: Option<f64>,
    ) -> Self {
        let (pan, tilt) = camera.angles_at(captured);
        let lens = Lens::pinhole(picture, camera.focal_px(captured, picture));
        let camera = CameraAboveWater {
            below: WaterPoint::default(),
            height_m: height_m.unwrap_or(1.0),
            pan: Angle::from_radians(pan),
            tilt: Angle::from_radians(tilt),
            roll: Angle::ZERO,
        };
        Self { view: WaterView::new(lens, &camera), sees_water: height_m.is_some() }
    }

    /// The point on the water at a pixel; `None`: at the horizon, above it, or the water is not known.
    pub fn fix(&self, pixel: PixelPoint) -> Option<WaterFix> {
        self.view.fix(pixel, &NOISE).filter(|_| self.sees_water)
    }

    /// The boat on the water.
    pub fn boat(&self, seen: &Localisation) -> Option<BoatFix> {
        let centre = seen.bounds.centre();
        let water = self.fix(centre)?;
        let heading = seen.heading.and_then(|heading| {
            let (sin, cos) = libm::sincos(heading.radians());
            let bow = PixelPoint { u: centre.u + BOW_PX * cos, v: centre.v - BOW_PX * sin };
            Some((water.point.bearing_to(self.fix(bow)?.point), HEADING_STD_DEV))
        });
        Some(BoatFix { captured: seen.captured, water, heading })
    }
}
