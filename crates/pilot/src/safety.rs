//! Whether the camera may move: the stop, and the rule of motion. Nothing else decides it.
//!
//! 1. A stop outranks everything. After it only an explicit `Engage` lets the camera move again.
//! 2. Motion rests on a fresh look. Only a fresh localisation starts or raises a rate. One that coasts can only
//!    lower it.
//! 3. A rate that is running lasts at most `coast_motion` after the last fresh localisation arrived; then zeros.
//!    A step that claims to lie before that arrival cannot tell how long ago it was: zeros, too.

use core::time::Duration;

use barrelman_vocab::{AngularRate, CameraCommand, OperatorRequest, StopCause, Timestamp};

use crate::outcome::{HoldCause, Mode};

/// What a step brings to judge by.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum ObservationResult {
    /// A fresh localisation, and what the law asks for.
    Fresh(CameraCommand),
    /// A localisation that coasts, and what the law would ask for.
    Coasting(CameraCommand),
    /// A look that showed no target, or came too late.
    Unusable(HoldCause),
    /// No look at all: a tick, a request, telemetry.
    NoObservation,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Engagement {
    Disengaged,
    Engaged,
    Stopped(StopCause),
}

/// The judge.
#[derive(Debug, Clone)]
pub struct Safety {
    coast_motion: Duration,
    engagement: Engagement,
    last_fresh_at: Option<Timestamp>,
    /// Why the camera will rest if nothing fresh comes from here on.
    hold_cause: HoldCause,
    command_in_force: CameraCommand,
}

/// What a judge rules.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Decision {
    /// The mode from here on.
    pub mode: Mode,
    /// The command in force from here on.
    pub command: CameraCommand,
    /// When to ask again at the latest.
    pub wake_at: Option<Timestamp>,
}

impl Safety {
    /// A judge who has seen nothing: disengaged, at rest.
    pub fn new(coast_motion: Duration) -> Self {
        Self {
            coast_motion,
            engagement: Engagement::Disengaged,
            last_fresh_at: None,
            hold_cause: HoldCause::NoSelection,
            command_in_force: CameraCommand::REST,
        }
    }

    /// Takes a request. A stop keeps its first cause until the camera is engaged again.
    pub fn on_request(&mut self, request: &OperatorRequest) {
        self.engagement = match (self.engagement, request) {
            (stopped @ Engagement::Stopped(_), OperatorRequest::Stop(_)) => stopped,
            (_, OperatorRequest::Stop(cause)) => Engagement::Stopped(*cause),
            (_, OperatorRequest::Engage) => Engagement::Engaged,
            (_, OperatorRequest::Disengage) => Engagement::Disengaged,
            (unchanged, OperatorRequest::Select(_)) => {
                // What was running rested on another target.
                self.command_in_force = CameraCommand::REST;
                self.last_fresh_at = None;
                unchanged
            }
        };
    }

    /// Rules on one step.
    pub fn decide(&mut self, observation: ObservationResult, now: Timestamp) -> Decision {
        match observation {
            ObservationResult::Fresh(_) => {
                self.last_fresh_at = Some(now);
                self.hold_cause = HoldCause::VideoSilent;
            }
            ObservationResult::Coasting(_) => self.hold_cause = HoldCause::Coasting,
            ObservationResult::Unusable(why) => self.hold_cause = why,
            ObservationResult::NoObservation => {}
        }
        let mode = self.mode(now);
        self.command_in_force = match (mode, observation) {
            (Mode::Servoing, ObservationResult::Fresh(wanted)) => wanted,
            (Mode::Servoing, ObservationResult::Coasting(wanted)) => reduced(self.command_in_force, wanted),
            (Mode::Servoing, _) => self.command_in_force,
            (Mode::Idle | Mode::Holding(_) | Mode::Stopped(_), _) => CameraCommand::REST,
        };
        let wake_at = match mode {
            Mode::Servoing => self.expires_at(),
            Mode::Idle | Mode::Holding(_) | Mode::Stopped(_) => None,
        };
        Decision { mode, command: self.command_in_force, wake_at }
    }

    fn expires_at(&self) -> Option<Timestamp> {
        self.last_fresh_at.map(|at| at.plus(self.coast_motion))
    }

    fn mode(&self, now: Timestamp) -> Mode {
        match self.engagement {
            Engagement::Disengaged => Mode::Idle,
            Engagement::Stopped(cause) => Mode::Stopped(cause),
            Engagement::Engaged if self.has_fresh_observation(now) => Mode::Servoing,
            Engagement::Engaged => Mode::Holding(self.hold_cause),
        }
    }

    fn has_fresh_observation(&self, now: Timestamp) -> bool {
        self.last_fresh_at.is_some_and(|at| at <= now && now < at.plus(self.coast_motion))
    }
}

/// The command in force, with each axis no faster than `wanted` asks for; an axis that would turn the other way
/// rests.
fn reduced(command_in_force: CameraCommand, wanted: CameraCommand) -> CameraCommand {
    let axis = |running: AngularRate, wanted: AngularRate| {
        let (running, wanted) = (running.radians_per_second(), wanted.radians_per_second());
        let rate = if running * wanted <= 0.0 {
            0.0
        } else if running > 0.0 {
            running.min(wanted)
        } else {
            running.max(wanted)
        };
        AngularRate::from_radians_per_second(rate)
    };
    CameraCommand {
        pan: axis(command_in_force.pan, wanted.pan),
        tilt: axis(command_in_force.tilt, wanted.tilt),
    }
}
