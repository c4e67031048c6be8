//! What the operator's requests do to the vessel and its marks.

use barrelman_vocab::{DrawnMark, PictureSize, Timestamp, VesselRequest};

use super::guiding::{GO_AGAIN, GuidanceLaw, NoWater};
use super::marks::{MarkRefusal, RouteChange};
use super::{FrameView, VesselNotice, VesselPilot, VesselView};
use crate::history::{KEPT, not_kept};
use crate::refusal::Refusal;

impl VesselPilot {
    /// Processes a request about the vessel. Returns what the operator has to know.
    ///
    /// # Errors
    /// The reason, if the request is not permitted now. It then has no effect.
    pub(crate) fn on_request(
        &mut self,
        request: &VesselRequest,
        picture: Option<PictureSize>,
        is_boat_seen: bool,
        view: VesselView<'_>,
    ) -> Result<Option<VesselNotice>, Refusal> {
        // What the operator wants now is not what the boat went on with.
        self.gate.set_clear(false);
        // A Go is confirmed by a Go alone.
        if !matches!(request, VesselRequest::Guide | VesselRequest::GoHome) {
            self.gone_in_picture_at = None;
        }
        match request {
            VesselRequest::Mark(drawn) => {
                return self.mark(drawn, picture, view).map(|id| Some(VesselNotice::Marked(id, drawn.mark)));
            }
            VesselRequest::MoveMark(moved) => {
                let frame_view = self.view_of(moved.captured_ns, picture, view)?;
                let has_moved = self.marks.move_to(moved, &frame_view, self.is_tilt_known());
                if has_moved.map_err(refusal_of)? == RouteChange::DestinationMoved {
                    self.guide.move_destination();
                }
                self.guide.anchor();
            }
            VesselRequest::Unmark { id } => {
                if !self.marks.remove(*id) {
                    return Err(Refusal::NoSuchMark);
                }
            }
            VesselRequest::UnmarkAll => self.marks.clear(),
            VesselRequest::NextMark => {
                self.marks.choose_next().ok_or(Refusal::NothingMarked)?;
            }
            VesselRequest::Guide => return self.engage(is_boat_seen, view).map(Some),
            VesselRequest::GoHome => {
                let before = self.marks;
                self.marks.choose_home().ok_or(Refusal::NoHome)?;
                return self.engage(is_boat_seen, view).inspect_err(|_| self.marks = before).map(Some);
            }
            VesselRequest::Steer(command) => self.gate.steer(*command, view.now)?,
            VesselRequest::StopVessel { by } => self.gate.stop_vessel(*by),
            VesselRequest::ReleaseVessel => self.gate.release(),
        }
        Ok(None)
    }

    /// The operator presses Go. Returns on which basis the boat goes. Where it would go in the picture though
    /// people or areas are marked, which it could then run into, Go has to be pressed twice.
    fn engage(&mut self, is_boat_seen: bool, view: VesselView<'_>) -> Result<VesselNotice, Refusal> {
        if self.guide.law() == GuidanceLaw::ByHand {
            return Err(Refusal::ByHandOnly);
        }
        if self.marks.destination().is_none() {
            return Err(Refusal::NothingMarked);
        }
        if !is_boat_seen {
            return Err(Refusal::BoatNotSeen);
        }
        let was_guiding = self.gate.is_guiding();
        let no_water = self.no_water(view.now);
        if let Some(why) =
            no_water.filter(|why| *why != NoWater::Law && !was_guiding && self.marks.have_circles())
        {
            let is_confirmed = |at: Timestamp| at <= view.now && view.now.since(at) <= GO_AGAIN;
            if !self.gone_in_picture_at.is_some_and(is_confirmed) {
                // A boat that cannot be commanded is refused for that, and not asked about.
                self.gate.clone().guide(view.now)?;
                self.gone_in_picture_at = Some(view.now);
                return Err(Refusal::PictureOnly(why));
            }
        }
        self.gate.guide(view.now)?;
        if !was_guiding {
            self.guide.expect_answer();
            self.marks.begin_route();
            self.goes_without_circles = no_water.is_some() && self.marks.have_circles();
        }
        self.gone_in_picture_at = None;
        Ok(VesselNotice::Going(no_water))
    }

    fn mark(
        &mut self,
        drawn: &DrawnMark,
        picture: Option<PictureSize>,
        view: VesselView<'_>,
    ) -> Result<u32, Refusal> {
        let frame_view = self.view_of(drawn.captured_ns, picture, view)?;
        let id = self
            .marks
            .add(drawn, &frame_view, self.is_tilt_known(), self.gate.is_guiding())
            .map_err(refusal_of)?;
        self.guide.anchor();
        Ok(id)
    }

    /// The camera of the video frame on which a mark was set or moved.
    fn view_of(
        &self,
        captured: Timestamp,
        picture: Option<PictureSize>,
        view: VesselView<'_>,
    ) -> Result<FrameView, Refusal> {
        let picture = picture.ok_or(Refusal::NoFreshVideo)?;
        if captured > view.now || view.now.since(captured) > KEPT {
            return Err(not_kept(captured, view.now));
        }
        Ok(self.frame_view_at(captured, picture, view, self.guide.displacement_at(captured)))
    }

    /// Whether a tilt was ever reported: before, the camera's model has that of the profile.
    const fn is_tilt_known(&self) -> bool {
        self.tilt_reported_at.is_some()
    }
}

const fn refusal_of(refusal: MarkRefusal) -> Refusal {
    match refusal {
        MarkRefusal::TooMany => Refusal::TooManyMarks,
        MarkRefusal::NotOnWater => Refusal::MarkNotOnWater,
        MarkRefusal::NoSuchMark => Refusal::NoSuchMark,
    }
}
