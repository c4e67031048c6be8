//! Where the water frame lies on Earth, from what the vehicle reports.
//!
//! Two reports are needed: the position of the vehicle, and the direction of the camera's axis from north.
//! The camera's model tells the pan at the time of that report, so that the direction of pan 0 is the
//! difference. Without one of the two there is no latitude and longitude of anything on the water, and the
//! reason is told. Not handled: how far the camera hangs from the antenna, and how far the vehicle moved
//! since a mark was set.

use core::fmt;
use core::time::Duration;

use barrelman_vocab::earth::{GeoPoint, WaterOnEarth};
use barrelman_vocab::{Angle, Timestamp};

/// A report holds for this time: autopilots report some times a second.
const LASTS: Duration = Duration::from_secs(3);

/// Why places on the water have no latitude and longitude.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum NotOnEarth {
    /// The vehicle reports no position, or has not for 3 s.
    NoPosition,
    /// The vehicle does not report the direction of the camera from north, or has not for 3 s.
    NoHeading,
}

impl fmt::Display for NotOnEarth {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::NoPosition => "the vehicle reports no position",
            Self::NoHeading => "the vehicle does not report the direction of the camera from north",
        })
    }
}

/// The newest reports.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct EarthReports {
    position: Option<(GeoPoint, Timestamp)>,
    ahead: Option<(Angle, Timestamp)>,
}

impl EarthReports {
    /// The vehicle tells its position. Values that are not finite are ignored.
    pub(crate) fn on_position(&mut self, position: GeoPoint, at: Timestamp) {
        if position.latitude.radians().is_finite() && position.longitude.radians().is_finite() {
            self.position = Some((position, at));
        }
    }

    /// The vehicle tells the direction of the camera's axis from north, at which the model has this pan
    /// (radians).
    pub(crate) fn on_heading(&mut self, heading: Angle, pan: f64, at: Timestamp) {
        let ahead = heading.radians() - pan;
        if ahead.is_finite() {
            self.ahead = Some((Angle::from_radians(ahead), at));
        }
    }

    /// The link begins anew: maybe with another vehicle.
    pub(crate) fn forget(&mut self) {
        *self = Self::default();
    }

    /// Where the water frame lies now.
    ///
    /// # Errors
    /// What the vehicle does not report.
    pub(crate) fn at(&self, now: Timestamp) -> Result<WaterOnEarth, NotOnEarth> {
        let is_current = |at: Timestamp| now.since(at) <= LASTS;
        let (origin, _) = self.position.filter(|(_, at)| is_current(*at)).ok_or(NotOnEarth::NoPosition)?;
        let (ahead, _) = self.ahead.filter(|(_, at)| is_current(*at)).ok_or(NotOnEarth::NoHeading)?;
        Ok(WaterOnEarth { origin, ahead })
    }
}
