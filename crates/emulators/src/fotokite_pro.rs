//! The emulated Fotokite Pro: its ground station.

use barrelman_vocab::{Timestamp, VehicleProfile, VehicleRates};
use barrelman_wire::fotokite_pro::GroundStation;
pub use barrelman_wire::fotokite_pro::ground_station::GroundStationSettings;
use barrelman_wire::fotokite_pro::ground_station::{SensorReadings, StationState};

use super::emulated_vehicle::EmulatedVehicle;
use super::log::VehicleState;
use crate::camera_link::Pointing;

/// An emulated Fotokite Pro.
#[derive(Debug)]
pub struct FotokitePro {
    station: GroundStation,
    settings: GroundStationSettings,
    profile: VehicleProfile,
}

impl FotokitePro {
    /// A ground station that has just been switched on.
    pub fn new(settings: GroundStationSettings, now: Timestamp) -> Self {
        let station = GroundStation::boot(settings, now);
        Self { station, settings, profile: VehicleProfile::fotokite_pro() }
    }
}

impl EmulatedVehicle for FotokitePro {
    const NAME: &'static str = "Fotokite Pro";

    fn profile(&self) -> &VehicleProfile {
        &self.profile
    }

    fn reboot(&mut self, now: Timestamp) {
        self.station = GroundStation::boot(self.settings, now);
    }

    fn take_over(&mut self, _now: Timestamp, _out: &mut Vec<Vec<u8>>) {
        self.station.take_over();
    }

    /// Passes bytes to the station one by one, so that every line is logged with the state after it.
    fn receive(
        &mut self,
        bytes: &[u8],
        now: Timestamp,
        out: &mut Vec<Vec<u8>>,
        on_message: &mut dyn FnMut(String, VehicleState),
    ) {
        let mut answer = Vec::new();
        for byte in bytes {
            let mut line = None;
            self.station.receive(&[*byte], now, &mut answer, |received| line = Some(received.to_owned()));
            if let Some(line) = line {
                on_message(line, self.state());
            }
        }
        out.push(answer);
    }

    fn advance(&mut self, pointing: Pointing, now: Timestamp, out: &mut Vec<Vec<u8>>) {
        self.station.tick(now);
        let mut lines = Vec::new();
        let Pointing { pan, tilt, height_m, .. } = pointing;
        let readings = SensorReadings { altitude_m: height_m, ..SensorReadings::of_camera(pan, tilt) };
        self.station.write_telemetry(&readings, now, &mut lines);
        out.push(lines);
    }

    fn state(&self) -> VehicleState {
        let rates = self.station.rates();
        VehicleState {
            name: match self.station.state() {
                StationState::Shell => "shell",
                StationState::RemoteControlled => "remote-controlled",
            },
            rates: VehicleRates::turning(rates.yaw, rates.pitch),
            roll: rates.roll,
            lost_lines: self.station.dropped_lines(),
        }
    }

    fn texts(&self, packet: &[u8]) -> Vec<String> {
        let text = String::from_utf8_lossy(packet);
        text.split("\r\n").filter(|line| !line.is_empty()).map(str::to_owned).collect()
    }
}
