//! Where the followed boat is on the water, seen from the camera: distance, direction, uncertainty.
//!
//! The line of sight through the centre of the boat's box meets the water at rest ([`WaterView`]). That takes
//! the height above the water, which is taken to be that above the place of the start, the reported tilt of
//! the camera, and its focal length. Without height or tilt there is no distance. The camera's roll is not
//! known here and counts as none, and so does the distortion of a lens that is not calibrated: at the border
//! of a wide picture the distance is then too large by some percent.

use barrelman_control::camera_model::{focal_share_of, lens_of_video};
use barrelman_control::water::WaterView;
use barrelman_control::water::earth::place_on_earth;
use barrelman_pilot::on_earth::NotOnEarth;
use barrelman_vocab::earth::{GeoPoint, WaterOnEarth};
use barrelman_vocab::profile::CameraDynamics;
use barrelman_vocab::{
    Angle, CameraAboveWater, Localisation, SightingNoise, Track, VehicleProfile, WaterPoint,
};

use super::vehicle::VehicleSnapshot;

/// What is known of the inputs, as standard deviations: a centre of a box, a barometer beside waves and tide,
/// a gimbal's level.
const NOISE: SightingNoise = SightingNoise {
    pixel_px: 3.0,
    height_m: 0.7,
    pan: Angle::ZERO,
    tilt: Angle::from_degrees(1.0),
    roll: Angle::from_degrees(1.0),
};
/// Least height, metres: on the ground nothing is looked down on.
const LEAST_HEIGHT_M: f64 = 1.0;
/// A distance whose standard deviation is larger than this share of the distance is not told.
const LARGEST_UNCERTAINTY: f64 = 0.5;

/// Where the boat is.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BoatOnWater {
    /// Distance over the water from the point below the camera, metres.
    pub distance_m: f64,
    /// Its standard deviation, metres.
    pub std_dev_m: f64,
    /// Direction from the camera's axis, positive to the right.
    pub direction: Angle,
    /// Its place on Earth; `None`: the vehicle does not report its position and the direction of its camera
    /// from north.
    pub on_earth: Option<GeoPoint>,
}

/// Finds the boat on the water.
#[derive(Debug, Clone, Copy)]
pub(super) struct BoatFinder {
    /// The camera, with its lens or the focal length of a camera that reports no field of view.
    camera: CameraDynamics,
}

impl BoatFinder {
    pub(super) const fn new(profile: &VehicleProfile) -> Self {
        Self { camera: profile.camera }
    }

    /// Where the boat is; `None`: nothing is followed, height or tilt are not reported, or the line of sight
    /// meets no water near enough.
    pub(super) fn find(
        self,
        track: Track,
        vehicle: &VehicleSnapshot,
        earth: Result<WaterOnEarth, NotOnEarth>,
    ) -> Option<BoatOnWater> {
        let Track::Tracking(Localisation { picture, bounds, .. }) = track else { return None };
        let height_m = vehicle.altitude_m.filter(|height| *height >= LEAST_HEIGHT_M)?;
        let share = vehicle.field_of_view.and_then(focal_share_of).unwrap_or(self.camera.focal_share);
        let of_other = vehicle.other_field_of_view.and_then(focal_share_of);
        let lens = lens_of_video(&self.camera, share, of_other, picture);
        let camera = CameraAboveWater {
            below: WaterPoint::default(),
            height_m,
            pan: Angle::ZERO,
            tilt: vehicle.tilt?,
            roll: Angle::ZERO,
        };
        let fix = WaterView::new(lens, &camera).fix(bounds.centre(), &NOISE)?;
        // Here, ahead is where the camera looks.
        let frame = earth.ok().zip(vehicle.camera_heading);
        let frame = frame.map(|(earth, heading)| WaterOnEarth { ahead: heading, ..earth });
        let distance_m = WaterPoint::default().distance_to(fix.point);
        let std_dev_m = fix.covariance.max_std_dev_m();
        (std_dev_m <= LARGEST_UNCERTAINTY * distance_m).then(|| BoatOnWater {
            distance_m,
            std_dev_m,
            direction: WaterPoint::default().bearing_to(fix.point),
            on_earth: frame.and_then(|frame| place_on_earth(&frame, fix.point)),
        })
    }
}

#[cfg(test)]
mod tests {
    use barrelman_experiments::scenario::{self, ScenarioOverrides};
    use barrelman_sim::World;
    use barrelman_sim::tick::TICKS_PER_SECOND;
    use barrelman_vocab::{PictureSize, PixelBox};

    use super::*;
    use crate::test_scenes::at;

    const PICTURE: PictureSize = PictureSize::new(1280, 720);

    /// A boat whose box has its centre here.
    fn boat(u: f64, v: f64) -> Track {
        boat_in(PICTURE, u, v)
    }

    fn boat_in(picture: PictureSize, u: f64, v: f64) -> Track {
        let bounds = PixelBox { u: u - 20.0, v: v - 8.0, w: 40.0, h: 16.0 };
        Track::Tracking(Localisation {
            captured: at(0),
            picture,
            centre: bounds.centre(),
            bounds,
            shape: None,
            heading: None,
            confidence: 0.9,
        })
    }

