//! Which answer a request gets from the outcome of its step.
//!
//! A selection is answered when its track has been confirmed or given up, several steps after the request;
//! every other request is answered by the outcome of its own step.

use barrelman_pilot::{Notice, Outcome};
use barrelman_vocab::{CameraRequest, OperatorRequest};

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
            OperatorRequest::Camera(CameraRequest::Propose(_))
                if matches!(outcome.notice, Some(Notice::Proposed(_))) =>
            {
                answer.give(Answer::Accepted(outcome.notice.as_ref().map(ToString::to_string)));
            }
            // A tap that proposes nothing new has taken what was proposed.
            OperatorRequest::Camera(
                CameraRequest::Select(_) | CameraRequest::Propose(_) | CameraRequest::TakeCandidate { .. },
            ) => {
                self.supersede_selection("another selection was made");
                self.selection = Some(answer);
            }
            OperatorRequest::Camera(
                CameraRequest::SelectNext(_) | CameraRequest::Reject | CameraRequest::Deselect,
            ) => {
                self.supersede_selection("the target was changed");
                answer.give(Answer::ACCEPTED);
            }
            OperatorRequest::Camera(
                CameraRequest::Nudge(_)
                | CameraRequest::KeepSize { .. }
                | CameraRequest::Candidates { .. }
                | CameraRequest::Search
                | CameraRequest::Calibrate { .. }
                | CameraRequest::NetYaw { .. }
                | CameraRequest::Law { .. }
                | CameraRequest::Engage
                | CameraRequest::Disengage,
            )
            | OperatorRequest::Vessel(_)
            | OperatorRequest::Stop(_) => answer.give(Answer::Accepted(going(outcome))),
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

/// On which basis the boat goes.
fn going(outcome: &Outcome) -> Option<String> {
    outcome.notice.as_ref().filter(|notice| matches!(notice, Notice::Going(_))).map(ToString::to_string)
}

#[cfg(test)]
mod tests {
    use barrelman_pilot::Refusal;
    use barrelman_pilot::outcome::Unconfirmed;
    use barrelman_vision::{NoProposal, SelectionError};
    use barrelman_vocab::{DrawnSelection, LawId, Nudge, PixelBox, Tap, Timestamp};
    use tokio::sync::oneshot::{Receiver, error::TryRecvError};

    use super::*;
    use crate::test_scenes::{PICTURE, at, idle, localisation};

    const BOUNDS: PixelBox = PixelBox { u: 1.0, v: 2.0, w: 30.0, h: 40.0 };
    const SELECT_ON: OperatorRequest = OperatorRequest::Camera(CameraRequest::Select(DrawnSelection {
        bounds: BOUNDS,
        captured_ns: Timestamp::ZERO,
    }));

    fn outcome(notice: Option<Notice>) -> Outcome {
        Outcome { notice, ..idle(at(0)) }
    }

    fn request(answers: &mut Answers, request: OperatorRequest, notice: Option<Notice>) -> Receiver<Answer> {
        let (slot, receiver) = AnswerSlot::new();
        answers.on_request_step(&request, slot, &outcome(notice));
        receiver
    }

    fn refused_selection() -> Notice {
        Notice::SelectionRefused(SelectionError::Empty { selection: BOUNDS, picture: PICTURE })
    }

    #[test]
    fn a_request_is_answered_by_the_outcome_of_its_own_step() {
        for (made, notice) in [
            (OperatorRequest::Camera(CameraRequest::Engage), None),
            (OperatorRequest::Camera(CameraRequest::Disengage), None),
            (OperatorRequest::Camera(CameraRequest::Nudge(Nudge::default())), None),
            (OperatorRequest::Camera(CameraRequest::SelectNext(BOUNDS)), None),
            (
                OperatorRequest::Camera(CameraRequest::Law { law: LawId::Eco }),
                Some(Notice::LawChanged(LawId::Eco)),
            ),
            (OperatorRequest::Camera(CameraRequest::Reject), Some(Notice::TargetRejected)),
            (OperatorRequest::Camera(CameraRequest::Deselect), Some(Notice::Deselected)),
        ] {
            let mut answer = request(&mut Answers::default(), made, notice);
            assert_eq!(answer.try_recv(), Ok(Answer::ACCEPTED), "{made:?}");
        }
        for (made, refusal) in [
            (OperatorRequest::Camera(CameraRequest::Nudge(Nudge::default())), Refusal::Stopped),
            (OperatorRequest::Camera(CameraRequest::Law { law: LawId::Eco }), Refusal::Engaged),
            (OperatorRequest::Camera(CameraRequest::Reject), Refusal::NothingToReject),
            (SELECT_ON, Refusal::NoFreshVideo),
        ] {
            let mut answer = request(&mut Answers::default(), made, Some(Notice::RequestRefused(refusal)));
            assert_eq!(answer.try_recv(), Ok(Answer::Refused(refusal.to_string())), "{made:?}");
        }
    }

