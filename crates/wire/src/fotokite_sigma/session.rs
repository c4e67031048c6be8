//! The client's end of the API: limits, control, commands, states, shut-down.
//!
//! ```text
//!           camera info 200           the vehicle has said who controls
//!   Looking ----------------> Joining --------------------------------> Up
//!     |  401 (any state)                                                |
//!     +-------> Refused -- 5 s --> (a new session, a new token)         | nothing heard for 3 s
//!                                                                       v
//!   any state -- close() --> Closing (zeros, release) --> Closed      Silent (a new session)
//! ```
//!
//! Motion needs the control: the first command after it was granted is a zero. Commands expire by themselves
//! after 0.45 s, or 0.15 s after the rates should have been renewed ([`crate::http::motion`]); therefore no
//! guard is needed, and nothing turns for longer than that after the last request, whatever becomes of this
//! program. [`FotokiteSigmaSession`] is the [`Session`] of this protocol: requests and the time out, answers
//! and the time in.

use core::time::Duration;

use barrelman_vocab::acceptance::Acceptance;
use barrelman_vocab::telemetry::LinkState;
use barrelman_vocab::{Named as _, Telemetry, Timestamp, VehicleRates, ZoomRate};

use super::call::{Call, STOP_DURATION, SelfStatus, TURN_DURATION};
use super::control::Control;
use super::json;
use super::reports::{CameraWatch, Flight};
use super::schedule::Schedule;
use super::speeds::Speeds;
use super::zoom::ZoomSteps;
use crate::http::motion::{Motion, Speeds as _, Surroundings};
use crate::http::{CommandAnswers, Lane, Lanes, Received, Request};
use crate::session::{LinkHistory, NextAction, RestEvidence, Session, WillStep};

/// A vehicle that was silent for this time is silent.
pub const SILENT_AFTER: Duration = Duration::from_secs(3);
/// Pause before a refused token is tried again.
const TOKEN_RETRY: Duration = Duration::from_secs(5);
/// Pause before the camera's limits are asked for again.
const INFO_RETRY: Duration = Duration::from_secs(1);
/// Least interval between two texts on the vehicle's tablet.
const STATUS_INTERVAL: Duration = Duration::from_secs(1);
/// A command to turn ends at most this long after the time by which the rates have to be renewed: a video
/// frame that is late by less does not interrupt the motion.
const AFTER_RENEWAL: Duration = Duration::from_millis(150);
/// Longest shut-down. Motion has ended by itself long before.
const CLOSING_TIMEOUT: Duration = Duration::from_secs(2);

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum State {
    Looking,
    Joining,
    Up,
    Refused { until: Timestamp },
    Silent,
    Closing { since: Timestamp, has_released: bool },
    Closed,
}

mod answers;

/// One session with a Sigma.
#[derive(Debug, Clone)]
pub struct FotokiteSigmaSession {
    /// The name of the video whose angle of view is reported; `None`: the main one.
    stream: Option<String>,
    state: State,
    lanes: Lanes<Call>,
    info: Option<json::CameraInfo>,
    info_at: Timestamp,
    rates: VehicleRates,
    /// When the rates have to be renewed.
    renew_by: Option<Timestamp>,
    control: Control,
    motion: Motion<Speeds>,
    zoom: ZoomSteps,
    camera: CameraWatch,
    flight: Flight,
    schedule: Schedule,
    is_offline: bool,
    commands: CommandAnswers,
    shown: Option<(&'static str, Timestamp)>,
    last_heard: Timestamp,
}

impl FotokiteSigmaSession {
    /// A session that begins now. `stream`: the video whose angle of view is reported, and that zooms;
    /// `None`: the main one. `full_zoom`: the rate of its zoom at the largest speed.
    pub fn open(stream: Option<String>, full_zoom: ZoomRate, now: Timestamp) -> Self {
        Self {
            stream,
            state: State::Looking,
            lanes: Lanes::default(),
            info: None,
            info_at: now,
            rates: VehicleRates::REST,
            renew_by: None,
            control: Control::asked_for(now),
            motion: Motion::default(),
            zoom: ZoomSteps::new(full_zoom),
            camera: CameraWatch::default(),
            flight: Flight::default(),
            schedule: Schedule::starting(now),
            is_offline: false,
            commands: CommandAnswers::default(),
            shown: None,
            last_heard: now,
        }
    }

