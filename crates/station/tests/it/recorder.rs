//! The recorder, with outputs in memory that can block and fail.

use std::io::{self, Write};
use std::sync::mpsc::{Receiver, TryRecvError, sync_channel};
use std::sync::{Arc, Condvar, Mutex};
use std::time::Duration;

use barrelman_host::clock::Clock;
use barrelman_pilot::CommandPath;
use barrelman_pilot::{Input, Pilot};
use barrelman_station::live::event::Event;
use barrelman_station::live::faults::FaultInjector;
use barrelman_station::live::recorder::{Extras, Recorder, RecorderInput};
use barrelman_station::live::recording_sync::{DiskSync, Wanted};
use barrelman_station::live::run_loop::{LiveStep, LiveStepObserver as _};
use barrelman_trial::records::{
    Entry, FrameFingerprint, RecordedInput, RecordedOutcome, RecordedVideo, RecordingReader, RecordingStart,
};
use barrelman_vocab::unit::{Rotation, UnitCodec};
use barrelman_vocab::video::{Capture, CaptureQuality, ColourEncoding};
use barrelman_vocab::{
    CameraRequest, EncodedUnit, OperatorRequest, Picture, PictureSize, VehicleProfile, VehicleRates,
    VideoFrame, VideoNumber,
};
use bytes::Bytes;

use crate::live_scenes::{SELECTION, at, frame, pilot};

/// A unit of this size fills a chunk, which is written before the next entry.
const WHOLE_CHUNK: usize = 1 << 20;

/// How an output answers to writes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
enum Writes {
    #[default]
    Succeed,
    Block,
    Fail,
}

/// An output in memory. Clones are the same output.
#[derive(Clone, Default)]
struct MemoryOutput(Arc<Shared>);

#[derive(Default)]
struct Shared {
    state: Mutex<OutputState>,
    changed: Condvar,
}

#[derive(Default)]
struct OutputState {
    writes: Writes,
    bytes: Vec<u8>,
}

impl MemoryOutput {
    fn set(&self, writes: Writes) {
        self.0.state.lock().unwrap().writes = writes;
        self.0.changed.notify_all();
    }

    /// Waits until this number of bytes is written.
    fn wait_for(&self, bytes: usize) {
        let state = self.0.state.lock().unwrap();
        drop(self.0.changed.wait_while(state, |state| state.bytes.len() < bytes).unwrap());
    }

    fn entries(&self) -> Vec<Entry> {
        let bytes = self.0.state.lock().unwrap().bytes.clone();
        RecordingReader::new(&bytes[..]).map(Result::unwrap).collect()
    }
}

impl Write for MemoryOutput {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let state = self.0.state.lock().unwrap();
        let mut state = self.0.changed.wait_while(state, |state| state.writes == Writes::Block).unwrap();
        if state.writes == Writes::Fail {
            return Err(io::Error::from(io::ErrorKind::StorageFull));
        }
        state.bytes.extend_from_slice(bytes);
        self.0.changed.notify_all();
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

fn recording_start() -> RecordingStart {
    RecordingStart {
        program: "0".to_owned(),
        monotonic_ns: 1,
        unix_ns: 2,
        configuration: String::new(),
        videos: RecordedVideo::only("sim:test", true),
        link: String::new(),
        command_path: CommandPath::DryRun,
        trial: None,
    }
}

/// The length that an output had when the disk was waited for, and whether its name was waited for, too.
type Wait = (usize, bool);

/// The disk of an output in memory.
#[derive(Clone, Default)]
struct MemoryDisk {
    output: MemoryOutput,
    waits: Arc<(Mutex<Vec<Wait>>, Condvar)>,
}

impl MemoryDisk {
    fn add(&self, is_with_name: bool) -> io::Result<()> {
        let state = self.output.0.state.lock().unwrap();
        let (waits, changed) = &*self.waits;
        waits.lock().unwrap().push((state.bytes.len(), is_with_name));
        changed.notify_all();
        if state.writes == Writes::Fail { Err(io::Error::from(io::ErrorKind::StorageFull)) } else { Ok(()) }
    }

