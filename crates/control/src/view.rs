//! The pinhole projection of a camera that pans and tilts, its inverse, and its Jacobian.
//!
//! A direction is a unit vector (right, ahead, up) in a frame that does not turn with the camera; *ahead* is
//! the initial pan direction. Unit vectors have no pole: a target may pass directly below the camera. With an
//! image point (x, y) and the focal length f, the ray has the components x/f (right), y/f (up) and 1 (along
//! the optical axis). A direction behind the camera is projected to a point far outside of the picture; the
//! distance grows with the angle. Lens distortion is not modelled.

use barrelman_vocab::ImagePoint;

/// A unit vector (right, ahead, up).
pub type Direction = [f64; 3];

/// Depths below this share of the distance count as behind the camera.
const MIN_DEPTH_SHARE: f64 = 0.15;

/// A camera's focal length, pan and tilt.
#[derive(Debug, Clone, Copy)]
pub struct View {
    focal_px: f64,
    pan: TurnAngle,
    tilt: TurnAngle,
}

/// An angle with its sine and cosine.
#[derive(Debug, Clone, Copy)]
struct TurnAngle {
    angle: f64,
    sin: f64,
    cos: f64,
}

impl TurnAngle {
    fn new(angle: f64) -> Self {
        let (sin, cos) = libm::sincos(angle);
        Self { angle, sin, cos }
    }

    /// The values of another angle; computed only if the angle differs.
    fn changed_to(self, angle: f64) -> Self {
        if angle.to_bits() == self.angle.to_bits() { self } else { Self::new(angle) }
    }
}

/// The image Jacobian: displacement `[x, y]` of an image point in pixels per radian of pan (right) and tilt
/// (up).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ImageJacobian {
    /// Displacement per radian of pan.
    pub pan: [f64; 2],
    /// Displacement per radian of tilt.
    pub tilt: [f64; 2],
}

impl View {
    /// A camera with this focal length in pixels, pan and tilt in radians.
    pub fn new(focal_px: f64, pan: f64, tilt: f64) -> Self {
        Self { focal_px, pan: TurnAngle::new(pan), tilt: TurnAngle::new(tilt) }
    }

    /// The same camera with another focal length, pan and tilt.
    #[must_use]
    pub fn with_pointing(&self, focal_px: f64, pan: f64, tilt: f64) -> Self {
        Self { focal_px, pan: self.pan.changed_to(pan), tilt: self.tilt.changed_to(tilt) }
    }

    /// The direction of an image point.
    pub fn unproject(&self, point: ImagePoint) -> Direction {
        let per_px = 1.0 / self.focal_px;
        let (right, up) = (per_px * point.x, per_px * point.y);
        let (TurnAngle { sin: sin_pan, cos: cos_pan, .. }, TurnAngle { sin: sin_tilt, cos: cos_tilt, .. }) =
            (self.pan, self.tilt);
        let ahead = cos_tilt - up * sin_tilt;
        let above = sin_tilt + up * cos_tilt;
        let scale = 1.0 / libm::sqrt(1.0 + right * right + up * up);
        [
            scale * (right * cos_pan + ahead * sin_pan),
            scale * (ahead * cos_pan - right * sin_pan),
            scale * above,
        ]
    }

    /// The image point of a direction. The vector's length matters only behind the camera.
    pub fn project(&self, [east, north, above]: Direction) -> ImagePoint {
        let (TurnAngle { sin: sin_pan, cos: cos_pan, .. }, TurnAngle { sin: sin_tilt, cos: cos_tilt, .. }) =
            (self.pan, self.tilt);
        let right = east * cos_pan - north * sin_pan;
        let ahead = east * sin_pan + north * cos_pan;
        let depth = ahead * cos_tilt + above * sin_tilt;
        let across = above * cos_tilt - ahead * sin_tilt;
        if depth < MIN_DEPTH_SHARE {
            return self.project_behind(depth, right, across);
        }
        let scale = self.focal_px / depth;
        ImagePoint { x: scale * right, y: scale * across }
    }

