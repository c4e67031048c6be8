//! Latitude and longitude of points on the water, against the published lengths of a degree on WGS 84, and
//! against the plane's points turned into geocentric coordinates and back.

use barrelman_control::water::earth::{MAX_DISTANCE_M, place_on_earth};
use barrelman_vocab::earth::{GeoPoint, WaterOnEarth};
use barrelman_vocab::{Angle, WaterPoint};
use proptest::prelude::*;

fn frame(latitude_deg: f64, longitude_deg: f64, ahead_deg: f64) -> WaterOnEarth {
    let degrees = Angle::from_degrees;
    let origin = GeoPoint { latitude: degrees(latitude_deg), longitude: degrees(longitude_deg) };
    WaterOnEarth { origin, ahead: degrees(ahead_deg) }
}

/// Lengths of a degree of latitude and of longitude on WGS 84 at a latitude, metres, as tables print them.
const DEGREES_M: [(f64, f64, f64); 6] = [
    (0.0, 110_574.0, 111_320.0),
    (15.0, 110_649.0, 107_551.0),
    (30.0, 110_852.0, 96_486.0),
    (45.0, 111_132.0, 78_847.0),
    (60.0, 111_412.0, 55_800.0),
    (75.0, 111_618.0, 28_902.0),
];

#[test]
fn a_degree_is_as_long_as_tables_say() {
    for (latitude, north_m, east_m) in DEGREES_M {
        for south in [1.0, -1.0] {
            // To the north and to the east, with north ahead; the tables are rounded to a metre.
            let frame = frame(south * latitude, 20.0, 0.0);
            let north = place_on_earth(&frame, WaterPoint { x: 0.0, y: 1_000.0 }).unwrap();
            let found = 1_000.0 / (north.latitude.degrees() - south * latitude);
            assert!((found - north_m).abs() <= 1.0, "{latitude}: {found} m, {north_m}");
            let east = place_on_earth(&frame, WaterPoint { x: 1_000.0, y: 0.0 }).unwrap();
            let found = 1_000.0 / (east.longitude.degrees() - 20.0);
            assert!((found - east_m).abs() <= 1.0, "{latitude}: {found} m, {east_m}");
        }
    }
}

#[test]
fn the_frame_is_turned_by_its_direction_from_north() {
    let check = |ahead: f64, point: WaterPoint, north: f64, east: f64| {
        let found = place_on_earth(&frame(50.0, 0.0, ahead), point).unwrap();
        // 111,229 m and 71,696 m a degree.
        let seen = [(found.latitude.degrees() - 50.0) * 111_229.0, found.longitude.degrees() * 71_696.0];
        assert!((seen[0] - north).abs() < 0.01 && (seen[1] - east).abs() < 0.01, "{ahead}: {seen:?}");
    };
    let ahead = WaterPoint { x: 0.0, y: 100.0 };
    let right = WaterPoint { x: 100.0, y: 0.0 };
    check(0.0, ahead, 100.0, 0.0);
    check(0.0, right, 0.0, 100.0);
    check(90.0, ahead, 0.0, 100.0);
    check(90.0, right, -100.0, 0.0);
    check(-135.0, ahead, -70.711, -70.711);
    check(585.0, ahead, -70.711, -70.711);
}

#[test]
fn the_longitude_goes_on_beyond_half_a_turn() {
    let east = place_on_earth(&frame(10.0, 179.9999, 90.0), WaterPoint { x: 0.0, y: 100.0 }).unwrap();
    assert!((-180.0..-179.99).contains(&east.longitude.degrees()), "{east:?}");
    let west = place_on_earth(&frame(10.0, -179.9999, 270.0), WaterPoint { x: 0.0, y: 100.0 }).unwrap();
    assert!((179.99..180.0).contains(&west.longitude.degrees()), "{west:?}");
}

#[test]
fn what_is_too_far_away_or_no_place_has_no_latitude() {
    let near = WaterPoint { x: 0.0, y: 100.0 };
    assert_eq!(place_on_earth(&frame(50.0, 0.0, 0.0), WaterPoint { x: MAX_DISTANCE_M, y: 1.0 }), None);
    assert_eq!(place_on_earth(&frame(50.0, 0.0, 0.0), WaterPoint { x: f64::NAN, y: 1.0 }), None);
    for (latitude, longitude, ahead) in
        [(86.0, 0.0, 0.0), (f64::NAN, 0.0, 0.0), (50.0, f64::INFINITY, 0.0), (50.0, 0.0, f64::NAN)]
    {
        assert_eq!(place_on_earth(&frame(latitude, longitude, ahead), near), None);
    }
}

const A: f64 = 6_378_137.0;
const B: f64 = 6_356_752.314_245;

/// Geodetic coordinates (radians) of the point of the tangent plane at a place, by geocentric coordinates and
/// iteration.
fn by_geocentric(latitude: f64, longitude: f64, east: f64, north: f64) -> (f64, f64) {
    let e2 = 1.0 - (B / A) * (B / A);
    let ((sp, cp), (sl, cl)) = (libm::sincos(latitude), libm::sincos(longitude));
    let n = A * A / (A * A * cp * cp + B * B * sp * sp).sqrt();
    let x = n * cp * cl - sl * east - sp * cl * north;
    let y = n * cp * sl + cl * east - sp * sl * north;
    let z = n * (1.0 - e2) * sp + cp * north;
    let p = libm::hypot(x, y);
    let mut phi = libm::atan2(z, p * (1.0 - e2));
    for _ in 0..20 {
        let (sin, cos) = libm::sincos(phi);
        let n = A * A / (A * A * cos * cos + B * B * sin * sin).sqrt();
        phi = libm::atan2(z + e2 * n * sin, p);
    }
    (phi, libm::atan2(y, x))
}

proptest! {
    /// The plane is as good as its documentation says.
    #[test]
    fn the_plane_is_near_the_ellipsoid(
        latitude in -60.0..60.0_f64, longitude in -170.0..170.0_f64, ahead in -360.0..360.0_f64,
        x in -700.0..700.0_f64, y in -700.0..700.0_f64
    ) {
        let found = place_on_earth(&frame(latitude, longitude, ahead), WaterPoint { x, y }).unwrap();
        let (sin, cos) = libm::sincos(ahead.to_radians());
        let (east, north) = (y * sin + x * cos, y * cos - x * sin);
        let (phi, lambda) = by_geocentric(latitude.to_radians(), longitude.to_radians(), east, north);
        let off_north_m = (found.latitude.radians() - phi) * A;
        let off_east_m = (found.longitude.radians() - lambda) * A * libm::cos(phi);
        let bound_m = (x * x + y * y) / A * libm::tan(60.0_f64.to_radians());
        prop_assert!(off_north_m.abs() <= 0.51 * bound_m + 1e-3, "{off_north_m} m of {bound_m}");
        prop_assert!(off_east_m.abs() <= 1.01 * bound_m + 1e-3, "{off_east_m} m of {bound_m}");
    }
}