    /// Waits until the disk was waited for so often.
    fn waits(&self, times: usize) -> Vec<Wait> {
        let (waits, changed) = &*self.waits;
        changed.wait_while(waits.lock().unwrap(), |waits| waits.len() < times).unwrap().clone()
    }
}

impl DiskSync for MemoryDisk {
    fn wait_for(&self, wanted: Wanted) -> io::Result<()> {
        self.add(wanted == Wanted::ContentAndName)
    }
}

fn begin() -> (MemoryOutput, Recorder, Receiver<Event>) {
    begin_on(&MemoryDisk::default())
}

fn begin_on(disk: &MemoryDisk) -> (MemoryOutput, Recorder, Receiver<Event>) {
    let (recorder, queue) = begin_with(&disk.output, Box::new(disk.clone()));
    // The start is on the disk: what a test does to the output concerns what comes after it.
    disk.waits(1);
    (disk.output.clone(), recorder, queue)
}

fn begin_with(output: &MemoryOutput, sync: Box<dyn DiskSync>) -> (Recorder, Receiver<Event>) {
    let (events, queue) = sync_channel(16);
    let recorder = Recorder::begin(
        output.clone(),
        &recording_start(),
        Clock::start(),
        FaultInjector::default(),
        events,
        Extras { sync: Some(sync), ..Extras::default() },
        &VehicleProfile::fotokite_pro(),
    );
    (recorder.unwrap(), queue)
}

fn unit(index: u64, bytes: usize) -> EncodedUnit {
    EncodedUnit {
        epoch: 0,
        index,
        capture: Capture { at: at(index), quality: CaptureQuality::Sensor },
        key: true,
        shown: true,
        rotation: Rotation::None,
        codec: UnitCodec::H264AnnexB,
        payload: Bytes::from(vec![1; bytes]),
    }
}

/// Steps a pilot and the recorder. Returns the entries that the recording must have of the step.
fn step(pilot: &mut Pilot, recorder: &mut RecorderInput, index: u64, input: Input<'_>) -> [Entry; 2] {
    let now = at(1_000 + index * 10);
    let outcome = pilot.step(input, now);
    recorder.on_step(&LiveStep {
        index,
        video: VideoNumber::First,
        input,
        outcome: &outcome,
        rates: VehicleRates::REST,
    });
    let recorded = match input {
        Input::Frame(frame) => RecordedInput::Frame(FrameFingerprint::from_frame(VideoNumber::First, frame)),
        other => RecordedInput::from_frameless(&other).unwrap(),
    };
    [
        Entry::Input { step: index, now, input: recorded },
        Entry::Outcome(RecordedOutcome::new(index, &outcome, VehicleRates::REST)),
    ]
}

#[test]
fn entries_are_written_in_order_and_can_be_read_back() {
    let (output, recorder, events) = begin();
    let (mut input, mut pilot) = (recorder.input(), pilot());
    let frame = frame(0, at(1_030));
    let mut expected = vec![Entry::Start(recording_start())];
    expected.extend(step(
        &mut pilot,
        &mut input,
        0,
        Input::Request(OperatorRequest::Camera(CameraRequest::SelectNext(SELECTION))),
    ));
    expected.extend(step(
        &mut pilot,
        &mut input,
        1,
        Input::Request(OperatorRequest::Camera(CameraRequest::Engage)),
    ));
    // The video thread has a handle of its own.
    recorder.input().unit(VideoNumber::First, &unit(0, 100));
    expected.push(Entry::Unit(VideoNumber::First, unit(0, 100)));
    expected.extend(step(&mut pilot, &mut input, 2, Input::Frame(&frame)));
    expected.extend(step(&mut pilot, &mut input, 3, Input::Tick));
    assert!(recorder.finish().is_some());
    assert_eq!(output.entries(), expected);
    assert!(events.try_recv().is_err(), "no alarm");
}

#[test]
fn a_full_queue_stops_the_recording_with_one_alarm_and_never_blocks() {
    let (output, recorder, events) = begin();
    let input = recorder.input();
    output.set(Writes::Block);
    input.unit(VideoNumber::First, &unit(0, WHOLE_CHUNK));
    let mut added = 1;
    let reason = loop {
        input.unit(VideoNumber::First, &unit(added, 1));
        added += 1;
        match events.try_recv() {
            Ok(Event::RecordingFailed { reason }) => break reason,
            Ok(other) => panic!("{other:?}"),
            Err(error) => assert_eq!(error, TryRecvError::Empty),
        }
    };
    assert!(reason.contains("disk is slower"), "{reason}");
    output.set(Writes::Succeed);
    // The writer has emptied part of the queue: there is room again.
    output.wait_for(WHOLE_CHUNK + 4096);
    (0..10).for_each(|more| input.unit(VideoNumber::First, &unit(added + more, 1)));
    assert!(recorder.finish().is_none(), "the end of the run is not in the recording");
    assert!(events.try_recv().is_err(), "one alarm");
    let units = output.entries().into_iter().filter_map(|entry| match entry {
        Entry::Unit(_, unit) => Some(unit.index),
        _ => None,
    });
    assert!(units.eq(0..added - 1), "what was added before the alarm is there, without a gap");
}

#[test]
fn pictures_that_wait_for_the_disk_take_a_bounded_memory_and_do_not_end_the_recording() {
    let (output, recorder, events) = begin();
    let (mut input, mut pilot) = (recorder.input(), pilot());
    output.set(Writes::Block);
    input.unit(VideoNumber::First, &unit(0, WHOLE_CHUNK));
    let picture = Arc::new(Picture::black(PictureSize::new(1920, 1080), ColourEncoding::JPEG));
    let mut expected = vec![Entry::Unit(VideoNumber::First, unit(0, WHOLE_CHUNK))];
    for index in 0..200 {
        let frame = VideoFrame { picture: Arc::clone(&picture), ..frame(index, at(1_000 + index * 10)) };
        expected.extend(step(&mut pilot, &mut input, index, Input::Frame(&frame)));
    }
    let held = Arc::strong_count(&picture) * picture.samples().len();
    assert!(held < 140 << 20, "{held} bytes");
    output.set(Writes::Succeed);
    assert!(recorder.finish().is_some());
    assert!(events.try_recv().is_err(), "no alarm");
    assert_eq!(output.entries()[1..], expected, "a picture and its fingerprint are recorded alike");
}

#[test]
fn units_that_wait_for_the_disk_take_a_bounded_memory() {
    let (output, recorder, events) = begin();
    let input = recorder.input();
    output.set(Writes::Block);
    input.unit(VideoNumber::First, &unit(0, WHOLE_CHUNK));
    let raw = unit(1, 16 << 20);
    (1..20).for_each(|index| input.unit(VideoNumber::First, &EncodedUnit { index, ..raw.clone() }));
    let Ok(Event::RecordingFailed { reason }) = events.try_recv() else { panic!("no alarm") };
    assert!(reason.contains("disk is slower"), "{reason}");
    output.set(Writes::Succeed);
    assert!(recorder.finish().is_none());
}

#[test]
fn a_write_error_stops_the_recording_with_one_alarm() {
    let (output, recorder, events) = begin();
    let input = recorder.input();
    output.set(Writes::Fail);
    input.unit(VideoNumber::First, &unit(0, WHOLE_CHUNK));
    input.unit(VideoNumber::First, &unit(1, 1));
    let Event::RecordingFailed { reason } = events.recv().unwrap() else { panic!("no alarm") };
    assert!(reason.starts_with("the recording cannot be written"), "{reason}");
    (2..10).for_each(|index| input.unit(VideoNumber::First, &unit(index, 1)));
    assert!(recorder.finish().is_none(), "the end of the run is not in the recording");
    assert!(events.try_recv().is_err(), "one alarm");
}

#[test]
fn the_disk_has_the_start_at_once_and_the_whole_recording_at_the_end() {
    let disk = MemoryDisk::default();
    let (output, recorder, _events) = begin_on(&disk);
    let start = output.0.state.lock().unwrap().bytes.len();
    assert_eq!(disk.waits(1), [(start, true)]);
    recorder.input().unit(VideoNumber::First, &unit(0, 100));
    // Every two seconds.
    let (length, is_with_name) = disk.waits(2)[1];
    assert!(length > start + 100 && !is_with_name, "{length} bytes");
    recorder.finish();
    let length = output.0.state.lock().unwrap().bytes.len();
    assert_eq!(disk.waits(3)[2..], [(length, true)]);
}

/// A disk that is waited for until the lock is free.
struct StalledDisk(Arc<Mutex<()>>);

impl DiskSync for StalledDisk {
    fn wait_for(&self, _: Wanted) -> io::Result<()> {
        drop(self.0.lock().unwrap());
        Ok(())
    }
}

#[test]
fn a_disk_that_stalls_holds_up_no_recording() {
    let stall = Arc::new(Mutex::new(()));
    let stalled = stall.lock().unwrap();
    let output = MemoryOutput::default();
    let (recorder, events) = begin_with(&output, Box::new(StalledDisk(Arc::clone(&stall))));
    let start = output.0.state.lock().unwrap().bytes.len();
    recorder.input().unit(VideoNumber::First, &unit(0, 100_000));
    while output.0.state.lock().unwrap().bytes.len() < start + 100_000 {
        std::thread::sleep(Duration::from_millis(10));
    }
    drop(stalled);
    assert!(recorder.finish().is_some() && events.try_recv().is_err());
}

#[test]
fn a_disk_that_does_not_keep_the_recording_ends_it_with_an_alarm() {
    let disk = MemoryDisk::default();
    let (output, recorder, events) = begin_on(&disk);
    output.set(Writes::Fail);
    let Event::RecordingFailed { reason } = events.recv().unwrap() else { panic!("no alarm") };
    assert!(reason.starts_with("the disk does not keep the recording"), "{reason}");
    assert!(recorder.finish().is_none());
}

#[test]
fn an_output_that_cannot_be_written_is_refused_at_the_start() {
    let output = MemoryOutput::default();
    output.set(Writes::Fail);
    let (events, _queue) = sync_channel(1);
    let start = recording_start();
    assert!(
        Recorder::begin(
            output,
            &start,
            Clock::start(),
            FaultInjector::default(),
            events,
            Extras::default(),
            &VehicleProfile::fotokite_pro()
        )
        .is_err()
    );
}
