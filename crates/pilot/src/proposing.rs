//! A proposal: the object at the point that the operator tapped, until it is taken or dropped.
//!
//! A selection must name a video frame of the last 1.5 s, but the operator may look at a proposal for longer.
//! A proposal that stands is therefore renewed on newer frames: the object at the middle of its box. Each
//! proposal costs less than 10 ms, and at most one is made in a step. A proposal is dropped where the renewed
//! box does not overlap the one before, and after [`LASTS`].

use core::time::Duration;

use barrelman_vision::{NoProposal, ObjectSizes, Proposer};
use barrelman_vocab::{DrawnSelection, PixelBox, PixelPoint, Tap, Timestamp, VideoFrame};

use crate::history::{FrameHistory, not_kept};
use crate::outcome::Refusal;

/// Age of its video frame from which on a proposal is renewed.
const RENEWED_AFTER: Duration = Duration::from_millis(250);
/// Time after which a proposal that nobody takes is dropped.
const LASTS: Duration = Duration::from_secs(20);
/// Least IoU of a renewed box with the one before.
const MIN_RENEWED_IOU: f64 = 0.3;

/// An object that is proposed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ProposedObject {
    /// The box, pixels.
    pub bounds: PixelBox,
    /// Time of capture of the video frame that the box belongs to.
    pub captured: Timestamp,
    /// Time of capture of the video frame that was tapped.
    tapped: Timestamp,
}

impl ProposedObject {
    /// The selection of the object.
    pub(crate) const fn selection(&self) -> DrawnSelection {
        DrawnSelection { bounds: self.bounds, captured_ns: self.captured }
    }
}

/// The proposal that stands, and what makes proposals.
#[derive(Debug, Default)]
pub(crate) struct Proposals {
    /// Made with the first tap: its buffers are of no use to a run without one.
    proposer: Option<Box<Proposer>>,
    standing: Option<ProposedObject>,
}

impl Proposals {
    /// The proposal that stands.
    pub(crate) const fn standing(&self) -> Option<ProposedObject> {
        self.standing
    }

    /// Takes the proposal that stands away.
    pub(crate) const fn take(&mut self) -> Option<ProposedObject> {
        self.standing.take()
    }

    /// Takes the proposal that stands away if a tap lies within its box.
    pub(crate) fn take_at(&mut self, point: PixelPoint) -> Option<ProposedObject> {
        self.standing.take_if(|object| object.bounds.contains(point))
    }

    /// Proposes the object at a tap, in place of an earlier proposal.
    ///
    /// # Errors
    /// The reason if nothing is proposed. No proposal stands then.
    pub(crate) fn propose(&mut self, tap: Tap, history: &FrameHistory) -> Result<ProposedObject, Refusal> {
        self.standing = None;
        let captured = tap.captured_ns;
        let frame = history.find(captured).ok_or_else(|| match history.newest() {
            Some(newest) => not_kept(captured, newest.capture.at),
            None => Refusal::NoFreshVideo,
        })?;
        let bounds = self.object_at(frame, tap.at).map_err(Refusal::NothingProposed)?;
        let captured = frame.capture.at;
        let object = ProposedObject { bounds, captured, tapped: captured };
        self.standing = Some(object);
        Ok(object)
    }

    /// Renews the proposal that stands on the newest frame, when it is due.
    pub(crate) fn on_frame(&mut self, frame: &VideoFrame) {
        let now = frame.capture.at;
        let Some(before) = self.standing else { return };
        if now >= before.captured && now.since(before.captured) < RENEWED_AFTER {
            return;
        }
        let is_current = now >= before.captured && now.since(before.tapped) < LASTS;
        let renewed = if is_current { self.object_at(frame, before.bounds.centre()).ok() } else { None };
        self.standing = renewed
            .filter(|bounds| bounds.iou(before.bounds) >= MIN_RENEWED_IOU)
            .map(|bounds| ProposedObject { bounds, captured: now, ..before });
    }

