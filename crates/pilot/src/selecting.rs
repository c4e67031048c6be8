//! A selection that was drawn on an earlier video frame: found in the history, brought up to the newest
//! frame, and confirmed.
//!
//! ```text
//!  SelectOn --> Requested --frame of the selection found--> CatchingUp --newest frame reached--> Confirming --> done
//!                  |                                            |                                    |
//!                  +-- too old, or the tracker refuses          +-- the track is lost: nothing is followed
//! ```
//! A selection that replaces one that is catching up or confirming makes the tracker forget that one.
//!
//! Each step processes at most [`MAX_CATCH_UP`] frames of the history, so that the duration of a step stays
//! bounded; frames that arrive meanwhile join the history. A second of 30 frames takes three steps.

use barrelman_vision::Tracker;
use barrelman_vocab::{DrawnSelection, MotionPrior, PictureSize, PixelBox, Timestamp, Track, VideoFrame};

use crate::history::{FrameHistory, not_kept};
use crate::outcome::{Notice, Unconfirmed};

/// Frames of the history that one step processes, beside its own frame.
const MAX_CATCH_UP: usize = 11;
/// Consecutive newest frames in which the target must be measured with confidence.
const CONFIRMING_FRAMES: u32 = 4;
/// Newest frames after which a selection that is not confirmed is given up.
const MAX_CONFIRMING_FRAMES: u32 = 15;
/// Least confidence of a frame that confirms. Of nine wrong confirmations in 270 simulated ones (all at 0.55
/// and more), two fall below, and no right one of the 260; on the filmed clips kept aside, wrong ones fall
/// from 101 to 77 of 630.
pub(crate) const MIN_CONFIDENCE: f64 = 0.7;
/// Factor by which the box's area may have grown or shrunk since the selection.
const MAX_AREA_FACTOR: f64 = 2.5;

/// A selection that waits for its confirmation.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct PendingSelection {
    state: SelectionState,
    selection: DrawnSelection,
}

#[derive(Debug, Clone, Copy, PartialEq)]
enum SelectionState {
    /// The selection was requested after the last frame.
    Requested,
    /// The frames up to this time of capture have been processed.
    CatchingUp(Progress),
    /// The track has reached the newest frame.
    Confirming {
        progress: Progress,
        /// Consecutive frames that confirm.
        confirmed: u32,
        /// Newest frames so far.
        frames: u32,
    },
}

#[derive(Debug, Clone, Copy, PartialEq)]
struct Progress {
    processed: Timestamp,
    /// Area of the box that the tracker took, as a share of the picture.
    selected_share: f64,
}

/// What a frame made of the pending selection.
#[derive(Debug)]
pub(crate) enum SelectingResult {
    /// The selection goes on; the track that is reported meanwhile.
    Pending(Track),
    /// The selection was confirmed on this frame.
    Confirmed(Track, Notice),
    /// The selection was refused. The tracker has not changed.
    Refused(Notice),
    /// The selection could not be confirmed. The tracker follows nothing.
    GivenUp(Notice),
}

/// What a step of the selection works with.
pub(crate) struct SelectingContext<'a> {
    pub(crate) tracker: &'a mut dyn Tracker,
    pub(crate) history: &'a FrameHistory,
    /// The newest frame, which the history contains, if it keeps frames.
    pub(crate) frame: &'a VideoFrame,
    /// Least confidence of a frame that confirms.
    pub(crate) min_confidence: f64,
    /// Shift of the picture between two times of capture.
    pub(crate) prior: &'a dyn Fn(Timestamp, Timestamp, PictureSize) -> MotionPrior,
}

impl PendingSelection {
    /// A selection that was requested now.
    pub(crate) const fn new(selection: DrawnSelection) -> Self {
        Self { state: SelectionState::Requested, selection }
    }

    /// Whether the tracker follows the selection already, and no longer what was followed before.
    pub(crate) fn is_followed(&self) -> bool {
        self.state != SelectionState::Requested
    }

    /// Processes the newest frame.
    pub(crate) fn advance(&mut self, context: &mut SelectingContext<'_>) -> SelectingResult {
        if self.state == SelectionState::Requested
            && let Some(result) = self.begin(context)
        {
            return result;
        }
        match self.state {
            SelectionState::Requested => SelectingResult::Pending(Track::Unseeded),
            SelectionState::CatchingUp(progress) => self.catch_up(progress, context),
            SelectionState::Confirming { progress, confirmed, frames } => {
                let track = track_after(context, progress.processed, context.frame);
                let progress = Progress { processed: context.frame.capture.at, ..progress };
                self.confirm(progress, confirmed, frames + 1, track, context)
            }
        }
    }

