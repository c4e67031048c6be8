//! The safety rule: the only place that decides whether the camera may move.
//!
//! 1. A stop outranks everything. After a stop, only `Engage` allows motion again; `Disengage` ends the stop in the
//!    idle mode.
//! 2. Motion requires fresh localisations. Only a fresh localisation starts or raises a rate; a coasting one can only
//!    lower it.
//! 3. A rate lasts at most `coast_motion` after the arrival of the last fresh localisation; then both rates become
//!    zero. They also become zero if the current time lies before that arrival, because its age is then unknown.
//! 4. A nudge moves the camera only while disengaged, with fresh video, at a low rate, and lasts at most [`NUDGE_LASTS`]
//!    after its last renewal.
//! 5. Nothing moves the camera while its vehicle takes no commands ([`VehicleState::obstacle`]). Motion begins again with
//!    the next fresh localisation. What the vehicle reports may end an engagement; it then takes a new `Engage`.

use core::time::Duration;

use barrelman_vocab::telemetry::Report;
use barrelman_vocab::{AngularRate, CameraCommand, Nudge, OperatorRequest, StopCause, Timestamp};

use crate::outcome::{HoldCause, Mode, Refusal};
use crate::vehicle::{CommandPath, VehicleState};

/// Rate of a nudge, rad/s: about 6 degrees a second.
pub const NUDGE_RATE_RAD_PER_S: f64 = 0.1;
/// How long a nudge lasts without a renewal: a page that is lost during a nudge ends in rest.
pub const NUDGE_LASTS: Duration = Duration::from_millis(250);
/// A nudge needs a video frame that arrived within this time.
const NUDGE_NEEDS_VIDEO: Duration = Duration::from_millis(1000);

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
    /// The nudge, and when it ends.
    nudge: Option<(CameraCommand, Timestamp)>,
    last_video_at: Option<Timestamp>,
    vehicle: VehicleState,
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
    /// The initial state: disengaged, at rest, no localisation; the commands take this path.
    pub fn new(coast_motion: Duration, path: CommandPath) -> Self {
        Self {
            coast_motion,
            engagement: Engagement::Disengaged,
            last_fresh_at: None,
            hold_cause: HoldCause::NoSelection,
            command_in_force: CameraCommand::REST,
            nudge: None,
            last_video_at: None,
            vehicle: VehicleState::new(path),
        }
    }

    /// Where the commands go.
    pub const fn path(&self) -> CommandPath {
        self.vehicle.path()
    }

    /// A video frame, or another observation, arrived.
    pub fn on_video(&mut self, now: Timestamp) {
        self.last_video_at = Some(now);
    }

    /// Takes a report of the vehicle. Some end an engagement.
    pub fn on_report(&mut self, report: &Report) {
        if let Some(cause) = self.vehicle.on_report(report) {
            self.nudge = None;
            if self.engagement == Engagement::Engaged {
                self.engagement = Engagement::Stopped(cause);
            }
        }
    }

    /// Processes an operator request. A stop keeps its first cause until the next `Engage` or `Disengage`.
    ///
    /// # Errors
    /// The reason, if the request is not permitted now. It then has no effect.
    pub fn on_request(&mut self, request: &OperatorRequest, now: Timestamp) -> Result<(), Refusal> {
        match request {
            OperatorRequest::Nudge(nudge) => return self.on_nudge(*nudge, now),
            OperatorRequest::ChangeLaw(_) if self.engagement == Engagement::Engaged => {
                return Err(Refusal::Engaged);
            }
            _ => self.nudge = None,
        }
        self.engagement = match (self.engagement, request) {
            (stopped @ Engagement::Stopped(_), OperatorRequest::Stop(_)) => stopped,
            (_, OperatorRequest::Stop(cause)) => Engagement::Stopped(*cause),
            (_, OperatorRequest::Engage) => Engagement::Engaged,
            (_, OperatorRequest::Disengage) => Engagement::Disengaged,
            (unchanged, OperatorRequest::Nudge(_) | OperatorRequest::ChangeLaw(_)) => unchanged,
            (
                unchanged,
                OperatorRequest::Select(_)
                | OperatorRequest::SelectOn(_)
                | OperatorRequest::Reject
                | OperatorRequest::Deselect,
            ) => {
                // The command in force was based on another target.
                self.command_in_force = CameraCommand::REST;
                self.last_fresh_at = None;
                unchanged
            }
        };
        Ok(())
    }

    /// Starts or renews a nudge. A nudge of zero ends it.
    fn on_nudge(&mut self, nudge: Nudge, now: Timestamp) -> Result<(), Refusal> {
        match self.engagement {
            Engagement::Engaged => return Err(Refusal::Engaged),
            Engagement::Stopped(_) => return Err(Refusal::Stopped),
            Engagement::Disengaged => {}
        }
        let is_fresh = |at: Timestamp| at <= now && now.since(at) <= NUDGE_NEEDS_VIDEO;
        let command = nudge_command(nudge);
        if command.is_rest() {
            self.nudge = None;
        } else if let Some(obstacle) = self.vehicle.obstacle() {
            self.nudge = None;
            return Err(Refusal::NoMotion(obstacle));
        } else if self.last_video_at.is_some_and(is_fresh) {
            self.nudge = Some((command, now.plus(NUDGE_LASTS)));
        } else {
            self.nudge = None;
            return Err(Refusal::NoFreshVideo);
        }
        Ok(())
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
        if self.vehicle.obstacle().is_some() {
            self.nudge = None;
        }
        let mode = self.mode(now);
        self.command_in_force = match (mode, observation) {
            (Mode::Servoing, ObservationResult::Fresh(advised)) => advised,
            (Mode::Servoing, ObservationResult::Coasting(advised)) => reduced(self.command_in_force, advised),
            (Mode::Servoing, _) => self.command_in_force,
            (Mode::Nudging, _) => self.nudge.map_or(CameraCommand::REST, |(command, _)| command),
            (Mode::Idle | Mode::Holding(_) | Mode::Stopped(_), _) => CameraCommand::REST,
        };
        let wake_at = match mode {
            Mode::Servoing => self.expires_at(),
            Mode::Nudging => self.nudge.map(|(_, ends)| ends),
            Mode::Idle | Mode::Holding(_) | Mode::Stopped(_) => None,
        };
        Decision { mode, command: self.command_in_force, wake_at }
    }

    fn expires_at(&self) -> Option<Timestamp> {
        self.last_fresh_at.map(|at| at.plus(self.coast_motion))
    }

    fn mode(&self, now: Timestamp) -> Mode {
        match self.engagement {
            Engagement::Disengaged if self.is_nudged(now) => Mode::Nudging,
            Engagement::Disengaged => Mode::Idle,
            Engagement::Stopped(cause) => Mode::Stopped(cause),
            Engagement::Engaged if let Some(obstacle) = self.vehicle.obstacle() => Mode::Holding(obstacle),
            Engagement::Engaged if self.has_fresh_observation(now) => Mode::Servoing,
            Engagement::Engaged => Mode::Holding(self.hold_cause),
        }
    }

    /// Whether a nudge is in force. The current time must not lie before its renewal.
    fn is_nudged(&self, now: Timestamp) -> bool {
        self.nudge.is_some_and(|(_, ends)| now < ends && ends.since(now) <= NUDGE_LASTS)
    }

    fn has_fresh_observation(&self, now: Timestamp) -> bool {
        self.last_fresh_at.is_some_and(|at| at <= now && now < at.plus(self.coast_motion))
    }
}

/// The command of a nudge. A share that is no number is zero.
fn nudge_command(nudge: Nudge) -> CameraCommand {
    let rate = |share: f64| {
        let share = if share.is_nan() { 0.0 } else { share.clamp(-1.0, 1.0) };
        AngularRate::from_radians_per_second(share * NUDGE_RATE_RAD_PER_S)
    };
    CameraCommand { pan: rate(nudge.pan), tilt: rate(nudge.tilt) }
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
