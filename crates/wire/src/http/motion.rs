//! When commands to turn are sent, and when zeros.
//!
//! ```text
//!             speeds wanted                      rest wanted, or no control
//!   Resting ----------------> Turning  --------------------------> Stopping
//!      ^                      (renewed)                               |  zeros every 0.1 s
//!      +--------------------------------------------------------------+
//!          at least 3 zeros, and the camera's state shows rest; or 12 zeros
//! ```
//!
//! A command ends by itself, and is renewed long before: one that is lost leaves the camera turning. At most
//! one command to turn is under way; the newest speeds wait for its answer, never a queue. Zeros do not wait:
//! they have a lane of their own, and take the other one where theirs hangs.

use core::time::Duration;

use barrelman_vocab::Timestamp;

use super::lanes::Lanes;
use super::request::{HttpCall, Lane};
use crate::session::RestEvidence;

/// Least interval between commands with different speeds: that of the video frames.
pub const SPACING: Duration = Duration::from_millis(30);
/// Interval between zeros.
pub const ZERO_SPACING: Duration = Duration::from_millis(100);
/// Least number of zeros.
pub const LEAST_ZEROS: u32 = 3;
/// Number of zeros where the camera's state does not show rest.
pub const MAX_ZEROS: u32 = 12;

/// The speeds of a camera's axes, as its protocol states them.
pub trait Speeds: Copy + PartialEq {
    /// No motion.
    const REST: Self;
    /// Interval at which a command to turn is renewed.
    const RENEWAL: Duration;

    /// Whether all are zero.
    fn is_rest(self) -> bool {
        self == Self::REST
    }
}

/// What is sent of the speeds.
#[derive(Debug, Clone, Copy, PartialEq)]
enum State<S> {
    Resting,
    Turning { sent: S, at: Timestamp },
    Stopping { zeros: u32, next_at: Timestamp, since: Timestamp },
}

/// The commands that are due.
#[derive(Debug, Clone)]
pub struct Motion<S> {
    state: State<S>,
    wanted: S,
    /// Whether a command to turn was not answered, and may be carried out late.
    has_unanswered: bool,
}

/// What of the session the motion depends on.
#[derive(Debug, Clone, Copy)]
pub struct Surroundings {
    /// Whether the lane of the zeros is free.
    pub is_stop_free: bool,
    /// Whether the lane of the commands to turn is free.
    pub is_turn_free: bool,
    /// Whether the camera's state shows rest.
    pub is_at_rest: bool,
}

impl Surroundings {
    /// Those of a session with these lanes and this evidence of rest.
    pub fn of<C: HttpCall>(lanes: &Lanes<C>, evidence: RestEvidence) -> Self {
        Self {
            is_stop_free: lanes.is_free(Lane::Stop),
            is_turn_free: lanes.is_free(Lane::Turn),
            is_at_rest: evidence == RestEvidence::AtRest,
        }
    }
}

impl<S: Speeds> Default for Motion<S> {
    fn default() -> Self {
        Self { state: State::Resting, wanted: S::REST, has_unanswered: false }
    }
}

impl<S: Speeds> Motion<S> {
    /// Sets the speeds that are wanted from now on.
    pub fn want(&mut self, speeds: S) {
        self.wanted = speeds;
    }

    /// Begins with zeros: what turns the camera is not known.
    pub fn stop(&mut self, now: Timestamp) {
        self.state = State::Stopping { zeros: 0, next_at: now, since: now };
    }

    /// Sends nothing more: another client has the control.
    pub fn yield_control(&mut self) {
        *self = Self::default();
    }

    /// Whether zeros are being sent, and since when.
    pub fn stopping_since(&self) -> Option<Timestamp> {
        match self.state {
            State::Stopping { since, .. } => Some(since),
            State::Resting | State::Turning { .. } => None,
        }
    }

    /// Whether nothing is being sent.
    pub fn is_resting(&self) -> bool {
        self.state == State::Resting
    }

    /// Whether the camera is being turned.
    pub fn is_turning(&self) -> bool {
        matches!(self.state, State::Turning { .. })
    }

