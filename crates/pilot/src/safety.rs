//! The safety rule: the only place that decides whether the camera may move.
//!
//! 1. A stop outranks everything. After a stop, only `Engage` allows motion again; `Disengage` ends the stop
//!    in the idle mode.
//! 2. Motion requires fresh localisations. Only a fresh localisation starts or raises a rate; a coasting one
//!    can only lower it, and make the view wider.
//! 3. A rate lasts at most `coast_motion` after the arrival of the last fresh localisation; then both rates
//!    become zero. They also become zero if the current time lies before that arrival, because its age is
//!    then unknown.
//! 4. Every motion has one licence with its own time to live ([`crate::licence`]): following, as above; a
//!    nudge, a search or a calibration, at a low rate, with video throughout, and only as long as it is
//!    renewed. So is a zoom by hand, which the licence to follow permits.
//! 5. Nothing moves the camera while its vehicle takes no commands ([`VehicleState::obstacle`]). Motion
//!    begins again with the next fresh localisation; the other licences end. What the vehicle reports may end
//!    an engagement; it then takes a new `Engage`.

use core::time::Duration;

use barrelman_vocab::telemetry::Report;
use barrelman_vocab::{
    AngularRate, CameraCommand, CameraRequest, HoldCause, Nudge, StopCause, Timestamp, ZoomAbility, ZoomRate,
};

use crate::licence::{Licences, NUDGE_LASTS};
use crate::outcome::{Mode, Refusal};
use crate::purpose::Purpose;
use crate::vehicle::{CommandPath, VehicleState};

/// Rate of a nudge, rad/s, and largest rate of a search and a calibration: about 6 degrees a second.
pub const NUDGE_RATE_RAD_PER_S: f64 = 0.1;
/// Largest rate of a zoom by hand, per second: a third closer in a second.
const NUDGE_ZOOM_PER_S: f64 = 0.3;
/// A nudge, a search and a calibration need a video frame that arrived within this time, throughout.
const NEEDS_VIDEO: Duration = Duration::from_millis(300);

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

