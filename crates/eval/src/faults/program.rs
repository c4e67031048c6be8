//! The simulated program: the real pilot on the truth, and its side of the pipe to the guard, or its messages to the link's
//! thread.

use std::collections::VecDeque;

use anyhow::Result;
use barrelman_experiments::tracker_choice::{TrackerName, TrackerSettings};
use barrelman_link::guard::gate::HEARTBEAT;
use barrelman_link::guard::message::ToGuard;
use barrelman_link::{LinkReport, RequestedRates};
use barrelman_pilot::{CommandPath, Input, LawSettings, Pilot, PilotSettings};
use barrelman_vocab::acceptance::Acceptance;
use barrelman_vocab::telemetry::{ControlState, FlightState, LinkState, Report};
use barrelman_vocab::{
    ImagePoint, Localisation, OperatorRequest, PictureSize, PixelBox, StopCause, Telemetry, Timestamp, Track,
    VehicleProfile,
};

use super::oracle::Oracle;

const PICTURE: PictureSize = PictureSize::new(640, 360);
/// Half the picture's width over the tangent of half its angle of view, pixels.
const FOCAL_PX: f64 = 330.0;

/// The program.
pub(super) struct Program {
    pilot: Pilot,
    profile: VehicleProfile,
    wake_at: Option<Timestamp>,
    requested: RequestedRates,
    sent_at: Timestamp,
    link: LinkState,
    control: Option<ControlState>,
    flight: Option<FlightState>,
    uptime_s: f64,
    lost_since: Option<Timestamp>,
    /// Messages for the link.
    pub(super) outbox: VecDeque<ToGuard>,
    /// Reports that the run loop has not read yet.
    pub(super) reports: VecDeque<LinkReport>,
}

/// What a picture shows, and when it was captured.
#[derive(Debug, Clone, Copy)]
pub(super) struct SeenPicture {
    pub(super) captured: Timestamp,
    /// To the right of the picture's centre, radians; `None`: the target is not found.
    pub(super) bearing_rad: Option<f64>,
    pub(super) is_coasting: bool,
}

impl SeenPicture {
    /// The track, with the time since when the boat has been lost where it is.
    fn track(self, lost_since: Timestamp) -> Track {
        let lost = Track::Lost { since: lost_since, confidence: 0.1 };
        let Some(x) = self.bearing_rad.map(|bearing| FOCAL_PX * bearing.tan()) else { return lost };
        if x.abs() > f64::from(PICTURE.width) / 2.0 {
            return lost;
        }
        let centre = ImagePoint { x, y: 20.0 }.in_pixels(PICTURE);
        let localisation = Localisation {
            captured: self.captured,
            picture: PICTURE,
            centre,
            bounds: PixelBox { u: centre.u - 20.0, v: centre.v - 8.0, w: 40.0, h: 16.0 },
            shape: None,
            heading: None,
            confidence: 0.9,
        };
        if self.is_coasting { Track::Coasting(localisation) } else { Track::Tracking(localisation) }
    }
}

impl Program {
    pub(super) fn new(profile: VehicleProfile, law: LawSettings) -> Result<Self> {
        let tracker = TrackerSettings::new(TrackerName::Camshift).build()?;
        let settings = PilotSettings { profile: profile.clone(), law };
        Ok(Self {
            pilot: Pilot::new(settings, tracker).commanding(CommandPath::Link),
            profile,
            wake_at: None,
            requested: RequestedRates::REST,
            sent_at: Timestamp::ZERO,
            link: LinkState::Opening,
            control: None,
            flight: None,
            uptime_s: 0.0,
            lost_since: None,
            outbox: VecDeque::new(),
            reports: VecDeque::new(),
        })
    }

    /// Whether the vehicle says that another commander has the control.
    pub(super) fn is_control_elsewhere(&self) -> bool {
        self.control == Some(ControlState::NotOurs)
    }

    /// The thread of the link: the sign of life.
    pub(super) fn beat(&mut self, now: Timestamp) {
        if now.since(self.sent_at) >= HEARTBEAT {
            self.sent_at = now;
            self.outbox.push_back(ToGuard::Request(self.requested));
        }
    }

    /// The run loop: what the link reports, and the pilot's deadline.
    pub(super) fn advance(&mut self, oracle: &mut Oracle, now: Timestamp) {
        while let Some(report) = self.reports.pop_front() {
            match report {
                LinkReport::Telemetry(telemetry) => self.on_telemetry(telemetry, oracle, now),
                LinkReport::Suspended(_) => self.on_suspension(oracle, now),
                LinkReport::GuardLost(_) => {
                    let opening = Telemetry { at: now, report: Report::Link(LinkState::Opening) };
                    self.on_telemetry(opening, oracle, now);
                }
                LinkReport::Lost { .. }
                | LinkReport::HeldUp
                | LinkReport::Stopped(_)
                | LinkReport::Panicked => {}
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
                let is_taken =
                    before == Some(ControlState::Ours) && self.control == Some(ControlState::NotOurs);
                if has_restarted || is_taken {
                    oracle.withdraw();
                }
            }
            Report::Acceptance(said) => {
                let is_taken = said == Acceptance::OtherClient;
                if is_taken && self.control != Some(ControlState::NotOurs) {
                    oracle.withdraw();
                }
                self.control = Some(if is_taken { ControlState::NotOurs } else { ControlState::Ours });
            }
            Report::Flight { state, .. } | Report::FlightState { state, .. } => {
                let begins = self.flight.replace(state) != Some(state);
                if begins && matches!(state, FlightState::Emergency | FlightState::Landing) {
                    oracle.withdraw();
                }
            }
            _ => {}
        }
        self.step(Input::Telemetry(telemetry), now);
    }

    /// A picture has arrived.
    pub(super) fn see(&mut self, picture: SeenPicture, oracle: &mut Oracle, now: Timestamp, at_ms: u64) {
        let track = picture.track(self.lost_since.unwrap_or(picture.captured));
        self.lost_since = match track {
            Track::Lost { since, .. } => Some(since),
            _ => None,
        };
        let age = now.since(picture.captured);
        let is_fresh = age <= self.profile.video_latency + self.profile.stale_after;
        oracle.saw(at_ms, is_fresh && matches!(track, Track::Tracking(_)));
        self.step(Input::Localisation(track), now);
    }

    /// An operator's request.
    pub(super) fn request(&mut self, request: OperatorRequest, now: Timestamp) {
        self.step(Input::Request(request), now);
        if request == OperatorRequest::Engage {
            self.outbox.push_back(ToGuard::TakeControl);
        }
    }

    fn step(&mut self, input: Input<'_>, now: Timestamp) {
        let outcome = self.pilot.step(input, now);
        self.wake_at = outcome.wake_at;
        let requested =
            RequestedRates { command: self.profile.to_vehicle(outcome.command), renew_by: outcome.wake_at };
        if std::mem::replace(&mut self.requested, requested) != requested {
            self.sent_at = now;
            self.outbox.push_back(ToGuard::Request(requested));
        }
    }

    /// Ends the link in order.
    pub(super) fn end(&mut self, now: Timestamp) {
        self.request(OperatorRequest::Stop(StopCause::Ending), now);
        self.outbox.push_back(ToGuard::Close);
    }
}
