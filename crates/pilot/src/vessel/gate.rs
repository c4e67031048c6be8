//! The vessel's safety rule: the only place that decides whether the boat may be commanded.
//!
//! ```text
//!               steer                           let go, or not renewed within 0.5 s
//!   Released ----------> ByHand ----------------------------------------> Neutral
//!       |  \                ^  \__ guide __                                 ^
//!       |   \ guide         |  steer       \                                |
//!       |    \-----------> Guided <---------+---------- guide --------------+
//!       |                   |  ^
//!       |   nothing fresh   v  |  fresh again within 5 s
//!       |        Holding or KeepingWay -- 5 s -> Stopped
//!       |        Guided or Holding -- no answer of the boat -> Stopped
//!       |
//!       +-- stop boat, Stop, console lost: from every mode but Released -> Stopped -- guide, or let go and steer -->
//! ```
//!
//! 1. A stop outranks everything. After a stop, a helm that is still held does nothing until it was let go,
//!    also one that was without effect at the stop (for want of video or of a link); guidance takes another
//!    request. The same holds after a time in which the boat took no commands: disarmed, in another mode,
//!    restarted, or without a link. Who arms a boat stands beside it.
//! 2. Guidance starts with fresh video only, and moves the boat only while fresh localisations of the boat
//!    arrive. The last command lasts at most [`GUIDED_LASTS`] after the last one, then the boat is neutral. A
//!    hold of more than [`HOLD_LASTS`] ends the guidance. So does a boat that does not answer
//!    ([`VesselStop::NoAnswer`]): the wrong object may be followed.
//! 3. A helm that is held lasts [`STEERED_LASTS`] after its last renewal, and needs fresh video: the operator
//!    steers by the picture. It needs no track: a boat that is lost to the tracker must not be lost to the
//!    operator.
//! 4. Nothing commands the boat while its link takes no commands. A vessel whose profile says so keeps way
//!    for a while instead ([`VesselMode::KeepingWay`]): ahead with the rudder amidships, at no more than the
//!    throttle that was in force. That holds for a guidance that does not see the boat any more (track lost
//!    or coasting, video late or silent), and only where the boat went ahead far enough from all marks
//!    ([`VesselGate::set_clear`]). Each request of the operator, each stop and each obstacle ends it; it does
//!    not begin again.
//! 5. The throttle grows by at most the profile's rate; less throttle takes effect at once.

use core::time::Duration;

use barrelman_vocab::acceptance::Acceptance;
use barrelman_vocab::drive_mode::DriveMode;
use barrelman_vocab::telemetry::{LinkState, Report};
use barrelman_vocab::{FailSafe, HoldCause, KeepWay, Timestamp, VesselCommand, VesselProfile};

use crate::vehicle::{CommandPath, VehicleState};

mod mode;
mod requests;

pub use super::said::Said;
pub use mode::{VesselHold, VesselMode, VesselStop};

/// How long a command of the guidance lasts after the last fresh localisation of the boat.
pub const GUIDED_LASTS: Duration = Duration::from_millis(250);
/// How long a helm lasts after its last renewal.
pub const STEERED_LASTS: Duration = Duration::from_millis(500);
/// How long the guidance may wait for the boat before it ends.
pub const HOLD_LASTS: Duration = Duration::from_secs(5);
/// A helm, and the start of the guidance, need a video frame that arrived within this time.
const NEEDS_VIDEO: Duration = Duration::from_millis(250);
/// Longest time for which the throttle grows in one step.
const LONGEST_RISE: Duration = Duration::from_millis(200);

/// What one step saw of the boat.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum GateInput {
    /// A fresh localisation, with what the guidance advises.
    Fresh(Result<VesselCommand, VesselHold>),
    /// An observation without a fresh localisation.
    Unusable(HoldCause),
    /// No observation.
    NoObservation,
}

#[derive(Debug, Clone, Copy, PartialEq)]
enum Holder {
    Released,
    Neutral,
    ByHand { wanted: VesselCommand, renewed_at: Timestamp },
    Guided { advised: VesselCommand, fresh_at: Option<Timestamp>, holding: Option<Hold> },
    Stopped { cause: VesselStop },
}

