//! Both ends of the Fotokite Sigma's web API.

use core::time::Duration;

use barrelman_vocab::{Timestamp, ZoomRate};
use barrelman_wire::Session as _;
use barrelman_wire::fotokite_sigma::call::{STOP_DURATION, TURN_DURATION};
use barrelman_wire::fotokite_sigma::sigma::{SigmaSettings, View};
use barrelman_wire::fotokite_sigma::{Call, FotokiteSigmaSession, Sigma};
use barrelman_wire::http::motion::Speeds as _;
use barrelman_wire::http::{HttpCall as _, Received, Request};

use crate::vehicle::{check_report, goes_on, rates_of};

/// Statuses of answers that the session tells apart.
const STATUSES: [u16; 10] = [200, 201, 202, 204, 400, 401, 403, 409, 500, 503];
/// Nothing real turns faster, degrees per second.
const MAX_SPEED: f64 = 360.0;
/// The camera of the emulated vehicle turns at most this fast, rad/s.
const VEHICLE_MAX: f64 = 0.437;

/// Any answers, messages and times to the client, and what the client and others ask of the vehicle. No speed
/// beyond what was requested is sent, no motion after the end, and no path leads elsewhere; every reported
/// number is finite.
pub fn sigma(bytes: &[u8]) {
    let mut rest = bytes.iter().copied();
    let mut now = Timestamp::from_secs_f64(1.0);
    let mut talk = Talk {
        session: FotokiteSigmaSession::open(None, ZoomRate::from_per_second(0.3), now),
        vehicle: Sigma::new(SigmaSettings::example()),
        waiting: Vec::new(),
        is_closing: false,
    };
    while let Some(byte) = rest.next() {
        let value = rest.next().unwrap_or(0);
        match byte % 8 {
            0 => now = now.plus(Duration::from_millis(u64::from(value) * 8)),
            1 => {
                let rates = rates_of(value, rest.next(), 200.0);
                talk.session.request(rates, Some(now.plus(Duration::from_millis(300))));
            }
            2 if value == 0 => {
                talk.session.close(now);
                talk.is_closing = true;
            }
            2 => talk.session.take_control(now),
            3 => talk.disturb(value, now),
            4 => talk.hear(Received::Message(taken(&mut rest, value)), now),
            5 => {
                let status = STATUSES[usize::from(value) % STATUSES.len()];
                let length = rest.next().unwrap_or(0);
                let body = taken(&mut rest, length);
                if let Some(request) = talk.waiting.pop() {
                    talk.hear(Received::Answer { id: request.id, status, body }, now);
                }
            }
            6 if value < 16 => talk.hear(Received::SocketEnded, now),
            6 => {
                if let Some(request) = talk.waiting.pop() {
                    talk.hear(Received::NoAnswer { id: request.id }, now);
                }
            }
            _ => talk.answer_all(now),
        }
        if !talk.step(now) {
            return;
        }
    }
}

fn taken(rest: &mut impl Iterator<Item = u8>, length: u8) -> Vec<u8> {
    rest.take(usize::from(length)).collect()
}

struct Talk {
    session: FotokiteSigmaSession,
    vehicle: Sigma,
    /// Requests without an answer yet.
    waiting: Vec<Request<Call>>,
    is_closing: bool,
}

impl Talk {
    fn hear(&mut self, received: Received, now: Timestamp) {
        self.session.received(&received, now, &mut |telemetry| check_report(&telemetry.report));
    }

    /// What others do to the vehicle.
    fn disturb(&mut self, value: u8, now: Timestamp) {
        match value % 8 {
            0 => self.vehicle.other_client_takes(),
            1 => self.vehicle.other_client_releases(now),
            2 => self.vehicle.restart(),
            3 => self.vehicle.set_ready(value & 8 == 0),
            4 => self.vehicle.set_expired(value & 8 == 0),
            5 => self.vehicle.set_flight_state("Landing"),
            6 => self.vehicle.set_flight_state("Flying"),
            _ => {
                let state = Sigma::camera_state(View { pan_ned: f64::from(value), tilt_ned: 20.0 });
                self.hear(Received::Message(state.to_string().into_bytes()), now);
            }
        }
    }

    /// The vehicle answers whatever waits.
    fn answer_all(&mut self, now: Timestamp) {
        for request in std::mem::take(&mut self.waiting) {
            let answer = self.vehicle.answer_call(&request.call, "token", View::default(), now);
            let body = answer.body.into_bytes();
            self.hear(Received::Answer { id: request.id, status: answer.status, body }, now);
        }
        let rates = self.vehicle.rates(now);
        for rate in [rates.yaw, rates.pitch] {
            assert!(rate.radians_per_second().abs() <= VEHICLE_MAX, "{rates:?}");
        }
    }

    /// Returns whether the conversation goes on.
    fn step(&mut self, now: Timestamp) -> bool {
        let mut sent = Vec::new();
        let next = self.session.poll(now, &mut sent);
        for request in &sent {
            self.check(request);
        }
        self.waiting.append(&mut sent);
        goes_on(next, self.is_closing)
    }

    fn check(&self, request: &Request<Call>) {
        let path = request.call.path();
        assert!(
            path.starts_with("/v1/") && !path.contains("..") && !path.contains("flight/control"),
            "{path}"
        );
        if let Call::Turn { speeds, duration } = &request.call {
            assert!((STOP_DURATION..=TURN_DURATION).contains(duration), "{duration:?}");
            for speed in [speeds.pan_deg_per_s(), speeds.tilt_deg_per_s()] {
                assert!(speed.abs() <= MAX_SPEED, "{speeds:?}");
            }
            assert!(!self.is_closing || speeds.is_rest(), "{speeds:?} after the end");
        }
    }
}