    /// Selects on the frame on which the box was drawn. Returns a result where that is the newest frame, or
    /// the selection is refused; `None`: later frames follow.
    fn begin(&mut self, context: &mut SelectingContext<'_>) -> Option<SelectingResult> {
        let DrawnSelection { bounds, captured_ns: captured } = self.selection;
        let newest = context.frame;
        let frame = match context.history.find(captured) {
            Some(frame) => frame,
            // Without a history, the newest frame is the only one.
            None if newest.capture.at == captured => newest,
            None => {
                let refusal = not_kept(captured, newest.capture.at);
                return Some(SelectingResult::Refused(Notice::RequestRefused(refusal)));
            }
        };
        let report = match context.tracker.select(frame, bounds) {
            Ok(report) => report,
            Err(refusal) => return Some(SelectingResult::Refused(Notice::SelectionRefused(refusal))),
        };
        let selected_share = share_of(report.localisation.bounds, report.localisation.picture);
        let progress = Progress { processed: frame.capture.at, selected_share };
        if frame.capture.at >= newest.capture.at {
            self.state = SelectionState::Confirming { progress, confirmed: 0, frames: 0 };
            return Some(SelectingResult::Pending(Track::Tracking(report.localisation)));
        }
        self.state = SelectionState::CatchingUp(progress);
        None
    }

    fn catch_up(&mut self, mut progress: Progress, context: &mut SelectingContext<'_>) -> SelectingResult {
        let mut track = Track::Unseeded;
        let history = context.history;
        for frame in history.after(progress.processed).take(MAX_CATCH_UP + 1) {
            track = track_after(context, progress.processed, frame);
            progress.processed = frame.capture.at;
            if let Track::Lost { .. } = track {
                return give_up(context, Unconfirmed::LostBeforeNewest);
            }
        }
        if progress.processed >= context.frame.capture.at {
            return self.confirm(progress, 0, 1, track, context);
        }
        self.state = SelectionState::CatchingUp(progress);
        SelectingResult::Pending(Track::Unseeded)
    }

    /// Judges the track on the newest frame.
    fn confirm(
        &mut self,
        progress: Progress,
        confirmed: u32,
        frames: u32,
        track: Track,
        context: &mut SelectingContext<'_>,
    ) -> SelectingResult {
        let confirmed = match track {
            Track::Tracking(seen) => {
                let factor = share_of(seen.bounds, seen.picture) / progress.selected_share;
                if !(1.0 / MAX_AREA_FACTOR..=MAX_AREA_FACTOR).contains(&factor) {
                    return give_up(context, Unconfirmed::SizeChanged);
                }
                if seen.confidence >= context.min_confidence { confirmed + 1 } else { 0 }
            }
            Track::Coasting(_) => 0,
            Track::Lost { .. } | Track::Unseeded => return give_up(context, Unconfirmed::Lost),
        };
        if confirmed >= CONFIRMING_FRAMES
            && let Track::Tracking(seen) = track
        {
            return SelectingResult::Confirmed(track, Notice::SelectionConfirmed(seen));
        }
        if frames >= MAX_CONFIRMING_FRAMES {
            return give_up(context, Unconfirmed::NotSure);
        }
        self.state = SelectionState::Confirming { progress, confirmed, frames };
        SelectingResult::Pending(track)
    }
}

fn track_after(context: &mut SelectingContext<'_>, before: Timestamp, frame: &VideoFrame) -> Track {
    let prior = (context.prior)(before, frame.capture.at, frame.picture.size());
    context.tracker.track(frame, Some(&prior))
}

fn give_up(context: &mut SelectingContext<'_>, why: Unconfirmed) -> SelectingResult {
    context.tracker.forget();
    SelectingResult::GivenUp(Notice::SelectionUnconfirmed(why))
}

/// Area of a box as a share of the picture.
fn share_of(bounds: PixelBox, picture: PictureSize) -> f64 {
    bounds.area() / (picture.area() as f64).max(1.0)
}
