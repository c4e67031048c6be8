//! What the camera of one video frame sees: pixels to lines of sight, and to points on the water where height
//! and tilt are known.

use barrelman_control::CameraModel;
use barrelman_control::guidance::input::BoatFix;
use barrelman_control::water::WaterView;
use barrelman_vocab::{
    Angle, CameraAboveWater, Localisation, PictureSize, PixelPoint, Sighting, SightingNoise, Timestamp,
    WaterCovariance, WaterFix, WaterPoint,
};

/// Standard deviations of what a point on the water is computed from, common errors apart: those of height
/// and attitude move boat and marks together.
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
/// Bisections by which the horizon is found on a border of the picture.
const HORIZON_STEPS: usize = 16;

/// Random turn of the view to the right and up while the camera rests, radians per root of a second: yaw and
/// place of a kite in the wind.
const SWAY_RAD_PER_ROOT_S: [f64; 2] = [0.029, 0.004];
/// The same for each rad/s at which the camera turns: what the camera's model does not know of its axes.
const SWAY_BY_RATE: f64 = 0.17;

/// The camera of one video frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FrameView {
    /// Lines of sight; points on the water only where `sees_water`.
    pub view: WaterView,
    /// Whether height and tilt are known.
    pub sees_water: bool,
    /// Size of the picture.
    picture: PictureSize,
    /// How fast the view may turn beside the camera's model, to the right and up, radians per root of a
    /// second.
    sway_rad_per_root_s: [f64; 2],
}

impl FrameView {
    /// The camera at the time of capture of a video frame; `None` for the height: height or tilt are not
    /// known, and only lines of sight mean anything. `below`: the camera's apparent displacement.
    pub fn new(
        camera: &CameraModel,
        captured: Timestamp,
        picture: PictureSize,
        height_m: Option<f64>,
        below: WaterPoint,
    ) -> Self {
        let (pan, tilt) = camera.angles_at(captured);
        let (pan_rate, tilt_rate) = camera.rates_at(captured);
        let [still_pan, still_tilt] = SWAY_RAD_PER_ROOT_S;
        let sway = |still, rate| libm::hypot(still, SWAY_BY_RATE * rate);
        let lens = camera.lens_at(captured, picture);
        let camera = CameraAboveWater {
            below,
            height_m: height_m.unwrap_or(1.0),
            pan: Angle::from_radians(pan),
            tilt: Angle::from_radians(tilt),
            roll: Angle::ZERO,
        };
        Self {
            view: WaterView::new(lens, &camera),
            sees_water: height_m.is_some(),
            picture,
            sway_rad_per_root_s: [sway(still_pan, pan_rate), sway(still_tilt, tilt_rate)],
        }
    }

    /// The point on the water at a pixel; `None`: at the horizon, above it, or the water is not known.
    pub fn fix(&self, pixel: PixelPoint) -> Option<WaterFix> {
        self.view.fix(pixel, &NOISE).filter(|_| self.sees_water)
    }

    /// How far a point on the water may seem to have moved after a time, as the view turns beside the
    /// camera's model: the larger standard deviation, metres.
    pub(super) fn sway_m(&self, point: WaterPoint, duration_s: f64) -> f64 {
        let moved = |((x, y), rate): ((f64, f64), f64)| rate * libm::hypot(x, y);
        let turned = self.view.slopes_at(point).into_iter().zip(self.sway_rad_per_root_s).map(moved);
        libm::sqrt(duration_s) * turned.fold(0.0, f64::max)
    }

    /// The corners of what the picture shows of the water: near left, far left, far right, near right. Where
    /// the horizon is in the picture, the far corners are the farthest points that are known on the left and
    /// right border. `None`: height or tilt are not known, or the lower border is not on the water.
    pub fn water_corners(&self) -> Option<[WaterPoint; 4]> {
        let (right, bottom) = (f64::from(self.picture.width), f64::from(self.picture.height));
        let point = |u: f64, v: f64| match self.view.sighting(PixelPoint { u, v }) {
            Sighting::OnWater(point) => Some(point),
            Sighting::AtHorizon { .. } | Sighting::OutsideLens => None,
        };
        let side = |u: f64| {
            let near = point(u, bottom)?;
            if let Some(far) = point(u, 0.0) {
                return Some((near, far));
            }
            let (mut far, mut low, mut high) = (near, bottom, 0.0);
            for _ in 0..HORIZON_STEPS {
                let middle = 0.5 * (low + high);
                match point(u, middle) {
                    Some(found) => (far, low) = (found, middle),
                    None => high = middle,
                }
            }
            Some((near, far))
        };
        if !self.sees_water {
            return None;
        }
        let ((near_left, far_left), (near_right, far_right)) = (side(0.0)?, side(right)?);
        Some([near_left, far_left, far_right, near_right])
    }

