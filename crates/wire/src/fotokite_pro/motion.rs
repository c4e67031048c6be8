//! Motion of the camera as telemetry shows it: the flight unit's attitude turns with yaw, the gimbal's with
//! pitch.

use core::time::Duration;

use barrelman_vocab::Timestamp;
use barrelman_vocab::telemetry::Report;

pub use crate::attitude_rate::MOTION_RAD_PER_S;
use crate::attitude_rate::{AttitudeRate, evidence};
use crate::session::RestEvidence;

/// Least time between two attitudes that are compared.
const LEAST_SPACING: Duration = Duration::from_millis(40);

/// The newest attitudes and how fast they turned.
#[derive(Debug, Clone, Copy)]
pub struct MotionWatch {
    vehicle: AttitudeRate,
    gimbal: AttitudeRate,
}

impl Default for MotionWatch {
    fn default() -> Self {
        Self { vehicle: AttitudeRate::new(LEAST_SPACING), gimbal: AttitudeRate::new(LEAST_SPACING) }
    }
}

impl MotionWatch {
    /// Takes a report.
    pub fn on_report(&mut self, report: &Report, now: Timestamp) {
        match *report {
            Report::VehicleAttitude(attitude) => self.vehicle.on_attitude(attitude, now),
            Report::GimbalAttitude(attitude) => self.gimbal.on_attitude(attitude, now),
            _ => {}
        }
    }

    /// Whether any motion, or rest, was ever shown.
    pub const fn has_seen(&self) -> bool {
        self.vehicle.has_seen() && self.gimbal.has_seen()
    }

    /// What the newest reports show, if they came after `since`.
    pub fn since(&self, since: Timestamp, now: Timestamp) -> RestEvidence {
        let rates = (self.vehicle.rate_since(since, now), self.gimbal.rate_since(since, now));
        let (Some(vehicle), Some(gimbal)) = rates else {
            return RestEvidence::NoTelemetry;
        };
        evidence(vehicle.max(gimbal))
    }
}
