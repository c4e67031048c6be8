//! Receives a live stream: connections one after the other, their units through the decoder to the sink.
//!
//! An [`Engine`] makes connections, and a [`Connection`] says what comes. This module turns that into units
//! with times of capture, and follows [`super::supervision`], which decides when to connect and when to
//! disconnect.

use std::time::{Duration, Instant};

use barrelman_host::suspend::SuspendWatch;
use barrelman_vocab::time::Timestamp;
use barrelman_vocab::unit::{EncodedUnit, Rotation, UnitCodec};
use barrelman_vocab::video::{Capture, CaptureQuality};
use bytes::Bytes;

use super::feed::{Feed, StopSignal};
use super::sender_clock::{ArrivedPicture, SenderClock, SenderReport, VideoTiming};
use super::sink::{VideoSink, VideoState};
use super::supervision::{Action, Event, State, Supervision};
use crate::error::VideoError;

/// Interval of the checks for the stop signal, a cut line and delayed units.
const POLL_INTERVAL: Duration = Duration::from_millis(50);

/// A server that is misread twice within this time is left to another engine: keep-alives come every 30 to 60
/// s.
const MISREAD_PERIOD: Duration = Duration::from_secs(120);

/// Ticks of RTP time and of MPEG-TS time per second (RFC 6184, 8.2.1; ISO/IEC 13818-1).
const CLOCK_RATE: u32 = 90_000;

/// Makes connections to one source.
pub(super) trait Engine {
    /// Maximum duration of an attempt to connect.
    const CONNECT_TIMEOUT: Duration;

    /// Begins an attempt to connect.
    ///
    /// # Errors
    /// The machine has no thread or no descriptor left.
    fn connect(&mut self) -> Result<impl Connection, VideoError>;
}

/// A connection, or an attempt to connect. Dropping it disconnects.
pub(super) trait Connection {
    /// Waits for the next event, at most until `until`.
    fn next(&mut self, until: Instant) -> ConnectionEvent;
}

/// What happens on a connection.
#[derive(Debug)]
pub(super) enum ConnectionEvent {
    /// No event before the time.
    Timeout,
    /// The server has agreed to send.
    Connected,
    /// An encoded picture.
    Unit(ReceivedUnit),
    /// Sender reports.
    Reports(Vec<SenderReport>),
    /// The attempt has failed, or the connection is broken.
    Broken(Broken),
}

/// Why there is no connection.
#[derive(Debug)]
pub(super) enum Broken {
    /// The next attempt may succeed. `is_reached`: the server was reached.
    Temporary { reason: String, is_reached: bool },
    /// The server sends what this engine does not take.
    Misread(String),
    /// The end of the stream. No further attempt is made.
    Ended,
    /// This engine cannot read the stream.
    Unsupported(VideoError),
    /// No engine can.
    Refused(VideoError),
}

/// A unit as it arrives.
#[derive(Debug)]
pub(super) struct ReceivedUnit {
    pub(super) codec: UnitCodec,
    pub(super) key: bool,
    /// Whether units are missing directly before.
    pub(super) follows_loss: bool,
    pub(super) rotation: Rotation,
    pub(super) time: ReceivedTime,
    /// Arrival of the first packet, which is nearest to the capture.
    pub(super) arrival: Timestamp,
    pub(super) payload: Bytes,
}

/// The time that a source gives to a unit.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum ReceivedTime {
    /// Of the sender's clock, in ticks of 1/90000 s.
    Ticks(u32),
    /// Time of capture.
    Captured(Timestamp),
    /// None: the time of arrival is used.
    Unknown,
}

/// How receiving ended.
#[derive(Debug)]
pub(super) enum ReceiverEnd {
    /// The stop signal was raised.
    Stopped,
    /// The stream ended.
    Ended,
    /// The stream cannot be used.
    Failed(VideoError),
    /// Another engine may do better, for this reason. It goes on where this one has ended.
    GivenUp { reason: String, progress: Progress },
}

/// What was received of a source, by any engine.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(super) struct Progress {
    /// The number of ended connections and of losses.
    pub(super) epoch: u32,
    pub(super) units: u64,
    /// Whether there was a picture.
    pub(super) was_up: bool,
}

/// Receives one source by one engine.
pub(super) struct Receiver<'a, S> {
    feed: &'a mut Feed<S>,
    supervision: Supervision,
    clock: SenderClock,
    /// What the sink knows of the times.
    timing: VideoTiming,
    suspensions: SuspendWatch,
    stop: &'a StopSignal,
    /// How long a server may be reached without a picture before another engine is tried; `None`: there is no
    /// other.
    patience: Option<Duration>,
    /// When the server was reached first.
    reached_at: Option<Timestamp>,
    /// When a connection ended last because of what the server sent.
    misread_at: Option<Timestamp>,
    progress: Progress,
}