    /// The boat on the water, seen from where the camera's model says. The camera may be elsewhere; that is
    /// told from a boat that `is_commanded`, whose motion is known.
    pub fn boat(&self, seen: &Localisation, is_commanded: bool) -> Option<BoatFix> {
        let centre = seen.bounds.centre();
        let water = self.fix(centre)?;
        let heading = seen.heading.and_then(|heading| {
            let (sin, cos) = libm::sincos(heading.radians());
            let bow = PixelPoint { u: centre.u + BOW_PX * cos, v: centre.v - BOW_PX * sin };
            Some((water.point.bearing_to(self.fix(bow)?.point), HEADING_STD_DEV))
        });
        let sway_per_s = is_commanded.then(|| {
            let mut growth = WaterCovariance::default();
            for ((x, y), rate) in self.view.slopes_at(water.point).into_iter().zip(self.sway_rad_per_root_s) {
                growth.xx += rate * rate * x * x;
                growth.xy += rate * rate * x * y;
                growth.yy += rate * rate * y * y;
            }
            growth
        });
        Some(BoatFix { captured: seen.captured, water, heading, is_commanded, sway_per_s })
    }
}

#[cfg(test)]
mod tests {
    use barrelman_vocab::profile::CameraDynamics;
    use barrelman_vocab::{BrownConrady, Distortion, Lens};

    use super::*;

    const PICTURE: PictureSize = PictureSize::new(1280, 720);

    fn view(tilt_deg: f64, height_m: Option<f64>) -> FrameView {
        let lens = Lens::pinhole(PICTURE, 1000.0);
        let camera = CameraAboveWater {
            below: WaterPoint::default(),
            height_m: height_m.unwrap_or(1.0),
            pan: Angle::ZERO,
            tilt: Angle::from_degrees(tilt_deg),
            roll: Angle::ZERO,
        };
        FrameView {
            view: WaterView::new(lens, &camera),
            sees_water: height_m.is_some(),
            picture: PICTURE,
            sway_rad_per_root_s: SWAY_RAD_PER_ROOT_S,
        }
    }

    #[test]
    fn the_corners_on_the_water_are_those_of_the_picture() {
        let corners = view(-45.0, Some(15.0)).water_corners().unwrap();
        let [near_left, far_left, far_right, near_right] = corners;
        assert!(near_left.x < 0.0 && (near_left.x + near_right.x).abs() < 1e-9, "{corners:?}");
        // 45 degrees less and more half the field of view, atan(0.36).
        let expected = |angle: f64| 15.0 / libm::tan(angle);
        let half = libm::atan(0.36);
        let near = expected(core::f64::consts::FRAC_PI_4 + half);
        let far = expected(core::f64::consts::FRAC_PI_4 - half);
        assert!((near_left.y - near).abs() < 1e-9 && (far_right.y - far).abs() < 1e-9, "{corners:?}");
        assert!(far_left.x < near_left.x, "{corners:?}");
    }

    #[test]
    fn a_calibrated_lens_is_the_one_that_sees() {
        let profile = barrelman_vocab::VehicleProfile::fotokite_pro();
        let model = BrownConrady { k1: -0.1, ..BrownConrady::default() };
        let focal_px = profile.camera.focal_share * f64::from(PICTURE.width);
        let lens = Lens { distortion: Distortion::BrownConrady(model), ..Lens::pinhole(PICTURE, focal_px) };
        let seen = |lens: Option<Lens>| {
            let camera = CameraModel::new(CameraDynamics { lens, ..profile.camera }, profile.limits, None);
            let half = PictureSize::new(640, 360);
            let view = FrameView::new(
                &camera,
                Timestamp::from_nanos(1_000_000_000),
                half,
                Some(15.0),
                WaterPoint::default(),
            );
            view.fix(PixelPoint { u: 600.0, v: 300.0 }).unwrap().point
        };
        // The pixel is 305 px from the centre, at r = 0.92, where r (1 - 0.1 r²) undone is 1.03.
        let (pinhole, calibrated) = (seen(None), seen(Some(lens)));
        assert!(calibrated.x / calibrated.y > 1.1 * pinhole.x / pinhole.y, "{pinhole:?} {calibrated:?}");
    }

    #[test]
    fn the_horizon_ends_the_water() {
        let [near, far, ..] = view(-10.0, Some(15.0)).water_corners().unwrap();
        // Points more than 2 degrees below the horizon are known.
        let distance = libm::hypot(far.x, far.y);
        assert!(near.y < far.y && (300.0..430.0).contains(&distance), "{near:?} {far:?}");
        assert_eq!(view(60.0, Some(15.0)).water_corners(), None, "the sky alone");
        assert_eq!(view(-45.0, None).water_corners(), None, "the height is not known");
    }
}
