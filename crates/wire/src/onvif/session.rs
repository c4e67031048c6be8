//! The client's end: services, motion, states, shut-down.
//!
//! ```text
//!             all questions answered
//!   Joining --------------------------> Up -- nothing heard for 3 s --> Silent (a new session)
//!     |                                  |
//!     +----- refused, unusable ----------+--> Refused -- 5 s --> (a new session, the camera's time anew)
//!
//!   any state -- close() --> Closing (zeros) --> Closed
//! ```
//!
//! Each motion ends by itself after [`super::ask::MOVE_TIMEOUT`] ([`crate::http::motion`] renews it before):
//! no guard is needed for a camera that keeps to that. A zero is a Stop and a ContinuousMove of 0 in turn, as
//! cameras are known that ignore one of them. Other clients may move the camera at any time: ONVIF has no
//! control that one of them holds.

use core::time::Duration;

use barrelman_vocab::acceptance::Acceptance;
use barrelman_vocab::speed_curve::AxisSpeeds;
use barrelman_vocab::telemetry::LinkState;
use barrelman_vocab::{Telemetry, Timestamp, VehicleRates};

use super::ask::Ask;
use super::call::{Call, Caller};
use super::joining::{Joined, Joining};
use super::joining_error::JoiningError;
use super::login::Login;
use super::schedule::Schedule;
use super::velocity::Velocity;
use super::watch::MotionWatch;
use crate::http::motion::{Motion, Speeds as _, Surroundings};
use crate::http::{CommandAnswers, Lane, Lanes, Received, Request};
use crate::session::{NextAction, RestEvidence, Session, WillStep};

/// A camera that was silent for this time is silent.
pub const SILENT_AFTER: Duration = Duration::from_secs(3);
/// Pause before a camera that cannot be used is asked again.
const RETRY: Duration = Duration::from_secs(5);
/// Longest shut-down. Motion has ended by itself before.
const CLOSING_TIMEOUT: Duration = Duration::from_secs(2);
/// What waits for a free lane is looked at after this time at the latest.
const LOOK_INTERVAL: Duration = Duration::from_millis(20);

mod answers;

/// What a session knows from the start.
#[derive(Debug, Clone, PartialEq)]
pub struct OnvifSettings {
    /// The login; `None`: the camera asks for none.
    pub login: Option<Login>,
    /// How fast the camera turns at its speeds; `None`: not measured, and the camera is not moved.
    pub speeds: Option<AxisSpeeds>,
    /// Token or name of the media profile that is moved and shown; `None`: the first that can be moved.
    pub profile: Option<String>,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum State {
    Joining,
    Up,
    Refused { until: Timestamp },
    Silent,
    Closing { since: Timestamp },
    Closed,
}

/// One session with a camera.
#[derive(Debug, Clone)]
pub struct OnvifSession {
    state: State,
    speeds: Option<AxisSpeeds>,
    caller: Caller,
    lanes: Lanes<Call>,
    joining: Joining,
    failure: Option<JoiningError>,
    rates: VehicleRates,
    motion: Motion<Velocity>,
    /// Zeros that were sent: they are a Stop and a ContinuousMove in turn.
    zeros: u32,
    /// Whether the camera was seen at rest, or was not turned, since the last command to turn.
    has_rested: bool,
    watch: MotionWatch,
    schedule: Schedule,
    commands: CommandAnswers,
    last_heard: Timestamp,
}

impl OnvifSession {
    /// A session that begins now. `seed` is new for each session: nonces are made of it.
    pub fn open(settings: &OnvifSettings, seed: [u8; 16], now: Timestamp) -> Self {
        Self {
            state: State::Joining,
            speeds: settings.speeds.clone(),
            caller: Caller::new(settings.login.clone(), seed),
            lanes: Lanes::default(),
            joining: Joining::new(settings.profile.clone()),
            failure: None,
            rates: VehicleRates::REST,
            motion: Motion::default(),
            zeros: 0,
            has_rested: true,
            watch: MotionWatch::default(),
            schedule: Schedule::starting(now),
            commands: CommandAnswers::default(),
            last_heard: now,
        }
    }

