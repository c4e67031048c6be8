//! Boat and marks as places on Earth. Where latitude and longitude are not known, there is no message.

use crate::console::api::{Place, Snapshot};
use crate::convert::frames::Frames;
use crate::messages::{CovarianceType, Header, NavSatFix, NavSatStatus, Time};

/// Where the followed boat is.
pub fn boat(snapshot: &Snapshot, stamp: Time, frames: &Frames) -> Option<NavSatFix> {
    let boat = snapshot.boat?;
    Some(fix(boat.on_earth?, Some(boat.std_dev_m), frames.boat(stamp)))
}

/// Where the marks are.
pub fn marks(snapshot: &Snapshot, stamp: Time, frames: &Frames) -> Vec<NavSatFix> {
    let marks = snapshot.vessel.iter().flat_map(|vessel| &vessel.marks);
    let known = marks.filter_map(|mark| {
        let header = frames.mark(stamp, &mark.kind, mark.id);
        mark.on_earth.map(|place| fix(place, mark.std_dev_m, header))
    });
    known.collect()
}

/// A place with a standard deviation, metres. Nothing is known of the altitude.
fn fix(place: Place, std_dev_m: Option<f64>, header: Header) -> NavSatFix {
    let (variance, position_covariance_type) = match std_dev_m {
        Some(std_dev) => (std_dev * std_dev, CovarianceType::Approximated),
        None => (0.0, CovarianceType::Unknown),
    };
    let mut position_covariance = [0.0; 9];
    if std_dev_m.is_some() {
        (position_covariance[0], position_covariance[4]) = (variance, variance);
        position_covariance[8] = f64::NAN;
    }
    NavSatFix {
        header,
        status: NavSatStatus::PLACE,
        latitude: place.latitude_deg,
        longitude: place.longitude_deg,
        altitude: f64::NAN,
        position_covariance,
        position_covariance_type,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::console::api::{Boat, Mark, Vessel};
    use crate::test_states::{snapshot, tracking};

    const PLACE: Place = Place { latitude_deg: 54.5, longitude_deg: -10.25 };
    const STAMP: Time = Time { sec: 7, nanosec: 0 };

    fn frames() -> Frames {
        Frames { node: "barrelman".to_owned() }
    }

    #[test]
    fn a_boat_has_a_fix_where_its_place_is_known() {
        let mut state = snapshot(tracking([0.0; 4], 0.5));
        assert_eq!(boat(&state, STAMP, &frames()), None);
        state.boat = Some(Boat { std_dev_m: 3.0, on_earth: None });
        assert_eq!(boat(&state, STAMP, &frames()), None);
        state.boat = Some(Boat { std_dev_m: 3.0, on_earth: Some(PLACE) });
        let fix = boat(&state, STAMP, &frames()).unwrap();
        assert_eq!((fix.latitude, fix.longitude), (54.5, -10.25));
        assert_eq!(fix.header, Header { stamp: STAMP, frame_id: "barrelman/boat".to_owned() });
        assert_eq!(fix.position_covariance[..8], [9.0, 0.0, 0.0, 0.0, 9.0, 0.0, 0.0, 0.0]);
        assert!(fix.altitude.is_nan() && fix.position_covariance[8].is_nan(), "no altitude is known");
        assert_eq!(fix.position_covariance_type, CovarianceType::Approximated);
    }

    #[test]
    fn each_mark_with_a_place_has_a_fix_that_names_it() {
        let mark =
            |id, kind: &str, on_earth, std_dev_m| Mark { id, kind: kind.to_owned(), on_earth, std_dev_m };
        let mut state = snapshot(tracking([0.0; 4], 0.5));
        state.vessel = Some(Vessel {
            marks: vec![
                mark(1, "person", Some(PLACE), Some(2.0)),
                mark(2, "way-point", None, Some(1.0)),
                mark(3, "way-point", Some(PLACE), None),
            ],
        });
        let fixes = marks(&state, STAMP, &frames());
        let names: Vec<_> = fixes.iter().map(|fix| fix.header.frame_id.as_str()).collect();
        assert_eq!(names, ["barrelman/person_1", "barrelman/way_point_3"]);
        assert_eq!(fixes[0].position_covariance[4], 4.0);
        assert_eq!(fixes[1].position_covariance, [0.0; 9]);
        assert_eq!(fixes[1].position_covariance_type, CovarianceType::Unknown);
    }
}
