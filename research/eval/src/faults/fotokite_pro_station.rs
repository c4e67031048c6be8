//! The simulated ground station of a Fotokite Pro, with its camera.

use barrelman_vocab::{Angle, Timestamp, VehicleRates};
use barrelman_wire::fotokite_pro::GroundStation;
use barrelman_wire::fotokite_pro::ground_station::{GroundStationSettings, SensorReadings};

use super::fault::{self, Fault, FaultKind};
use super::line::Line;
use super::station::{Station, TICK_S};

/// `!FlightStatus` of a vehicle that lands by itself, and the warning bit of a low battery.
const EMERGENCY_MODE: u32 = 48;
const BATTERY_LOW: u32 = 1 << 6;

/// The ground station.
pub(super) struct FotokiteProStation {
    station: GroundStation,
    settings: GroundStationSettings,
    faults: Vec<Fault>,
    /// To the left.
    yaw_rad: f64,
    pitch_rad: f64,
}

impl FotokiteProStation {
    pub(super) fn new(faults: &[Fault], stop_keeps_rates: bool) -> Self {
        let settings = GroundStationSettings { stop_keeps_rates, ..GroundStationSettings::default() };
        Self {
            station: GroundStation::boot(settings, Timestamp::ZERO),
            settings,
            faults: faults.to_vec(),
            yaw_rad: 0.0,
            pitch_rad: 0.0,
        }
    }

    fn readings(&self, at_ms: u64) -> SensorReadings {
        let is_active = |kind| fault::active(&self.faults, kind, at_ms).is_some();
        SensorReadings {
            flight_mode: if is_active(FaultKind::Emergency) { EMERGENCY_MODE } else { 2 },
            flags: if is_active(FaultKind::BatteryLow) { BATTERY_LOW } else { 0 },
            ..SensorReadings::of_camera(
                Angle::from_radians(-self.yaw_rad),
                Angle::from_radians(-self.pitch_rad),
            )
        }
    }
}

impl Station for FotokiteProStation {
    fn rates(&self) -> VehicleRates {
        let rates = self.station.rates();
        VehicleRates::turning(rates.yaw, rates.pitch)
    }

    /// The vehicle's yaw is positive to the left.
    fn pan_rad(&self) -> f64 {
        -self.yaw_rad
    }

    fn advance(&mut self, line: &mut Line, at_ms: u64, trace: &mut dyn FnMut(&str)) {
        let now = Timestamp::from_nanos(at_ms * 1_000_000);
        for fault in &self.faults {
            match fault.kind {
                FaultKind::StationReboots if fault.from_ms == at_ms => {
                    self.station = GroundStation::boot(self.settings, now);
                }
                FaultKind::ControlTaken if fault.from_ms == at_ms => self.station.take_over(),
                _ => {}
            }
        }
        let mut answer = Vec::new();
        while let Some(packet) = line.arrived_up(at_ms) {
            self.station.receive(&packet, now, &mut answer, |line| trace(&format!("{at_ms} ms: {line}")));
        }
        self.station.tick(now);
        let readings = self.readings(at_ms);
        self.station.write_telemetry(&readings, now, &mut answer);
        line.send_down(answer, at_ms);
        let rates = self.rates();
        self.yaw_rad += rates.yaw.radians_per_second() * TICK_S;
        self.pitch_rad += rates.pitch.radians_per_second() * TICK_S;
    }
}
