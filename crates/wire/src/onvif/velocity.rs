//! How fast a camera is told to move: shares of its largest speeds.

use core::time::Duration;

use barrelman_vocab::VehicleRates;
use barrelman_vocab::speed_curve::{AxisSpeeds, SpeedCurve};

use crate::http::motion::Speeds;

/// Shares of the largest speeds, -1 to 1, positive to the right, upwards, and to a closer view.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct SpeedShares {
    /// Pan.
    pub pan: f64,
    /// Tilt.
    pub tilt: f64,
    /// Zoom.
    pub zoom: f64,
}

impl SpeedShares {
    /// Shares that turn the camera and do not zoom.
    pub const fn turning(pan: f64, tilt: f64) -> Self {
        Self { pan, tilt, zoom: 0.0 }
    }
}

/// The upper ends of a camera's ranges of speeds, mostly 1.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FullSpeeds {
    /// Pan.
    pub pan: f64,
    /// Tilt.
    pub tilt: f64,
    /// Zoom; `None`: the camera states none.
    pub zoom: Option<f64>,
}

impl FullSpeeds {
    /// The ranges of -1 to 1 that every camera must know, without a zoom.
    pub const GENERIC: Self = Self { pan: 1.0, tilt: 1.0, zoom: None };
}

/// Speeds of the axes in thousandths of the largest, so that two requests compare exactly. Positive: right,
/// up, closer.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Velocity {
    pan: i16,
    tilt: i16,
    zoom: i16,
}

impl Speeds for Velocity {
    const REST: Self = Self { pan: 0, tilt: 0, zoom: 0 };
    /// Less than a third of [`super::ask::MOVE_TIMEOUT`]: two renewals that are lost leave the camera
    /// turning, three end the motion.
    const RENEWAL: Duration = Duration::from_millis(300);
}

impl Velocity {
    /// The speeds at which the axes turn at these rates.
    pub fn of(rates: VehicleRates, speeds: &AxisSpeeds) -> Self {
        let thousandths = |share: f64| (share * 1e3).round() as i16;
        let axis = |curve: &SpeedCurve, rate| thousandths(curve.speed_for(rate));
        Self {
            pan: axis(&speeds.pan, rates.yaw),
            tilt: axis(&speeds.tilt, rates.pitch),
            zoom: thousandths(rates.zoom.clamp(-1.0, 1.0)),
        }
    }

    /// As shares.
    pub fn shares(self) -> SpeedShares {
        let [pan, tilt, zoom] =
            [self.pan, self.tilt, self.zoom].map(|thousandths| f64::from(thousandths) / 1e3);
        SpeedShares { pan, tilt, zoom }
    }
}
