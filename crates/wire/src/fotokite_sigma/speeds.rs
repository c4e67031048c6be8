//! Rates as a Sigma takes them: degrees per second, pan positive to the right, tilt positive downwards, each
//! 0 or between the least and the largest speed that the camera states.

use core::time::Duration;

use barrelman_vocab::{AngularRate, VehicleRates};

use super::json::CameraInfo;
use crate::http;

/// Speeds of both axes in thousandths of a degree per second, so that two requests compare exactly.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Speeds {
    pan: i32,
    tilt: i32,
}

impl http::motion::Speeds for Speeds {
    const REST: Self = Self { pan: 0, tilt: 0 };
    /// A third of [`super::call::TURN_DURATION`]: one command that is lost leaves the camera turning, two
    /// that are lost end the motion.
    const RENEWAL: Duration = Duration::from_millis(150);
}

impl Speeds {
    /// The rates within the camera's limits. What lies below the least speed is zero, as the vehicle would
    /// refuse it.
    pub fn within(rates: VehicleRates, info: &CameraInfo) -> Self {
        Self {
            pan: speed(rates.yaw, info.pan_speed_min, info.pan_speed_max),
            tilt: speed(rates.pitch, info.tilt_speed_min, info.tilt_speed_max),
        }
    }

    /// Pan, degrees per second, positive to the right.
    pub fn pan_deg_per_s(self) -> f64 {
        f64::from(self.pan) / 1e3
    }

    /// Tilt, degrees per second, positive downwards.
    pub fn tilt_deg_per_s(self) -> f64 {
        f64::from(self.tilt) / 1e3
    }
}

/// Nothing real turns faster, degrees per second.
const MAX_SPEED: f64 = 360.0;

fn speed(rate: AngularRate, least: f64, largest: f64) -> i32 {
    // Limits that are no numbers allow nothing.
    let thousandths = |limit: f64| if limit >= 0.0 { limit.min(MAX_SPEED) * 1e3 } else { 0.0 };
    // A speed at the least, as the profile sends it, must not fall below it by rounding.
    let (least, largest) = (thousandths(least).ceil() as i32, thousandths(largest).floor() as i32);
    let wanted = rate.radians_per_second().to_degrees() * 1e3;
    if !wanted.is_finite() {
        return 0;
    }
    let size = (wanted.abs().min(MAX_SPEED * 1e3).round() as i32).min(largest);
    if size == 0 || size < least { 0 } else { size * if wanted < 0.0 { -1 } else { 1 } }
}
