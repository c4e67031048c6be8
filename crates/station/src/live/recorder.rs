//! The recorder: receives entries through a bounded queue and writes them on a thread of its own. The queue
//! is bounded by number and by memory.
//!
//! The recorder flushes twice a second, so a killed process loses less than one second. Every two seconds the
//! disk is made to keep the recording (`recording_sync`), so a power cut loses little more than two seconds.
//! If the disk is full or too slow, the recording stops with an alarm; the run goes on. So does a recording
//! that would use the disk's reserve.

use std::io::{BufWriter, Write};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError, SyncSender, TrySendError, channel, sync_channel};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use anyhow::{Context as _, Result};
use barrelman_host::clock::Clock;
use barrelman_trial::records::{
    Entry, FrameFingerprint, LiveChannels, RecordedInput, RecordedOutcome, RecordingStart, RecordingWriter,
};
use barrelman_trial::sortie::Sortie;
use barrelman_vocab::{EncodedUnit, Note, Timestamp, VehicleProfile, VideoFrame, VideoNumber};

use super::event::Event;
use super::faults::{FaultInjector, RECORDER};
use super::inbox::Inbox;
use super::recording_folder::DiskReserve;
use super::recording_sync::{DiskSync, SyncThread, Wanted};
use super::run_loop::{LiveStep, LiveStepObserver};
use super::threads;

/// Capacity of the queue of entries: some ten seconds of a run.
const QUEUE_CAPACITY: usize = 2048;
/// Memory of the units and pictures in the queue, bytes: what a disk may fall behind.
const MAX_QUEUED_BYTES: usize = 256 << 20;
/// From here on the fingerprint of a picture is queued in the place of the picture: pictures alone never fill
/// the queue.
const MAX_QUEUED_BYTES_FOR_PICTURES: usize = MAX_QUEUED_BYTES / 2;
/// Interval between flushes.
const FLUSH_INTERVAL: Duration = Duration::from_millis(500);
/// Flushes from one wait for the disk to the next: 2 s.
const FLUSHES_PER_SYNC: u32 = 4;
const NOT_KEPT: &str = "the disk does not keep the recording";

enum Item {
    Unit(VideoNumber, EncodedUnit),
    /// A video frame that the pilot processed. The recorder thread computes the fingerprint, as this reads
    /// the whole luma plane; while much is queued, the loop does.
    Frame {
        step: u64,
        now: Timestamp,
        video: VideoNumber,
        frame: VideoFrame,
    },
    Input {
        step: u64,
        now: Timestamp,
        input: RecordedInput,
    },
    Outcome(Box<RecordedOutcome>),
    Note {
        at: Timestamp,
        note: Note,
    },
    End,
}

impl Item {
    /// The memory of the unit or the picture.
    fn bytes(&self) -> usize {
        match self {
            Self::Unit(_, unit) => unit.payload.len(),
            Self::Frame { frame, .. } => frame.picture.samples().len(),
            Self::Input { .. } | Self::Outcome(_) | Self::Note { .. } | Self::End => 0,
        }
    }
}

/// Adds entries to a recording. Clones add to the same recording.
#[derive(Clone)]
pub struct RecorderInput {
    items: SyncSender<Item>,
    /// The memory of the units and pictures in the queue.
    queued_bytes: Arc<AtomicUsize>,
    events: SyncSender<Event>,
    failure: Arc<Failure>,
}

/// Whether the recording has failed, and whether the loop was told.
#[derive(Debug, Default)]
struct Failure {
    has_failed: AtomicBool,
    is_told: AtomicBool,
}

impl RecorderInput {
    /// Adds a unit of a video as received.
    pub fn unit(&self, video: VideoNumber, unit: &EncodedUnit) {
        self.enqueue(Item::Unit(video, unit.clone()));
    }