/// A wait for the boat.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Hold {
    cause: VesselHold,
    since: Timestamp,
    /// The way that is kept meanwhile.
    way: Option<Way>,
}

/// Way that is kept since the hold began.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Way {
    throttle: f64,
    until: Timestamp,
}

/// The helm at the page, whether or not the boat obeys it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Helm {
    /// Let go.
    Free,
    /// Held: a command that is not neutral was the last one.
    Held,
    /// Held through a stop, or while the boat took no commands: without effect until it is let go.
    Barred,
}

/// The rule with its state.
#[derive(Debug, Clone)]
pub struct VesselGate {
    profile: VesselProfile,
    holder: Holder,
    helm: Helm,
    vessel: VehicleState,
    /// What the boat says to commands, and its mode.
    said: Option<Said>,
    mode: Option<DriveMode>,
    last_video_at: Option<Timestamp>,
    /// Whether the boat went ahead at the last fresh localisation with room to keep way.
    is_clear: bool,
    command: VesselCommand,
    last_step: Option<Timestamp>,
}

/// The decision of one step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct VesselDecision {
    /// The mode from this step on.
    pub mode: VesselMode,
    /// The command in force from this step on.
    pub command: VesselCommand,
    /// Latest time of the next step; `None` if no deadline is pending.
    pub renew_by: Option<Timestamp>,
}

impl VesselGate {
    /// A gate for this vessel, which is not commanded yet; commands take this path.
    pub const fn new(profile: VesselProfile, path: CommandPath) -> Self {
        Self {
            profile,
            holder: Holder::Released,
            helm: Helm::Free,
            vessel: VehicleState::new(path),
            said: None,
            mode: None,
            last_video_at: None,
            is_clear: false,
            command: VesselCommand::NEUTRAL,
            last_step: None,
        }
    }

    /// A video frame arrived.
    pub const fn on_video(&mut self, now: Timestamp) {
        self.last_video_at = Some(now);
    }

    /// Whether the boat has room to keep way, as of the newest fresh localisation. Without room, no way is
    /// kept from now on.
    pub const fn set_clear(&mut self, is_clear: bool) {
        self.is_clear = is_clear;
        if let (false, Holder::Guided { holding: Some(hold), .. }) = (is_clear, &mut self.holder) {
            hold.way = None;
        }
    }

    /// Takes a report of the vessel or its link. Some stop the boat: a boat that somebody else steers, and
    /// one that goes by itself and takes no commands any more, wait for another request, whether or not the
    /// link was up meanwhile.
    pub fn on_report(&mut self, report: &Report) {
        if self.vessel.path() != CommandPath::Link {
            return;
        }
        match *report {
            Report::DriveMode(mode) => self.mode = Some(mode),
            Report::Acceptance(acceptance) => {
                let said = Said { acceptance, mode: self.mode };
                self.said = Some(said);
                if acceptance.is_elsewhere() || (self.is_guiding() && acceptance != Acceptance::Accepted) {
                    self.stop(VesselStop::NotAccepted(said));
                }
            }
            Report::Link(LinkState::Up) => {}
            Report::Link(_) => (self.said, self.mode) = (None, None),
            _ => {}
        }
        if let Some(cause) = self.vessel.on_report(report) {
            self.stop(VesselStop::Vessel(cause));
        }
        if self.vessel.obstacle().is_some() {
            self.bar_helm();
            if matches!(self.holder, Holder::ByHand { .. }) {
                self.holder = Holder::Neutral;
            }
        }
    }

    /// Whether the boat goes by itself, or waits to.
    pub const fn is_guiding(&self) -> bool {
        matches!(self.holder, Holder::Guided { .. })
    }

    /// Whether nothing but this program steers the boat: it is steered by hand or by guidance or is kept
    /// neutral, and its link takes commands.
    pub fn is_commanding(&self) -> bool {
        let is_held = matches!(self.holder, Holder::Neutral | Holder::ByHand { .. } | Holder::Guided { .. });
        is_held && self.vessel.obstacle().is_none()
    }

    /// Stops the boat. A boat that this program does not command is left alone. The first cause counts. A
    /// helm that is held now, also one that the boat does not obey, does nothing until it was let go.
    pub const fn stop(&mut self, cause: VesselStop) {
        self.bar_helm();
        if !matches!(self.holder, Holder::Released | Holder::Stopped { .. }) {
            self.holder = Holder::Stopped { cause };
        }
    }