    /// What the vehicle says to commands.
    pub fn acceptance(&self, now: Timestamp) -> Acceptance {
        if let State::Refused { .. } = self.state {
            return Acceptance::TokenRefused;
        }
        if self.info.is_none() {
            return self.commands.refusal().unwrap_or(Acceptance::Unanswered);
        }
        let offline = self.is_offline.then_some(Acceptance::NoCamera);
        self.control.obstacle().or(offline).or(self.commands.holding(now)).unwrap_or(Acceptance::Accepted)
    }

    fn is_open(&self) -> bool {
        matches!(self.state, State::Looking | State::Joining | State::Up)
    }

    fn send(&mut self, lane: Lane, call: Call, now: Timestamp, out: &mut Vec<Request<Call>>) {
        self.lanes.send(lane, call, now, out);
    }

    fn surroundings(&self, now: Timestamp) -> Surroundings {
        let since = self.motion.stopping_since().unwrap_or(Timestamp::ZERO);
        Surroundings::of(&self.lanes, self.camera.since(since, now))
    }

    /// Sends the commands that are due.
    fn poll_motion(&mut self, now: Timestamp, out: &mut Vec<Request<Call>>) {
        if !self.control.is_ours() {
            return;
        }
        let may_turn = self.state == State::Up && self.acceptance(now) == Acceptance::Accepted;
        let wanted = match self.info.filter(|_| may_turn) {
            Some(info) => Speeds::within(self.rates, &info),
            None => Speeds::REST,
        };
        self.motion.want(wanted);
        if let Some((lane, speeds)) = self.motion.due(self.surroundings(now), now) {
            let duration = if speeds.is_rest() { STOP_DURATION } else { self.turn_duration(now) };
            self.send(lane, Call::Turn { speeds, duration }, now, out);
        }
    }

    /// How long a command to turn that is sent now lasts: where zeros do not reach the vehicle, or are
    /// refused, the motion ends soon after the time by which the rates have to be renewed.
    fn turn_duration(&self, now: Timestamp) -> Duration {
        let until_renewal = self.renew_by.map_or(TURN_DURATION, |by| by.since(now));
        (until_renewal + AFTER_RENEWAL).min(TURN_DURATION)
    }

    fn poll_states(&mut self, now: Timestamp, out: &mut Vec<Request<Call>>) {
        if self.lanes.is_free(Lane::Control)
            && let Some(call) = self.control.due(now)
        {
            self.send(Lane::Control, call, now, out);
        }
        let is_stopping = self.motion.stopping_since().is_some();
        if self.lanes.is_free(Lane::Camera)
            && let Some(call) = self.schedule.due_camera(is_stopping, now)
        {
            self.send(Lane::Camera, call, now, out);
        }
        if self.lanes.is_free(Lane::Socket)
            && let Some(call) = self.schedule.due_socket(now)
        {
            self.send(Lane::Socket, call, now, out);
        }
        if self.lanes.is_free(Lane::State) {
            let zoom = self.due_zoom(now);
            let call = zoom.or_else(|| self.due_status(now)).or_else(|| self.schedule.due_state(now));
            if let Some(call) = call {
                self.send(Lane::State, call, now, out);
            }
        }
    }

    /// The next step of the zoom, if one is due.
    fn due_zoom(&mut self, now: Timestamp) -> Option<Call> {
        let may_zoom = self.state == State::Up && self.acceptance(now) == Acceptance::Accepted;
        let stream = self.schedule.stream().filter(|_| may_zoom)?.clone();
        let level = self.zoom.due(self.rates.zoom, now)?;
        Some(Call::Zoom { stream, level })
    }

