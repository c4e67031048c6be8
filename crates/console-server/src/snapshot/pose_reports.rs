//! When tilt and height of the camera were reported: a report holds for as long as it does in the pilot.

use barrelman_pilot::vessel::POSE_LASTS;
use barrelman_vocab::telemetry::Report;
use barrelman_vocab::{Telemetry, Timestamp};

use super::vehicle::VehicleSnapshot;

/// The times of the last reports; `None`: there was none.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct PoseReports {
    tilt: Option<Timestamp>,
    height: Option<Timestamp>,
}

impl PoseReports {
    /// Takes a report's time.
    pub(super) fn note(&mut self, telemetry: &Telemetry) {
        if let Report::CameraTilt(_) = telemetry.report {
            self.tilt = Some(telemetry.at);
        }
        if telemetry.report.height_m().is_some() {
            self.height = Some(telemetry.at);
        }
    }

    /// Forgets what is too old to be true. What a demo's world says has no age.
    pub(super) fn forget_old(&self, vehicle: &mut VehicleSnapshot, now: Timestamp) {
        let is_old = |at: Option<Timestamp>| at.is_some_and(|at| now.since(at) > POSE_LASTS);
        if is_old(self.tilt) {
            vehicle.tilt = None;
        }
        if is_old(self.height) {
            vehicle.altitude_m = None;
        }
    }
}
