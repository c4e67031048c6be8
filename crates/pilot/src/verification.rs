//! Whether a detector agrees that what the tracker found again is the boat.
//!
//! ```text
//!   Agreed --track lost--> Lost --found again--> Waiting --a boat is detected there--> Agreed
//!                                                   |                                     ^
//!                                                   +--in 3 pictures there is none--> Doubted: the camera rests
//! ```
//! A doubt ends when a boat is detected there, when the operator engages, or with another selection. A
//! detector that does not know this boat doubts nothing: before the loss it must have detected it in 6 of 8
//! pictures.

use barrelman_vocab::{Timestamp, Track};

use crate::detections::{Detection, Detections, MAX_DETECTIONS, is_near, is_recent};
use crate::object_trackers::PictureShift;

/// Pictures of the last eight before a loss in which the boat must have been detected.
const KNOWN_IN: u32 = 6;
/// Pictures in a row without the boat that make a doubt.
const MISSED_IN: u32 = 3;

#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
enum State {
    #[default]
    Agreed,
    Lost,
    /// Found again at this time of capture.
    Waiting {
        since: Timestamp,
        missed: u32,
    },
    Doubted,
}

/// What a detector says of the boat that is followed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(crate) struct Verification {
    state: State,
    /// The last eight pictures before the loss: a bit is set where the boat was detected.
    detected_in: u8,
}

impl Verification {
    /// Whether the detector contradicts.
    pub(crate) const fn is_doubted(&self) -> bool {
        matches!(self.state, State::Doubted)
    }

    /// The operator agrees.
    pub(crate) const fn accept(&mut self) {
        self.state = State::Agreed;
    }

    /// The tracker has answered.
    pub(crate) fn on_track(&mut self, track: &Track) {
        match (track, self.state) {
            (Track::Lost { .. }, _) => self.state = State::Lost,
            (Track::Tracking(seen), State::Lost) => {
                let is_known = self.detected_in.count_ones() >= KNOWN_IN;
                self.state =
                    if is_known { State::Waiting { since: seen.captured, missed: 0 } } else { State::Agreed };
            }
            _ => {}
        }
    }

    /// The detector has looked at a picture.
    pub(crate) fn on_detections(&mut self, detections: &Detections, track: &Track, shift: PictureShift<'_>) {
        let Track::Tracking(seen) = track else { return };
        let captured = detections.captured;
        if !is_recent((captured, detections.picture), (seen.captured, seen.picture)) {
            return;
        }
        let moved = shift(captured, seen.captured, seen.picture);
        let is_boat_there = |found: &Detection| {
            found.classification.class.is_boat()
                && is_near(found.moved(&moved, seen.picture).bounds, seen.bounds)
        };
        let is_there = detections.found.iter().take(MAX_DETECTIONS).any(is_boat_there);
        match &mut self.state {
            State::Agreed => self.detected_in = self.detected_in << 1 | u8::from(is_there),
            State::Lost => {}
            State::Waiting { since, .. } if captured < *since => {}
            State::Waiting { .. } | State::Doubted if is_there => self.state = State::Agreed,
            State::Waiting { missed, .. } => {
                *missed += 1;
                if *missed >= MISSED_IN {
                    self.state = State::Doubted;
                }
            }
            State::Doubted => {}
        }
    }
}
