//! Candidates: the objects on the water that the operator may want, each with a number, while nothing is
//! followed or on demand.
//!
//! A round begins with the places of a picture that stand out. One of them is looked at every [`LOOK_EVERY`]:
//! the proposer finds the object's box there, or none. A tracker follows the object from then on. A candidate
//! is shown after it was found in two rounds, and keeps its number until its tracker loses it, or it was
//! missed in three. A candidate may be anything: boat, person, buoy, foam. Where a detector runs, it says
//! what some of them are, and finds others; persons that it detects are shown while the boat is followed,
//! too, to be marked.
//!
//! Each look costs less than 10 ms; times are those of capture, so that a replay repeats them.

use core::time::Duration;

use barrelman_vision::{MAX_PLACES, ObjectSizes, Proposer, Saliency};
use barrelman_vocab::{DrawnSelection, PixelBox, PixelPoint, Timestamp, VideoFrame};

use crate::detections::{Classification, Detection, Detections, is_near};
use crate::object_trackers::{MAX_OBJECTS, ObjectTrackers, PictureShift};

mod detected;

use detected::{Detected, Given};

/// Most candidates at a time.
pub const MAX_CANDIDATES: usize = MAX_OBJECTS;
/// Time between two looks, and between a round and the next.
const LOOK_EVERY: Duration = Duration::from_millis(150);
/// Rounds in which an object must be found before it is shown, and may be missed before it is forgotten.
const FOUND: u32 = 2;
const MISSED: u32 = 3;
/// Least IoU of the boxes of a candidate and of the detection that names it. The proposer's box may be a part
/// of the object.
const SAME_IOU: f64 = 0.1;

/// An object that may be the wanted one.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Candidate {
    /// Number of the candidate, from 1.
    pub number: u32,
    /// The box, pixels.
    pub bounds: PixelBox,
    /// Time of capture of the video frame that the box belongs to.
    pub captured: Timestamp,
    /// What a detector says the object is; `None`: nothing.
    pub classification: Option<Classification>,
}

impl Candidate {
    /// The selection of the object.
    pub(crate) const fn selection(&self) -> DrawnSelection {
        DrawnSelection { bounds: self.bounds, captured_ns: self.captured }
    }
}

/// What is looked for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(crate) enum Sought {
    /// Objects of every kind.
    #[default]
    Objects,
    /// Persons, by the detector alone.
    Persons,
}

/// In how many rounds an object was found, and missed since.
#[derive(Debug, Clone, Copy)]
struct Known {
    number: u32,
    found: u32,
    missed: u32,
    is_in_round: bool,
    classification: Given,
}

impl Known {
    /// An object that was found for the first time.
    const fn new(number: u32) -> Self {
        Self { number, found: 1, missed: 0, is_in_round: true, classification: None }
    }

    fn on_found(&mut self) {
        self.found += u32::from(!self.is_in_round);
        (self.missed, self.is_in_round) = (0, true);
    }

    /// The object was detected in a video frame. Of several detections the first one, of the highest score,
    /// counts.
    fn on_detected(&mut self, classification: Classification, captured: Timestamp) {
        if self.classification.is_none_or(|(_, at)| at != captured) {
            self.found += 1;
            (self.missed, self.is_in_round) = (0, true);
            self.classification = Some((classification, captured));
        }
    }

    fn is_person(&self) -> bool {
        self.classification.is_some_and(|(classification, _)| classification.class.is_person())
    }
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
    /// By the numbers of the candidates.
    trackers: ObjectTrackers,
    detected: Detected,
    sought: Sought,
}

impl Candidates {
    /// The candidates that are shown, by their numbers.
    pub(crate) fn shown(&self) -> [Option<Candidate>; MAX_CANDIDATES] {
        let mut shown = [None; MAX_CANDIDATES];
        for known in self.known.iter().filter(|known| known.found >= FOUND) {
            let seen = self.trackers.seen(known.number);
            shown[(known.number as usize - 1).min(MAX_CANDIDATES - 1)] = seen.map(|seen| Candidate {
                number: known.number,
                bounds: seen.bounds,
                captured: seen.captured,
                classification: known.classification.map(|(classification, _)| classification),
            });
        }
        shown
    }

    /// The candidate of a number. Beside the boat, persons have none: a wrong key would follow another
    /// object.
    pub(crate) fn numbered(&self, number: u32) -> Option<Candidate> {
        let is_offered = |candidate: &Candidate| self.sought == Sought::Objects && candidate.number == number;
        self.shown().into_iter().flatten().find(is_offered)
    }

    /// The candidate at a point.
    pub(crate) fn at(&self, point: PixelPoint) -> Option<Candidate> {
        self.shown().into_iter().flatten().find(|candidate| candidate.bounds.contains(point))
    }

    /// Forgets all.
    pub(crate) fn clear(&mut self) {
        self.known.clear();
        self.places.clear();
        self.detected.clear();
        self.trackers.keep(|_| false);
        self.looked = None;
    }

