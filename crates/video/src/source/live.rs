//! Runs a video source in real time, on a thread of its own.
//!
//! The thread `video` reads or receives units, decodes each of them, and passes units and frames to a
//! [`VideoSink`] at once. The sink must not block; it decides which frames to drop. A file is paced by its
//! times (time of capture = start + PTS) and ends. A stream reconnects indefinitely (see
//! [`super::receiver`]).

use std::any::Any;
use std::fmt;
use std::path::Path;
use std::sync::Arc;
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant};

use barrelman_host::clock::Clock;
use barrelman_media_protocol::source::{RtspTransport, SourceSettings};
use barrelman_vocab::unit::EncodedUnit;
use barrelman_vocab::video::{Capture, CaptureQuality, VideoFrame};

use super::demux::FileReader;
use super::feed::{Feed, StopSignal};
use super::media_engine::MediaEngine;
use super::pipe::Pipe;
use super::receiver::{Progress, Receiver, ReceiverEnd};
use super::rtsp::RtspEngine;
use super::sender_clock::VideoTiming;
use super::sink::{VideoSink, VideoState};
use super::url::{VideoSource, VideoUrl};
use crate::engine::VideoEngine;
use crate::error::{DecodeError, VideoError};
use crate::media::MediaProgram;

/// A running source.
#[derive(Debug)]
pub struct VideoHandle {
    stop: Arc<StopSignal>,
    thread: Option<JoinHandle<()>>,
    /// What the source needs until it has ended.
    kept: Option<Box<dyn Any + Send>>,
}

/// Maximum wait for the thread to end after the stop signal.
const STOP_TIMEOUT: Duration = Duration::from_secs(2);

/// The thread did not end normally.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum StopError {
    /// The thread panicked.
    Panicked,
    /// The thread did not end in time, for instance because the sink blocks. It is left running.
    StillRunning,
}

impl fmt::Display for StopError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Panicked => "the video thread panicked",
            Self::StillRunning => "the video thread does not end",
        })
    }
}

impl std::error::Error for StopError {}

/// Starts a source.
///
/// # Errors
/// The system refuses a thread. An error of the source itself reaches the sink as [`VideoState::Failed`].
pub fn spawn(url: VideoUrl, clock: Clock, sink: impl VideoSink + 'static) -> Result<VideoHandle, VideoError> {
    VideoHandle::start(move |stop| {
        let feed = Feed::new(url.feed_settings(), clock, sink);
        match &url.source {
            VideoSource::File(_) => run_file(&url, feed, stop),
            VideoSource::Pipe(path) => run_pipe(&url, path, feed, stop),
            VideoSource::Rtsp { .. } | VideoSource::Media(_) => run_stream(&url, feed, stop),
        }
    })
}

/// How long a server may be reached by the built-in engine without a picture before GStreamer tries.
const PATIENCE: Duration = Duration::from_secs(5);

/// Receives a stream by the built-in engine where that reads it. Where it does not, by GStreamer.
fn run_stream<S: VideoSink>(url: &VideoUrl, mut feed: Feed<S>, stop: &StopSignal) {
    let (program, clock) = (url.engine.media_program(), feed.clock);
    let mut received = Progress::default();
    if let Some(mut engine) = built_in_engine(url, clock) {
        let patience = program.is_some().then_some(PATIENCE);
        match Receiver::new(&mut feed, patience, stop).run(&mut engine) {
            ReceiverEnd::GivenUp { reason, progress } => {
                tracing::warn!("{url}: {reason}: GStreamer reads the stream from now on");
                if progress.was_up {
                    feed.sink.on_state(VideoState::Lost { reason });
                    // The times of the other engine's pictures are judged anew.
                    feed.sink.on_timing(VideoTiming::default());
                }
                received = progress;
            }
            end => return finish(end, &mut feed),
        }
    }
    let Some(settings) = url.media_settings() else {
        return feed.fail(VideoError::Stream {
            address: url.to_string(),
            what: "is encrypted, which this command does not read".to_owned(),
            remedy: "`barrelman run` reads it".to_owned(),
        });
    };
    match program {
        Some(program) => {
            let end = Receiver::new(&mut feed, None, stop)
                .resuming(received)
                .run(&mut media_engine(url, program, settings, clock));
            finish(end, &mut feed);
        }
        None => feed.fail(VideoError::NoMedia { address: url.to_string() }),
    }
}

