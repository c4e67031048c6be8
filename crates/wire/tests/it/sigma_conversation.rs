//! A session and a Sigma in virtual time, with an answer time for each lane.

use std::time::Duration;

use barrelman_vocab::acceptance::Acceptance;
use barrelman_vocab::telemetry::Report;
use barrelman_vocab::{AngularRate, Timestamp, VehicleRates, ZoomRate};
use barrelman_wire::fotokite_sigma::sigma::{SigmaSettings, View};
use barrelman_wire::fotokite_sigma::{Call, FotokiteSigmaSession, Sigma};
use barrelman_wire::http::{Lane, Received, Request};
use barrelman_wire::{NextAction, Session as _};

use crate::talk::Talk;

pub(crate) const MS: Duration = Duration::from_millis(1);

pub(crate) fn at(ms: u64) -> Timestamp {
    Timestamp::from_nanos(ms * 1_000_000)
}

/// Rates of a vehicle, degrees per second.
pub(crate) fn rates(yaw: f64, pitch: f64) -> VehicleRates {
    let rate = |deg: f64| AngularRate::from_radians_per_second(deg.to_radians());
    VehicleRates::turning(rate(yaw), rate(pitch))
}

/// A session and a Sigma.
pub(crate) struct Conversation {
    pub(crate) session: FotokiteSigmaSession,
    pub(crate) sigma: Sigma,
    pub(crate) now: Timestamp,
    pub(crate) token: &'static str,
    /// The time of a request on its way, and of its answer on the way back.
    pub(crate) delay: Duration,
    /// Lanes whose requests reach the vehicle, or not (`Some(false)`), and are never answered.
    pub(crate) hung: Vec<(Lane, bool)>,
    pub(crate) has_socket: bool,
    under_way: Vec<(Timestamp, Request<Call>, bool)>,
    answers: Vec<(Timestamp, Received)>,
    view: View,
    /// Every request, with its time.
    pub(crate) sent: Vec<(Timestamp, Request<Call>)>,
    /// Every answer's status.
    pub(crate) statuses: Vec<(Call, u16)>,
    pub(crate) reports: Vec<Report>,
    pub(crate) last: NextAction,
}

impl Talk for Conversation {
    fn step(&mut self) {
        self.now = self.now.plus(MS);
        let turning = self.turning();
        self.view.pan_ned += turning.yaw.radians_per_second().to_degrees() * 1e-3;
        self.view.tilt_ned += turning.pitch.radians_per_second().to_degrees() * 1e-3;
        self.arrive();
        if self.has_socket && self.now.as_nanos().is_multiple_of(100_000_000) {
            let state = Sigma::camera_state(self.view).to_string();
            self.answers.push((self.now, Received::Message(state.into_bytes())));
        }
        let due: Vec<_> = self.answers.extract_if(.., |(when, _)| *when <= self.now).collect();
        for (_, received) in due {
            let reports = &mut self.reports;
            self.session.received(&received, self.now, &mut |telemetry| reports.push(telemetry.report));
        }
        let mut out = Vec::new();
        self.last = self.session.poll(self.now, &mut out);
        for request in out {
            let is_free = self.under_way.iter().all(|(.., pending, _)| pending.lane != request.lane)
                || self.hung.iter().any(|(lane, _)| *lane == request.lane);
            assert!(is_free, "two requests under way on {:?}", request.lane);
            self.sent.push((self.now, request.clone()));
            let fate = self.hung.iter().find(|(lane, _)| *lane == request.lane).map(|(_, arrives)| *arrives);
            match fate {
                Some(false) => {}
                Some(true) => self.under_way.push((self.now.plus(self.delay), request, false)),
                None => self.under_way.push((self.now.plus(self.delay), request, true)),
            }
        }
    }

    fn reports(&self) -> &[Report] {
        &self.reports
    }
}

impl Conversation {
    pub(crate) fn new() -> Self {
        Self {
            session: FotokiteSigmaSession::open(None, ZoomRate::from_per_second(0.3), at(0)),
            sigma: Sigma::new(SigmaSettings::example()),
            now: at(0),
            token: "token",
            delay: 4 * MS,
            hung: Vec::new(),
            has_socket: true,
            under_way: Vec::new(),
            answers: Vec::new(),
            view: View { pan_ned: 170.0, tilt_ned: 24.0 },
            sent: Vec::new(),
            statuses: Vec::new(),
            reports: Vec::new(),
            last: NextAction::WaitUntil(at(0)),
        }
    }

    /// A conversation whose session is up and has the control.
    pub(crate) fn up() -> Self {
        let mut talk = Self::new();
        talk.run_for(1_500);
        assert_eq!(talk.acceptance(), Some(Acceptance::Accepted));
        talk
    }

    pub(crate) fn turning(&self) -> VehicleRates {
        self.sigma.rates(self.now)
    }

    fn arrive(&mut self) {
        let due: Vec<_> = self.under_way.extract_if(.., |(when, ..)| *when <= self.now).collect();
        for (_, request, is_answered) in due {
            let answer = self.ask(&request);
            self.statuses.push((request.call, answer.0));
            if is_answered {
                let (status, body) = answer;
                self.answers.push((self.now, Received::Answer { id: request.id, status, body }));
            }
        }
    }

    fn ask(&mut self, request: &Request<Call>) -> (u16, Vec<u8>) {
        if request.call == Call::Subscribe {
            return (if self.has_socket { 101 } else { 404 }, Vec::new());
        }
        let answer = self.sigma.answer_call(&request.call, self.token, self.view, self.now);
        (answer.status, answer.body.into_bytes())
    }

    /// Calls that only the one in control may make, from a time on.
    pub(crate) fn commands_since(&self, since: Timestamp) -> usize {
        let is_command = |(when, request): &&(Timestamp, Request<Call>)| {
            *when > since && matches!(request.call, Call::Turn { .. })
        };
        self.sent.iter().filter(is_command).count()
    }
}