/// The safety rule with its state.
#[derive(Debug, Clone)]
pub struct Safety {
    licences: Licences,
    last_fresh_at: Option<Timestamp>,
    /// The cause to report if the camera rests for lack of fresh localisations.
    hold_cause: HoldCause,
    /// The command in force while the camera follows.
    following: CameraCommand,
    /// The command of a nudge, a search or a calibration.
    proposed: CameraCommand,
    /// The rate of a zoom by hand while the camera follows, and when it was renewed.
    zoom_by_hand: Option<(ZoomRate, Timestamp)>,
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
            licences: Licences::new(coast_motion),
            last_fresh_at: None,
            hold_cause: HoldCause::NoSelection,
            following: CameraCommand::REST,
            proposed: CameraCommand::REST,
            zoom_by_hand: None,
            last_video_at: None,
            vehicle: VehicleState::new(path),
        }
    }

    /// Where the commands go.
    pub const fn path(&self) -> CommandPath {
        self.vehicle.path()
    }

    /// Whether the vehicle's camera zooms.
    pub const fn zoom(&self) -> ZoomAbility {
        self.vehicle.zoom()
    }

    /// A video frame, or another observation, arrived.
    pub fn on_video(&mut self, now: Timestamp) {
        self.last_video_at = Some(now);
    }

    /// Takes a report of the vehicle. Some end an engagement.
    pub fn on_report(&mut self, report: &Report) {
        if let Some(cause) = self.vehicle.on_report(report) {
            match self.licences.held() {
                Some(Purpose::Follow) => self.licences.stop(cause),
                _ => self.licences.end_behaviours(),
            }
        }
    }

    /// Whether a stop is in force.
    pub fn is_stopped(&self) -> bool {
        self.licences.stop_cause().is_some()
    }

    /// Stops. A stop keeps its first cause until the next `Engage` or `Disengage`.
    pub fn stop(&mut self, cause: StopCause) {
        self.licences.stop(cause);
    }

    /// Processes a request about the camera.
    ///
    /// # Errors
    /// The reason, if the request is not permitted now. It then has no effect.
    pub fn on_request(&mut self, request: &CameraRequest, now: Timestamp) -> Result<(), Refusal> {
        match request {
            CameraRequest::Nudge(nudge) => self.on_nudge(*nudge, now)?,
            CameraRequest::Law { .. } if self.licences.held() == Some(Purpose::Follow) => {
                return Err(Refusal::Engaged);
            }
            CameraRequest::Law { .. } => self.licences.end_behaviours(),
            CameraRequest::Engage if self.vehicle.is_absent() => {
                return Err(Refusal::NoMotion(HoldCause::LinkDown));
            }
            CameraRequest::Engage => {
                self.licences.consent(Purpose::Follow, now)?;
                if let Some(seen_at) = self.last_fresh_at {
                    self.licences.renew(Purpose::Follow, seen_at);
                }
            }
            CameraRequest::Disengage => self.licences.withdraw(),
            CameraRequest::Search => self.consent(Purpose::Search, now)?,
            CameraRequest::Calibrate { .. } => self.consent(Purpose::Calibrate, now)?,
            CameraRequest::NetYaw { .. }
            | CameraRequest::Propose(_)
            | CameraRequest::Candidates { .. }
            | CameraRequest::KeepSize { .. }
            | CameraRequest::TakeCandidate { .. } => {}
            CameraRequest::Select(_)
            | CameraRequest::SelectNext(_)
            | CameraRequest::Reject
            | CameraRequest::Deselect => {
                self.licences.end_behaviours();
                // The command in force was based on another target.
                self.licences.forget_renewals();
                self.following = CameraCommand::REST;
                self.last_fresh_at = None;
            }
        }
        Ok(())
    }

    /// Starts or renews a nudge. A nudge of zero ends it. While the camera follows, it may zoom by hand.
    fn on_nudge(&mut self, nudge: Nudge, now: Timestamp) -> Result<(), Refusal> {
        let command = nudge_command(nudge);
        match (self.licences.held(), self.licences.stop_cause()) {
            (Some(Purpose::Follow), _) if !(command.pan.is_zero() && command.tilt.is_zero()) => {
                return Err(Refusal::Engaged);
            }
            (Some(Purpose::Follow), _) => {
                self.zoom_by_hand = None;
                if !command.zoom.is_zero() {
                    self.may_begin(now)?;
                    self.zoom_by_hand = Some((command.zoom, now));
                }
            }
            (_, Some(_)) => return Err(Refusal::Stopped),
            _ if command.is_rest() => self.licences.end(Purpose::Nudge),
            _ => {
                self.consent(Purpose::Nudge, now).inspect_err(|_| self.licences.end(Purpose::Nudge))?;
                self.propose(Purpose::Nudge, command, now);
            }
        }
        Ok(())
    }

    /// The operator consents to a nudge, a search or a calibration: the camera rests until a command is
    /// proposed.
    ///
    /// # Errors
    /// The reason, if the camera may not be moved for that purpose now.
    pub fn consent(&mut self, purpose: Purpose, now: Timestamp) -> Result<(), Refusal> {
        self.may_begin(now)?;
        if self.licences.held() != Some(purpose) {
            self.licences.consent(purpose, now)?;
            self.proposed = CameraCommand::REST;
        }
        Ok(())
    }

    /// Whether the vehicle takes commands, and there is video.
    fn may_begin(&self, now: Timestamp) -> Result<(), Refusal> {
        match self.vehicle.obstacle() {
            Some(obstacle) => Err(Refusal::NoMotion(obstacle)),
            None if self.has_video(now) => Ok(()),
            None => Err(Refusal::NoFreshVideo),
        }
    }

    /// Renews the licence of a purpose with its next command, which is held to the low rate; nothing happens
    /// without that licence.
    pub fn propose(&mut self, purpose: Purpose, command: CameraCommand, now: Timestamp) {
        if purpose != Purpose::Follow && self.licences.held() == Some(purpose) {
            let limit = AngularRate::from_radians_per_second(NUDGE_RATE_RAD_PER_S);
            self.proposed = CameraCommand {
                pan: command.pan.clamped(limit),
                tilt: command.tilt.clamped(limit),
                ..command
            };
            self.licences.renew(purpose, now);
        }
    }

    /// The purpose that the operator consented to.
    pub const fn held(&self) -> Option<Purpose> {
        self.licences.held()
    }

    /// The picture turns against the command: whatever moves the camera is stopped.
    pub fn on_opposed_motion(&mut self, cause: StopCause) {
        if self.licences.held().is_some() {
            self.licences.stop(cause);
        }
    }

    /// Ends a search that has found the target or has given up. The camera follows again if it did before.
    pub fn finish_search(&mut self, now: Timestamp) -> bool {
        self.licences.finish_search(now)
    }

    /// Ends a calibration that has been made.
    pub fn finish_calibration(&mut self) {
        self.licences.end(Purpose::Calibrate);
    }

    /// Decides the mode and the command of one step.
    pub fn decide(&mut self, observation: ObservationResult, now: Timestamp) -> Decision {
        match observation {
            ObservationResult::Fresh(_) => {
                self.last_fresh_at = Some(now);
                self.licences.renew(Purpose::Follow, now);
                self.hold_cause = HoldCause::VideoSilent;
            }
            ObservationResult::Coasting(_) => self.hold_cause = HoldCause::Coasting,
            ObservationResult::Unusable(cause) => self.hold_cause = cause,
            ObservationResult::NoObservation => {}
        }
        let obstacle = self.vehicle.obstacle();
        let has_lapsed = self.licences.in_force(now).is_none() || !self.has_video(now);
        if obstacle.is_some() || has_lapsed {
            self.licences.end_behaviours();
        }
        let mode = self.mode(obstacle, now);
        let command = match (mode, observation) {
            (Mode::Servoing, ObservationResult::Fresh(advised)) => advised,
            (Mode::Servoing, ObservationResult::Coasting(advised)) => reduced(self.following, advised),
            (Mode::Servoing, _) => self.following,
            (Mode::Nudging | Mode::Searching | Mode::Calibrating, _) => self.proposed,
            (Mode::Idle | Mode::Holding(_) | Mode::Stopped(_), _) => CameraCommand::REST,
        };
        let wake_at = match mode {
            Mode::Servoing => self.licences.ends_at(),
            Mode::Nudging | Mode::Searching | Mode::Calibrating => self.behaviour_ends_at(),
            Mode::Idle | Mode::Holding(_) | Mode::Stopped(_) => None,
        };
        // What is left of a nudge is no rate to follow with.
        self.following = if mode == Mode::Servoing { command } else { CameraCommand::REST };
        let (command, wake_at) = self.with_zoom_by_hand(command, wake_at, now);
        Decision { mode, command, wake_at }
    }

    /// The command with the zoom by hand while the camera follows, or waits for what to follow.
    fn with_zoom_by_hand(
        &mut self,
        command: CameraCommand,
        wake_at: Option<Timestamp>,
        now: Timestamp,
    ) -> (CameraCommand, Option<Timestamp>) {
        let is_held = |(_, since): &(ZoomRate, Timestamp)| {
            *since <= now
                && now < since.plus(NUDGE_LASTS)
                && self.licences.held() == Some(Purpose::Follow)
                && self.may_begin(now).is_ok()
        };
        self.zoom_by_hand = self.zoom_by_hand.filter(is_held);
        let Some((rate, since)) = self.zoom_by_hand else { return (command, wake_at) };
        let video_ends = self.last_video_at.map_or(now, |at| at.plus(NEEDS_VIDEO));
        let ends = since.plus(NUDGE_LASTS).min(video_ends);
        (command.zooming(rate), Some(wake_at.map_or(ends, |at| at.min(ends))))
    }

    /// What the vehicle can execute of the decided command: a rate that was taken away while the camera
    /// follows starts again with a fresh localisation only.
    pub fn on_executed(&mut self, command: CameraCommand) {
        let lower = |wanted: &mut AngularRate, executed: AngularRate| {
            if executed.abs() < wanted.abs() {
                *wanted = executed;
            }
        };
        lower(&mut self.following.pan, command.pan);
        lower(&mut self.following.tilt, command.tilt);
        if command.zoom.abs() < self.following.zoom.abs() {
            self.following.zoom = command.zoom;
        }
    }

    fn mode(&self, obstacle: Option<HoldCause>, now: Timestamp) -> Mode {
        if let Some(cause) = self.licences.stop_cause() {
            return Mode::Stopped(cause);
        }
        match (self.licences.held(), obstacle) {
            (None, _) => Mode::Idle,
            (Some(Purpose::Nudge), _) => Mode::Nudging,
            (Some(Purpose::Search), _) => Mode::Searching,
            (Some(Purpose::Calibrate), _) => Mode::Calibrating,
            (Some(Purpose::Follow), Some(obstacle)) => Mode::Holding(obstacle),
            (Some(Purpose::Follow), None) if self.licences.in_force(now).is_some() => Mode::Servoing,
            (Some(Purpose::Follow), None) => Mode::Holding(self.hold_cause),
        }
    }

    /// When a nudge, a search or a calibration ends without a renewal or without a further video frame.
    fn behaviour_ends_at(&self) -> Option<Timestamp> {
        let video_ends = self.last_video_at.map(|at| at.plus(NEEDS_VIDEO));
        let ends = self.licences.ends_at();
        ends.map(|ends| video_ends.map_or(ends, |video_ends| ends.min(video_ends)))
    }

    /// Whether the newest video frame is fresh enough for a camera that moves without following. The current
    /// time must not lie before it.
    fn has_video(&self, now: Timestamp) -> bool {
        self.last_video_at.is_some_and(|at| at <= now && now.since(at) < NEEDS_VIDEO)
    }
}

