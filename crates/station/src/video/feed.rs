//! Units on their way through faults and decoder to the sink, and the signal that ends it all.

use std::collections::VecDeque;
use std::sync::{Condvar, Mutex, PoisonError};
use std::time::Instant;

use barrelman_vocab::unit::EncodedUnit;
use barrelman_vocab::video::VideoFrame;

use super::decoder::{DecodeMode, UnitDecoder};
use super::error::{DecodeError, VideoError};
use super::fault::FaultFilter;
use super::sink::{VideoSink, VideoState};
use super::url::VideoUrl;
use crate::clock::Clock;

/// Tells a thread to end, also while it waits.
#[derive(Debug, Default)]
pub(crate) struct StopSignal {
    raised: Mutex<bool>,
    changed: Condvar,
}

impl StopSignal {
    pub(crate) fn raise(&self) {
        *self.raised.lock().unwrap_or_else(PoisonError::into_inner) = true;
        self.changed.notify_all();
    }

    pub(crate) fn is_raised(&self) -> bool {
        *self.raised.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Waits until `moment`. True if the thread must end.
    pub(crate) fn wait_until(&self, moment: Instant) -> bool {
        let raised = self.raised.lock().unwrap_or_else(PoisonError::into_inner);
        let left = moment.saturating_duration_since(Instant::now());
        let waited = self.changed.wait_timeout_while(raised, left, |raised| !*raised);
        *waited.unwrap_or_else(PoisonError::into_inner).0
    }
}

/// Units on their way through faults and decoder to the sink.
pub(crate) struct Feed<S> {
    pub(crate) sink: S,
    pub(crate) clock: Clock,
    pub(crate) place: String,
    pub(super) faults: FaultFilter,
    pub(crate) decoder: UnitDecoder,
}

/// What became of a unit.
#[derive(Debug, Default)]
pub(crate) struct Fed {
    /// Frames that are ready, in the order of display.
    pub(crate) frames: VecDeque<VideoFrame>,
    /// The first error.
    pub(crate) error: Option<DecodeError>,
}

impl<S: VideoSink> Feed<S> {
    pub(crate) fn new(url: &VideoUrl, clock: Clock, sink: S) -> Self {
        let mode = if url.is_live() { DecodeMode::Live } else { DecodeMode::File };
        Self {
            sink,
            clock,
            place: url.to_string(),
            faults: FaultFilter::new(url.faults.clone()),
            decoder: UnitDecoder::new(mode),
        }
    }

    /// A unit through the faults; what is left of it is decoded. The times of faults count from the program's start.
    pub(crate) fn put(&mut self, unit: Option<EncodedUnit>) -> (Vec<EncodedUnit>, Fed) {
        let at = self.clock.now();
        self.faults.panic_if_planned(at);
        let mut units = Vec::new();
        match unit {
            Some(unit) => self.faults.pass(unit, at, &mut |unit| units.push(unit)),
            None => self.faults.release(at, &mut |unit| units.push(unit)),
        }
        let mut fed = Fed::default();
        for unit in &units {
            let decoded = self.decoder.decode(unit, &mut |frame| fed.frames.push_back(frame));
            if let Err(error) = decoded {
                self.sink.damaged(&error);
                fed.error.get_or_insert(error);
            }
        }
        (units, fed)
    }

    pub(crate) fn fail(&mut self, error: VideoError) {
        self.sink.state(VideoState::Failed(error));
    }

    /// The decoder found that the stream can never be shown.
    pub(crate) fn fail_to_decode(&mut self, cause: DecodeError) {
        let place = self.place.clone();
        self.fail(VideoError::Decode { place, cause });
    }
}

#[cfg(test)]
mod tests {
    use std::time::Duration;

    use super::*;
    use crate::video::demux::FileReader;

    struct NoSink;

    impl VideoSink for NoSink {
        fn unit(&mut self, _unit: &EncodedUnit) {}
        fn frame(&mut self, _frame: VideoFrame) {}
        fn state(&mut self, _state: VideoState) {}
    }

    /// Units that pass a source that is started this long after the program.
    fn passed(faults: &str, started_after_s: u64) -> usize {
        let clip = concat!(env!("CARGO_MANIFEST_DIR"), "/../../fixtures/video/baseline.mp4");
        let url = VideoUrl::parse(&format!("{clip}?fault={faults}")).unwrap();
        let clock = Clock::start().earlier_by(Duration::from_secs(started_after_s));
        let mut feed = Feed::new(&url, clock, NoSink);
        let mut reader = FileReader::open(&url).unwrap();
        let unit = reader.next_unit().unwrap();
        feed.put(unit).0.len()
    }

    #[test]
    fn fault_times_count_from_the_start_of_the_program() {
        assert_eq!(passed("drop@100", 0), 1, "the fault is still to come");
        assert_eq!(passed("drop@100", 200), 0, "the fault began before the source was started");
        assert_eq!(passed("drop@0+100", 200), 1, "the fault was over before the source was started");
    }
}
