//! How fast a camera is told to turn: shares of its largest speeds.

use core::time::Duration;

use barrelman_vocab::VehicleRates;
use barrelman_vocab::speed_curve::{AxisSpeeds, SpeedCurve};

use crate::http::motion::Speeds;

/// Speeds of both axes in thousandths of the largest, so that two requests compare exactly. Positive: right, up.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Velocity {
    pan: i16,
    tilt: i16,
}

impl Speeds for Velocity {
    const REST: Self = Self { pan: 0, tilt: 0 };
    /// Less than a third of [`super::ask::MOVE_TIMEOUT`]: two renewals that are lost leave the camera turning, three end the
    /// motion.
    const RENEWAL: Duration = Duration::from_millis(300);
}

impl Velocity {
    /// The speeds at which the axes turn at these rates.
    pub fn of(rates: VehicleRates, speeds: &AxisSpeeds) -> Self {
        let thousandths = |curve: &SpeedCurve, rate| (curve.speed_for(rate) * 1e3).round() as i16;
        Self { pan: thousandths(&speeds.pan, rates.yaw), tilt: thousandths(&speeds.tilt, rates.pitch) }
    }

    /// Pan, -1 to 1, positive to the right.
    pub fn pan(self) -> f64 {
        f64::from(self.pan) / 1e3
    }

    /// Tilt, -1 to 1, positive upwards.
    pub fn tilt(self) -> f64 {
        f64::from(self.tilt) / 1e3
    }
}
