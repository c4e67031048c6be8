//! The pilot's part of a search and of a calibration: when a search may begin, their commands, and their end.

use barrelman_vocab::{CameraRequest, DrawnSelection, ImagePoint, PictureSize, Tap, Timestamp, Track};

use super::Pilot;
use crate::outcome::{LOST_BEFORE_SEARCH, Notice, Refusal};
use crate::purpose::Purpose;
use crate::refusal::MAX_NET_YAW_DEG;
use crate::safety::ObservationResult;
use crate::search::{LastBearing, Search, SearchReach};

impl Pilot {
    /// Why the request makes no sense now, whatever the safety rule says.
    pub(super) fn refusal(&self, request: &CameraRequest, now: Timestamp) -> Option<Refusal> {
        match request {
            CameraRequest::Search => self.nothing_to_search(now),
            CameraRequest::NetYaw { degrees } => {
                let is_plausible = degrees.abs() <= MAX_NET_YAW_DEG;
                (!is_plausible).then_some(Refusal::NetYawOutOfRange)
            }
            CameraRequest::KeepSize { keep: true } => self.no_zoom(),
            CameraRequest::Nudge(nudge) if nudge.zoom != 0.0 => self.no_zoom(),
            CameraRequest::Select(DrawnSelection { captured_ns, .. })
            | CameraRequest::Propose(Tap { captured_ns, .. }) => self.other_video(*captured_ns),
            CameraRequest::SelectNext(_)
            | CameraRequest::Candidates { .. }
            | CameraRequest::TakeCandidate { .. }
            | CameraRequest::Reject
            | CameraRequest::Deselect
            | CameraRequest::Nudge(_)
            | CameraRequest::Calibrate { .. }
            | CameraRequest::KeepSize { .. }
            | CameraRequest::Law { .. }
            | CameraRequest::Engage
            | CameraRequest::Disengage => None,
        }
    }

    /// Why there is nothing to search for.
    fn nothing_to_search(&self, now: Timestamp) -> Option<Refusal> {
        let is_selecting = self.drawn_selection.is_some() || self.pending_selection.is_some();
        if is_selecting {
            return Some(Refusal::NothingLost);
        }
        match self.track {
            Track::Lost { since, .. } if now.since(since) >= LOST_BEFORE_SEARCH => None,
            Track::Lost { .. } => Some(Refusal::LostTooBriefly),
            Track::Unseeded | Track::Tracking(_) | Track::Coasting(_) => Some(Refusal::NothingLost),
        }
    }

    /// Why a search would be refused now.
    pub(super) fn search_refusal(&self, now: Timestamp) -> Option<Refusal> {
        self.nothing_to_search(now).or_else(|| self.safety.clone().consent(Purpose::Search, now).err())
    }

    /// Notes where the target was seen, for a search.
    pub(super) fn note_bearing(&mut self, point: ImagePoint, picture: PictureSize, captured: Timestamp) {
        let camera = self.law.camera();
        let focal_px = camera.focal_px(captured, picture);
        let bearing = LastBearing::bearing(focal_px, camera.angles_at(captured), point);
        self.last_bearing = Some(LastBearing::update(self.last_bearing, bearing, captured));
    }

    /// The operator asked for a search, and the safety rule permits it.
    pub(super) fn begin_search(&mut self, now: Timestamp) {
        let camera = self.law.camera();
        if self.search.is_none() {
            let pointing = camera.angles_at(now);
            let aspect =
                self.picture.map_or(1.0, |size| f64::from(size.height) / f64::from(size.width.max(1)));
            // A camera that zooms by command is widened meanwhile.
            let focal_share = match self.no_zoom() {
                None => self.settings.profile.camera.focal_share,
                Some(_) => camera.focal_share_at(now),
            };
            let reach = SearchReach::new(focal_share, aspect, camera.dynamics());
            self.search = Some(Search::new(self.last_bearing, pointing, reach, now));
        }
    }

    /// Proposes the next command of a search after an observation, or ends the search.
    pub(super) fn advance_search(&mut self, result: ObservationResult, now: Timestamp) -> Option<Notice> {
        if self.safety.held() != Some(Purpose::Search) {
            return None;
        }
        if matches!(result, ObservationResult::Fresh(_)) {
            self.safety.finish_search(now);
            return Some(Notice::SearchFound);
        }
        self.law.advance_to(now);
        let pointing = self.law.camera().angles_at(now);
        let command = self.search.as_mut()?.command(pointing, self.net_yaw.pan_range(), now);
        let Some(command) = command else {
            self.safety.finish_search(now);
            return Some(Notice::SearchGaveUp);
        };
        self.safety.propose(Purpose::Search, self.widened(command, now), now);
        None
    }

    /// Proposes the next test motion of a calibration after an observation, or ends the calibration.
    pub(super) fn advance_calibration(&mut self, is_video_fresh: bool, now: Timestamp) -> Option<Notice> {
        if self.safety.held() != Some(Purpose::Calibrate) || !is_video_fresh {
            return None;
        }
        let Some(command) = self.calibration.as_ref()?.command(now) else {
            self.calibration = None;
            self.safety.finish_calibration();
            return Some(Notice::TestMotionsMade);
        };
        self.safety.propose(Purpose::Calibrate, command, now);
        None
    }
}
