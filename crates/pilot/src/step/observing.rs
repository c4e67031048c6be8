//! The pilot's part of a video frame: tracking, and selections that wait.

use barrelman_vocab::{Track, VideoFrame};

use super::{Observation, Pilot};
use crate::candidates::Sought;
use crate::detections::Detections;
use crate::growth::Growth;
use crate::outcome::Notice;
use crate::selecting::{MIN_CONFIDENCE, PendingSelection, SelectingContext, SelectingResult};

impl Pilot {
    /// Tracks the target in a video frame, or takes the pending selection in it.
    pub(super) fn observe_frame(&mut self, frame: &VideoFrame) -> Observation {
        self.history.add(frame);
        self.proposals.on_frame(frame);
        self.measure_growth(frame);
        if let Some(vessel) = &self.vessel {
            self.tracker.set_bow_first(vessel.may_be_bow_first(frame.capture.at));
        }
        let size = frame.picture.size();
        let (track, notice) = match self.drawn_selection.take() {
            Some(pending) => self.advance_selection(pending, frame),
            None => {
                let answer = self.track_frame(frame);
                self.check_motion(frame);
                answer
            }
        };
        let law = &self.law;
        let shift = |from, to, size| law.motion_prior(from, to, size);
        self.held_marks.trackers.advance(frame, &shift);
        self.verification.on_track(&track);
        match self.sought(&track) {
            Some(sought) => {
                let boat = track.localisation().map(|seen| seen.bounds);
                let excluded = self.held_marks.trackers.boxes().chain(boat);
                self.candidates.on_frame(frame, sought, excluded, &shift);
            }
            None => self.candidates.clear(),
        }
        let picture = track.localisation().map_or(size, |measured| measured.picture);
        Observation { track, captured: Some(frame.capture.at), picture: Some(picture), notice }
    }

    /// Measures how the picture grows where the camera zooms and does not report its field of view.
    fn measure_growth(&mut self, frame: &VideoFrame) {
        let Some(zoom) = self.law.camera().unreported_zoom(frame.capture.at) else { return };
        let growth = self.zooming.as_mut().and_then(|zooming| zooming.growth.by_zoom(frame, zoom));
        if let Some(Growth { growth, from, to }) = growth {
            self.law.on_growth(growth, from, to);
        }
    }

    /// What candidates are looked for.
    fn sought(&self, track: &Track) -> Option<Sought> {
        let is_selecting = self.drawn_selection.is_some() || self.pending_selection.is_some();
        let is_followed = is_selecting || *track != Track::Unseeded;
        if self.are_candidates_wanted || !is_followed && self.history.is_kept() {
            return Some(Sought::Objects);
        }
        // Persons are of use where they can be marked.
        (self.vessel.is_some() && !is_selecting && self.history.is_kept()).then_some(Sought::Persons)
    }

    /// A detector has looked at an earlier video frame.
    pub(super) fn on_detections(&mut self, detections: &Detections) {
        if self.other_video(detections.captured).is_some() {
            return;
        }
        self.candidates.on_detections(detections);
        if self.drawn_selection.is_none() {
            let law = &self.law;
            let shift = |from, to, size| law.motion_prior(from, to, size);
            self.verification.on_detections(detections, &self.track, &shift);
        }
    }

    fn track_frame(&mut self, frame: &VideoFrame) -> (Track, Option<Notice>) {
        let size = frame.picture.size();
        let prior = self
            .last_capture
            .filter(|last| *last <= frame.capture.at)
            .map(|last| self.law.motion_prior(last, frame.capture.at, size));
        match self.pending_selection.take() {
            None => (self.tracker.track(frame, prior.as_ref()), None),
            Some(selection) => match self.tracker.select(frame, selection) {
                Ok(report) => (Track::Tracking(report.localisation), Some(Notice::Selected(report))),
                Err(refusal) => {
                    (self.tracker.track(frame, prior.as_ref()), Some(Notice::SelectionRefused(refusal)))
                }
            },
        }
    }

    /// Brings a selection that was drawn on an earlier frame closer to its confirmation.
    fn advance_selection(
        &mut self,
        mut pending: PendingSelection,
        frame: &VideoFrame,
    ) -> (Track, Option<Notice>) {
        let law = &self.law;
        let result = pending.advance(&mut SelectingContext {
            min_confidence: MIN_CONFIDENCE,
            tracker: &mut *self.tracker,
            history: &self.history,
            frame,
            prior: &|from, to, size| law.motion_prior(from, to, size),
        });
        match result {
            SelectingResult::Pending(track) => {
                self.drawn_selection = Some(pending);
                (track, None)
            }
            SelectingResult::Confirmed(track, notice) => (track, Some(notice)),
            SelectingResult::Refused(notice) => {
                let (track, _) = self.track_frame(frame);
                (track, Some(notice))
            }
            SelectingResult::GivenUp(notice) => (Track::Unseeded, Some(notice)),
        }
    }
}