fn media_engine(
    url: &VideoUrl,
    program: MediaProgram,
    settings: SourceSettings,
    clock: Clock,
) -> MediaEngine {
    MediaEngine { program, settings, shown_address: url.to_string(), clock }
}

/// The built-in engine for a stream; `None`: it does not read such a stream, or must not.
fn built_in_engine(url: &VideoUrl, clock: Clock) -> Option<RtspEngine> {
    let VideoSource::Rtsp { address, login, transport } = &url.source else { return None };
    let is_tcp = matches!(transport, RtspTransport::Auto | RtspTransport::Tcp);
    if url.engine == VideoEngine::Gstreamer || !is_tcp {
        return None;
    }
    let address = url.reachable(address)?;
    Some(RtspEngine { address, login: login.clone(), shown_address: url.to_string(), clock })
}

/// Tells the sink how a stream ended.
fn finish<S: VideoSink>(end: ReceiverEnd, feed: &mut Feed<S>) {
    match end {
        ReceiverEnd::Stopped => {}
        ReceiverEnd::Ended => feed.sink.on_state(VideoState::Ended),
        ReceiverEnd::Failed(error) => feed.fail(error),
        ReceiverEnd::GivenUp { reason, .. } => feed.sink.on_state(VideoState::Lost { reason }),
    }
}

/// Plays what another program writes into a pipe, as it comes. The picture's time is that of its arrival,
/// unless GStreamer finds times in the stream.
fn run_pipe<S: VideoSink>(url: &VideoUrl, path: &Path, mut feed: Feed<S>, stop: &StopSignal) {
    feed.sink.on_state(VideoState::Connecting);
    let mut reader = match Pipe::open(path) {
        Ok(Pipe::Y4m(reader)) => reader,
        Ok(Pipe::Other(pipe)) => {
            return match pipe.reading_program(url, path) {
                Ok(program) => {
                    let settings = SourceSettings::file(pipe.path.clone(), true);
                    let mut engine = media_engine(url, program, settings, feed.clock);
                    let end = Receiver::new(&mut feed, None, stop).run(&mut engine);
                    finish(end, &mut feed);
                }
                Err(error) => feed.fail(error),
            };
        }
        Err(error) => return feed.fail(error),
    };
    let mut is_up = false;
    loop {
        let unit = match reader.next_unit() {
            Ok(Some(unit)) => unit,
            Ok(None) => return feed.sink.on_state(VideoState::Ended),
            Err(error) => return feed.fail(error),
        };
        if stop.is_raised() {
            return;
        }
        let capture = Capture { at: feed.clock.now(), quality: CaptureQuality::Arrival };
        let decoded = feed.decode(Some(EncodedUnit { capture, ..unit }));
        decoded.units.iter().for_each(|unit| feed.sink.on_unit(unit));
        for frame in decoded.frames {
            show(&mut feed, frame, &mut is_up);
        }
    }
}

/// Passes a frame to the sink. The first one says that the video is up.
fn show<S: VideoSink>(feed: &mut Feed<S>, frame: VideoFrame, is_up: &mut bool) {
    if !std::mem::replace(is_up, true) {
        feed.sink.on_state(VideoState::Up);
    }
    feed.sink.on_frame(frame);
}