    /// Whether [`Self::stop`] would change nothing.
    pub fn is_at_rest_by_stop(&self) -> bool {
        matches!(self.holder, Holder::Released | Holder::Stopped { .. }) && self.helm != Helm::Held
    }

    const fn bar_helm(&mut self) {
        if matches!(self.helm, Helm::Held) {
            self.helm = Helm::Barred;
        }
    }

    fn has_video(&self, now: Timestamp) -> bool {
        self.last_video_at.is_some_and(|at| at <= now && now.since(at) < NEEDS_VIDEO)
    }

    /// Decides the mode and the command of one step.
    pub fn decide(&mut self, sight: GateInput, now: Timestamp) -> VesselDecision {
        let obstacle = self.vessel.obstacle();
        self.advance(sight, obstacle, now);
        let (mode, wanted) = match self.holder {
            Holder::Released => (VesselMode::Released, VesselCommand::NEUTRAL),
            Holder::Neutral => (VesselMode::Neutral, VesselCommand::NEUTRAL),
            Holder::ByHand { wanted, .. } => (VesselMode::ByHand, wanted),
            Holder::Guided { holding: Some(Hold { cause, way: Some(way), .. }), .. } => {
                let ahead = VesselCommand { throttle: way.throttle, rudder: 0.0 };
                (VesselMode::KeepingWay(cause), ahead)
            }
            Holder::Guided { holding: Some(Hold { cause, way: None, .. }), .. } => {
                (VesselMode::Holding(cause), VesselCommand::NEUTRAL)
            }
            Holder::Guided { advised, holding: None, .. } => (VesselMode::Guided, advised),
            Holder::Stopped { cause } => (VesselMode::Stopped(cause), VesselCommand::NEUTRAL),
        };
        let limits =
            if mode == VesselMode::ByHand { self.profile.hand_limits() } else { self.profile.limits };
        let command = self.risen(limits.applied_to(wanted), now);
        self.command = command;
        VesselDecision { mode, command, renew_by: self.renew_by(now) }
    }

    /// What time, sight and link make of the state.
    fn advance(&mut self, sight: GateInput, obstacle: Option<HoldCause>, now: Timestamp) {
        let ends_at = self.ends_at();
        let has_ended = ends_at.is_some_and(|at| at <= now) || self.is_before_renewal(now);
        let has_video = self.has_video(now);
        let is_clock_right = !self.is_before_renewal(now);
        if let Some(hold) = self.held_too_long(now) {
            self.stop(VesselStop::HeldTooLong(hold));
        }
        let (command, fail_safe, is_clear) = (self.command, self.profile.fail_safe, self.is_clear);
        match &mut self.holder {
            Holder::Released | Holder::Neutral | Holder::Stopped { .. } => {}
            Holder::ByHand { .. } => {
                if has_ended || obstacle.is_some() || !has_video {
                    self.holder = Holder::Neutral;
                }
            }
            Holder::Guided { advised, fresh_at, holding } => {
                let hold = match (obstacle, sight) {
                    (Some(obstacle), _) => Some(VesselHold::Cause(obstacle)),
                    (None, GateInput::Fresh(Ok(command))) => {
                        (*advised, *fresh_at, *holding) = (command, Some(now), None);
                        None
                    }
                    (None, GateInput::Fresh(Err(hold))) => Some(hold),
                    (None, GateInput::Unusable(cause)) if has_ended || holding.is_some() => {
                        Some(VesselHold::Cause(cause))
                    }
                    (None, _) if has_ended => Some(VesselHold::Cause(HoldCause::VideoSilent)),
                    (None, _) => None,
                };
                if let Some(cause) = hold {
                    // A pilot that was held up has waited since the command ended.
                    let ended_at = ends_at.filter(|at| *at <= now).unwrap_or(now);
                    let (since, way) = match *holding {
                        Some(Hold { since, way, .. }) => (since, way),
                        None => (ended_at, way_of(fail_safe, command, ended_at).filter(|_| is_clear)),
                    };
                    let way = way.filter(|_| is_clock_right && keeps_way(cause));
                    (*advised, *fresh_at, *holding) =
                        (VesselCommand::NEUTRAL, None, Some(Hold { cause, since, way }));
                }
                if let Some(hold) = holding {
                    hold.way = hold.way.filter(|way| hold.since <= now && now < way.until);
                }
            }
        }
    }

