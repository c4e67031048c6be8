//! A camera above the water: pixels to lines of sight and to points on the water, and back, with uncertainty.
//!
//! A line of sight is a vector (right, ahead, up) in the frame of reference that does not turn with the
//! camera. With the tangents (x, y) of a pixel, the pan p, the tilt t (positive upwards) and the roll r:
//!
//! ```text
//! level right:  a =  x cos r - y sin r        (roll turns the picture about the optical axis)
//! level down:   b =  x sin r + y cos r
//! forwards:     f =  cos t + b sin t
//! downwards:    d = -sin t + b cos t
//! point:        (h / d) (a cos p + f sin p,  f cos p - a sin p)
//! ```
//!
//! where h is the height above the water. The covariance of a point is that of its first-order dependence on
//! pixel, height and attitude.

use barrelman_vocab::{
    Angle, CameraAboveWater, Lens, PixelPoint, Sighting, SightingNoise, WaterCovariance, WaterFix, WaterPoint,
};

use super::lens;
use crate::view::Direction;

/// A line of sight that is less than this below the horizon meets the water too far away to be of use: an
/// error of a tenth of a degree there is a twentieth of the distance.
pub const MIN_DEPRESSION: Angle = Angle::from_degrees(2.0);

/// Points less far ahead than this share of the distance have no pixel.
const MIN_DEPTH_SHARE: f64 = 1e-6;

/// A camera above the water, with the sines and cosines of its attitude.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WaterView {
    lens: Lens,
    below: WaterPoint,
    height_m: f64,
    pan: (f64, f64),
    tilt: (f64, f64),
    roll: (f64, f64),
    sin_min_depression: f64,
}

/// A line of sight in the level frame of reference of the camera: right, forwards, down. Its depth along the
/// optical axis is 1.
#[derive(Debug, Clone, Copy)]
struct LevelRay {
    right: f64,
    forwards: f64,
    down: f64,
}

impl LevelRay {
    fn norm(self) -> f64 {
        libm::sqrt(self.right * self.right + self.forwards * self.forwards + self.down * self.down)
    }
}

impl WaterView {
    /// A camera with this lens, position and attitude.
    pub fn new(lens: Lens, camera: &CameraAboveWater) -> Self {
        Self {
            lens,
            below: camera.below,
            height_m: camera.height_m,
            pan: libm::sincos(camera.pan.radians()),
            tilt: libm::sincos(camera.tilt.radians()),
            roll: libm::sincos(camera.roll.radians()),
            sin_min_depression: libm::sin(MIN_DEPRESSION.radians()),
        }
    }

    /// The direction of a pixel: a unit vector (right, ahead, up). `None`: the lens maps no line of sight to
    /// this pixel.
    pub fn direction_of(&self, pixel: PixelPoint) -> Option<Direction> {
        let ray = self.level_ray(lens::tangents_of(&self.lens, pixel)?);
        let scale = 1.0 / ray.norm();
        let (x, y) = self.turned_by_pan(ray.right, ray.forwards);
        Some([scale * x, scale * y, -scale * ray.down])
    }

    /// The pixel of a direction (right, ahead, up) of any length. `None`: behind the camera, or outside of
    /// the lens.
    pub fn pixel_of(&self, [x, y, up]: Direction) -> Option<PixelPoint> {
        let ((sp, cp), (st, ct), (sr, cr)) = (self.pan, self.tilt, self.roll);
        let (right, forwards) = (x * cp - y * sp, x * sp + y * cp);
        let depth = forwards * ct + up * st;
        let below_axis = forwards * st - up * ct;
        let length = libm::sqrt(x * x + y * y + up * up);
        // A vector that is not finite is not ahead of the camera, either.
        if !(depth > MIN_DEPTH_SHARE * length && length.is_finite()) {
            return None;
        }
        let (right, below_axis) = (right * cr + below_axis * sr, below_axis * cr - right * sr);
        lens::pixel_of(&self.lens, [right / depth, below_axis / depth])
    }

    /// What is seen at a pixel.
    pub fn sighting(&self, pixel: PixelPoint) -> Sighting {
        let Some(tangents) = lens::tangents_of(&self.lens, pixel) else { return Sighting::OutsideLens };
        let ray = self.level_ray(tangents);
        if !self.meets_water(ray) {
            return Sighting::AtHorizon {
                depression: Angle::from_radians(libm::asin((ray.down / ray.norm()).clamp(-1.0, 1.0))),
            };
        }
        Sighting::OnWater(self.water_point(ray))
    }

