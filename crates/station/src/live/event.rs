//! Everything that can wake the run loop, and where the loop waits for it.

use std::sync::mpsc::{Receiver, RecvTimeoutError, SyncSender};
use std::time::Duration;

use barrelman_host::absence::AbsenceWatch;
use barrelman_host::clock::Clock;
use barrelman_pilot::Detections;
use barrelman_video::VideoState;
use barrelman_video::sender_clock::VideoTiming;
use barrelman_vocab::{Timestamp, VideoNumber};

use crate::link::LinkReport;

/// An event.
#[derive(Debug)]
pub enum Event {
    /// The slot of the newest frame holds a frame of the tracked video.
    Frame,
    /// The source of a video changed its state.
    Video(VideoNumber, VideoState),
    /// What the times of a video's pictures tell has changed.
    VideoTiming(VideoNumber, VideoTiming),
    /// The link reports something.
    Link(LinkReport),
    /// A report of the link to the boat.
    Vessel(LinkReport),
    /// The detector has looked at a frame.
    Detections(Box<Detections>),
    /// The gateway holds requests or a stop, or the controlling page is gone or has come back.
    Operator,
    /// The program must end.
    Quit(QuitCause),
    /// A thread panicked.
    ThreadPanicked {
        /// The name of the thread.
        thread: String,
    },
    /// The recording had to stop.
    RecordingFailed {
        /// What happened.
        reason: String,
    },
}

/// Wakes the loop with [`Event::Operator`]. Where the queue is full, the loop is awake, and looks into the
/// gateway before its next event.
pub fn wake_by(events: SyncSender<Event>) -> impl Fn() + Send + Sync + 'static {
    move || {
        let _ = events.try_send(Event::Operator);
    }
}

/// Reports the panic of a thread with [`Event::ThreadPanicked`].
pub fn report_panics(events: SyncSender<Event>) -> impl Fn(String) + Clone + Send + 'static {
    move |thread| {
        // Without a receiver, the run is ending already.
        let _ = events.send(Event::ThreadPanicked { thread });
    }
}

/// Why the program must end.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum QuitCause {
    /// The operator pressed `q`.
    Key,
    /// A signal, by its name.
    Signal(&'static str),
    /// The reader of the standard output has closed it.
    OutputClosed,
    /// The test motions of a calibration have been made, or have ended.
    CalibrationEnded,
}

impl std::fmt::Display for QuitCause {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Key => f.write_str("q was pressed"),
            Self::Signal(name) => write!(f, "{name} was received"),
            Self::OutputClosed => f.write_str("the output was closed"),
            Self::CalibrationEnded => f.write_str("the calibration has ended"),
        }
    }
}

/// The events of a run and the time at which they arrive.
pub trait EventSource {
    /// The time now.
    fn now(&self) -> Timestamp;

    /// Waits for the next event, at most for `wait`.
    ///
    /// # Errors
    /// `Timeout` if no event arrived, `Disconnected` if no further event can arrive.
    fn next_event(&mut self, wait: Duration) -> Result<Event, RecvTimeoutError>;

    /// How long the loop made no turn since the last call, if it was away for a second or more, or the
    /// machine was suspended.
    fn suspension(&mut self) -> Option<Duration> {
        None
    }
}

/// The queue into which the threads of a live run put their events.
#[derive(Debug)]
pub struct EventQueue {
    /// The queue. Dropping it releases the threads that wait to add an event.
    pub queue: Receiver<Event>,
    /// The program's clock.
    pub clock: Clock,
    /// Detects that the loop was away.
    pub absence: AbsenceWatch,
}

impl EventSource for EventQueue {
    fn now(&self) -> Timestamp {
        self.clock.now()
    }

    fn next_event(&mut self, wait: Duration) -> Result<Event, RecvTimeoutError> {
        self.queue.recv_timeout(wait)
    }

    fn suspension(&mut self) -> Option<Duration> {
        self.absence.turn(self.clock.now())
    }
}

#[cfg(test)]
mod tests {
    use std::sync::mpsc::sync_channel;

    use super::*;

    #[test]
    fn waking_delays_nobody() {
        let (events, queue) = sync_channel(2);
        let wake = wake_by(events);
        for _ in 0..10 {
            wake();
        }
        assert_eq!(queue.try_iter().filter(|event| matches!(event, Event::Operator)).count(), 2);
        drop(queue);
        // A loop that has ended delays nobody either.
        wake();
    }
}
