//! Reads all frames of a source one after the other, for offline use. Of a file no frame is dropped, and
//! nothing waits for a clock. A live source sets the pace.

use std::collections::VecDeque;
use std::sync::mpsc::{Receiver, RecvTimeoutError, SyncSender, TrySendError, sync_channel};
use std::time::{Duration, Instant};

use barrelman_host::clock::Clock;
use barrelman_vocab::unit::EncodedUnit;
use barrelman_vocab::video::VideoFrame;

use super::demux::FileReader;
use super::live::{VideoHandle, spawn};
use super::sink::{VideoSink, VideoState};
use super::url::{VideoSource, VideoUrl};
use crate::codec::decoder::UnitDecoder;
use crate::codec::mode::DecodeMode;
use crate::error::{DecodeError, VideoError};

/// Longest wait for the first picture of a live source.
const FIRST_PICTURE_TIMEOUT: Duration = Duration::from_secs(20);

/// Frames of a live source that wait for the reader. Further ones are dropped.
const MAX_WAITING: usize = 32;

/// The frames of a source, in the order of display.
pub struct VideoFrames {
    address: String,
    origin: Origin,
    ready: VecDeque<VideoFrame>,
    error: Option<VideoError>,
    ended: bool,
}

enum Origin {
    Stored { reader: Box<FileReader>, decoder: Box<UnitDecoder> },
    Live(LiveFrames),
}

impl VideoFrames {
    /// Opens a file, a folder or a pipe, or starts a live source.
    ///
    /// # Errors
    /// As [`FileReader::open`]. An error of a live source comes with the first frame.
    pub fn open(url: &VideoUrl) -> Result<Self, VideoError> {
        let origin = match &url.source {
            VideoSource::File(_) | VideoSource::Pipe(_) => Origin::Stored {
                reader: Box::new(FileReader::open(url)?),
                decoder: Box::new(UnitDecoder::with_engine(DecodeMode::File, url.engine)),
            },
            VideoSource::Rtsp { .. } | VideoSource::Media(_) => Origin::Live(LiveFrames::start(url)?),
        };
        let address = url.to_string();
        Ok(Self { address, origin, ready: VecDeque::new(), error: None, ended: false })
    }

    /// Upper bound of the number of frames, if the file states one.
    pub fn frame_count(&self) -> Option<u64> {
        match &self.origin {
            Origin::Stored { reader, .. } => reader.unit_count(),
            Origin::Live(_) => None,
        }
    }

    /// The next frame, or `None` at the end. Reads and decodes on the calling thread, or waits for a live
    /// source.
    ///
    /// # Errors
    /// Damage in the file. All intact frames before it are returned first. After a damaged picture
    /// ([`DecodeError::Damaged`]) the next call continues with the next key frame; after any other error no
    /// frame follows.
    pub fn next_frame(&mut self) -> Result<Option<VideoFrame>, VideoError> {
        loop {
            if let Some(frame) = self.ready.pop_front() {
                return Ok(Some(frame));
            }
            if let Some(error) = self.error.take() {
                return Err(error);
            }
            if self.ended {
                return Ok(None);
            }
            match &mut self.origin {
                Origin::Stored { .. } => self.decode_next_unit(),
                Origin::Live(live) => match live.next_frame() {
                    Ok(Some(frame)) => return Ok(Some(frame)),
                    Ok(None) => self.ended = true,
                    Err(error) => {
                        self.ended = true;
                        return Err(error);
                    }
                },
            }
        }
    }

    fn decode_next_unit(&mut self) {
        let Origin::Stored { reader, decoder } = &mut self.origin else { return };
        let mut out = |frame| self.ready.push_back(frame);
        let result = match reader.next_unit() {
            Ok(Some(unit)) => decoder
                .decode(&unit, &mut out)
                .map_err(|cause| VideoError::Decode { address: self.address.clone(), cause }),
            Ok(None) => {
                self.ended = true;
                Ok(())
            }
            Err(error) => Err(error),
        };
        if let Err(error) = result {
            let may_continue = matches!(error, VideoError::Decode { cause: DecodeError::Damaged { .. }, .. });
            self.error = Some(error);
            self.ended |= !may_continue;
        }
        if self.ended {
            decoder.finish(&mut out);
        }
    }
}

/// The frames of a live source, up to its first loss.
struct LiveFrames {
    address: String,
    queue: Receiver<Delivery>,
    was_up: bool,
    _source: VideoHandle,
}

enum Delivery {
    Frame(VideoFrame),
    State(VideoState),
}

struct QueueSink(SyncSender<Delivery>);

impl VideoSink for QueueSink {
    fn on_unit(&mut self, _unit: &EncodedUnit) {}

    fn on_frame(&mut self, frame: VideoFrame) {
        if let Err(TrySendError::Full(_)) = self.0.try_send(Delivery::Frame(frame)) {
            tracing::debug!("a picture is dropped: the pictures before are still being worked on");
        }
    }

    fn on_state(&mut self, state: VideoState) {
        // The queue has room for the states of a connection while its frames are read. A reader that has gone
        // needs none.
        let _ = self.0.try_send(Delivery::State(state));
    }
}

impl LiveFrames {
    fn start(url: &VideoUrl) -> Result<Self, VideoError> {
        let (deliveries, queue) = sync_channel(MAX_WAITING);
        let source = spawn(url.clone(), Clock::start(), QueueSink(deliveries))?;
        Ok(Self { address: url.to_string(), queue, was_up: false, _source: source })
    }

    fn next_frame(&mut self) -> Result<Option<VideoFrame>, VideoError> {
        let deadline = Instant::now() + FIRST_PICTURE_TIMEOUT;
        let mut reason = "it does not answer".to_owned();
        loop {
            let wait = deadline.saturating_duration_since(Instant::now());
            match self.queue.recv_timeout(wait) {
                Ok(Delivery::Frame(frame)) => {
                    self.was_up = true;
                    return Ok(Some(frame));
                }
                Ok(Delivery::State(VideoState::Ended)) => return Ok(None),
                Ok(Delivery::State(VideoState::Failed(error))) => return Err(error),
                Ok(Delivery::State(VideoState::Lost { .. })) if self.was_up => return Ok(None),
                Ok(Delivery::State(VideoState::Lost { reason: newest })) => reason = newest,
                Ok(Delivery::State(VideoState::Connecting | VideoState::Up)) => {}
                Err(RecvTimeoutError::Timeout) => {
                    let seconds = FIRST_PICTURE_TIMEOUT.as_secs();
                    return Err(VideoError::Stream {
                        address: self.address.clone(),
                        what: format!("gave no picture within {seconds} s: {reason}"),
                        remedy: "`barrelman check --video` tries it again".to_owned(),
                    });
                }
                Err(RecvTimeoutError::Disconnected) => return Ok(None),
            }
        }
    }
}