    #[test]
    fn a_tap_is_answered_by_its_step_if_it_proposes_and_as_a_selection_if_it_takes() {
        let tap = Tap { at: BOUNDS.centre(), captured_ns: Timestamp::ZERO, take: false };
        let tap = OperatorRequest::Camera(CameraRequest::Propose(tap));
        let proposed = Notice::Proposed(BOUNDS);
        let mut answer = request(&mut Answers::default(), tap, Some(proposed.clone()));
        assert_eq!(answer.try_recv(), Ok(Answer::Accepted(Some(proposed.to_string()))));
        let nothing = Refusal::NothingProposed(NoProposal::NothingStandsOut);
        let mut answer = request(&mut Answers::default(), tap, Some(Notice::RequestRefused(nothing)));
        assert_eq!(answer.try_recv(), Ok(Answer::Refused("nothing stands out here".to_owned())));
        let mut answers = Answers::default();
        let mut answer = request(&mut answers, tap, None);
        assert_eq!(answer.try_recv(), Err(TryRecvError::Empty), "not answered by its own step");
        let confirmed = Notice::SelectionConfirmed(localisation(at(0)));
        answers.on_step(&outcome(Some(confirmed.clone())));
        assert_eq!(answer.try_recv(), Ok(Answer::Accepted(Some(confirmed.to_string()))));
    }

    /// The answer to a selection after a later step with this notice; `None`: there is none yet.
    fn answer_after(notice: Option<Notice>) -> Option<Answer> {
        let mut answers = Answers::default();
        let mut answer = request(&mut answers, SELECT_ON, None);
        assert_eq!(answer.try_recv(), Err(TryRecvError::Empty), "not answered by its own step");
        answers.on_step(&outcome(notice));
        answer.try_recv().ok()
    }

    #[test]
    fn a_selection_is_answered_when_it_is_confirmed_or_given_up() {
        assert_eq!(answer_after(None), None);
        assert_eq!(answer_after(Some(Notice::VideoClockWentBack)), None);
        assert_eq!(answer_after(Some(Notice::LawChanged(LawId::Eco))), None);
        let confirmed = Notice::SelectionConfirmed(localisation(at(0)));
        let remark = "following the selection; confidence 0.75".to_owned();
        assert_eq!(answer_after(Some(confirmed)), Some(Answer::Accepted(Some(remark))));
        for notice in [
            Notice::SelectionUnconfirmed(Unconfirmed::Lost),
            Notice::SelectionUnconfirmed(Unconfirmed::NotSure),
            refused_selection(),
            Notice::RequestRefused(Refusal::NoFreshVideo),
        ] {
            let reason = notice.to_string();
            assert_eq!(answer_after(Some(notice)), Some(Answer::Refused(reason)));
        }
    }

    #[test]
    fn a_later_choice_of_the_target_supersedes_a_selection_that_waits() {
        let superseded_by = |made, notice| {
            let mut answers = Answers::default();
            let mut first = request(&mut answers, SELECT_ON, None);
            request(&mut answers, made, notice);
            first.try_recv().ok()
        };
        let superseded = |why: &str| Some(Answer::Superseded(why.to_owned()));
        assert_eq!(superseded_by(SELECT_ON, None), superseded("another selection was made"));
        let changed = superseded("the target was changed");
        assert_eq!(superseded_by(OperatorRequest::Camera(CameraRequest::SelectNext(BOUNDS)), None), changed);
        assert_eq!(
            superseded_by(OperatorRequest::Camera(CameraRequest::Reject), Some(Notice::TargetRejected)),
            changed
        );
        assert_eq!(
            superseded_by(OperatorRequest::Camera(CameraRequest::Deselect), Some(Notice::Deselected)),
            changed
        );
        let refused = Some(Notice::RequestRefused(Refusal::NothingToReject));
        assert_eq!(superseded_by(OperatorRequest::Camera(CameraRequest::Reject), refused), None);
        assert_eq!(superseded_by(OperatorRequest::Camera(CameraRequest::Engage), None), None);
        assert_eq!(superseded_by(OperatorRequest::Camera(CameraRequest::Disengage), None), None);
    }

    #[test]
    fn a_confirmation_answers_the_newest_selection_once() {
        let mut answers = Answers::default();
        request(&mut answers, SELECT_ON, None);
        let mut newest = request(&mut answers, SELECT_ON, None);
        let confirmed = outcome(Some(Notice::SelectionConfirmed(localisation(at(0)))));
        answers.on_step(&confirmed);
        answers.on_step(&confirmed);
        assert!(matches!(newest.try_recv(), Ok(Answer::Accepted(Some(_)))));
    }

    #[test]
    fn a_selection_that_waits_at_the_end_learns_that_the_session_has_ended() {
        let mut answers = Answers::default();
        let mut waiting = request(&mut answers, SELECT_ON, None);
        drop(answers);
        assert_eq!(waiting.try_recv(), Err(TryRecvError::Closed));
    }
}