    /// The image point of a direction behind the camera: far outside, in the direction of the offset from the
    /// optical axis. The exact opposite of the optical axis is projected below.
    fn project_behind(&self, depth: f64, right: f64, across: f64) -> ImagePoint {
        let off_squared = right * right + across * across;
        let off = libm::sqrt(off_squared);
        let (right, across) = if off > 0.0 { (right / off, across / off) } else { (0.0, -1.0) };
        let off_at_min_depth = libm::sqrt(off_squared + depth * depth - MIN_DEPTH_SHARE * MIN_DEPTH_SHARE);
        let radius = self.focal_px / MIN_DEPTH_SHARE * (off_at_min_depth + MIN_DEPTH_SHARE - depth);
        ImagePoint { x: radius * right, y: radius * across }
    }

    /// The image Jacobian at an image point.
    pub fn jacobian(&self, point: ImagePoint) -> ImageJacobian {
        let ImagePoint { x, y } = point;
        let (f, TurnAngle { sin, cos, .. }) = (self.focal_px, self.tilt);
        let per_f = 1.0 / f;
        ImageJacobian {
            pan: [-(f * cos - y * sin + x * per_f * x * cos), -(x * sin + x * per_f * y * cos)],
            tilt: [-x * per_f * y, -(f + y * per_f * y)],
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const FOCAL_PX: f64 = 330.0;
    const TILTS_DEG: [f64; 6] = [10.0, 0.0, -24.0, -60.0, -85.0, -90.0];

    fn each_view(mut check: impl FnMut(f64, f64, ImagePoint)) {
        for tilt_deg in TILTS_DEG {
            for pan in [-3.0, 0.0, 0.7] {
                for (x, y) in [(0.0, 0.0), (300.0, 170.0), (-310.0, 20.0), (40.0, -175.0)] {
                    check(pan, tilt_deg.to_radians(), ImagePoint { x, y });
                }
            }
        }
    }

    #[test]
    fn a_point_is_seen_where_its_direction_is() {
        each_view(|pan, tilt, point| {
            let view = View::new(FOCAL_PX, pan, tilt);
            let again = view.project(view.unproject(point));
            assert!(
                (again.x - point.x).abs() < 1e-9 && (again.y - point.y).abs() < 1e-9,
                "{point:?} {again:?}"
            );
        });
    }

    #[test]
    fn what_lies_behind_is_far_outside_and_moves_on_steadily() {
        let view = View::new(FOCAL_PX, 0.0, 0.0);
        let mut last = 0.0;
        for degrees in 60..=180 {
            let (sin, cos) = libm::sincos(f64::from(degrees).to_radians());
            let x = view.project([sin, cos, 0.0]).x;
            if degrees < 180 {
                assert!(x > last && x > 500.0, "{degrees} degrees: {x} px, before {last}");
                last = x;
            }
        }
        let astern = view.project([0.0, -1.0, 0.0]);
        assert!(libm::hypot(astern.x, astern.y) > 2000.0, "{astern:?}");
    }

    #[test]
    fn a_point_moves_as_the_sensitivity_says() {
        const STEP: f64 = 1e-6;
        each_view(|pan, tilt, point| {
            let view = View::new(FOCAL_PX, pan, tilt);
            let direction = view.unproject(point);
            let found = view.jacobian(point);
            for (axis, expected) in [(0, found.pan), (1, found.tilt)] {
                let seen = |off: f64| {
                    let (pan, tilt) = if axis == 0 { (pan + off, tilt) } else { (pan, tilt + off) };
                    View::new(FOCAL_PX, pan, tilt).project(direction)
                };
                let (before, after) = (seen(-STEP), seen(STEP));
                let slope = [(after.x - before.x) / (2.0 * STEP), (after.y - before.y) / (2.0 * STEP)];
                for (slope, expected) in slope.into_iter().zip(expected) {
                    assert!((slope - expected).abs() < 1e-3, "{slope} {expected} at {point:?}, tilt {tilt}");
                }
            }
        });
    }
}
