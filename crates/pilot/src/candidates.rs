//! Candidates: the objects on the water that the operator may want, each with a number, while nothing is
//! followed or on demand.
//!
//! A round begins with the places of a picture that stand out. One of them is looked at every [`LOOK_EVERY`]:
//! the proposer finds the object's box there, or none. A candidate is shown after it was found in two rounds,
//! and keeps its number until it was missed in two. A candidate may be anything: boat, person, buoy, foam.
//!
//! Each look costs less than 10 ms; times are those of capture, so that a replay repeats them.

use core::time::Duration;

use barrelman_vision::{MAX_PLACES, ObjectSizes, Proposer, Saliency};
use barrelman_vocab::{
    DrawnSelection, MotionPrior, PictureSize, PixelBox, PixelPoint, Timestamp, VideoFrame,
};

/// Most candidates at a time.
pub const MAX_CANDIDATES: usize = 8;
/// Time between two looks, and between a round and the next.
const LOOK_EVERY: Duration = Duration::from_millis(150);
/// Rounds in which an object must be found before it is shown, and may be missed before it is forgotten.
const FOUND: u32 = 2;
const MISSED: u32 = 2;
/// Least IoU of the boxes of one object in two rounds, or largest distance in sizes of the object.
const SAME_IOU: f64 = 0.2;
const SAME_DISTANCE: f64 = 1.5;

/// An object that may be the wanted one.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Candidate {
    /// Number of the candidate, from 1.
    pub number: u32,
    /// The box, pixels.
    pub bounds: PixelBox,
    /// Time of capture of the video frame that the box belongs to.
    pub captured: Timestamp,
}

impl Candidate {
    /// The selection of the object.
    pub(crate) const fn selection(&self) -> DrawnSelection {
        DrawnSelection { bounds: self.bounds, captured_ns: self.captured }
    }

    fn is_hit(&self, PixelPoint { u, v }: PixelPoint) -> bool {
        let PixelBox { u: left, v: top, w, h } = self.bounds;
        (left..=left + w).contains(&u) && (top..=top + h).contains(&v)
    }
}

/// An object, and in how many rounds it was found, and missed since.
#[derive(Debug, Clone, Copy)]
struct Known {
    candidate: Candidate,
    found: u32,
    missed: u32,
    is_in_round: bool,
}

/// What finds candidates, and those that are known.
#[derive(Default)]
pub(crate) struct Candidates {
    /// Made with the first round: its buffers are of no use to a run without one.
    finder: Option<Box<(Saliency, Proposer)>>,
    /// Places of the round that were not looked at yet, the last one first.
    places: Vec<PixelPoint>,
    /// When the places belong to.
    round: Timestamp,
    looked: Option<Timestamp>,
    known: Vec<Known>,
}

impl Candidates {
    /// The candidates that are shown, by their numbers.
    pub(crate) fn shown(&self) -> [Option<Candidate>; MAX_CANDIDATES] {
        let mut shown = [None; MAX_CANDIDATES];
        let found = self.known.iter().filter(|known| known.found >= FOUND).map(|known| known.candidate);
        for candidate in found {
            shown[(candidate.number as usize - 1).min(MAX_CANDIDATES - 1)] = Some(candidate);
        }
        shown
    }

    /// The candidate of a number.
    pub(crate) fn numbered(&self, number: u32) -> Option<Candidate> {
        self.shown().into_iter().flatten().find(|candidate| candidate.number == number)
    }

    /// The candidate at a point.
    pub(crate) fn at(&self, point: PixelPoint) -> Option<Candidate> {
        self.shown().into_iter().flatten().find(|candidate| candidate.is_hit(point))
    }

    /// Forgets all.
    pub(crate) fn clear(&mut self) {
        self.known.clear();
        self.places.clear();
        self.looked = None;
    }

    /// Looks at the next place of the newest frame when it is due. `excluded`: boxes of what is followed.
    pub(crate) fn on_frame(
        &mut self,
        frame: &VideoFrame,
        excluded: impl Iterator<Item = PixelBox> + Clone,
        shift: &dyn Fn(Timestamp, Timestamp, PictureSize) -> MotionPrior,
    ) {
        let (now, picture) = (frame.capture.at, &*frame.picture);
        if self.looked.is_some_and(|looked| looked <= now && now.since(looked) < LOOK_EVERY) {
            return;
        }
        self.looked = Some(now);
        let Some(place) = self.places.pop() else {
            self.end_round();
            let (saliency, _) = &mut **self.finder.get_or_insert_default();
            self.places.extend(saliency.places(picture));
            self.places.reverse();
            self.round = now;
            return;
        };
        let size = picture.size();
        let moved = |point: PixelPoint, since: Timestamp| {
            if since > now {
                return point;
            }
            let shift = shift(since, now, size);
            PixelPoint { u: point.u + shift.shift_u_px, v: point.v + shift.shift_v_px }
        };
        let (_, proposer) = &mut **self.finder.get_or_insert_default();
        let sizes = ObjectSizes::in_picture_of_height(size.height);
        let Ok(proposed) = proposer.propose(picture, moved(place, self.round), sizes) else { return };
        let bounds = proposed.bounds;
        if excluded.clone().any(|other| other.iou(bounds) > SAME_IOU) {
            return;
        }
        let is_same = |known: &&mut Known| {
            let before = known.candidate.bounds;
            let at = moved(before.centre(), known.candidate.captured);
            let before = PixelBox { u: at.u - 0.5 * before.w, v: at.v - 0.5 * before.h, ..before };
            let (one, other) = (before.centre(), bounds.centre());
            let size = libm::sqrt(bounds.area().min(before.area()));
            before.iou(bounds) > SAME_IOU
                || libm::hypot(one.u - other.u, one.v - other.v) < SAME_DISTANCE * size
        };
        if let Some(known) = self.known.iter_mut().find(is_same) {
            known.found += u32::from(!known.is_in_round);
            (known.candidate.bounds, known.candidate.captured) = (bounds, now);
            (known.missed, known.is_in_round) = (0, true);
        } else if let Some(number) = self.free_number() {
            let candidate = Candidate { number, bounds, captured: now };
            self.known.push(Known { candidate, found: 1, missed: 0, is_in_round: true });
        }
    }

    /// Forgets what was missed too often, and what was found once and not again.
    fn end_round(&mut self) {
        self.known.retain_mut(|known| {
            known.missed += u32::from(!known.is_in_round);
            known.is_in_round = false;
            known.missed == 0 || (known.found >= FOUND && known.missed < MISSED)
        });
    }

    fn free_number(&self) -> Option<u32> {
        (1..=MAX_CANDIDATES as u32)
            .find(|number| self.known.iter().all(|known| known.candidate.number != *number))
    }
}

const _: () = assert!(MAX_PLACES <= MAX_CANDIDATES, "each place of a round may be a candidate");
