//! A session and a PTZ camera in virtual time.

use std::time::Duration;

use barrelman_vocab::acceptance::Acceptance;
use barrelman_vocab::speed_curve::{AxisSpeeds, SpeedCurve};
use barrelman_vocab::telemetry::Report;
use barrelman_vocab::{AngularRate, Timestamp, VehicleRates};
use barrelman_wire::http::{HttpCall as _, Lane, Received, Request};
use barrelman_wire::onvif::{Ask, Call, CameraSettings, OnvifSession, OnvifSettings, PtzCamera, SpeedShares};
use barrelman_wire::{NextAction, Session as _};

use crate::sigma_conversation::{MS, at};
use crate::talk::Talk;

/// Both axes turn at 1 rad/s at the speed 1.
pub(crate) fn speeds() -> AxisSpeeds {
    let curve = SpeedCurve::linear(AngularRate::from_radians_per_second(1.0));
    AxisSpeeds { pan: curve.clone(), tilt: curve }
}

pub(crate) fn rates(yaw: f64, pitch: f64) -> VehicleRates {
    let rate = AngularRate::from_radians_per_second;
    VehicleRates::turning(rate(yaw), rate(pitch))
}

/// A session and a camera.
pub(crate) struct OnvifConversation {
    settings: OnvifSettings,
    sessions: u8,
    pub(crate) session: OnvifSession,
    pub(crate) camera: PtzCamera,
    pub(crate) now: Timestamp,
    /// The time of a request on its way, and of its answer on the way back.
    pub(crate) delay: Duration,
    /// Whether nothing arrives.
    pub(crate) is_cut: bool,
    under_way: Vec<(Timestamp, Request<Call>)>,
    answers: Vec<(Timestamp, Received)>,
    position: (f64, f64),
    /// Every request, with its time.
    pub(crate) sent: Vec<(Timestamp, Ask)>,
    pub(crate) reports: Vec<Report>,
    pub(crate) last: NextAction,
}

impl Talk for OnvifConversation {
    fn step(&mut self) {
        self.now = self.now.plus(MS);
        let SpeedShares { pan, tilt, .. } = self.camera.velocity(self.now);
        // At 1 rad/s, half a turn takes pi seconds.
        self.position.0 += pan * 1e-3 / std::f64::consts::PI;
        self.position.1 += tilt * 1e-3 / std::f64::consts::FRAC_PI_2;
        let due: Vec<_> = self.under_way.extract_if(.., |(when, _)| *when <= self.now).collect();
        for (_, Request { id, call, .. }) in due {
            let message = call.body().unwrap();
            let answer = self.camera.answer(message.as_bytes(), self.position, false, self.now);
            let received = Received::Answer { id, status: answer.status, body: answer.body.into_bytes() };
            self.answers.push((self.now.plus(self.delay), received));
        }
        let due: Vec<_> = self.answers.extract_if(.., |(when, _)| *when <= self.now).collect();
        for (_, received) in due {
            self.receive(&received);
        }
        let mut out = Vec::new();
        self.last = self.session.poll(self.now, &mut out);
        if matches!(self.last, NextAction::Reopen { .. }) {
            self.sessions += 1;
            self.session = OnvifSession::open(&self.settings, [self.sessions; 16], self.now);
        }
        for request in out {
            let is_free = self.under_way.iter().all(|(_, pending)| pending.lane != request.lane);
            assert!(is_free, "two requests under way on {:?}", request.lane);
            self.sent.push((self.now, request.call.ask.clone()));
            if !self.is_cut {
                self.under_way.push((self.now.plus(self.delay), request));
            }
        }
    }

    fn reports(&self) -> &[Report] {
        &self.reports
    }
}

impl OnvifConversation {
    pub(crate) fn new(camera: CameraSettings, settings: OnvifSettings) -> Self {
        Self {
            session: OnvifSession::open(&settings, [1; 16], at(0)),
            settings,
            sessions: 1,
            camera: PtzCamera::new(camera),
            now: at(0),
            delay: 4 * MS,
            is_cut: false,
            under_way: Vec::new(),
            answers: Vec::new(),
            position: (0.2, -0.3),
            sent: Vec::new(),
            reports: Vec::new(),
            last: NextAction::WaitUntil(at(0)),
        }
    }

    /// A conversation with a camera of measured speeds, which is up.
    pub(crate) fn up(camera: CameraSettings) -> Self {
        let login = camera.login.clone();
        let mut talk = Self::new(camera, OnvifSettings { login, speeds: Some(speeds()), profile: None });
        talk.run_for(1_500);
        assert_eq!(talk.acceptance(), Some(Acceptance::Accepted));
        talk
    }

    pub(crate) fn is_turning(&self) -> bool {
        self.camera.velocity(self.now) != SpeedShares::default()
    }

    pub(crate) fn receive(&mut self, received: &Received) {
        let reports = &mut self.reports;
        self.session.received(received, self.now, &mut |telemetry| reports.push(telemetry.report));
    }

    /// The commands that were sent after a time.
    pub(crate) fn commands_since(&self, since: Timestamp) -> Vec<&Ask> {
        let is_command = |ask: &Ask| matches!(ask, Ask::Move { .. } | Ask::Stop { .. });
        self.sent.iter().filter(|(when, ask)| *when > since && is_command(ask)).map(|(_, ask)| ask).collect()
    }
}

#[test]
fn a_lane_is_that_of_its_question() {
    let mut talk = OnvifConversation::up(CameraSettings::example());
    talk.session.request(rates(0.2, 0.0), None);
    talk.run_for(500);
    for (_, ask) in &talk.sent {
        assert!(Call::LANES.contains(&ask.lane()), "{ask:?}");
        assert!(ask.lane() != Lane::Turn || matches!(ask, Ask::Move { .. }), "{ask:?}");
    }
}