    /// The text for the vehicle's tablet, if it has changed.
    fn due_status(&mut self, now: Timestamp) -> Option<Call> {
        let (status, text) = match self.acceptance(now) {
            Acceptance::Accepted if self.motion.is_turning() => {
                (SelfStatus::Connected, "The camera follows the boat")
            }
            Acceptance::Accepted => (SelfStatus::Connected, "Ready; the camera rests"),
            Acceptance::Queued => (SelfStatus::Warning, "Waits for the control"),
            Acceptance::OtherClient => (SelfStatus::Warning, "Has given way to another client"),
            said => (SelfStatus::Warning, said.text()),
        };
        let is_due = self.shown.is_none_or(|(shown, at)| shown != text && now.since(at) >= STATUS_INTERVAL);
        is_due.then(|| {
            self.shown = Some((text, now));
            Call::ShowStatus { status, text }
        })
    }

    fn poll_closing(
        &mut self,
        since: Timestamp,
        has_released: bool,
        now: Timestamp,
        out: &mut Vec<Request<Call>>,
    ) -> NextAction {
        self.rates = VehicleRates::REST;
        self.poll_motion(now, out);
        let is_over = now.since(since) >= CLOSING_TIMEOUT;
        let is_stopped = self.motion.is_resting() || !self.control.is_ours();
        if !is_over && !is_stopped {
            if self.lanes.is_free(Lane::Camera)
                && let Some(call) = self.schedule.due_camera(true, now)
            {
                self.send(Lane::Camera, call, now, out);
            }
            return NextAction::WaitUntil(self.wake_at(now).min(since.plus(CLOSING_TIMEOUT)));
        }
        let is_free = self.lanes.is_free(Lane::Control);
        if !is_over && !has_released && self.info.is_some() {
            if is_free {
                self.state = State::Closing { since, has_released: true };
                if self.control.has_claim() {
                    self.send(Lane::Control, Call::ReleaseControl, now, out);
                }
                if self.lanes.is_free(Lane::State) {
                    self.send(Lane::State, Call::ShowStatus { status: SelfStatus::None, text: "" }, now, out);
                }
            }
            return NextAction::WaitUntil(self.wake_at(now).min(since.plus(CLOSING_TIMEOUT)));
        }
        if !is_over && has_released && !is_free {
            return NextAction::WaitUntil(self.wake_at(now).min(since.plus(CLOSING_TIMEOUT)));
        }
        self.state = State::Closed;
        NextAction::Closed
    }

    fn wake_at(&self, now: Timestamp) -> Timestamp {
        let control = self.control.wake_at().filter(|_| self.lanes.is_free(Lane::Control));
        let motion = self.motion.wake_at().filter(|_| self.control.is_ours());
        let zoom = self.zoom.wake_at(self.rates.zoom).filter(|_| self.lanes.is_free(Lane::State));
        let times = [control, motion, zoom, self.commands.held_until(now), self.lanes.next_overdue()];
        let soon = times.into_iter().flatten().min().unwrap_or(Timestamp::from_nanos(u64::MAX));
        // What waits for a free lane is looked at when the lane's answer arrives.
        let states = self.schedule.wake_at(now).max(now.plus(Duration::from_millis(20)));
        soon.max(now.plus(Duration::from_millis(1))).min(states).min(self.last_heard.plus(SILENT_AFTER))
    }

    fn is_starting(&self) -> bool {
        matches!(self.state, State::Looking | State::Joining)
    }

    fn is_told(&self) -> bool {
        self.commands.refusal().is_some() || self.control.is_known()
    }
}

impl Session for FotokiteSigmaSession {
    type Sent = Request<Call>;
    type Received = Received;
    type Command = VehicleRates;

