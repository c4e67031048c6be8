//! Delivers pictures of a simulated world when they arrive, through the deliberate faults.

use std::collections::VecDeque;
use std::sync::mpsc::Receiver;

use barrelman_video::feed::{Feed, StopSignal};
use barrelman_video::{VideoError, VideoSink, VideoState};
use barrelman_vocab::{EncodedUnit, PixelBox, Timestamp};

/// What the thread `render` hands over.
pub(super) enum SourceEvent {
    /// A picture, and the time at which it arrives.
    Picture { at: Timestamp, unit: EncodedUnit, target: Option<PixelBox> },
    /// A picture could not be encoded; no further one comes.
    Failed(VideoError),
    /// The world is over.
    End,
}

/// Delivers until the world is over or the signal is raised.
pub(super) fn deliver<S: VideoSink>(arriving: &Receiver<SourceEvent>, feed: &mut Feed<S>, stop: &StopSignal) {
    let mut targets: VecDeque<(Timestamp, PixelBox)> = VecDeque::new();
    let mut is_target_told = false;
    // A channel that closes without an end belongs to a thread that panicked.
    while let Ok(delivery) = arriving.recv() {
        let (at, unit, target) = match delivery {
            SourceEvent::Picture { at, unit, target } => (at, unit, target),
            SourceEvent::Failed(error) => return feed.fail(error),
            SourceEvent::End if stop.is_raised() => return,
            SourceEvent::End => return feed.sink.on_state(VideoState::Ended),
        };
        if stop.wait_until(feed.clock.instant(at)) {
            return;
        }
        if let Some(target) = target.filter(|_| !is_target_told) {
            targets.push_back((unit.capture.at, target));
        }
        let decoded = feed.decode(Some(unit));
        decoded.units.iter().for_each(|unit| feed.sink.on_unit(unit));
        for frame in decoded.frames {
            while targets.front().is_some_and(|(at, _)| *at < frame.capture.at) {
                targets.pop_front();
            }
            let is_of_frame = |(at, _): &mut (Timestamp, PixelBox)| *at == frame.capture.at;
            if !is_target_told && let Some((_, target)) = targets.pop_front_if(is_of_frame) {
                is_target_told = true;
                feed.sink.on_target(target);
            }
            feed.sink.on_frame(frame);
        }
    }
}
