//! The newest state of the vehicle and its link, from telemetry.

use barrelman_vocab::telemetry::{ControlState, FlightState, LinkState, Report};
use barrelman_vocab::{Angle, Telemetry};

/// Where commands go.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum LinkStatus {
    /// Nowhere: a dry run.
    #[default]
    DryRun,
    /// To the camera of a demo's world, which cannot be lost.
    Simulated,
    /// To a link in this state.
    Link(LinkState),
}

/// The newest state of the vehicle and its link.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct VehicleSnapshot {
    /// The link.
    pub link: LinkStatus,
    /// Whether the vehicle accepts commands from this program.
    pub control: Option<ControlState>,
    /// Battery voltage, volts.
    pub battery_v: Option<f64>,
    /// Whether the vehicle says that one of its batteries is low.
    pub is_battery_low: bool,
    /// Elevation of the camera's axis.
    pub tilt: Option<Angle>,
    /// Altitude, metres.
    pub altitude_m: Option<f64>,
    /// Flight state.
    pub flight: Option<FlightState>,
}

impl VehicleSnapshot {
    /// Takes a report.
    pub(super) fn on_telemetry(&mut self, telemetry: &Telemetry) {
        match telemetry.report {
            Report::Link(state) => {
                self.link = LinkStatus::Link(state);
                if state != LinkState::Up {
                    *self = Self { link: self.link, ..Self::default() };
                }
            }
            Report::Ground { control, battery_v, .. } => {
                (self.control, self.battery_v) = (Some(control), Some(battery_v));
            }
            Report::CameraTilt(tilt) => self.tilt = Some(tilt),
            Report::Tether { altitude_m, .. } => self.altitude_m = Some(altitude_m),
            Report::Flight { state, is_battery_low, .. } => {
                (self.flight, self.is_battery_low) = (Some(state), is_battery_low);
            }
            Report::VehicleAttitude(_) | Report::GimbalAttitude(_) | Report::FieldOfView(_) => {}
        }
    }
}
