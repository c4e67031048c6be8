//! The pilot's part of the zoom: keeping the target's size, by hand, and wide in a search.

use barrelman_control::size_keeping::SizeInput;
use barrelman_control::{LawInput, Percept};
use barrelman_vocab::{CameraCommand, Framed, Localisation, Nudge, Timestamp, ZoomAbility};

use super::Pilot;
use crate::outcome::{Notice, Refusal, ZoomState};

impl Pilot {
    /// Why the camera is not zoomed; `None`: it zooms.
    pub(super) fn no_zoom(&self) -> Option<Refusal> {
        // What zooms is not the camera of the video that is followed.
        let zooms = self.zooming.is_some() && !self.law.camera().is_of_other();
        match (self.safety.zoom(), zooms) {
            (_, false) | (ZoomAbility::Absent, true) => Some(Refusal::NoZoom),
            (ZoomAbility::NotKnown, true) => Some(Refusal::ZoomNotKnown),
            (ZoomAbility::Present, true) => None,
        }
    }

    /// The size is kept from now on, or no longer. Returns what the operator has to know.
    pub(super) fn keep_size(&mut self, keep: bool) -> Option<Notice> {
        let zooming = self.zooming.as_mut().filter(|zooming| zooming.keeps_size != keep)?;
        zooming.keeps_size = keep;
        zooming.keeper.reset_target();
        Some(Notice::KeepingSize(keep))
    }

    /// The operator zooms by hand: the size is not kept any more.
    pub(super) fn on_nudge(&mut self, nudge: Nudge) -> Option<Notice> {
        if nudge.zoom == 0.0 { None } else { self.keep_size(false) }
    }

    /// The law's command for a localisation, with the zoom that keeps the size.
    pub(super) fn with_zoom(
        &mut self,
        command: CameraCommand,
        seen: &Localisation,
        percept: &Percept,
        input: &LawInput<'_>,
    ) -> CameraCommand {
        let destination_share = match (self.settings.law.framed(), input.destination) {
            (Framed::Both, Some(destination)) => destination.share_to_border(input.picture),
            (Framed::Boat, _) | (Framed::Both, None) => 0.0,
        };
        let camera = self.law.camera();
        let focal_shares = (camera.focal_share_at(input.captured), camera.focal_share_at(input.now));
        let zooms = self.no_zoom().is_none();
        let Some(zooming) = self.zooming.as_mut().filter(|zooming| zooms && zooming.keeps_size) else {
            return command;
        };
        let longer = seen.bounds.w.max(seen.bounds.h);
        let size_input = SizeInput {
            size: longer / f64::from(seen.picture.height.max(1)),
            p: percept.p,
            destination_share,
            is_measured: input.is_measured,
            confidence: if self.verification.is_doubted() { 0.0 } else { seen.confidence },
            focal_shares,
            captured: input.captured,
        };
        command.zooming(zooming.keeper.rate(&size_input))
    }

    /// The command of a search, with the view as wide as it can be.
    pub(super) fn widened(&self, command: CameraCommand, now: Timestamp) -> CameraCommand {
        let is_wide = self.zoom_ratio(now).is_none_or(|ratio| ratio <= 1.0);
        if is_wide { command } else { command.zooming(-self.settings.profile.max_zoom_rate()) }
    }

    /// The present focal length over that of the widest view; `None`: the camera is not zoomed.
    fn zoom_ratio(&self, now: Timestamp) -> Option<f64> {
        let widest = self.settings.profile.camera.focal_share;
        self.no_zoom().is_none().then(|| self.law.camera().focal_share_at(now) / widest)
    }

    /// The zoom after a step.
    pub(super) fn zoom_state(&self, now: Timestamp) -> Option<ZoomState> {
        let keeps_size = self.zooming.as_ref()?.keeps_size;
        Some(ZoomState { ratio: self.zoom_ratio(now)?, keeps_size })
    }
}