    fn object_at(&mut self, frame: &VideoFrame, at: PixelPoint) -> Result<PixelBox, NoProposal> {
        let sizes = ObjectSizes::in_picture_of_height(frame.picture.size().height);
        let proposer = self.proposer.get_or_insert_default();
        proposer.propose(&frame.picture, at, sizes).map(|proposal| proposal.bounds)
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use barrelman_vocab::video::{Capture, CaptureQuality, ColourEncoding};
    use barrelman_vocab::{Picture, PictureSize};

    use super::*;

    const SIZE: PictureSize = PictureSize::new(640, 360);

    /// A light boat, whose left edge is here, on dark water.
    fn frame(at_ms: u64, left: Option<usize>) -> VideoFrame {
        let mut picture = Picture::black(SIZE, ColourEncoding::JPEG);
        let [y, ..] = picture.planes_mut();
        y.fill(60);
        for row in 160..180 {
            if let Some(left) = left {
                y[row * 640 + left..][..40].fill(220);
            }
        }
        let capture =
            Capture { at: Timestamp::from_nanos(at_ms * 1_000_000), quality: CaptureQuality::Sender };
        VideoFrame { sequence: at_ms, capture, picture: Arc::new(picture) }
    }

    fn tap(u: f64, v: f64, at_ms: u64) -> Tap {
        Tap { at: PixelPoint { u, v }, captured_ns: Timestamp::from_nanos(at_ms * 1_000_000), take: false }
    }

    fn history(frames: &[VideoFrame]) -> FrameHistory {
        let mut history = FrameHistory::keeping();
        frames.iter().for_each(|frame| history.add(frame));
        history
    }

    #[test]
    fn the_object_at_a_tap_stands_until_it_is_taken() {
        let history = history(&[frame(100, Some(300))]);
        let mut proposals = Proposals::default();
        let proposed = proposals.propose(tap(320.0, 170.0, 100), &history).unwrap();
        let truth = PixelBox { u: 300.0, v: 160.0, w: 40.0, h: 20.0 };
        assert!(proposed.bounds.iou(truth) > 0.5, "{proposed:?}");
        assert_eq!(proposals.take_at(PixelPoint { u: 100.0, v: 170.0 }), None);
        assert_eq!(proposals.take_at(PixelPoint { u: 318.0, v: 168.0 }), Some(proposed));
        assert_eq!(proposals.standing(), None);
    }

    #[test]
    fn a_tap_on_water_or_on_a_frame_that_is_not_kept_proposes_nothing() {
        let history = history(&[frame(5000, Some(300))]);
        let mut proposals = Proposals::default();
        let nothing = Refusal::NothingProposed(NoProposal::NothingStandsOut);
        assert_eq!(proposals.propose(tap(60.0, 60.0, 5000), &history), Err(nothing));
        assert_eq!(proposals.propose(tap(320.0, 170.0, 9000), &history), Err(Refusal::NotYetCaptured));
        let old = proposals.propose(tap(320.0, 170.0, 0), &history);
        assert!(matches!(old, Err(Refusal::SelectionTooOld { .. })), "{old:?}");
        let none = proposals.propose(tap(320.0, 170.0, 0), &FrameHistory::default());
        assert_eq!(none, Err(Refusal::NoFreshVideo));
    }

    #[test]
    fn a_proposal_moves_with_its_object_and_goes_with_it() {
        let mut proposals = Proposals::default();
        proposals.propose(tap(320.0, 170.0, 100), &history(&[frame(100, Some(300))])).unwrap();
        for step in 1..=5 {
            proposals.on_frame(&frame(100 + 300 * step, Some(300 + 8 * step as usize)));
        }
        let moved = proposals.standing().unwrap();
        assert!(moved.bounds.iou(PixelBox { u: 340.0, v: 160.0, w: 40.0, h: 20.0 }) > 0.5, "{moved:?}");
        assert_eq!(moved.captured, Timestamp::from_nanos(1_600_000_000));
        proposals.on_frame(&frame(1700, None));
        assert_eq!(proposals.standing(), Some(moved), "not due yet");
        proposals.on_frame(&frame(2000, None));
        assert_eq!(proposals.standing(), None);
    }

    #[test]
    fn a_proposal_that_nobody_takes_is_dropped() {
        let mut proposals = Proposals::default();
        proposals.propose(tap(320.0, 170.0, 0), &history(&[frame(0, Some(300))])).unwrap();
        for second in 1..20 {
            proposals.on_frame(&frame(1000 * second, Some(300)));
            assert!(proposals.standing().is_some(), "{second}");
        }
        proposals.on_frame(&frame(20_000, Some(300)));
        assert_eq!(proposals.standing(), None);
    }
}
