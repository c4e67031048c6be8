//! The safety rule: the only place that decides whether the camera may move.
//!
//! 1. A stop outranks everything. After a stop, only `Engage` allows motion again; `Disengage` ends the stop in the
//!    idle mode.
//! 2. Motion requires fresh localisations. Only a fresh localisation starts or raises a rate; a coasting one can only
//!    lower it.
//! 3. A rate lasts at most `coast_motion` after the arrival of the last fresh localisation; then both rates become
//!    zero. They also become zero if the current time lies before that arrival, because its age is then unknown.

use core::time::Duration;

use barrelman_vocab::{AngularRate, CameraCommand, OperatorRequest, StopCause, Timestamp};

use crate::outcome::{HoldCause, Mode};

/// What the observation of one step means for motion.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum ObservationResult {
    /// A fresh localisation, with the command that the law advises.
    Fresh(CameraCommand),
    /// A coasting localisation, with the command that the law advises.
    Coasting(CameraCommand),
    /// An observation without target, or a stale one.
    Unusable(HoldCause),
    /// No observation: a tick, a request, or telemetry.
    NoObservation,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Engagement {
    Disengaged,
    Engaged,
    Stopped(StopCause),
}

/// The safety rule with its state.
#[derive(Debug, Clone)]
pub struct Safety {
    coast_motion: Duration,
    engagement: Engagement,
    last_fresh_at: Option<Timestamp>,
    /// The cause to report if the camera rests for lack of fresh localisations.
    hold_cause: HoldCause,
    command_in_force: CameraCommand,
}

/// The decision of one step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Decision {
    /// The mode from this step on.
    pub mode: Mode,
    /// The command in force from this step on.
    pub command: CameraCommand,
    /// Latest time of the next step; `None` if no deadline is pending.
    pub wake_at: Option<Timestamp>,
}

impl Safety {
    /// The initial state: disengaged, at rest, no localisation.
    pub fn new(coast_motion: Duration) -> Self {
        Self {
            coast_motion,
            engagement: Engagement::Disengaged,
            last_fresh_at: None,
            hold_cause: HoldCause::NoSelection,
            command_in_force: CameraCommand::REST,
        }
    }

    /// Processes an operator request. A stop keeps its first cause until the next `Engage` or `Disengage`.
    pub fn on_request(&mut self, request: &OperatorRequest) {
        self.engagement = match (self.engagement, request) {
            (stopped @ Engagement::Stopped(_), OperatorRequest::Stop(_)) => stopped,
            (_, OperatorRequest::Stop(cause)) => Engagement::Stopped(*cause),
            (_, OperatorRequest::Engage) => Engagement::Engaged,
            (_, OperatorRequest::Disengage) => Engagement::Disengaged,
            (unchanged, OperatorRequest::Select(_)) => {
                // The command in force was based on another target.
                self.command_in_force = CameraCommand::REST;
                self.last_fresh_at = None;
                unchanged
            }
        };
    }

    /// Decides the mode and the command of one step.
    pub fn decide(&mut self, observation: ObservationResult, now: Timestamp) -> Decision {
        match observation {
            ObservationResult::Fresh(_) => {
                self.last_fresh_at = Some(now);
                self.hold_cause = HoldCause::VideoSilent;
            }
            ObservationResult::Coasting(_) => self.hold_cause = HoldCause::Coasting,
            ObservationResult::Unusable(cause) => self.hold_cause = cause,
            ObservationResult::NoObservation => {}
        }
        let mode = self.mode(now);
        self.command_in_force = match (mode, observation) {
            (Mode::Servoing, ObservationResult::Fresh(advised)) => advised,
            (Mode::Servoing, ObservationResult::Coasting(advised)) => reduced(self.command_in_force, advised),
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

/// The command in force, with each axis limited to the advised rate. An axis with the opposite direction rests.
fn reduced(in_force: CameraCommand, advised: CameraCommand) -> CameraCommand {
    let axis = |running: AngularRate, advised: AngularRate| {
        let (running, advised) = (running.radians_per_second(), advised.radians_per_second());
        let rate = if running * advised <= 0.0 {
            0.0
        } else if running > 0.0 {
            running.min(advised)
        } else {
            running.max(advised)
        };
        AngularRate::from_radians_per_second(rate)
    };
    CameraCommand { pan: axis(in_force.pan, advised.pan), tilt: axis(in_force.tilt, advised.tilt) }
}