    fn frame_item(&self, step: &LiveStep<'_>, frame: &VideoFrame) -> Item {
        let (index, now, video) = (step.index, step.outcome.at, step.video);
        let queued = self.queued_bytes.load(Ordering::Relaxed);
        if queued.saturating_add(frame.picture.samples().len()) <= MAX_QUEUED_BYTES_FOR_PICTURES {
            return Item::Frame { step: index, now, video, frame: frame.clone() };
        }
        let input = RecordedInput::Frame(FrameFingerprint::from_frame(video, frame));
        Item::Input { step: index, now, input }
    }

    /// Adds an item without blocking. A full queue ends the recording, as a recording with a gap cannot be
    /// replayed.
    fn enqueue(&self, item: Item) {
        let Failure { has_failed, is_told } = &*self.failure;
        if !has_failed.load(Ordering::Relaxed) {
            let bytes = item.bytes();
            let queued = self.queued_bytes.fetch_add(bytes, Ordering::Relaxed);
            let is_too_much = queued.saturating_add(bytes) > MAX_QUEUED_BYTES;
            if !is_too_much && !matches!(self.items.try_send(item), Err(TrySendError::Full(_))) {
                return;
            }
            has_failed.store(true, Ordering::Relaxed);
        }
        if !is_told.swap(true, Ordering::Relaxed) {
            let reason = "the disk is slower than what is to be recorded".to_owned();
            // Where the loop's queue is full, the loop is told with a later item.
            let is_taken = self.events.try_send(Event::RecordingFailed { reason }).is_ok();
            is_told.store(is_taken, Ordering::Relaxed);
        }
    }
}

impl LiveStepObserver for RecorderInput {
    fn on_step(&mut self, step: &LiveStep<'_>) {
        let (index, now) = (step.index, step.outcome.at);
        self.enqueue(match RecordedInput::from_frameless(&step.input) {
            Ok(input) => Item::Input { step: index, now, input },
            Err(frame) => self.frame_item(step, frame),
        });
        let outcome = RecordedOutcome::new(index, step.outcome, step.rates);
        self.enqueue(Item::Outcome(Box::new(outcome)));
    }

    fn on_note(&mut self, at: Timestamp, note: &Note) {
        self.enqueue(Item::Note { at, note: note.clone() });
    }
}

/// What not every recording has.
#[derive(Default)]
pub struct Extras {
    /// The free space that stays on the disk.
    pub reserve: Option<DiskReserve>,
    /// Where the messages go, too.
    pub live: Option<LiveChannels>,
    /// The disk of an output that is a file.
    pub sync: Option<Box<dyn DiskSync>>,
}

/// A recording that is being written.
pub struct Recorder {
    input: RecorderInput,
    thread: JoinHandle<()>,
    /// The summary, at the end.
    sortie: Receiver<Sortie>,
}

impl Recorder {
    /// Begins a recording: writes its first record and starts the thread.
    ///
    /// # Errors
    /// If the output cannot be written.
    pub fn begin(
        output: impl Write + Send + 'static,
        start: &RecordingStart,
        clock: Clock,
        fault_injector: FaultInjector,
        events: SyncSender<Event>,
        Extras { reserve, live, sync }: Extras,
        profile: &VehicleProfile,
    ) -> Result<Self> {
        let writer = RecordingWriter::begin(BufWriter::new(output), start, profile)?;
        let mut writer = writer.with_live(live);
        writer.flush()?;
        let (items, queue) = sync_channel(QUEUE_CAPACITY);
        let failure = Arc::new(Failure::default());
        let queued_bytes = Arc::<AtomicUsize>::default();
        let input = RecorderInput {
            items,
            queued_bytes: Arc::clone(&queued_bytes),
            events: events.clone(),
            failure: Arc::clone(&failure),
        };
        let alarm = events.clone();
        let sync = sync.map(|sync| SyncThread::start(sync, events.clone())).transpose()?;
        let (finished, sortie) = channel();
        let thread = threads::spawn("recorder", events, move || {
            let mut queue = fault_injector.inbox(RECORDER, clock, queue);
            let disk = RecordingDisk { reserve, sync };
            match disk.write(&mut *queue, &queued_bytes, writer) {
                // Without a receiver, nobody wants it.
                Ok(sortie) => drop(finished.send(sortie)),
                Err(error) => {
                    failure.is_told.store(true, Ordering::Relaxed);
                    failure.has_failed.store(true, Ordering::Relaxed);
                    let reason = format!("{error:#}");
                    let _ = alarm.send(Event::RecordingFailed { reason });
                }
            }
        })?;
        Ok(Self { input, thread, sortie })
    }

