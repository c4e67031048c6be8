//! Both ends of ONVIF.

use core::time::Duration;

use barrelman_vocab::speed_curve::{AxisSpeeds, SpeedCurve};
use barrelman_vocab::{AngularRate, Timestamp};
use barrelman_wire::Session as _;
use barrelman_wire::http::{HttpCall as _, Received, Request};
use barrelman_wire::onvif::discovery::found;
use barrelman_wire::onvif::{
    Ask, Call, CameraFaults, CameraSettings, Login, OnvifSession, OnvifSettings, PtzCamera, SpeedShares,
};

use crate::vehicle::{check_report, goes_on, rates_of};

/// Statuses of answers that the session tells apart.
const STATUSES: [u16; 6] = [200, 400, 401, 404, 500, 503];

/// Any answers and times to the client, and damaged messages to the camera. No velocity beyond the range is
/// sent, no motion after the end, and no path leads elsewhere; every reported number is finite.
pub fn onvif(bytes: &[u8]) {
    found(bytes);
    let mut rest = bytes.iter().copied();
    let mut now = Timestamp::from_secs_f64(1.0);
    let curve = SpeedCurve::linear(AngularRate::from_radians_per_second(1.0));
    let login = Login::new("admin".to_owned(), "password".to_owned());
    let settings = OnvifSettings {
        login: Some(login.clone()),
        speeds: Some(AxisSpeeds { pan: curve.clone(), tilt: curve }),
        profile: None,
    };
    let mut talk = Talk {
        session: OnvifSession::open(&settings, [7; 16], now),
        camera: PtzCamera::new(CameraSettings { login: Some(login), ..CameraSettings::example() }),
        waiting: Vec::new(),
        is_closing: false,
    };
    while let Some(byte) = rest.next() {
        let value = rest.next().unwrap_or(0);
        match byte % 8 {
            0 => now = now.plus(Duration::from_millis(u64::from(value) * 8)),
            1 => {
                let rates = rates_of(value, rest.next(), 2.0);
                talk.session.request(rates, Some(now.plus(Duration::from_millis(300))));
            }
            2 if value == 0 => {
                talk.session.close(now);
                talk.is_closing = true;
            }
            2 => talk.camera.set_faults(CameraFaults {
                ignores_timeouts: value & 1 != 0,
                ignores_stops: value & 2 != 0,
                ignores_zeros: value & 4 != 0,
                refuses_login: value & 8 != 0,
                clock_ahead_s: i64::from(value) << (value % 48),
            }),
            3 => talk.damage(value, rest.next().unwrap_or(0), now),
            4 => {
                let status = STATUSES[usize::from(value) % STATUSES.len()];
                let length = rest.next().unwrap_or(0);
                let body: Vec<u8> = rest.by_ref().take(usize::from(length)).collect();
                talk.answer(status, body, now);
            }
            5 => {
                if let Some(request) = talk.waiting.pop() {
                    talk.hear(&Received::NoAnswer { id: request.id }, now);
                }
            }
            _ => talk.answer_all(now),
        }
        if !talk.step(now) {
            return;
        }
    }
}

struct Talk {
    session: OnvifSession,
    camera: PtzCamera,
    /// Requests without an answer yet.
    waiting: Vec<Request<Call>>,
    is_closing: bool,
}

impl Talk {
    fn hear(&mut self, received: &Received, now: Timestamp) {
        self.session.received(received, now, &mut |telemetry| check_report(&telemetry.report));
    }

    fn answer(&mut self, status: u16, body: Vec<u8>, now: Timestamp) {
        if let Some(request) = self.waiting.pop() {
            self.hear(&Received::Answer { id: request.id, status, body }, now);
        }
    }

    /// A byte of the newest message, or of its answer, is another one.
    fn damage(&mut self, place: u8, byte: u8, now: Timestamp) {
        let Some(request) = self.waiting.last() else { return };
        let changed = |text: String, step: usize| {
            let mut bytes = text.into_bytes();
            let at = usize::from(place) * step % bytes.len().max(1);
            if let Some(found) = bytes.get_mut(at) {
                *found = byte;
            }
            bytes
        };
        let message = request.call.body().unwrap_or_default();
        self.camera.answer(&changed(message.clone(), 7), (0.1, -0.2), false, now);
        let answer = self.camera.answer(message.as_bytes(), (0.1, -0.2), false, now);
        self.answer(answer.status, changed(answer.body, 5), now);
    }

    /// The camera answers whatever waits.
    fn answer_all(&mut self, now: Timestamp) {
        for request in std::mem::take(&mut self.waiting) {
            let message = request.call.body().unwrap_or_default();
            let answer = self.camera.answer(message.as_bytes(), (0.1, -0.2), false, now);
            let (status, body) = (answer.status, answer.body.into_bytes());
            self.hear(&Received::Answer { id: request.id, status, body }, now);
        }
        let SpeedShares { pan, tilt, zoom } = self.camera.velocity(now);
        assert!([pan, tilt, zoom].iter().all(|share| share.abs() <= 1.0), "{pan} {tilt} {zoom}");
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
        assert!(path.starts_with('/') && path.bytes().all(|byte| byte.is_ascii_graphic()), "{path}");
        if let Ask::Move { velocity, timeout, .. } = &request.call.ask {
            let SpeedShares { pan, tilt, zoom } = velocity.shares();
            assert!([pan, tilt, zoom].iter().all(|share| share.abs() <= 1.0), "{velocity:?}");
            assert!(*timeout <= Duration::from_secs(2), "{timeout:?}");
        }
        assert!(!self.is_closing || !request.call.ask.is_motion(), "motion after the end");
    }
}
