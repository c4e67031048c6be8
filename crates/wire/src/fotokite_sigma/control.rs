//! Who has the control: asked for, kept, yielded.
//!
//! ```text
//!            201                          202, or a command refused with 403
//!   Asking -------> Ours (asked again every 3 s) -------------------> Elsewhere
//!     |  ^           |                                                    |
//!     |  |           | 9 s without a renewal                              |
//!     |  +-----------+                                                    |
//!     |  202                       201                                    |
//!     +-------> Queued (every 3 s) -----> Ours                            |
//!     ^                                                                   |
//!     +------------------------- take_control() --------------------------+
//! ```
//!
//! The control lapses after 10 s. Another client's control is never overridden, and never asked for again
//! unless the operator wants it: the wish that a renewal left in the vehicle's queue is withdrawn.

use core::time::Duration;

use barrelman_vocab::Timestamp;
use barrelman_vocab::acceptance::Acceptance;

use super::call::Call;

/// Interval at which the control is asked for again.
pub const RENEWAL: Duration = Duration::from_secs(3);
/// A control that was not renewed for this time counts as lapsed, a second before the vehicle's own 10 s.
pub const LAPSES_AFTER: Duration = Duration::from_secs(9);
/// Pause after a request for the control that was not answered as hoped.
pub const RETRY: Duration = Duration::from_secs(1);

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum State {
    Asking { at: Timestamp },
    Queued { at: Timestamp },
    Ours { granted: Timestamp, at: Timestamp },
    Elsewhere { withdraws: bool },
}

/// Who has the control.
#[derive(Debug, Clone)]
pub struct Control {
    state: State,
    /// Why a request for it was refused.
    refused: Option<Acceptance>,
    /// Whether the vehicle has said who has it.
    is_known: bool,
}

impl Control {
    /// The control is asked for at once.
    pub const fn asked_for(now: Timestamp) -> Self {
        Self { state: State::Asking { at: now }, refused: None, is_known: false }
    }

    /// A second client had it in the session before, and the operator has not taken it back: a wish for it
    /// that was left in the vehicle's queue is withdrawn.
    pub const fn left_to_another() -> Self {
        Self { state: State::Elsewhere { withdraws: true }, refused: None, is_known: true }
    }

    /// Whether another client has taken it.
    pub const fn is_anothers(&self) -> bool {
        matches!(self.state, State::Elsewhere { .. })
    }

    /// Whether it is ours.
    pub const fn is_ours(&self) -> bool {
        matches!(self.state, State::Ours { .. })
    }

    /// Whether there is something to give up: the control, or the wish for it.
    pub const fn has_claim(&self) -> bool {
        matches!(self.state, State::Ours { .. } | State::Queued { .. })
    }

    /// Whether the vehicle has said who has it.
    pub const fn is_known(&self) -> bool {
        self.is_known
    }

    /// The operator wants the control back.
    pub fn take(&mut self, now: Timestamp) {
        if let State::Elsewhere { .. } = self.state {
            self.state = State::Asking { at: now };
        }
    }

    /// Another client has taken the control.
    pub fn lose(&mut self) {
        if self.is_ours() {
            self.state = State::Elsewhere { withdraws: false };
        }
    }

    /// The call that is due.
    pub fn due(&mut self, now: Timestamp) -> Option<Call> {
        match self.state {
            State::Asking { at } | State::Queued { at } | State::Ours { at, .. } => {
                (at <= now).then_some(Call::RequestControl)
            }
            State::Elsewhere { withdraws: true } => {
                self.state = State::Elsewhere { withdraws: false };
                Some(Call::ReleaseControl)
            }
            State::Elsewhere { withdraws: false } => None,
        }
    }

    /// The vehicle has answered a request for the control, or not. Returns whether the control is newly ours.
    pub fn on_answer(&mut self, status: Option<u16>, now: Timestamp) -> bool {
        let was_ours = self.is_ours();
        self.refused = status.and_then(refusal);
        match (status, self.state) {
            // Asked before the control was lost: only the wish is withdrawn.
            (Some(201 | 202), State::Elsewhere { .. }) => self.state = State::Elsewhere { withdraws: true },
            (Some(201), _) => {
                self.is_known = true;
                self.state = State::Ours { granted: now, at: now.plus(RENEWAL) };
            }
            (Some(202), State::Ours { .. }) => self.state = State::Elsewhere { withdraws: true },
            (Some(202), _) => {
                self.is_known = true;
                self.state = State::Queued { at: now.plus(RENEWAL) };
            }
            (_, State::Ours { granted, .. }) => {
                self.state = if now.since(granted) >= LAPSES_AFTER {
                    State::Asking { at: now.plus(RETRY) }
                } else {
                    State::Ours { granted, at: now.plus(RETRY) }
                };
            }
            (_, State::Asking { .. }) => {
                self.is_known |= status.is_some();
                self.state = State::Asking { at: now.plus(RETRY) };
            }
            (_, State::Queued { .. }) => self.state = State::Queued { at: now.plus(RETRY) },
            (_, State::Elsewhere { .. }) => {}
        }
        self.is_ours() && !was_ours
    }

    /// Why commands are not accepted; `None`: the control is ours.
    pub fn obstacle(&self) -> Option<Acceptance> {
        match self.state {
            State::Ours { .. } => None,
            State::Queued { .. } => Some(Acceptance::Queued),
            State::Elsewhere { .. } => Some(Acceptance::OtherClient),
            State::Asking { .. } => Some(self.refused.unwrap_or(Acceptance::Unanswered)),
        }
    }

    /// When the next call is due.
    pub fn wake_at(&self) -> Option<Timestamp> {
        match self.state {
            State::Asking { at } | State::Queued { at } | State::Ours { at, .. } => Some(at),
            State::Elsewhere { .. } => None,
        }
    }
}

/// Why a request was refused, by the status of its answer; `None`: it was not.
pub const fn refusal(status: u16) -> Option<Acceptance> {
    Some(match status {
        200..=299 => return None,
        401 | 403 => Acceptance::TokenRefused,
        404 => Acceptance::NoCamera,
        409 => Acceptance::FlightState,
        503 => Acceptance::NotReady,
        400..=499 => Acceptance::Unusable,
        _ => Acceptance::Fault,
    })
}