impl<'a, S: VideoSink> Receiver<'a, S> {
    pub(super) fn new(feed: &'a mut Feed<S>, patience: Option<Duration>, stop: &'a StopSignal) -> Self {
        Self {
            supervision: Supervision::new(feed.clock.now()),
            clock: SenderClock::new(CLOCK_RATE, feed.timing),
            timing: VideoTiming::default(),
            suspensions: SuspendWatch::start(),
            stop,
            patience,
            reached_at: None,
            misread_at: None,
            progress: Progress::default(),
            feed,
        }
    }

    /// The same, which goes on where another engine has ended.
    pub(super) fn resuming(self, progress: Progress) -> Self {
        Self { progress, ..self }
    }

    /// Receives until the stop signal, or until the stream turns out to be unusable.
    pub(super) fn run<E: Engine>(mut self, engine: &mut E) -> ReceiverEnd {
        self.supervision = self.supervision.with_connect_timeout(E::CONNECT_TIMEOUT);
        loop {
            if self.stop.wait_until(self.feed.clock.instant(self.supervision.wake_at())) {
                return ReceiverEnd::Stopped;
            }
            if self.notify(Event::Tick) != Some(Action::Connect) {
                continue;
            }
            self.feed.sink.on_state(VideoState::Connecting);
            let end = match engine.connect() {
                Ok(mut connection) => self.serve(&mut connection),
                Err(error) => return ReceiverEnd::Failed(error),
            };
            self.progress.epoch += 1;
            let reason = match end {
                ConnectionEnd::Over(end) => return end,
                ConnectionEnd::GivenUp(reason) => return self.given_up(reason),
                ConnectionEnd::Lost(reason) => reason,
                // The stream was usable before: its settings were changed and may be changed back.
                ConnectionEnd::Unusable(error) if self.progress.was_up => {
                    self.notify(Event::Broken);
                    error.to_string()
                }
                ConnectionEnd::Unusable(error) => return ReceiverEnd::Failed(error),
            };
            if self.is_out_of_patience() {
                return self.given_up(reason);
            }
            self.feed.sink.on_state(VideoState::Lost { reason });
        }
    }

    const fn given_up(&self, reason: String) -> ReceiverEnd {
        ReceiverEnd::GivenUp { reason, progress: self.progress }
    }

    fn notify(&mut self, event: Event) -> Option<Action> {
        self.supervision.handle(event, self.feed.clock.now())
    }

    /// Whether the server was reached long ago, and no picture has come.
    fn is_out_of_patience(&self) -> bool {
        let (Some(patience), Some(reached_at)) = (self.patience, self.reached_at) else { return false };
        !self.progress.was_up && self.feed.clock.now().since(reached_at) >= patience
    }

    /// Serves one connection, from the attempt to the end.
    fn serve(&mut self, connection: &mut impl Connection) -> ConnectionEnd {
        loop {
            let wake_at = self.supervision.wake_at().min(self.feed.clock.now().plus(POLL_INTERVAL));
            let event = connection.next(self.feed.clock.instant(wake_at));
            if self.stop.is_raised() {
                return ConnectionEnd::Over(ReceiverEnd::Stopped);
            }
            let now = self.feed.clock.now();
            if let Some(reason) = self.feed.faults.as_ref().and_then(|path| path.cut(now)) {
                self.notify(Event::Broken);
                return ConnectionEnd::Lost(reason.to_owned());
            }
            let action = match self.handle(event) {
                Ok(action) => action,
                Err(end) => return end,
            };
            if let Some(Action::Disconnect(loss)) = action {
                return ConnectionEnd::Lost(loss.to_string());
            }
            if self.is_out_of_patience() {
                let reason = format!("no picture in {:.0?}", self.patience.unwrap_or_default());
                return ConnectionEnd::GivenUp(reason);
            }
        }
    }

    fn handle(&mut self, event: ConnectionEvent) -> Result<Option<Action>, ConnectionEnd> {
        match event {
            ConnectionEvent::Timeout => {
                self.deliver(None)?;
                Ok(self.notify(Event::Tick))
            }
            ConnectionEvent::Connected => {
                self.reached_at.get_or_insert(self.feed.clock.now());
                self.clock.on_connected();
                Ok(self.notify(Event::Connected))
            }
            ConnectionEvent::Unit(unit) => {
                self.on_unit(unit)?;
                Ok(self.judge_times())
            }
            ConnectionEvent::Reports(reports) => {
                reports.into_iter().for_each(|report| self.clock.on_sender_report(report));
                Ok(self.judge_times())
            }
            ConnectionEvent::Broken(broken) => {
                self.notify(Event::Broken);
                Err(self.on_broken(broken))
            }
        }
    }

