//! The simulated Fotokite Sigma: its service behind the network, and its camera.

use barrelman_vocab::{Timestamp, VehicleRates};
use barrelman_wire::fotokite_sigma::Sigma;
use barrelman_wire::fotokite_sigma::sigma::{Incoming, SigmaSettings, View};
use barrelman_wire::http::Received;

use super::fault::{self, Fault, FaultKind};
use super::http_network::{ReceivedRequest, write_received};
use super::line::Line;
use super::mutant::Mutant;
use super::station::{Station, TICK_S};

const TURN: &str = "/v1/camera/control/rotate_with_speed";
const SUBSCRIBE: &str = "/v1/camera/state/subscribe";
/// Interval between messages of the WebSocket, ms.
const MESSAGE_MS: u64 = 100;
/// A command may be under way while the answer is that tells that another client has the control, ms.
const UNDER_WAY_MS: u64 = 20;
/// The duration of each command of a vehicle that does not end commands as it is told, s.
const MUTANT_DURATION_S: f64 = 10.0;

/// The vehicle.
pub(super) struct FotokiteSigmaStation {
    sigma: Sigma,
    faults: Vec<Fault>,
    mutant: Mutant,
    view: View,
    rates: VehicleRates,
    has_socket: bool,
    is_another_clients: bool,
    /// When an answer has told that another client has the control, ms.
    told_at_ms: Option<u64>,
    is_meddled_with: bool,
}

impl FotokiteSigmaStation {
    pub(super) fn new(faults: &[Fault], mutant: Mutant) -> Self {
        Self {
            sigma: Sigma::new(SigmaSettings::example()),
            faults: faults.to_vec(),
            mutant,
            view: View { pan_ned: 0.0, tilt_ned: 25.0 },
            rates: VehicleRates::REST,
            has_socket: false,
            is_another_clients: false,
            told_at_ms: None,
            is_meddled_with: false,
        }
    }

    fn is_active(&self, kind: FaultKind, at_ms: u64) -> bool {
        fault::active(&self.faults, kind, at_ms).is_some()
    }

    fn apply_faults(&mut self, line: &mut Line, now: Timestamp, at_ms: u64) {
        for fault in self.faults.clone() {
            match fault.kind {
                FaultKind::ControlTaken if fault.from_ms == at_ms => {
                    self.sigma.other_client_takes();
                    (self.is_another_clients, self.told_at_ms) = (true, None);
                }
                FaultKind::ControlTaken if fault.until_ms == at_ms => {
                    self.sigma.other_client_releases(now);
                    self.is_another_clients = false;
                }
                FaultKind::StationReboots if fault.from_ms == at_ms => {
                    self.sigma.restart();
                    self.is_another_clients = false;
                    self.end_socket(line, at_ms);
                }
                FaultKind::WebSocketMissing if fault.from_ms == at_ms => self.end_socket(line, at_ms),
                _ => {}
            }
        }
        self.sigma.set_ready(!self.is_active(FaultKind::ServerNotReady, at_ms));
        self.sigma.set_expired(self.is_active(FaultKind::TokenExpired, at_ms));
        let lands = self.is_active(FaultKind::Emergency, at_ms);
        self.sigma.set_flight_state(if lands { "Landing" } else { "Flying" });
    }

    fn end_socket(&mut self, line: &mut Line, at_ms: u64) {
        if std::mem::take(&mut self.has_socket) {
            line.send_down(write_received(&Received::SocketEnded), at_ms);
        }
    }

    fn answer(&mut self, request: &ReceivedRequest, line: &Line, now: Timestamp, at_ms: u64) -> Received {
        if request.path == SUBSCRIBE {
            let is_missing = self.is_active(FaultKind::WebSocketMissing, at_ms);
            self.has_socket = !is_missing;
            let status = if is_missing { 404 } else { 101 };
            return Received::Answer { id: request.id, status, body: Vec::new() };
        }
        let is_told = self.told_at_ms.is_some_and(|told| at_ms > told + UNDER_WAY_MS);
        self.is_meddled_with |= self.is_another_clients && is_told && request.path == TURN;
        let mut body = request.body.clone();
        if self.mutant == Mutant::CommandsLast
            && let Ok(mut command) = serde_json::from_str::<serde_json::Value>(&body)
            && let Some(duration) = command.get_mut("duration")
        {
            *duration = MUTANT_DURATION_S.into();
            body = command.to_string();
        }
        let asked = Incoming {
            method: &request.method,
            path: &request.path,
            token: Some("token"),
            body: body.as_bytes(),
        };
        let answer = self.sigma.answer(asked, self.view, now);
        let tells = answer.status == 403 || (answer.status == 202 && request.path != TURN);
        if self.is_another_clients && tells && !line.is_disturbed(at_ms) {
            self.told_at_ms.get_or_insert(at_ms);
        }
        Received::Answer { id: request.id, status: answer.status, body: answer.body.into_bytes() }
    }
}

impl Station for FotokiteSigmaStation {
    fn advance(&mut self, line: &mut Line, at_ms: u64, trace: &mut dyn FnMut(&str)) {
        let now = Timestamp::from_nanos(at_ms * 1_000_000);
        self.is_meddled_with = false;
        self.apply_faults(line, now, at_ms);
        // A server that hangs carries out later what it was asked meanwhile.
        while !self.is_active(FaultKind::ServerHangs, at_ms)
            && let Some(packet) = line.arrived_up(at_ms)
        {
            let Some(request) = ReceivedRequest::read(&packet) else { continue };
            let answer = self.answer(&request, line, now, at_ms);
            if let Received::Answer { id, status, .. } = &answer {
                trace(&format!(
                    "{at_ms} ms: {id} {} {} {}: {status}",
                    request.method, request.path, request.body
                ));
            }
            line.send_down(write_received(&answer), at_ms);
        }
        if self.has_socket && at_ms.is_multiple_of(MESSAGE_MS) {
            let message = Sigma::camera_state(self.view).to_string().into_bytes();
            line.send_down(write_received(&Received::Message(message)), at_ms);
        }
        self.rates = self.sigma.rates(now);
        self.view.pan_ned += self.rates.yaw.radians_per_second().to_degrees() * TICK_S;
        self.view.tilt_ned += self.rates.pitch.radians_per_second().to_degrees() * TICK_S;
    }

    fn rates(&self) -> VehicleRates {
        self.rates
    }

    fn pan_rad(&self) -> f64 {
        self.view.pan_ned.to_radians()
    }

    fn is_anothers(&self) -> bool {
        self.is_another_clients
    }

    fn is_meddled_with(&self) -> bool {
        self.is_meddled_with
    }
}
