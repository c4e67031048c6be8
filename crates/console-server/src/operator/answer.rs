//! The answer to a request, and where it goes.

use tokio::sync::oneshot;

/// What became of a request.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Answer {
    /// The request is in force; with a remark for the operator, if there is one.
    Accepted(Option<String>),
    /// The request has no effect, for this reason.
    Refused(String),
    /// A later request took its place.
    Superseded(String),
}

impl Answer {
    /// Accepted, without a remark.
    pub const ACCEPTED: Self = Self::Accepted(None);

    /// Refused: nothing is recorded in which a moment could be marked.
    pub fn not_recorded() -> Self {
        Self::Refused("nothing is recorded: start with `--record FILE`".to_owned())
    }
}

/// Where the answer to a request goes. Answering never waits. A slot that is dropped without an answer tells
/// its reader that the session has ended.
#[derive(Debug)]
pub struct AnswerSlot(Option<oneshot::Sender<Answer>>);

impl AnswerSlot {
    /// A slot, and the receiver of its answer.
    pub fn new() -> (Self, oneshot::Receiver<Answer>) {
        let (sender, receiver) = oneshot::channel();
        (Self(Some(sender)), receiver)
    }

    /// A slot whose refusals are logged: for requests of the terminal and of the program itself.
    pub const fn logged() -> Self {
        Self(None)
    }

    /// Gives the answer.
    pub fn give(self, answer: Answer) {
        match (self.0, answer) {
            (Some(sender), answer) => drop(sender.send(answer)),
            (None, Answer::Refused(reason)) => tracing::warn!("{reason}"),
            (None, Answer::Accepted(_) | Answer::Superseded(_)) => {}
        }
    }
}
