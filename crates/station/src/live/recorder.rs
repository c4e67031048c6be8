//! The recorder: takes entries from a bounded queue and writes them, on a thread of its own.
//!
//! It flushes twice a second, so a process that is killed loses less than one second. Where the disk is full, or slower
//! than what comes, the recording stops with an alarm; the pilot goes on.

use std::io::BufWriter;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError, SyncSender, TrySendError, sync_channel};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use anyhow::{Context, Result};
use barrelman_trial::records::{
    Entry, FrameFingerprint, RecordedInput, RecordedOutcome, RecordingStart, RecordingWriter, WriteError,
};
use barrelman_vocab::{EncodedUnit, Timestamp, VideoFrame};

use super::event::Event;
use super::threads::{self, FaultInjector};
use barrelman_host::clock::Clock;
use barrelman_host::output::OutputFile;

/// Entries that may wait to be written: some ten seconds of a run.
const QUEUE: usize = 2048;
/// How often what was written is handed to the system: twice a second, so that what a killed process loses stays
/// below one.
const FLUSH_INTERVAL: Duration = Duration::from_millis(500);

enum Item {
    Unit(EncodedUnit),
    /// A frame that was put into the pilot: stamped here, since that reads its whole luma plane.
    Frame {
        step: u64,
        now: Timestamp,
        frame: VideoFrame,
    },
    Input {
        step: u64,
        now: Timestamp,
        input: RecordedInput,
    },
    Outcome(Box<RecordedOutcome>),
    End,
}

/// The way into a recording. Cloning it gives another thread a way in.
#[derive(Clone)]
pub struct RecorderInput {
    items: SyncSender<Item>,
    events: SyncSender<Event>,
    failed: Arc<AtomicBool>,
}

impl RecorderInput {
    /// A unit of video as received.
    pub fn unit(&self, unit: &EncodedUnit) {
        self.put(Item::Unit(unit.clone()));
    }

    /// A frame that was put into the pilot.
    pub fn frame(&self, step: u64, now: Timestamp, frame: &VideoFrame) {
        self.put(Item::Frame { step, now, frame: frame.clone() });
    }

    /// Any other input of the pilot.
    pub fn input(&self, step: u64, now: Timestamp, input: RecordedInput) {
        self.put(Item::Input { step, now, input });
    }

    /// What came of a step.
    pub fn outcome(&self, outcome: RecordedOutcome) {
        self.put(Item::Outcome(Box::new(outcome)));
    }

    /// Never waits: a recording that cannot keep up must not hold the pilot. One with a gap in it could not be
    /// replayed, so it ends there.
    fn put(&self, item: Item) {
        if self.failed.load(Ordering::Relaxed) {
            return;
        }
        if let Err(TrySendError::Full(_)) = self.items.try_send(item)
            && !self.failed.swap(true, Ordering::Relaxed)
        {
            let reason = "the disk is slower than what is to be recorded".to_owned();
            // A full queue of events means that the loop is far behind: it will see the status soon enough.
            let _ = self.events.try_send(Event::RecordingFailed { reason });
        }
    }
}

/// A recording that is being written.
pub struct Recorder {
    input: RecorderInput,
    thread: JoinHandle<()>,
}

impl Recorder {
    /// Begins a recording.
    ///
    /// # Errors
    /// If the file cannot be written.
    pub fn begin(
        file: OutputFile,
        start: &RecordingStart,
        clock: Clock,
        fault_injector: FaultInjector,
        events: SyncSender<Event>,
    ) -> Result<Self> {
        let cannot_be_written = format!("the recording {} cannot be written", file.path().display());
        let writer = RecordingWriter::begin(BufWriter::new(file), start)
            .and_then(|mut writer| writer.flush().map(|()| writer))
            .context(cannot_be_written)?;
        let (items, queue) = sync_channel(QUEUE);
        let failed = Arc::new(AtomicBool::new(false));
        let input = RecorderInput { items, events: events.clone(), failed: Arc::clone(&failed) };
        let alarm = events.clone();
        let thread = threads::spawn("recorder", events, move || {
            if let Err(error) = write(&queue, writer, clock, &fault_injector) {
                failed.store(true, Ordering::Relaxed);
                let reason = format!("{:#}", anyhow::Error::from(error));
                let _ = alarm.send(Event::RecordingFailed { reason });
            }
        })?;
        Ok(Self { input, thread })
    }

    /// A way into the recording.
    pub fn input(&self) -> RecorderInput {
        self.input.clone()
    }

    /// Ends the recording: what was put in before is written, with the file's index.
    pub fn finish(self) {
        // Of a recorder that has failed nobody listens at the other end.
        let _ = self.input.items.send(Item::End);
        let _ = self.thread.join();
    }
}

fn write(
    queue: &Receiver<Item>,
    mut writer: RecordingWriter<BufWriter<OutputFile>>,
    clock: Clock,
    fault_injector: &FaultInjector,
) -> Result<(), WriteError> {
    let mut flush_at = Instant::now() + FLUSH_INTERVAL;
    loop {
        fault_injector.apply_faults("recorder", clock.now());
        match queue.recv_timeout(flush_at.saturating_duration_since(Instant::now())) {
            Ok(Item::End) | Err(RecvTimeoutError::Disconnected) => return writer.finish(),
            Ok(Item::Unit(unit)) => writer.write(&Entry::Unit(unit))?,
            Ok(Item::Frame { step, now, frame }) => {
                let input = RecordedInput::Frame(FrameFingerprint::from_frame(&frame));
                writer.write(&Entry::Input { step, now, input })?;
            }
            Ok(Item::Input { step, now, input }) => writer.write(&Entry::Input { step, now, input })?,
            Ok(Item::Outcome(outcome)) => writer.write(&Entry::Outcome(*outcome))?,
            Err(RecvTimeoutError::Timeout) => {}
        }
        if Instant::now() >= flush_at {
            writer.flush()?;
            flush_at = Instant::now() + FLUSH_INTERVAL;
        }
    }
}