impl VideoHandle {
    /// Starts a source on the thread `video`. `run` plays the source and returns when the source has ended or
    /// when the signal is raised.
    ///
    /// # Errors
    /// [`VideoError::Thread`]: the system refuses a thread.
    pub fn start(run: impl FnOnce(&StopSignal) + Send + 'static) -> Result<Self, VideoError> {
        let stop = Arc::new(StopSignal::default());
        let thread_stop = Arc::clone(&stop);
        let thread = thread::Builder::new()
            .name("video".to_owned())
            .spawn(move || run(&thread_stop))
            .map_err(VideoError::Thread)?;
        Ok(Self { stop, thread: Some(thread), kept: None })
    }

    /// The same source, which keeps `part` until it has ended.
    #[must_use]
    pub fn keeping(mut self, part: impl Send + 'static) -> Self {
        self.kept = Some(Box::new(part));
        self
    }

    /// Tells the thread to end and waits for it, at most 2 s.
    ///
    /// # Errors
    /// The thread panicked, or does not end.
    pub fn stop(mut self) -> Result<(), StopError> {
        self.stop_and_join()
    }

    /// Whether the thread has ended by itself: at the end of the file, because the source failed, or by a
    /// panic.
    pub fn is_finished(&self) -> bool {
        self.thread.as_ref().is_none_or(JoinHandle::is_finished)
    }

    fn stop_and_join(&mut self) -> Result<(), StopError> {
        self.stop.raise();
        let Some(thread) = self.thread.take() else { return Ok(()) };
        let deadline = Instant::now() + STOP_TIMEOUT;
        while !thread.is_finished() {
            if Instant::now() >= deadline {
                return Err(StopError::StillRunning);
            }
            thread::sleep(Duration::from_millis(1));
        }
        thread.join().map_err(|_| StopError::Panicked)
    }
}

impl Drop for VideoHandle {
    fn drop(&mut self) {
        // `stop` returns how the thread ended; here the result is not needed.
        let _ = self.stop_and_join();
    }
}

/// Plays a file at the pace of its times.
fn run_file<S: VideoSink>(url: &VideoUrl, mut feed: Feed<S>, stop: &StopSignal) {
    feed.sink.on_state(VideoState::Connecting);
    let mut reader = match FileReader::open(url) {
        Ok(reader) => reader,
        Err(error) => return feed.fail(error),
    };
    let start = feed.clock.now();
    let mut first = None;
    let mut is_up = false;
    let mut read_error = None;
    loop {
        let unit = match reader.next_unit() {
            Ok(unit) => unit,
            Err(error) => {
                read_error = Some(error);
                None
            }
        };
        let at_end = unit.is_none();
        let unit = unit.map(|mut unit| {
            // A part of a longer video may begin at any time.
            let first = *first.get_or_insert(unit.capture.at);
            unit.capture.at = start.plus(unit.capture.at.since(first));
            unit
        });
        let unit_at = unit.as_ref().map_or(start, |unit| unit.capture.at);
        let mut decoded = feed.decode(unit);
        if at_end {
            feed.decoder.finish(&mut |frame| decoded.frames.push_back(frame));
        }
        if let Some(error) = decoded.error.filter(DecodeError::is_final) {
            return feed.fail_to_decode(error);
        }
        // A unit is delivered with its frame, at the time of the frame. A lost unit is delivered at its own
        // time. For a unit whose picture is still in the decoder, the file is read on without a wait.
        let is_lost = decoded.units.is_empty() || feed.decoder.is_awaiting_key();
        let due = match decoded.frames.front() {
            Some(frame) => frame.capture.at,
            None if is_lost => unit_at,
            None => start,
        };
        if stop.wait_until(feed.clock.instant(due)) {
            return;
        }
        decoded.units.iter().for_each(|unit| feed.sink.on_unit(unit));
        for frame in decoded.frames {
            if stop.wait_until(feed.clock.instant(frame.capture.at)) {
                return;
            }
            show(&mut feed, frame, &mut is_up);
        }
        if at_end {
            return match read_error {
                Some(error) => feed.fail(error),
                None => feed.sink.on_state(VideoState::Ended),
            };
        }
    }
}
