//! The simulated ONVIF camera: its services behind the network, and its motors.

use barrelman_vocab::{Timestamp, VehicleRates};
use barrelman_wire::http::Received;
use barrelman_wire::onvif::{CameraFaults, CameraSettings, Login, PtzCamera, SpeedShares};

use super::fault::{self, Fault, FaultKind};
use super::http_network::{ReceivedRequest, write_received};
use super::line::Line;
use super::mutant::Mutant;
use super::station::{Station, TICK_S};
use crate::vehicle::onvif_speeds;

/// By how much the clock jumps, seconds.
const JUMP_S: i64 = 3_600;

/// The camera.
pub(super) struct OnvifStation {
    camera: PtzCamera,
    faults: Vec<Fault>,
    mutant: Mutant,
    /// Pan and tilt, radians.
    view: (f64, f64),
    rates: VehicleRates,
    jumped_s: i64,
}

/// The login that the camera asks for.
pub(super) fn login() -> Login {
    Login::new("admin".to_owned(), "password".to_owned())
}

impl OnvifStation {
    pub(super) fn new(faults: &[Fault], mutant: Mutant) -> Self {
        let settings = CameraSettings { login: Some(login()), ..CameraSettings::example() };
        Self {
            camera: PtzCamera::new(settings),
            faults: faults.to_vec(),
            mutant,
            view: (0.0, -0.4),
            rates: VehicleRates::REST,
            jumped_s: 0,
        }
    }

    fn is_active(&self, kind: FaultKind, at_ms: u64) -> bool {
        fault::active(&self.faults, kind, at_ms).is_some()
    }

    fn apply_faults(&mut self, at_ms: u64) {
        for fault in &self.faults {
            if fault.begins(FaultKind::StationReboots, at_ms) {
                self.camera.restart();
            }
            if fault.begins(FaultKind::ClockJumps, at_ms) {
                self.jumped_s += JUMP_S;
            }
        }
        self.camera.set_faults(CameraFaults {
            ignores_timeouts: self.mutant == Mutant::CommandsLast,
            ignores_stops: self.is_active(FaultKind::StopsIgnored, at_ms),
            refuses_login: self.is_active(FaultKind::TokenExpired, at_ms),
            clock_ahead_s: self.jumped_s,
            ..CameraFaults::default()
        });
    }
}

impl Station for OnvifStation {
    fn advance(&mut self, line: &mut Line, at_ms: u64, trace: &mut dyn FnMut(&str)) {
        let now = Timestamp::from_nanos(at_ms * 1_000_000);
        self.apply_faults(at_ms);
        // A server that hangs carries out later what it was asked meanwhile.
        while !self.is_active(FaultKind::ServerHangs, at_ms)
            && let Some(packet) = line.arrived_up(at_ms)
        {
            let Some(request) = ReceivedRequest::read(&packet) else { continue };
            let position = (self.view.0 / std::f64::consts::PI, self.view.1 / std::f64::consts::FRAC_PI_2);
            let (status, body) = if self.is_active(FaultKind::ServerNotReady, at_ms) {
                (503, String::new())
            } else {
                let answer = self.camera.answer(request.body.as_bytes(), position, false, now);
                (answer.status, answer.body)
            };
            let asked = request.body.split_once("Body>").map_or("", |(_, asked)| asked);
            trace(&format!("{at_ms} ms: {} {} {asked}: {status}", request.id, request.path));
            let answer = Received::Answer { id: request.id, status, body: body.into_bytes() };
            line.send_down(write_received(&answer), at_ms);
        }
        let SpeedShares { pan, tilt, zoom } = self.camera.velocity(now);
        let speeds = onvif_speeds();
        self.rates = VehicleRates::turning(speeds.pan.rate_at(pan), speeds.tilt.rate_at(tilt)).zooming(zoom);
        self.view.0 += self.rates.yaw.radians_per_second() * TICK_S;
        self.view.1 += self.rates.pitch.radians_per_second() * TICK_S;
    }

    fn rates(&self) -> VehicleRates {
        self.rates
    }

    fn pan_rad(&self) -> f64 {
        self.view.0
    }
}