/// The command of a nudge. A share that is no number is zero.
fn nudge_command(nudge: Nudge) -> CameraCommand {
    let share = |share: f64| if share.is_nan() { 0.0 } else { share.clamp(-1.0, 1.0) };
    let rate = |wanted: f64| AngularRate::from_radians_per_second(share(wanted) * NUDGE_RATE_RAD_PER_S);
    let zoom = ZoomRate::from_per_second(share(nudge.zoom) * NUDGE_ZOOM_PER_S);
    CameraCommand::turning(rate(nudge.pan), rate(nudge.tilt)).zooming(zoom)
}

/// The command in force, with each axis limited to the advised rate. An axis with the opposite direction
/// rests. The view may become wider as advised: more of the water is seen then.
fn reduced(in_force: CameraCommand, advised: CameraCommand) -> CameraCommand {
    let smaller = |running: f64, advised: f64| {
        if running * advised <= 0.0 {
            0.0
        } else if running > 0.0 {
            running.min(advised)
        } else {
            running.max(advised)
        }
    };
    let axis = |running: AngularRate, advised: AngularRate| {
        let rate = smaller(running.radians_per_second(), advised.radians_per_second());
        AngularRate::from_radians_per_second(rate)
    };
    let zoom = match advised.zoom.per_second() {
        wider if wider < 0.0 => wider,
        closer => smaller(in_force.zoom.per_second(), closer),
    };
    CameraCommand::turning(axis(in_force.pan, advised.pan), axis(in_force.tilt, advised.tilt))
        .zooming(ZoomRate::from_per_second(zoom))
}
