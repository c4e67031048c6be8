//! The simulated autopilot with a MAVLink gimbal.
//!
//! In half of the runs the autopilot is the worst kind: it obeys everybody and keeps a rate for ever. In the
//! other half it obeys the primary control alone. Another commander who takes the control inherits the rates
//! in force, and sends nothing.

use barrelman_vocab::{Angle, Timestamp, VehicleRates};
use barrelman_wire::mavlink::GimbalManager;
use barrelman_wire::mavlink::gimbal_manager::{GimbalAngles, GimbalManagerSettings, Habits, OTHER_COMMANDER};

use super::fault::{self, Fault, FaultKind};
use super::line::Line;
use super::station::{Station, TICK_S};

/// Claims that get lost while claims get lost.
const DROPPED_CLAIMS: u32 = u32::MAX;

/// The autopilot.
pub(super) struct GimbalStation {
    manager: GimbalManager,
    settings: GimbalManagerSettings,
    faults: Vec<Fault>,
    /// Of the gimbal: to the right and upwards.
    yaw_rad: f64,
    pitch_rad: f64,
    is_meddled_with: bool,
}

impl GimbalStation {
    pub(super) fn new(faults: &[Fault], obeys_everybody: bool) -> Self {
        let habits = if obeys_everybody { Habits::ArduPilot } else { Habits::Px4 };
        let settings = GimbalManagerSettings { habits, ..GimbalManagerSettings::default() };
        Self {
            manager: GimbalManager::boot(settings, Timestamp::ZERO),
            settings,
            faults: faults.to_vec(),
            yaw_rad: 0.0,
            pitch_rad: -0.4,
            is_meddled_with: false,
        }
    }

    /// The settings with the faults of this moment.
    fn settings_at(&self, at_ms: u64) -> GimbalManagerSettings {
        let is_active = |kind| fault::active(&self.faults, kind, at_ms).is_some();
        GimbalManagerSettings {
            withholds_information: is_active(FaultKind::InformationWithheld),
            withholds_status: is_active(FaultKind::StatusWithheld),
            denies_claims: is_active(FaultKind::ClaimsDenied),
            dropped_claims: if is_active(FaultKind::ClaimsLost) { DROPPED_CLAIMS } else { 0 },
            ..self.settings
        }
    }
}

impl Station for GimbalStation {
    fn advance(&mut self, line: &mut Line, at_ms: u64, trace: &mut dyn FnMut(&str)) {
        let now = Timestamp::from_nanos(at_ms * 1_000_000);
        let mut out = Vec::new();
        for fault in self.faults.iter().filter(|fault| fault.from_ms == at_ms) {
            match fault.kind {
                FaultKind::StationReboots => self.manager = GimbalManager::boot(self.settings, now),
                FaultKind::ControlTaken => self.manager.take_over(now, &mut out),
                _ => {}
            }
        }
        let settings = self.settings_at(at_ms);
        self.manager.set_settings(settings);
        self.is_meddled_with = false;
        while let Some(packet) = line.arrived_up(at_ms) {
            let is_theirs = self.is_anothers();
            let is_meddled_with = &mut self.is_meddled_with;
            self.manager.receive(&packet, now, &mut out, |text, _| {
                *is_meddled_with |= is_theirs && text.starts_with("SET_PITCHYAW");
                trace(&format!("{at_ms} ms: {text}"));
            });
        }
        let angles = GimbalAngles {
            yaw: Angle::from_radians(self.yaw_rad),
            pitch: Angle::from_radians(self.pitch_rad),
        };
        self.manager.write_telemetry(angles, now, &mut out);
        for packet in out {
            line.send_down(packet, at_ms);
        }
        let rates = self.rates();
        self.yaw_rad += rates.yaw.radians_per_second() * TICK_S;
        self.pitch_rad += rates.pitch.radians_per_second() * TICK_S;
    }

    fn rates(&self) -> VehicleRates {
        self.manager.rates()
    }

    fn pan_rad(&self) -> f64 {
        self.yaw_rad
    }

    fn is_anothers(&self) -> bool {
        self.manager.primary() == Some(OTHER_COMMANDER)
    }

    fn is_meddled_with(&self) -> bool {
        self.is_meddled_with
    }
}