    /// A command to turn has been answered, or not. Zeros that were sent before may have come too early, and
    /// begin anew.
    pub fn on_turn_answer(&mut self, is_answered: bool, now: Timestamp) {
        self.has_unanswered = !is_answered;
        if let State::Stopping { since, .. } = self.state {
            self.state = State::Stopping { zeros: 0, next_at: now, since };
        }
    }

    /// The camera turns. Without a wish to turn, a command that was not answered has been carried out late;
    /// and one that does more than to sway with its kite gets zeros as long as it does.
    pub fn on_unexpected_motion(&mut self, turns: bool, now: Timestamp) {
        if self.is_resting() && (turns || self.has_unanswered) {
            self.stop(now);
        }
    }

    /// The command that is due, and its lane.
    pub fn due(&mut self, around: Surroundings, now: Timestamp) -> Option<(Lane, S)> {
        match self.state {
            State::Resting if self.wanted.is_rest() => None,
            State::Turning { .. } if self.wanted.is_rest() => {
                self.stop(now);
                self.due(around, now)
            }
            State::Turning { sent, at } => {
                let spacing = if sent == self.wanted { S::RENEWAL } else { SPACING };
                (now.since(at) >= spacing).then_some(())?;
                self.turn(around, now)
            }
            // A zero that is under way must not end a motion that begins after it, and one zero comes before
            // any motion.
            State::Stopping { zeros: 1.., .. } | State::Resting if !self.wanted.is_rest() => {
                around.is_stop_free.then_some(())?;
                self.turn(around, now)
            }
            State::Resting => None,
            State::Stopping { zeros, next_at, since } => {
                let is_enough = zeros >= MAX_ZEROS || (zeros >= LEAST_ZEROS && around.is_at_rest);
                if is_enough && around.is_turn_free && around.is_stop_free {
                    self.state = State::Resting;
                    return None;
                }
                if now < next_at || zeros >= MAX_ZEROS {
                    return None;
                }
                let lane = match (around.is_stop_free, around.is_turn_free) {
                    (true, _) => Lane::Stop,
                    (false, true) => Lane::Turn,
                    (false, false) => return None,
                };
                let next_at = now.plus(ZERO_SPACING);
                self.state = State::Stopping { zeros: zeros + 1, next_at, since };
                Some((lane, S::REST))
            }
        }
    }

    fn turn(&mut self, around: Surroundings, now: Timestamp) -> Option<(Lane, S)> {
        around.is_turn_free.then_some(())?;
        self.state = State::Turning { sent: self.wanted, at: now };
        Some((Lane::Turn, self.wanted))
    }

    /// When the next command may be due.
    pub fn wake_at(&self) -> Option<Timestamp> {
        match self.state {
            State::Resting => None,
            State::Turning { sent, at } if sent == self.wanted => Some(at.plus(S::RENEWAL)),
            State::Turning { at, .. } => Some(at.plus(SPACING)),
            State::Stopping { next_at, .. } => Some(next_at),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{Motion, Speeds as _, Surroundings, Timestamp};
    use crate::fotokite_sigma::speeds::Speeds;

    /// Zeros that are sent within five seconds to a camera that turns, or rests, while zero is wanted.
    fn zeros(turns: bool) -> usize {
        let mut motion: Motion<Speeds> = Motion::default();
        let around = Surroundings { is_stop_free: true, is_turn_free: true, is_at_rest: false };
        let mut sent = 0;
        for ms in (0..5_000).step_by(10) {
            let now = Timestamp::from_nanos(ms * 1_000_000);
            if ms % 100 == 0 {
                motion.on_unexpected_motion(turns, now);
            }
            sent += usize::from(motion.due(around, now).is_some_and(|(_, speeds)| speeds.is_rest()));
        }
        sent
    }

    #[test]
    fn zeros_go_on_while_the_camera_turns_unasked() {
        assert!(zeros(true) >= 45, "{}", zeros(true));
        assert_eq!(zeros(false), 0, "a camera that only sways is left alone");
    }
}
