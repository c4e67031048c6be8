//! The simulated program: the real pilot on the truth, and its side of the pipe to the guard, or its messages
//! to the link's thread.

use core::time::Duration;

use anyhow::Result;
use barrelman_experiments::tracker_choice::{TrackerName, TrackerSettings};
use barrelman_link::RequestedRates;
use barrelman_link::guard::message::ToGuard;
use barrelman_pilot::{CommandPath, Input, LawSettings, Pilot, PilotSettings};
use barrelman_vocab::acceptance::Acceptance;
use barrelman_vocab::telemetry::{ControlState, FlightState, LinkState, Report};
use barrelman_vocab::{
    CameraRequest, OperatorRequest, StopCause, Telemetry, Timestamp, Track, VehicleProfile,
};

use super::link_end::{LinkEnd, LinkEvent};
use super::oracle::Oracle;
use super::video_path::Arrived;

/// A reported attitude counts for this time.
const ATTITUDE_LASTS: Duration = Duration::from_millis(300);

/// The program.
pub(super) struct Program {
    pilot: Pilot,
    profile: VehicleProfile,
    wake_at: Option<Timestamp>,
    link: LinkState,
    control: Option<ControlState>,
    flight: Option<FlightState>,
    uptime_s: f64,
    lost_since: Option<Timestamp>,
    /// Whether zero is commanded, and whether the operator knows of a camera that turns.
    pub(super) is_rest_commanded: bool,
    pub(super) is_motion_told: bool,
    attitude_at: Option<Timestamp>,
    /// The program's end of the link.
    pub(super) end: LinkEnd,
}

impl Program {
    pub(super) fn new(profile: VehicleProfile, law: LawSettings) -> Result<Self> {
        let tracker = TrackerSettings::new(TrackerName::Camshift).build()?;
        let settings = PilotSettings { profile: profile.clone(), law };
        Ok(Self {
            pilot: Pilot::new(settings, tracker).commanding(CommandPath::Link),
            profile,
            wake_at: None,
            link: LinkState::Opening,
            control: None,
            flight: None,
            uptime_s: 0.0,
            lost_since: None,
            is_rest_commanded: true,
            is_motion_told: false,
            attitude_at: None,
            end: LinkEnd::new(RequestedRates::REST),
        })
    }

    /// The run loop: what the link reports, and the pilot's deadline.
    pub(super) fn advance(&mut self, oracle: &mut Oracle, now: Timestamp) {
        while let Some(event) = self.end.next_event(now) {
            match event {
                LinkEvent::Telemetry(telemetry) => self.on_telemetry(telemetry, oracle, now),
                LinkEvent::Suspended => self.on_suspension(oracle, now),
            }
        }
        if self.wake_at.is_some_and(|at| at <= now) {
            self.step(Input::Tick, now);
        }
    }

    pub(super) fn on_suspension(&mut self, oracle: &mut Oracle, now: Timestamp) {
        oracle.withdraw();
        self.request(OperatorRequest::Stop(StopCause::Suspended), now);
    }

    fn on_telemetry(&mut self, telemetry: Telemetry, oracle: &mut Oracle, now: Timestamp) {
        // What takes a new Engage, judged apart from the pilot.
        match telemetry.report {
            Report::Link(state) => {
                self.link = state;
                if state != LinkState::Up {
                    self.control = None;
                    oracle.end_behaviours();
                }
                if state == LinkState::Silent {
                    oracle.withdraw();
                }
            }
            Report::Ground { control, uptime_s, .. } | Report::Control { control, uptime_s } => {
                let has_restarted = uptime_s + 1.0 < self.uptime_s;
                self.uptime_s = uptime_s;
                let before = std::mem::replace(
                    &mut self.control,
                    Some(control).filter(|_| self.link == LinkState::Up),
                );
                let is_taken = before == Some(ControlState::Ours)
                    && self.control.is_some_and(|now| now != ControlState::Ours);
                if has_restarted || is_taken {
                    oracle.withdraw();
                }
            }
            Report::Acceptance(said) => {
                let is_taken = said == Acceptance::OtherClient;
                if is_taken && self.control != Some(ControlState::Elsewhere) {
                    oracle.withdraw();
                }
                self.control = Some(if is_taken { ControlState::Elsewhere } else { ControlState::Ours });
            }
            Report::Flight { state, .. } | Report::FlightState { state, .. } => {
                let begins = self.flight.replace(state) != Some(state);
                if begins && matches!(state, FlightState::Emergency | FlightState::Landing) {
                    oracle.withdraw();
                }
            }
            Report::GimbalAttitude(_) => self.attitude_at = Some(now),
            _ => {}
        }
        self.step(Input::Telemetry(telemetry), now);
    }

    /// Whether the vehicle flies, obeys nobody else, and has reported its attitude just now.
    pub(super) fn sees_camera(&self, now: Timestamp) -> bool {
        self.control != Some(ControlState::Elsewhere)
            && self.flight.is_none_or(|state| state == FlightState::Flying)
            && self.attitude_at.is_some_and(|at| now.since(at) <= ATTITUDE_LASTS)
    }

    /// A picture has arrived.
    pub(super) fn see(&mut self, arrived: Arrived, oracle: &mut Oracle, now: Timestamp, at_ms: u64) {
        let track = arrived.picture.track(arrived.captured, self.lost_since);
        self.lost_since = match track {
            Track::Lost { since, .. } => Some(since),
            _ => None,
        };
        let is_fresh = arrived.delay <= self.profile.video_latency + self.profile.stale_after;
        oracle.saw(at_ms, is_fresh && matches!(track, Track::Tracking(_)));
        self.step(Input::Localisation(track), now);
    }

    /// An operator's request.
    pub(super) fn request(&mut self, request: OperatorRequest, now: Timestamp) {
        self.step(Input::Request(request), now);
        if request == OperatorRequest::Camera(CameraRequest::Engage) {
            self.end.take_control();
        }
    }

    fn step(&mut self, input: Input<'_>, now: Timestamp) {
        let outcome = self.pilot.step(input, now);
        self.wake_at = outcome.wake_at;
        self.is_rest_commanded = outcome.command.is_rest();
        self.is_motion_told = outcome.unasked_motion.is_some();
        let requested =
            RequestedRates { command: self.profile.to_vehicle(outcome.command), renew_by: outcome.wake_at };
        self.end.request(requested, now);
    }

    /// Ends the link in order.
    pub(super) fn close(&mut self, now: Timestamp) {
        self.request(OperatorRequest::Stop(StopCause::Ending), now);
        self.end.outbox.push_back(ToGuard::Close);
    }
}