    fn vehicle(height_m: f64, tilt_deg: f64) -> VehicleSnapshot {
        VehicleSnapshot {
            altitude_m: Some(height_m),
            tilt: Some(Angle::from_degrees(tilt_deg)),
            ..VehicleSnapshot::default()
        }
    }

    fn finder() -> BoatFinder {
        BoatFinder { camera: CameraDynamics { focal_share: 0.75, ..CameraDynamics::laboratory() } }
    }

    const NOWHERE: Result<WaterOnEarth, NotOnEarth> = Err(NotOnEarth::NoPosition);

    fn find(track: Track, vehicle: &VehicleSnapshot) -> Option<BoatOnWater> {
        finder().find(track, vehicle, NOWHERE)
    }

    #[test]
    fn the_boat_has_latitude_and_longitude_where_position_and_direction_are_reported() {
        let degrees = Angle::from_degrees;
        let origin = GeoPoint { latitude: degrees(54.0), longitude: degrees(-10.0) };
        // Where pan 0 looks is not what counts here.
        let earth = Ok(WaterOnEarth { origin, ahead: degrees(200.0) });
        let east = VehicleSnapshot { camera_heading: Some(degrees(90.0)), ..vehicle(15.0, -45.0) };
        let found = finder().find(boat(640.0, 360.0), &east, earth).unwrap().on_earth.unwrap();
        // A degree of longitude is 65.6 km there.
        let off_m = (found.longitude.degrees() + 10.0) * 65_578.0;
        assert!((off_m - 15.0).abs() < 0.01, "{off_m}");
        assert!((found.latitude.degrees() - 54.0).abs() < 1e-9, "{found:?}");
        let known = |vehicle, earth| finder().find(boat(640.0, 360.0), vehicle, earth).unwrap().on_earth;
        assert_eq!(known(&east, NOWHERE), None);
        assert_eq!(known(&vehicle(15.0, -45.0), earth), None, "no direction from north");
    }

    #[test]
    fn the_boat_at_the_centre_is_where_the_axis_meets_the_water() {
        let found = find(boat(639.5, 359.5), &vehicle(15.0, -45.0)).unwrap();
        assert!((found.distance_m - 15.0).abs() < 0.05, "{found:?}");
        assert!(found.direction.degrees().abs() < 0.1 && found.std_dev_m < 2.0, "{found:?}");
        let right = find(boat(900.0, 359.5), &vehicle(15.0, -45.0)).unwrap();
        // 260 px of 960 px at a depression of 45 degrees: the direction over the water is wider than in the
        // picture.
        let wanted = ((260.5 / 960.0) / 45_f64.to_radians().cos()).atan().to_degrees();
        assert!((right.direction.degrees() - wanted).abs() < 0.2, "{right:?}, {wanted}");
    }

    #[test]
    fn the_simulated_boat_is_as_far_away_as_it_is_said_to_be() {
        for name in ["open", "arena1", "sea3", "gusts"] {
            let loaded = scenario::load(name, &ScenarioOverrides::default()).unwrap();
            let finder = BoatFinder::new(&loaded.profile().unwrap());
            let mut world = World::new(&loaded.scenario, 11).unwrap();
            let picture = loaded.scenario.camera.optics.picture;
            let mut told = 0;
            for tick in 0..40 * TICKS_PER_SECOND {
                world.advance();
                let truth = world.truth();
                if !tick.is_multiple_of(TICKS_PER_SECOND) || !truth.in_picture {
                    continue;
                }
                let (camera, target) = (truth.camera.position, truth.target.position);
                let distance_m = (camera.x - target.x).hypot(camera.y - target.y);
                let vehicle = VehicleSnapshot { tilt: Some(truth.camera.tilt), ..vehicle(camera.z, 0.0) };
                let centre = truth.image.in_pixels(picture);
                let Some(found) = finder.find(boat_in(picture, centre.u, centre.v), &vehicle, NOWHERE) else {
                    continue;
                };
                told += 1;
                let error_m = (found.distance_m - distance_m).abs();
                // The lens's distortion is up to 3 % of the way to the border.
                assert!(
                    error_m <= 3.0 * found.std_dev_m + 0.04 * distance_m,
                    "{name}: {found:?}, {distance_m}"
                );
            }
            assert!(told >= 5, "{name}: {told} distances");
        }
    }

    #[test]
    fn a_reported_field_of_view_counts_and_what_is_not_known_gives_no_distance() {
        let near = |vehicle: &VehicleSnapshot| find(boat(639.5, 500.0), vehicle);
        let wide = near(&vehicle(15.0, -30.0)).unwrap();
        let zoomed =
            VehicleSnapshot { field_of_view: Some(Angle::from_degrees(10.0)), ..vehicle(15.0, -30.0) };
        assert!(near(&zoomed).unwrap().distance_m > wide.distance_m + 1.0);
        assert_eq!(near(&VehicleSnapshot { tilt: None, ..vehicle(15.0, -30.0) }), None);
        assert_eq!(near(&VehicleSnapshot { altitude_m: None, ..vehicle(15.0, -30.0) }), None);
        assert_eq!(near(&vehicle(0.2, -30.0)), None, "on the ground");
        assert_eq!(find(boat(639.5, 359.5), &vehicle(15.0, -1.0)), None, "at the horizon");
        assert_eq!(find(Track::Unseeded, &vehicle(15.0, -30.0)), None);
    }
}
