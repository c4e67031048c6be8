//! What the loop makes of the operator's requests.

use barrelman_console_server::operator::{Answer, SessionRequest, Submitted};
use barrelman_pilot::{Input, Notice, Outcome, Refusal};
use barrelman_vocab::{CameraRequest, HoldCause, Note, NoteRequest, OperatorRequest, VesselRequest};

use super::{LoopState, RunLoop};

impl RunLoop<'_> {
    /// Takes a pressed stop, and all requests that wait. A stop that is pressed meanwhile comes before the
    /// next request.
    pub(super) fn take_requests(&mut self, state: &mut LoopState) {
        let now = self.events.now();
        self.publisher.set_console_lost(self.gateway.is_console_lost(), now);
        let stop = state.vessel_mode.and_then(|mode| self.gateway.stop_for_left_vessel(mode, now));
        if let Some(request) = stop {
            self.step(state, Input::Request(request));
        }
        loop {
            self.take_stop(state);
            let Some(Submitted { request, answer }) = self.gateway.next_request() else { break };
            match request {
                SessionRequest::Pilot(request) => {
                    let outcome = self.step(state, Input::Request(request));
                    self.take_control_back(request, &outcome);
                    state.answers.on_request_step(&request, answer, &outcome);
                }
                SessionRequest::World(request) => answer.give(self.world_answer(state, &request)),
                SessionRequest::Video(request) => answer.give(self.video_answer(state, request)),
                SessionRequest::Note(NoteRequest::Note(note)) => answer.give(self.note_answer(&note)),
            }
        }
    }

    /// Records a marked moment.
    fn note_answer(&mut self, note: &Note) -> Answer {
        let now = self.events.now();
        let Some(recorder) = &mut self.recorder else { return Answer::not_recorded() };
        recorder.on_note(now, note);
        self.publisher.events().add_note(now, note);
        Answer::ACCEPTED
    }

    /// With Engage, the operator takes the control back that another client has. An engagement that the start
    /// of the run asks for does not: who has the control is not known then, and the link takes the control by
    /// itself where it is free.
    fn take_control_back(&self, request: OperatorRequest, outcome: &Outcome) {
        // A boat that another program or a person steers refuses the request, and is asked for: the next one
        // may succeed.
        let asks_for_vessel = matches!(
            (request, &outcome.notice),
            (
                OperatorRequest::Vessel(VesselRequest::Guide | VesselRequest::GoHome),
                Some(Notice::RequestRefused(
                    Refusal::NoVesselMotion(HoldCause::NoControl) | Refusal::NotAccepted(_)
                ))
            )
        );
        if let (true, Some(boat)) = (asks_for_vessel, self.boat) {
            boat.take_control();
        }
        let is_refused = matches!(outcome.notice, Some(Notice::RequestRefused(_)));
        if let (OperatorRequest::Camera(CameraRequest::Engage), false, Some(link)) =
            (request, is_refused, self.link)
        {
            link.take_control();
        }
    }
}
