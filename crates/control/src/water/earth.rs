//! From a point on the water to latitude and longitude.
//!
//! The water is taken for the plane that touches the ellipsoid of WGS 84 below the camera. With the latitude
//! φ there, the direction ψ of the frame's y from north, the semi-major axis a and the eccentricity e:
//!
//! ```text
//! north = y cos ψ - x sin ψ              east = y sin ψ + x cos ψ
//! M = a (1 - e²) / (1 - e² sin²φ)^1.5    N = a / (1 - e² sin²φ)^0.5
//! latitude  = φ + north / M
//! longitude = λ + east / (N cos φ)
//! ```
//!
//! What the plane neglects grows with the square of the distance d, to d² tan φ / (2 N) in the latitude and
//! twice that in the longitude: at 300 m and 60 degrees 12 and 25 mm, at 1 km 0.14 and 0.27 m. Beyond
//! [`MAX_DISTANCE_M`], and nearer to a pole than [`MAX_LATITUDE`], there is no answer. Not handled: the
//! height of the geoid, which moves no place by more than a hundred-thousandth of its distance.

use barrelman_vocab::earth::{GeoPoint, WaterOnEarth};
use barrelman_vocab::{Angle, WaterPoint, wrapped};

/// Largest distance from the camera, metres.
pub const MAX_DISTANCE_M: f64 = 2_000.0;
/// Largest latitude on both hemispheres.
pub const MAX_LATITUDE: Angle = Angle::from_degrees(85.0);

/// Semi-major axis of WGS 84, metres.
const SEMI_MAJOR_M: f64 = 6_378_137.0;
/// Flattening of WGS 84.
const FLATTENING: f64 = 1.0 / 298.257_223_563;
/// Square of the eccentricity.
const ECCENTRICITY_SQUARED: f64 = FLATTENING * (2.0 - FLATTENING);

/// The place of a point on the water. `None`: too far away, too near to a pole, or not finite.
pub fn place_on_earth(frame: &WaterOnEarth, point: WaterPoint) -> Option<GeoPoint> {
    let GeoPoint { latitude, longitude } = frame.origin;
    let (latitude, longitude) = (latitude.radians(), longitude.radians());
    let is_near = WaterPoint::default().distance_to(point) <= MAX_DISTANCE_M;
    let is_finite = longitude.is_finite() && frame.ahead.radians().is_finite();
    if !(is_near && is_finite && latitude.abs() <= MAX_LATITUDE.radians()) {
        return None;
    }
    let ((sin, cos), (sin_ahead, cos_ahead)) = (libm::sincos(latitude), libm::sincos(frame.ahead.radians()));
    let north_m = point.y * cos_ahead - point.x * sin_ahead;
    let east_m = point.y * sin_ahead + point.x * cos_ahead;
    let shape = 1.0 - ECCENTRICITY_SQUARED * sin * sin;
    let normal_m = SEMI_MAJOR_M / libm::sqrt(shape);
    let meridian_m = normal_m * (1.0 - ECCENTRICITY_SQUARED) / shape;
    Some(GeoPoint {
        latitude: Angle::from_radians(latitude + north_m / meridian_m),
        longitude: Angle::from_radians(wrapped(longitude + east_m / (normal_m * cos))),
    })
}