    /// The point on the water at a pixel, with its covariance. `None` where there is no such point
    /// ([`Self::sighting`] says why).
    pub fn fix(&self, pixel: PixelPoint, noise: &SightingNoise) -> Option<WaterFix> {
        let (tangents, slope) = lens::line_of_sight(&self.lens, pixel)?;
        let ray = self.level_ray(tangents);
        if !self.meets_water(ray) {
            return None;
        }
        let ((st, ct), (sr, cr)) = (self.tilt, self.roll);
        let reach = self.height_m / ray.down;
        let (right, forwards) = (reach * ray.right, reach * ray.forwards);
        // Derivatives of the point (right, forwards) by the ray's right and down-in-picture components a and
        // b.
        let by_a = [reach, 0.0];
        let by_b = [-right * ct / ray.down, reach * st - forwards * ct / ray.down];
        let by_tangents = |x: f64, y: f64| {
            let (a, b) = (x * cr - y * sr, x * sr + y * cr);
            [by_a[0] * a + by_b[0] * b, by_a[1] * a + by_b[1] * b]
        };
        let by_u = by_tangents(slope[0][0], slope[1][0]);
        let by_v = by_tangents(slope[0][1], slope[1][1]);
        let [by_pan, by_tilt] = self.slopes_by_turn(right, forwards);
        let level_down = tangents[0] * sr + tangents[1] * cr;
        // A roll by dr turns a' = -b and b' = a.
        let by_roll =
            [-by_a[0] * level_down + by_b[0] * ray.right, -by_a[1] * level_down + by_b[1] * ray.right];
        let by_height = [right / self.height_m, forwards / self.height_m];
        let mut covariance = WaterCovariance::default();
        for (std_dev, by) in [
            (noise.pixel_px, by_u),
            (noise.pixel_px, by_v),
            (noise.tilt.radians(), by_tilt),
            (noise.roll.radians(), by_roll),
            (noise.pan.radians(), by_pan),
            (noise.height_m, by_height),
        ] {
            let (x, y) = self.turned_by_pan(std_dev * by[0], std_dev * by[1]);
            covariance.xx += x * x;
            covariance.xy += x * y;
            covariance.yy += y * y;
        }
        Some(WaterFix { point: self.water_point(ray), covariance })
    }

    /// The pixel of a point on the water. `None`: behind the camera, or outside of the lens.
    pub fn pixel_of_water(&self, point: WaterPoint) -> Option<PixelPoint> {
        let (x, y) = self.below.vector_to(point);
        self.pixel_of([x, y, -self.height_m])
    }

    /// How the point on the water at a pixel moves along x and y, metres for each radian by which the camera
    /// turns to the right, and up, where the pixel is that of `point`.
    pub fn slopes_at(&self, point: WaterPoint) -> [(f64, f64); 2] {
        let (x, y) = self.below.vector_to(point);
        let (sp, cp) = self.pan;
        self.slopes_by_turn(x * cp - y * sp, x * sp + y * cp)
            .map(|[right, forwards]| self.turned_by_pan(right, forwards))
    }

    /// Derivatives of a point (right, forwards; metres) by pan and by tilt, metres per radian. A tilt upwards
    /// by dt turns forwards' = down and down' = -forwards.
    fn slopes_by_turn(&self, right: f64, forwards: f64) -> [[f64; 2]; 2] {
        let slope = forwards / self.height_m;
        [[forwards, -right], [right * slope, self.height_m + forwards * slope]]
    }

    fn level_ray(&self, [x, y]: lens::Tangents) -> LevelRay {
        let ((st, ct), (sr, cr)) = (self.tilt, self.roll);
        let (right, down) = (x * cr - y * sr, x * sr + y * cr);
        LevelRay { right, forwards: ct + down * st, down: -st + down * ct }
    }

    fn meets_water(&self, ray: LevelRay) -> bool {
        ray.down >= self.sin_min_depression * ray.norm()
    }

    fn water_point(&self, ray: LevelRay) -> WaterPoint {
        let reach = self.height_m / ray.down;
        let (x, y) = self.turned_by_pan(reach * ray.right, reach * ray.forwards);
        WaterPoint { x: self.below.x + x, y: self.below.y + y }
    }

    /// Right and forwards of the camera along the water frame's x and y.
    fn turned_by_pan(&self, right: f64, forwards: f64) -> (f64, f64) {
        let (sp, cp) = self.pan;
        (right * cp + forwards * sp, forwards * cp - right * sp)
    }
}
