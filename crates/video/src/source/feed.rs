//! Passes the units of a source to the decoder, and the signal that stops a source.

use std::collections::VecDeque;
use std::sync::{Condvar, Mutex, PoisonError};
use std::time::Instant;

use barrelman_vocab::unit::EncodedUnit;
use barrelman_vocab::video::VideoFrame;

use super::faulty_path::FaultyPath;
use super::sender_clock::TimingSettings;
use super::sink::{VideoSink, VideoState};
use crate::codec::decoder::UnitDecoder;
use crate::codec::mode::DecodeMode;
use crate::engine::VideoEngine;
use crate::error::{DecodeError, VideoError};
use barrelman_host::clock::Clock;
use barrelman_host::fault::FaultPlan;

/// Tells the thread of a source to end. A waiting thread wakes up.
#[derive(Debug, Default)]
pub struct StopSignal {
    raised: Mutex<bool>,
    changed: Condvar,
}

impl StopSignal {
    /// Tells the thread to end.
    pub fn raise(&self) {
        *self.raised.lock().unwrap_or_else(PoisonError::into_inner) = true;
        self.changed.notify_all();
    }

    /// Whether the thread must end.
    pub fn is_raised(&self) -> bool {
        *self.raised.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Waits until `moment`. Returns true if the thread must end.
    pub fn wait_until(&self, moment: Instant) -> bool {
        let raised = self.raised.lock().unwrap_or_else(PoisonError::into_inner);
        let left = moment.saturating_duration_since(Instant::now());
        let waited = self.changed.wait_timeout_while(raised, left, |raised| !*raised);
        *waited.unwrap_or_else(PoisonError::into_inner).0
    }
}

/// The settings of a [`Feed`].
#[derive(Debug, Clone)]
pub struct FeedSettings {
    /// The address of the source, without a password, for error messages.
    pub address: String,
    /// The deliberate faults of the source. Their times count from the program's start.
    pub faults: FaultPlan,
    /// Whether the decoder delivers each picture at once or in the order of display.
    pub mode: DecodeMode,
    /// The engine that decodes.
    pub engine: VideoEngine,
    /// How the times of a live stream are judged.
    pub timing: TimingSettings,
}

/// Passes units through the decoder to the sink.
pub struct Feed<S> {
    /// Receives units, frames and the state of the source.
    pub sink: S,
    /// The program's clock.
    pub clock: Clock,
    pub(super) address: String,
    /// The deliberate faults on the way to the decoder, if any are planned.
    pub(super) faults: Option<FaultyPath>,
    pub(super) decoder: UnitDecoder,
    pub(super) timing: TimingSettings,
}

/// The result of one call of [`Feed::decode`].
#[derive(Debug, Default)]
pub struct DecodedUnits {
    /// The units that came to the decoder, in the order of decoding.
    pub units: Vec<EncodedUnit>,
    /// Frames that are ready, in the order of display.
    pub frames: VecDeque<VideoFrame>,
    /// The first error.
    pub error: Option<DecodeError>,
}

impl<S: VideoSink> Feed<S> {
    /// A feed that starts now.
    pub fn new(settings: FeedSettings, clock: Clock, sink: S) -> Self {
        let FeedSettings { address, faults, mode, engine, timing } = settings;
        let faults = (!faults.is_empty()).then(|| FaultyPath::new(faults));
        let decoder = UnitDecoder::with_engine(mode, engine);
        Self { sink, clock, address, faults, decoder, timing }
    }

    /// Decodes what comes of a unit on its way. Without a unit: decodes the delayed units that are due.
    pub fn decode(&mut self, unit: Option<EncodedUnit>) -> DecodedUnits {
        let mut decoded = DecodedUnits::default();
        match &mut self.faults {
            Some(path) => path.pass(unit, self.clock.now(), &mut |unit| decoded.units.push(unit)),
            None => decoded.units.extend(unit),
        }
        for unit in &decoded.units {
            let result = self.decoder.decode(unit, &mut |frame| decoded.frames.push_back(frame));
            if let Err(error) = result {
                self.sink.on_damage(&error);
                decoded.error.get_or_insert(error);
            }
        }
        decoded
    }

    /// Reports to the sink that the source failed.
    pub fn fail(&mut self, error: VideoError) {
        self.sink.on_state(VideoState::Failed(error));
    }

    /// Reports to the sink that the stream cannot be decoded.
    pub(super) fn fail_to_decode(&mut self, cause: DecodeError) {
        let address = self.address.clone();
        self.fail(VideoError::Decode { address, cause });
    }
}

#[cfg(test)]
mod tests {
    use std::time::Duration;

    use super::*;
    use crate::source::demux::FileReader;
    use crate::source::url::VideoUrl;

    struct NoSink;

    impl VideoSink for NoSink {
        fn on_unit(&mut self, _unit: &EncodedUnit) {}
        fn on_frame(&mut self, _frame: VideoFrame) {}
        fn on_state(&mut self, _state: VideoState) {}
    }

    /// The number of units that pass a source that is started this long after the program.
    fn passed(faults: &str, started_after_s: u64) -> usize {
        let clip = concat!(env!("CARGO_MANIFEST_DIR"), "/../../fixtures/video/baseline.mp4");
        let url = VideoUrl::parse(&format!("{clip}?fault={faults}")).unwrap();
        let clock = Clock::start().started_earlier(Duration::from_secs(started_after_s));
        let mut feed = Feed::new(url.feed_settings(), clock, NoSink);
        let mut reader = FileReader::open(&url).unwrap();
        let unit = reader.next_unit().unwrap();
        feed.decode(unit).units.len()
    }

    #[test]
    fn fault_times_count_from_the_start_of_the_program() {
        assert_eq!(passed("drop@100", 0), 1, "the fault is still to come");
        assert_eq!(passed("drop@100", 200), 0, "the fault began before the source was started");
        assert_eq!(passed("drop@0+100", 200), 1, "the fault was over before the source was started");
    }
}
