//! Delivers the pictures of a simulated world at their times of arrival, with the deliberate faults applied.

use std::collections::VecDeque;
use std::sync::mpsc::Receiver;

use barrelman_video::feed::{Feed, StopSignal};
use barrelman_video::{VideoError, VideoSink};
use barrelman_vocab::{EncodedUnit, PixelBox, Timestamp};

/// A message of the thread `render`.
pub(super) enum SourceEvent {
    /// A picture, its time of arrival, and the target's bounds in the picture.
    Picture { at: Timestamp, unit: EncodedUnit, target: Option<PixelBox> },
    /// A picture could not be encoded. No further picture follows.
    Failed(VideoError),
    /// The world is over.
    End,
}

/// Delivers until the world is over or the signal is raised. Returns whether the world is over.
pub(super) fn deliver<S: VideoSink>(
    arriving: &Receiver<SourceEvent>,
    feed: &mut Feed<S>,
    stop: &StopSignal,
) -> bool {
    let mut targets: VecDeque<(Timestamp, PixelBox)> = VecDeque::new();
    let mut is_target_reported = false;
    // The channel closes without `End` if a thread panicked.
    while let Ok(delivery) = arriving.recv() {
        let (at, unit, target) = match delivery {
            SourceEvent::Picture { at, unit, target } => (at, unit, target),
            SourceEvent::Failed(error) => {
                feed.fail(error);
                return false;
            }
            SourceEvent::End => return !stop.is_raised(),
        };
        if stop.wait_until(feed.clock.instant(at)) {
            return false;
        }
        if let Some(target) = target.filter(|_| !is_target_reported) {
            targets.push_back((unit.capture.at, target));
        }
        let decoded = feed.decode(Some(unit));
        decoded.units.iter().for_each(|unit| feed.sink.on_unit(unit));
        for frame in decoded.frames {
            while targets.front().is_some_and(|(at, _)| *at < frame.capture.at) {
                targets.pop_front();
            }
            let is_of_frame = |(at, _): &mut (Timestamp, PixelBox)| *at == frame.capture.at;
            if !is_target_reported && let Some((_, target)) = targets.pop_front_if(is_of_frame) {
                is_target_reported = true;
                feed.sink.on_target(target);
            }
            feed.sink.on_frame(frame);
        }
    }
    false
}
