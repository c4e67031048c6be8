//! What a source sends, in one queue with a bound, and the thread that sends it.
//!
//! The thread is the only one that writes to the channel. It notices that the channel is closed, at the
//! latest with the next [`FromSource::Alive`], and ends the process.

use std::collections::VecDeque;
use std::sync::mpsc;
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use barrelman_media_protocol::channel::{Channel, ChannelError};
use barrelman_media_protocol::failure::SourceFailure;
use barrelman_media_protocol::source::{ALIVE_INTERVAL_MS, FromSource};
use gst::prelude::*;
use gstreamer as gst;

/// Signs of life come a little earlier than they must.
const ALIVE_INTERVAL: Duration = Duration::from_millis(ALIVE_INTERVAL_MS * 4 / 5);

/// Largest number of units that wait where the source is live: a second or two of video.
const MAX_LIVE_UNITS: usize = 60;

/// Largest number of units that wait where the source is read at the reader's pace.
const MAX_UNITS: usize = 4;

/// Longest wait for a reader of a live source.
const PATIENCE: Duration = Duration::from_secs(1);

/// Longest time for the source to take leave of its server.
const TEARDOWN: Duration = Duration::from_millis(100);

/// The bytes of a unit.
pub(super) enum Payload {
    None,
    Buffer(gst::MappedBuffer<gst::buffer::Readable>),
    Bytes(Vec<u8>),
}

impl Payload {
    pub(super) fn as_slice(&self) -> &[u8] {
        match self {
            Self::None => &[],
            Self::Buffer(buffer) => buffer.as_slice(),
            Self::Bytes(bytes) => bytes,
        }
    }
}

/// The queue.
pub(super) struct Outbox {
    is_live: bool,
    state: Mutex<State>,
    changed: Condvar,
}

#[derive(Default)]
struct State {
    waiting: VecDeque<(FromSource, Payload)>,
    units: usize,
    /// When a unit was queued, or sent, for the last time.
    moved_at: Option<Instant>,
    /// The last message is in the queue.
    is_closed: bool,
}

impl Outbox {
    /// Starts the thread. It ends the process after the last message, or when the channel is closed.
    pub(super) fn start(channel: Channel, is_live: bool, pipeline: gst::Pipeline) -> Arc<Self> {
        let outbox = Arc::new(Self { is_live, state: Mutex::default(), changed: Condvar::new() });
        let sending = outbox.clone();
        std::thread::spawn(move || {
            let sent = sending.send_all(channel);
            if matches!(sent, Err(ChannelError::Stopped)) {
                crate::log::print_line("barrelman does not read what this source sends");
            }
            leave(pipeline);
        });
        outbox
    }

    /// Queues a unit. Waits for room: for long where the source is not live, and for [`PATIENCE`] where it
    /// is, since many units may come at once after a packet that was late.
    pub(super) fn unit(&self, message: FromSource, payload: Payload) {
        let most = if self.is_live { MAX_LIVE_UNITS } else { MAX_UNITS };
        let state = self.lock();
        let is_full = |state: &mut State| state.units >= most && !state.is_closed;
        let mut state = if self.is_live {
            let waited = self.changed.wait_timeout_while(state, PATIENCE, is_full);
            let (state, waited) = waited.unwrap_or_else(PoisonError::into_inner);
            if waited.timed_out() {
                crate::log::print_line("barrelman does not read what this source sends");
                std::process::exit(1);
            }
            state
        } else {
            self.changed.wait_while(state, is_full).unwrap_or_else(PoisonError::into_inner)
        };
        if !state.is_closed {
            state.units += 1;
            state.moved_at = Some(Instant::now());
            state.waiting.push_back((message, payload));
            self.changed.notify_all();
        }
    }

    /// Queues a message without a payload.
    pub(super) fn message(&self, message: FromSource) {
        let mut state = self.lock();
        if !state.is_closed {
            state.waiting.push_back((message, Payload::None));
            self.changed.notify_all();
        }
    }

    /// Queues the last message, unless there is one. The process ends when it is sent.
    pub(super) fn end(&self, message: FromSource) {
        let mut state = self.lock();
        if !std::mem::replace(&mut state.is_closed, true) {
            state.waiting.push_back((message, Payload::None));
            self.changed.notify_all();
        }
    }

    /// How long no unit has come although the reader waits for one. Counts from `start` where there was none.
    pub(super) fn idle(&self, start: Instant) -> Duration {
        let state = self.lock();
        if state.units > 0 { Duration::ZERO } else { state.moved_at.unwrap_or(start).elapsed() }
    }

    /// Ends with a failure.
    pub(super) fn fail(&self, failure: SourceFailure) {
        self.end(FromSource::Failed(failure));
    }

    fn send_all(&self, mut channel: Channel) -> Result<(), ChannelError> {
        let mut alive_at = Instant::now();
        loop {
            let now = Instant::now();
            if now >= alive_at {
                channel.send(&FromSource::Alive, &[])?;
                alive_at = now + ALIVE_INTERVAL;
            }
            let Some((message, payload)) = self.next(alive_at) else { continue };
            channel.send(&message, payload.as_slice())?;
            self.lock().moved_at = Some(Instant::now());
            if matches!(message, FromSource::Ended | FromSource::Failed(_)) {
                return Ok(());
            }
        }
    }

    /// The next message; `None`: none has come until then.
    fn next(&self, until: Instant) -> Option<(FromSource, Payload)> {
        let mut state = self.lock();
        loop {
            if let Some((message, payload)) = state.waiting.pop_front() {
                if matches!(message, FromSource::Unit(_)) {
                    state.units -= 1;
                    self.changed.notify_all();
                }
                return Some((message, payload));
            }
            let left = until.saturating_duration_since(Instant::now());
            if left.is_zero() {
                return None;
            }
            state = self.changed.wait_timeout(state, left).unwrap_or_else(PoisonError::into_inner).0;
        }
    }

    fn lock(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// Takes leave of the server, if that is quick, and ends the process.
fn leave(pipeline: gst::Pipeline) {
    let (done, is_done) = mpsc::channel();
    std::thread::spawn(move || {
        let _ = pipeline.set_state(gst::State::Null);
        let _ = done.send(());
    });
    let _ = is_done.recv_timeout(TEARDOWN);
    std::process::exit(0);
}