    /// A handle that adds entries to the recording.
    pub fn input(&self) -> RecorderInput {
        self.input.clone()
    }

    /// Ends the recording: writes the entries added before, the summary, and the file's index. Returns the
    /// summary; `None` where the recording has failed, as it lacks the end of the run.
    pub fn finish(self) -> Option<Sortie> {
        // A thread that has failed no longer receives.
        let _ = self.input.items.send(Item::End);
        let _ = self.thread.join();
        self.sortie.try_recv().ok().filter(|_| !self.input.failure.has_failed.load(Ordering::Relaxed))
    }
}

/// The disk of a recording.
struct RecordingDisk {
    reserve: Option<DiskReserve>,
    sync: Option<SyncThread>,
}

impl RecordingDisk {
    fn write<W: Write>(
        self,
        queue: &mut dyn Inbox<Item>,
        queued_bytes: &AtomicUsize,
        mut writer: RecordingWriter<W>,
    ) -> Result<Sortie> {
        // The start is in the file already, which has its name since then.
        self.ask_for_sync(Wanted::ContentAndName)?;
        let mut flush_at = Instant::now() + FLUSH_INTERVAL;
        let mut flushes = 0;
        loop {
            match queue.next(flush_at.saturating_duration_since(Instant::now())) {
                Ok(Item::End) | Err(RecvTimeoutError::Disconnected) => return self.finish(writer),
                Ok(item) => {
                    let bytes = item.bytes();
                    entry_of(item).map_or(Ok(()), |entry| writer.write(&entry))?;
                    queued_bytes.fetch_sub(bytes, Ordering::Relaxed);
                }
                Err(RecvTimeoutError::Timeout) => {}
            }
            if Instant::now() >= flush_at {
                writer.flush()?;
                if let Some(Err(full)) = self.reserve.as_ref().map(DiskReserve::check) {
                    // What was recorded so far stays readable.
                    self.finish(writer)?;
                    return Err(full);
                }
                flushes += 1;
                if flushes % FLUSHES_PER_SYNC == 0 {
                    self.ask_for_sync(Wanted::Content)?;
                }
                flush_at = Instant::now() + FLUSH_INTERVAL;
            }
        }
    }

    fn finish<W: Write>(self, writer: RecordingWriter<W>) -> Result<Sortie> {
        let sortie = writer.finish()?;
        self.sync.map_or(Ok(()), SyncThread::finish).context(NOT_KEPT)?;
        Ok(sortie)
    }

    fn ask_for_sync(&self, wanted: Wanted) -> Result<()> {
        self.sync.as_ref().map_or(Ok(()), |sync| sync.ask(wanted)).context(NOT_KEPT)
    }
}

/// The entry of an item; `None` for the end. The fingerprint of a frame is computed here, on the recorder's
/// thread.
fn entry_of(item: Item) -> Option<Entry> {
    Some(match item {
        Item::Unit(video, unit) => Entry::Unit(video, unit),
        Item::Frame { step, now, video, frame } => {
            let input = RecordedInput::Frame(FrameFingerprint::from_frame(video, &frame));
            Entry::Input { step, now, input }
        }
        Item::Input { step, now, input } => Entry::Input { step, now, input },
        Item::Outcome(outcome) => Entry::Outcome(*outcome),
        Item::Note { at, note } => Entry::Note { at, note },
        Item::End => return None,
    })
}