    /// What the camera says to commands; `None`: nothing yet.
    pub fn acceptance(&self, now: Timestamp) -> Option<Acceptance> {
        if let Some(failure) = &self.failure {
            return Some(failure.said());
        }
        self.joining.joined()?;
        if self.speeds.is_none() {
            return Some(Acceptance::NotCalibrated);
        }
        Some(self.commands.holding(now).unwrap_or(Acceptance::Accepted))
    }

    fn send(&mut self, lane: Lane, ask: Ask, now: Timestamp, out: &mut Vec<Request<Call>>) {
        let call = self.caller.call(ask, self.joining.paths(), now);
        self.lanes.send(lane, call, now, out);
    }

    fn surroundings(&self, now: Timestamp) -> Surroundings {
        let since = self.motion.stopping_since().unwrap_or(Timestamp::ZERO);
        Surroundings::of(&self.lanes, self.watch.since(since, now))
    }

    /// Sends the commands that are due.
    fn poll_motion(&mut self, now: Timestamp, out: &mut Vec<Request<Call>>) {
        let Some(joined) = self.joining.joined().cloned() else { return };
        let may_turn = self.state == State::Up && self.acceptance(now) == Some(Acceptance::Accepted);
        let wanted = match self.speeds.as_ref().filter(|_| may_turn) {
            Some(speeds) => Velocity::of(self.rates, speeds),
            None => Velocity::REST,
        };
        self.motion.want(wanted);
        let Some((lane, velocity)) = self.motion.due(self.surroundings(now), now) else { return };
        self.has_rested &= velocity.is_rest();
        let ask = if velocity.is_rest() {
            self.zeros = self.zeros.wrapping_add(1);
            zero(&joined, self.zeros)
        } else {
            movement(&joined, velocity)
        };
        self.send(lane, ask, now, out);
    }

    fn poll_states(&mut self, now: Timestamp, out: &mut Vec<Request<Call>>) {
        let is_stopping = self.motion.stopping_since().is_some();
        if let Some(joined) = self.joining.joined()
            && self.lanes.is_free(Lane::Camera)
            && self.schedule.take_due(is_stopping, now)
        {
            let ask = Ask::Status { profile: joined.profile.clone() };
            self.send(Lane::Camera, ask, now, out);
        }
        if self.state == State::Joining
            && self.lanes.is_free(Lane::State)
            && let Some(ask) = self.joining.next()
        {
            self.send(Lane::State, ask, now, out);
        }
    }

    fn poll_closing(&mut self, since: Timestamp, now: Timestamp, out: &mut Vec<Request<Call>>) -> NextAction {
        self.rates = VehicleRates::REST;
        self.poll_motion(now, out);
        // A camera that still turns gets more zeros.
        let is_moving = matches!(self.watch.since(since, now), RestEvidence::Moving { .. });
        if (self.motion.is_resting() && !is_moving) || now.since(since) >= CLOSING_TIMEOUT {
            self.state = State::Closed;
            return NextAction::Closed;
        }
        self.poll_states(now, out);
        NextAction::WaitUntil(self.wake_at(now).min(since.plus(CLOSING_TIMEOUT)))
    }

    fn wake_at(&self, now: Timestamp) -> Timestamp {
        let times = [self.motion.wake_at(), self.commands.held_until(now), self.lanes.next_overdue()];
        let soon = times.into_iter().flatten().min().unwrap_or(Timestamp::from_nanos(u64::MAX));
        let states = self.schedule.wake_at().max(now.plus(LOOK_INTERVAL));
        soon.max(now.plus(Duration::from_millis(1))).min(states).min(self.last_heard.plus(SILENT_AFTER))
    }
}

fn movement(joined: &Joined, velocity: Velocity) -> Ask {
    let (profile, full, timeout) = (joined.profile.clone(), joined.full, joined.timeout);
    Ask::Move { profile, velocity, full, timeout }
}

/// The zero of this number.
fn zero(joined: &Joined, number: u32) -> Ask {
    if number.is_multiple_of(2) {
        movement(joined, Velocity::REST)
    } else {
        Ask::Stop { profile: joined.profile.clone() }
    }
}

impl Session for OnvifSession {
    type Sent = Request<Call>;
    type Received = Received;
    type Command = VehicleRates;

