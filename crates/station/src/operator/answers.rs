//! Which answer a request gets from the outcome of its step.
//!
//! A selection is answered when its track has been confirmed or given up, several steps after the request; every other
//! request is answered by the outcome of its own step.

use barrelman_pilot::{Notice, Outcome};
use barrelman_vocab::OperatorRequest;

use super::answer::{Answer, AnswerSlot};

/// The answers that are still to be given.
#[derive(Debug, Default)]
pub struct Answers {
    selection: Option<AnswerSlot>,
}

impl Answers {
    /// The pilot made the step of `request`.
    pub fn on_request_step(&mut self, request: &OperatorRequest, answer: AnswerSlot, outcome: &Outcome) {
        if let Some(Notice::RequestRefused(refusal)) = &outcome.notice {
            return answer.give(Answer::Refused(refusal.to_string()));
        }
        match request {
            OperatorRequest::SelectOn(_) => {
                self.supersede_selection("another selection was made");
                self.selection = Some(answer);
            }
            OperatorRequest::Select(_) | OperatorRequest::Reject | OperatorRequest::Deselect => {
                self.supersede_selection("the target was changed");
                answer.give(Answer::ACCEPTED);
            }
            _ => answer.give(Answer::ACCEPTED),
        }
    }

    /// The pilot made a step with another input.
    pub fn on_step(&mut self, outcome: &Outcome) {
        let Some(notice) = &outcome.notice else { return };
        let answer = match notice {
            Notice::SelectionConfirmed(_) => Answer::Accepted(Some(notice.to_string())),
            Notice::SelectionUnconfirmed(_) | Notice::SelectionRefused(_) | Notice::RequestRefused(_) => {
                Answer::Refused(notice.to_string())
            }
            _ => return,
        };
        if let Some(selection) = self.selection.take() {
            selection.give(answer);
        }
    }

    fn supersede_selection(&mut self, why: &str) {
        if let Some(earlier) = self.selection.take() {
            earlier.give(Answer::Superseded(why.to_owned()));
        }
    }
}