    /// Follows the candidates in the newest frame, and looks at the next place when that is due. `others`:
    /// the boxes of what is followed otherwise.
    pub(crate) fn on_frame(
        &mut self,
        frame: &VideoFrame,
        sought: Sought,
        others: impl Iterator<Item = PixelBox> + Clone,
        shift: PictureShift<'_>,
    ) {
        self.sought = sought;
        self.follow(frame, others.clone(), shift);
        self.take_detections(frame, others.clone(), shift);
        let now = frame.capture.at;
        if sought == Sought::Persons {
            self.places.clear();
            return;
        }
        if self.looked.is_some_and(|looked| looked <= now && now.since(looked) < LOOK_EVERY) {
            return;
        }
        self.looked = Some(now);
        let Some(place) = self.places.pop() else {
            self.end_round();
            let (saliency, _) = &mut **self.finder.get_or_insert_default();
            self.places.extend(saliency.places(&frame.picture));
            self.places.reverse();
            self.round = now;
            return;
        };
        let size = frame.picture.size();
        let moved = shift(self.round.min(now), now, size).at(place, size);
        let place = PixelPoint { u: place.u + moved.shift_u_px, v: place.v + moved.shift_v_px };
        self.look(frame, place, others);
    }

    /// Follows the candidates, and forgets those that are lost, or are what is followed otherwise.
    fn follow(
        &mut self,
        frame: &VideoFrame,
        others: impl Iterator<Item = PixelBox> + Clone,
        shift: PictureShift<'_>,
    ) {
        self.trackers.advance(frame, shift);
        self.trackers.separate(None);
        let Self { known, trackers, sought, .. } = self;
        known.retain_mut(|known| {
            known.classification = detected::current(known.classification, frame.capture.at);
            if *sought == Sought::Persons && !known.is_person() {
                return false;
            }
            let seen = trackers.seen(known.number);
            seen.is_some_and(|seen| others.clone().all(|other| !is_near(other, seen.bounds)))
        });
        trackers.keep(|number| known.iter().any(|known| known.number == number));
        for object in trackers.iter_mut() {
            object.expected = object.track.localisation().map(|seen| seen.centre);
        }
    }

    /// Looks for an object at a place that stands out.
    fn look(&mut self, frame: &VideoFrame, place: PixelPoint, mut others: impl Iterator<Item = PixelBox>) {
        let (_, proposer) = &mut **self.finder.get_or_insert_default();
        let sizes = ObjectSizes::in_picture_of_height(frame.picture.size().height);
        let Ok(proposed) = proposer.propose(&frame.picture, place, sizes) else { return };
        if others.any(|other| is_near(other, proposed.bounds)) {
            return;
        }
        let is_here = |number: u32| {
            self.trackers.seen(number).is_some_and(|seen| is_near(seen.bounds, proposed.bounds))
        };
        if let Some(known) = self.known.iter_mut().find(|known| is_here(known.number)) {
            known.on_found();
        } else if let Some(number) = self.free_number()
            && self.trackers.add(number, proposed.bounds, frame)
        {
            self.known.push(Known::new(number));
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

    /// A detector found these objects. They are used with the next frame.
    pub(crate) fn on_detections(&mut self, detections: &Detections) {
        self.detected.set(detections);
    }

    /// Names the candidates that were detected. Others are added, at most one in a frame, as a new tracker
    /// costs time; the rest waits. Like what the proposer finds, they are shown once they are found again.
    fn take_detections(
        &mut self,
        frame: &VideoFrame,
        others: impl Iterator<Item = PixelBox> + Clone,
        shift: PictureShift<'_>,
    ) {
        let Some(captured) = self.detected.captured_before(frame) else {
            self.detected.clear();
            return;
        };
        let size = frame.picture.size();
        let moved = shift(captured, frame.capture.at, size);
        while let Some(detection) = self.detected.waiting.pop() {
            let Detection { bounds, classification } = detection.moved(&moved, size);
            if self.sought == Sought::Persons && !classification.class.is_person() {
                continue;
            }
            if others.clone().any(|other| is_near(other, bounds)) {
                continue;
            }
            if let Some(known) = self.best_match(bounds) {
                known.on_detected(classification, captured);
            } else if self.is_known_near(bounds) {
                // Which of two neighbours is meant is not known.
            } else if let Some(number) = self.free_number()
                && self.trackers.add(number, bounds, frame)
            {
                let classification = Some((classification, captured));
                self.known.push(Known { classification, ..Known::new(number) });
                return;
            }
        }
    }

    fn best_match(&mut self, bounds: PixelBox) -> Option<&mut Known> {
        let trackers = &self.trackers;
        let iou = |known: &Known| trackers.seen(known.number).map_or(0.0, |seen| seen.bounds.iou(bounds));
        let best = self.known.iter_mut().map(|known| (iou(known), known));
        let (iou, known) = best.max_by(|(one, _), (other, _)| one.total_cmp(other))?;
        (iou >= SAME_IOU).then_some(known)
    }

    fn is_known_near(&self, bounds: PixelBox) -> bool {
        self.trackers.boxes().any(|known| is_near(known, bounds))
    }

    fn free_number(&self) -> Option<u32> {
        (1..=MAX_CANDIDATES as u32).find(|number| self.known.iter().all(|known| known.number != *number))
    }
}

const _: () = assert!(MAX_PLACES <= MAX_CANDIDATES, "each place of a round may be a candidate");
