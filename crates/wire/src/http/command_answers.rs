//! What a vehicle says to commands: refusals, which hold the camera for a while, commands without an answer,
//! and when the operator is told.

use core::time::Duration;

use barrelman_vocab::acceptance::Acceptance;
use barrelman_vocab::telemetry::Report;
use barrelman_vocab::{Telemetry, Timestamp};

/// How long a refusal of a command holds the camera, before another one is tried.
pub const REFUSAL_HOLD: Duration = Duration::from_secs(2);
/// Number of commands in a row without an answer from which on the vehicle counts as not answering.
const UNANSWERED: u32 = 2;

/// What a vehicle has said to commands.
#[derive(Debug, Clone, Default)]
pub struct CommandAnswers {
    /// The newest refusal, and until when no other command is tried.
    refused: Option<(Acceptance, Timestamp)>,
    unanswered: u32,
    reported: Option<(Acceptance, Timestamp)>,
}

impl CommandAnswers {
    /// A command was answered.
    pub const fn on_answer(&mut self) {
        self.unanswered = 0;
    }

    /// A command had no answer: from the second one in a row on, that counts as a refusal.
    pub fn on_no_answer(&mut self, now: Timestamp) {
        self.unanswered += 1;
        if self.unanswered >= UNANSWERED {
            self.refuse(Acceptance::Unanswered, now);
        }
    }

    /// A command was refused.
    pub fn refuse(&mut self, said: Acceptance, now: Timestamp) {
        self.refused = Some((said, now.plus(REFUSAL_HOLD)));
    }

    /// What was refused is no more.
    pub const fn forget_refusal(&mut self) {
        self.refused = None;
    }

    /// The newest refusal, whether it still holds the camera or not.
    pub fn refusal(&self) -> Option<Acceptance> {
        self.refused.map(|(said, _)| said)
    }

    /// The refusal that holds the camera.
    pub fn holding(&self, now: Timestamp) -> Option<Acceptance> {
        self.refused.filter(|(_, until)| now < *until).map(|(said, _)| said)
    }

    /// When the refusal that holds the camera ends.
    pub fn held_until(&self, now: Timestamp) -> Option<Timestamp> {
        self.refused.map(|(_, until)| until).filter(|until| now < *until)
    }

    /// Reports what the vehicle says: at changes, and once a second, as a report may find no room.
    pub fn report(&mut self, said: Acceptance, now: Timestamp, report: &mut dyn FnMut(Telemetry)) {
        if self.reported.is_none_or(|(before, at)| before != said || now.since(at).as_secs() >= 1) {
            self.reported = Some((said, now));
            report(Telemetry { at: now, report: Report::Acceptance(said) });
        }
    }
}
