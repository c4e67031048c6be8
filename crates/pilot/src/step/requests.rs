//! What the operator's requests do.

use barrelman_control::LawSettings;
use barrelman_vocab::{Angle, CameraRequest, LawId, OperatorRequest, Timestamp, Track};

use super::Pilot;
use crate::calibration::Calibration;
use crate::outcome::{Notice, Refusal};
use crate::selecting::PendingSelection;
use crate::verification::Verification;

impl Pilot {
    /// Processes a request. Returns what the operator has to know.
    pub(super) fn on_request(&mut self, request: &OperatorRequest, now: Timestamp) -> Option<Notice> {
        match request {
            OperatorRequest::Stop(cause) => {
                self.safety.stop(*cause);
                if let Some(vessel) = &mut self.vessel {
                    vessel.stop(*cause);
                }
                None
            }
            OperatorRequest::Camera(request) => self.on_camera_request(request, now),
            OperatorRequest::Vessel(request) => self.on_vessel_request(request, now),
        }
    }

    /// Processes a request about the camera. Returns what the operator has to know.
    pub(super) fn on_camera_request(&mut self, request: &CameraRequest, now: Timestamp) -> Option<Notice> {
        if *request == CameraRequest::Reject && !self.tracker.reject() {
            return Some(Notice::RequestRefused(Refusal::NothingToReject));
        }
        let refusal = self.refusal(request, now);
        if let Some(refusal) = refusal.or_else(|| self.safety.on_request(request, now).err()) {
            return Some(Notice::RequestRefused(refusal));
        }
        match request {
            CameraRequest::SelectNext(selection) => {
                self.begin_selection();
                self.pending_selection = Some(*selection);
                None
            }
            CameraRequest::Select(selection) => {
                self.begin_selection();
                self.drawn_selection = Some(PendingSelection::new(*selection));
                None
            }
            CameraRequest::Reject => {
                self.end_target(Track::Lost { since: self.last_capture.unwrap_or(now), confidence: 0.0 });
                Some(Notice::TargetRejected)
            }
            CameraRequest::Deselect => {
                self.tracker.forget();
                self.end_target(Track::Unseeded);
                Some(Notice::Deselected)
            }
            CameraRequest::Nudge(nudge) => self.on_nudge(*nudge),
            CameraRequest::KeepSize { keep } => self.keep_size(*keep),
            CameraRequest::Law { law } => {
                self.change_law(*law);
                Some(Notice::LawChanged(*law))
            }
            CameraRequest::Search => {
                self.begin_search(now);
                None
            }
            CameraRequest::NetYaw { degrees } => {
                let pan = self.pan_at(now);
                self.net_yaw.set(Angle::from_degrees(*degrees), pan);
                Some(Notice::NetYaw(self.net_yaw.state(pan)))
            }
            CameraRequest::Calibrate { motions } => {
                self.calibration = Some(Calibration::new(*motions, now));
                None
            }
            CameraRequest::Propose(tap) => self.on_tap(*tap, now),
            CameraRequest::Candidates { shown } => {
                self.are_candidates_wanted = *shown;
                None
            }
            CameraRequest::TakeCandidate { number } => match self.candidates.numbered(*number) {
                Some(candidate) => self.on_camera_request(&CameraRequest::Select(candidate.selection()), now),
                None => Some(Notice::RequestRefused(Refusal::NoSuchCandidate)),
            },
            CameraRequest::Engage => {
                self.verification.accept();
                self.take_proposal_to_follow(now)
            }
            // The safety rule has done what there is to do.
            CameraRequest::Disengage => None,
        }
    }

    /// Another target is followed from now on.
    pub(super) fn begin_target(&mut self) {
        if let Some(vessel) = &mut self.vessel {
            vessel.begin_target();
        }
        self.law.reset_target();
        if let Some(zooming) = &mut self.zooming {
            zooming.begin_target();
        }
        self.proposals.take();
        self.candidates.clear();
        self.verification = Verification::default();
        self.drawn_selection = None;
        self.last_bearing = None;
    }

    /// Nothing is followed from now on.
    fn end_target(&mut self, track: Track) {
        self.begin_target();
        self.pending_selection = None;
        self.set_unlocalised(track);
    }

    /// A selection is to be confirmed; it replaces every other one.
    fn begin_selection(&mut self) {
        self.forget_unconfirmed();
        self.begin_target();
        self.pending_selection = None;
    }

    /// The selection that waits for its confirmation is replaced. If the tracker follows it already, the
    /// tracker forgets it: a selection that is not confirmed is not followed, also where the new one is
    /// refused. The earlier track is gone.
    fn forget_unconfirmed(&mut self) {
        let is_followed = self.drawn_selection.is_some_and(|pending| pending.is_followed());
        if is_followed {
            self.tracker.forget();
            self.set_unlocalised(Track::Unseeded);
        }
    }

    /// The target's position is not known.
    pub(super) fn set_unlocalised(&mut self, track: Track) {
        (self.track, self.percept, self.advice) = (track, None, None);
    }

    /// Changes the law. The settings at the start are those of their own law; every other law has its
    /// defaults, and shows the same.
    fn change_law(&mut self, law: LawId) {
        self.settings.law = if law == self.first_law.id() {
            self.first_law
        } else {
            LawSettings::new(law).showing(self.first_law.framed())
        };
        self.law.change_law(self.settings.law, &self.settings.profile);
    }
}