    fn poll(&mut self, now: Timestamp, out: &mut Vec<Request<Call>>) -> NextAction {
        for id in self.lanes.overdue(now) {
            self.on_answer(id, None, now, &mut |_| {});
        }
        let is_open = matches!(self.state, State::Joining | State::Up);
        if is_open && now.since(self.last_heard) >= SILENT_AFTER {
            self.state = State::Silent;
        }
        match self.state {
            State::Refused { until } if now < until => return NextAction::WaitUntil(until),
            State::Refused { .. } => {
                return NextAction::Reopen { reason: "the camera cannot be used" };
            }
            State::Silent => return NextAction::Reopen { reason: "the camera does not answer" },
            State::Closed => return NextAction::Closed,
            State::Closing { since } => return self.poll_closing(since, now, out),
            State::Joining | State::Up => {}
        }
        // Commands go first.
        self.poll_motion(now, out);
        self.poll_states(now, out);
        NextAction::WaitUntil(self.wake_at(now))
    }

    fn received(&mut self, packet: &Received, now: Timestamp, report: &mut dyn FnMut(Telemetry)) {
        match packet {
            Received::Answer { id, status, body } => {
                self.last_heard = now;
                self.on_answer(*id, Some((*status, body)), now, report);
            }
            Received::NoAnswer { id } => self.on_answer(*id, None, now, report),
            // No WebSocket is opened.
            Received::Message(_) | Received::SocketEnded => {}
        }
        self.report_acceptance(now, report);
    }

    fn request(&mut self, rates: VehicleRates, _: Option<Timestamp>) {
        if !matches!(self.state, State::Closing { .. } | State::Closed) {
            self.rates = rates;
        }
    }

    /// Zeros at once, until the camera's state shows rest.
    fn close(&mut self, now: Timestamp) {
        match self.state {
            State::Closing { .. } | State::Closed => {}
            State::Refused { .. } | State::Silent | State::Joining => self.state = State::Closed,
            State::Up => {
                self.motion.stop(now);
                self.state = State::Closing { since: now };
            }
        }
    }

    fn link_state(&self) -> LinkState {
        match self.state {
            State::Joining | State::Refused { .. } => LinkState::Starting,
            State::Up => LinkState::Up,
            State::Silent if self.joining.joined().is_some() => LinkState::Silent,
            State::Silent => LinkState::Opening,
            State::Closing { .. } => LinkState::Closing,
            State::Closed => LinkState::Closed,
        }
    }

    /// Never: each motion ends by itself.
    fn may_be_turning(&self) -> bool {
        false
    }

    fn rest_evidence(&self, now: Timestamp) -> RestEvidence {
        let since = if let State::Closing { since } = self.state { since } else { Timestamp::ZERO };
        self.watch.since(since, now)
    }

    fn failure(&self) -> Option<String> {
        self.failure.as_ref().map(ToString::to_string)
    }

    /// A zero of each kind, each on its lane.
    fn last_will(&self, now: Timestamp) -> Vec<WillStep<Request<Call>>> {
        let Some(joined) = self.joining.joined() else { return Vec::new() };
        let mut caller = self.caller.clone();
        let zeros = [(1, Lane::Stop), (2, Lane::Turn)];
        let step = |(number, lane): (u32, Lane)| {
            let call = caller.call(zero(joined, number), self.joining.paths(), now);
            let packet = Request { id: u64::from(number), lane, call };
            WillStep { packet, pause: Duration::from_millis(100) }
        };
        zeros.map(step).into()
    }
}