    fn poll(&mut self, now: Timestamp, out: &mut Vec<Request<Call>>) -> NextAction {
        for id in self.lanes.overdue(now) {
            self.on_answer(id, None, now, &mut |_| {});
        }
        if self.is_open() && now.since(self.last_heard) >= SILENT_AFTER {
            self.state = State::Silent;
        }
        match self.state {
            State::Refused { until } if now < until => return NextAction::WaitUntil(until),
            State::Refused { .. } => {
                return NextAction::Reopen { reason: "the vehicle refuses the token (401)" };
            }
            State::Silent => return NextAction::Reopen { reason: "the vehicle does not answer" },
            State::Closed => return NextAction::Closed,
            State::Closing { since, has_released } => {
                return self.poll_closing(since, has_released, now, out);
            }
            State::Looking | State::Joining | State::Up => {}
        }
        // Commands go first.
        self.poll_motion(now, out);
        let needs_info = self.info.is_none() || self.info_at <= now && self.commands.refusal().is_some();
        if needs_info && self.info_at <= now && self.lanes.is_free(Lane::State) {
            self.info_at = now.plus(INFO_RETRY);
            self.send(Lane::State, Call::CameraInfo, now, out);
        }
        if self.info.is_some() {
            self.poll_states(now, out);
            return NextAction::WaitUntil(self.wake_at(now));
        }
        NextAction::WaitUntil(self.wake_at(now).min(self.info_at.max(now.plus(Duration::from_millis(20)))))
    }

    fn received(&mut self, packet: &Received, now: Timestamp, report: &mut dyn FnMut(Telemetry)) {
        match packet {
            Received::Answer { id, status, body } => {
                self.last_heard = now;
                self.on_answer(*id, Some((*status, body)), now, report);
            }
            Received::NoAnswer { id } => self.on_answer(*id, None, now, report),
            Received::Message(body) => {
                self.last_heard = now;
                if let Some(state) = json::read::<json::CameraState>(body)
                    && state.tilt_ned.is_some()
                {
                    self.schedule.on_message(now);
                    self.on_camera_state(&state, now, report);
                }
            }
            Received::SocketEnded => self.schedule.on_socket_end(now),
        }
        self.report_acceptance(now, report);
    }

    fn request(&mut self, rates: VehicleRates, renew_by: Option<Timestamp>) {
        if !matches!(self.state, State::Closing { .. } | State::Closed) {
            (self.rates, self.renew_by) = (rates, renew_by);
        }
    }

    fn take_control(&mut self, now: Timestamp) {
        self.control.take(now);
    }

    /// Zeros at once, until the camera's state shows rest; then the control is released. Without the control
    /// nothing is sent.
    fn close(&mut self, now: Timestamp) {
        match self.state {
            State::Closing { .. } | State::Closed => {}
            State::Refused { .. } | State::Silent => self.state = State::Closed,
            State::Looking | State::Joining | State::Up => {
                if self.control.is_ours() {
                    self.motion.stop(now);
                }
                self.state = State::Closing { since: now, has_released: false };
            }
        }
    }

    fn link_state(&self) -> LinkState {
        match self.state {
            State::Looking | State::Joining | State::Refused { .. } => LinkState::Starting,
            State::Up => LinkState::Up,
            State::Silent if self.control.is_known() => LinkState::Silent,
            State::Silent => LinkState::Opening,
            State::Closing { .. } => LinkState::Closing,
            State::Closed => LinkState::Closed,
        }
    }

    fn resume(&mut self, history: LinkHistory) {
        if history.is_anothers {
            self.control = Control::left_to_another();
        }
    }

    fn is_anothers(&self) -> bool {
        self.control.is_anothers()
    }

    /// Never: each command ends by itself.
    fn may_be_turning(&self) -> bool {
        false
    }

    fn rest_evidence(&self, now: Timestamp) -> RestEvidence {
        let since = if let State::Closing { since, .. } = self.state { since } else { Timestamp::ZERO };
        self.camera.since(since, now)
    }

    /// A zero on each of the lanes of the commands. Where another client controls, the vehicle refuses it.
    fn last_will(&self, _: Timestamp) -> Vec<WillStep<Request<Call>>> {
        let zero = |id, lane| Request { id, lane, call: Call::STOP };
        [(1, Lane::Stop), (2, Lane::Turn)]
            .map(|(id, lane)| WillStep { packet: zero(id, lane), pause: Duration::from_millis(100) })
            .into()
    }
}