    fn on_broken(&mut self, broken: Broken) -> ConnectionEnd {
        match broken {
            Broken::Temporary { reason, is_reached } => {
                if is_reached {
                    self.reached_at.get_or_insert(self.feed.clock.now());
                }
                ConnectionEnd::Lost(reason)
            }
            Broken::Misread(reason) => {
                let now = self.feed.clock.now();
                self.reached_at.get_or_insert(now);
                let is_repeated =
                    self.misread_at.replace(now).is_some_and(|at| now.since(at) < MISREAD_PERIOD);
                match self.patience {
                    Some(_) if is_repeated => ConnectionEnd::GivenUp(reason),
                    _ => ConnectionEnd::Lost(reason),
                }
            }
            Broken::Ended => ConnectionEnd::Over(ReceiverEnd::Ended),
            Broken::Unsupported(error) if self.patience.is_some() => {
                let reason = match error {
                    VideoError::Stream { what, .. } => format!("the stream {what}"),
                    other => other.to_string(),
                };
                ConnectionEnd::GivenUp(reason)
            }
            Broken::Unsupported(error) | Broken::Refused(error) => ConnectionEnd::Unusable(error),
        }
    }

    fn on_unit(&mut self, unit: ReceivedUnit) -> Result<(), ConnectionEnd> {
        if let Some(gap) = self.suspensions.check() {
            self.clock.on_suspension(gap);
        }
        // A unit never refers to a picture of another epoch: behind a loss, a new one begins.
        if unit.follows_loss && !unit.key {
            self.progress.epoch += 1;
            self.notify(Event::KeyNeeded);
        }
        let capture = self.capture(&unit);
        let unit = EncodedUnit {
            epoch: self.progress.epoch,
            index: self.progress.units,
            capture,
            key: unit.key,
            shown: true,
            rotation: unit.rotation,
            codec: unit.codec,
            payload: unit.payload,
        };
        self.progress.units += 1;
        self.deliver(Some(unit))
    }

    fn capture(&mut self, unit: &ReceivedUnit) -> Capture {
        let (bytes, arrival) = (unit.payload.len(), unit.arrival);
        match unit.time {
            ReceivedTime::Ticks(rtp) => self.clock.capture(ArrivedPicture { rtp, bytes, arrival }),
            ReceivedTime::Captured(at) => {
                Capture { at: at.min(self.feed.clock.now()), quality: CaptureQuality::Sensor }
            }
            ReceivedTime::Unknown => Capture { at: arrival, quality: CaptureQuality::Arrival },
        }
    }

    /// Tells the sink what the times of the pictures say, where that changed. A delay that stays ends the
    /// connection.
    fn judge_times(&mut self) -> Option<Action> {
        let timing = self.clock.timing();
        if timing.differs_from(self.timing) {
            self.timing = timing;
            self.feed.sink.on_timing(timing);
        }
        match timing {
            VideoTiming::Late { since, .. } => self.notify(Event::Late { since }),
            VideoTiming::InTime | VideoTiming::ClockWrong(_) => self.notify(Event::Tick),
        }
    }

    /// Passes a unit, or the delayed units that are due, through the decoder to the sink.
    fn deliver(&mut self, unit: Option<EncodedUnit>) -> Result<(), ConnectionEnd> {
        let decoded = self.feed.decode(unit);
        for unit in &decoded.units {
            self.feed.sink.on_unit(unit);
            self.notify(Event::Unit);
        }
        for frame in decoded.frames {
            if !matches!(self.supervision.state(), State::Up { .. }) {
                self.feed.sink.on_state(VideoState::Up);
            }
            self.progress.was_up = true;
            self.notify(Event::Picture);
            self.feed.sink.on_frame(frame);
        }
        match decoded.error {
            None => Ok(()),
            Some(cause) if cause.is_final() => {
                self.notify(Event::Broken);
                let address = self.feed.address.clone();
                Err(self.on_broken(Broken::Unsupported(VideoError::Decode { address, cause })))
            }
            Some(_) => {
                self.notify(Event::KeyNeeded);
                Ok(())
            }
        }
    }
}

/// The end of a connection.
enum ConnectionEnd {
    /// No other connection is made.
    Over(ReceiverEnd),
    /// No other connection is made by this engine, for this reason.
    GivenUp(String),
    /// Lost, for this reason.
    Lost(String),
    /// The stream cannot be used as it is.
    Unusable(VideoError),
}

#[cfg(test)]
mod tests;