    /// Why the guidance has waited for too long; `None`: it has not. A pilot that was held up counts as one
    /// that waited. A destination is the operator's to give: that may take longer.
    fn held_too_long(&self, now: Timestamp) -> Option<VesselHold> {
        let (hold, since) = match self.holder {
            Holder::Guided { holding: Some(Hold { cause, since, .. }), .. } => (cause, since),
            Holder::Guided { fresh_at: Some(fresh_at), .. } => {
                (VesselHold::Cause(HoldCause::VideoSilent), fresh_at.plus(GUIDED_LASTS))
            }
            _ => return None,
        };
        (hold != VesselHold::NoDestination && since <= now && now.since(since) >= HOLD_LASTS).then_some(hold)
    }

    /// A time before the last renewal: the age of the command is not known.
    fn is_before_renewal(&self, now: Timestamp) -> bool {
        match self.holder {
            Holder::ByHand { renewed_at, .. } => now < renewed_at,
            Holder::Guided { fresh_at: Some(fresh_at), .. } => now < fresh_at,
            _ => false,
        }
    }

    /// When the command in force, or the wait for the boat, ends without renewal.
    fn ends_at(&self) -> Option<Timestamp> {
        match self.holder {
            Holder::ByHand { renewed_at, .. } => {
                let steered_until = renewed_at.plus(STEERED_LASTS);
                Some(self.last_video_at.map_or(steered_until, |at| steered_until.min(at.plus(NEEDS_VIDEO))))
            }
            Holder::Guided { holding: Some(Hold { cause: VesselHold::NoDestination, .. }), .. } => None,
            Holder::Guided { holding: Some(Hold { since, .. }), .. } => Some(since.plus(HOLD_LASTS)),
            Holder::Guided { fresh_at, .. } => fresh_at.map(|at| at.plus(GUIDED_LASTS)),
            Holder::Released | Holder::Neutral | Holder::Stopped { .. } => None,
        }
    }

    /// Latest time of the next step. Way that is kept is renewed as often as a command of the guidance: a
    /// pilot that hangs keeps none.
    fn renew_by(&self, now: Timestamp) -> Option<Timestamp> {
        match self.holder {
            Holder::Guided { holding: Some(Hold { way: Some(way), .. }), .. } => {
                Some(way.until.min(now.plus(GUIDED_LASTS)))
            }
            _ => self.ends_at(),
        }
    }

    /// The command with a throttle that grows slowly enough.
    fn risen(&mut self, wanted: VesselCommand, now: Timestamp) -> VesselCommand {
        let since = self.last_step.replace(now).map_or(Duration::ZERO, |last| now.since(last));
        let rise = self.profile.throttle_rise_per_s * since.min(LONGEST_RISE).as_secs_f64();
        let (before, throttle) = (self.command.throttle, wanted.throttle);
        let from = if before * throttle > 0.0 { before.abs() } else { 0.0 };
        VesselCommand { throttle: throttle.abs().min(from + rise).copysign(throttle), ..wanted }.clamped()
    }
}

/// The way that a vessel with this fail-safe keeps from `since` on: none where it did not go ahead.
fn way_of(fail_safe: FailSafe, command: VesselCommand, since: Timestamp) -> Option<Way> {
    let FailSafe::KeepWay(keep) = fail_safe else { return None };
    let throttle = keep.throttle.min(KeepWay::MAX_THROTTLE).min(command.throttle);
    (throttle > 0.0).then(|| Way { throttle, until: since.plus(keep.lasts.min(KeepWay::MAX_LASTS)) })
}

/// Whether way may be kept for want of this.
const fn keeps_way(cause: VesselHold) -> bool {
    matches!(
        cause,
        VesselHold::Cause(
            HoldCause::TrackLost | HoldCause::Coasting | HoldCause::VideoStale | HoldCause::VideoSilent
        )
    )
}

#[cfg(test)]
mod tests;
