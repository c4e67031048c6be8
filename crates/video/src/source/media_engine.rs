//! GStreamer as the engine of a live stream: each connection is a process `barrelman-media`.

use std::time::{Duration, Instant};

use barrelman_host::clock::Clock;
use barrelman_media_protocol::channel::ChannelError;
use barrelman_media_protocol::role::Role;
use barrelman_media_protocol::source::{FromSource, SourceReport, SourceSettings, SourceUnit, UnitTime};
use barrelman_vocab::time::Timestamp;
use bytes::Bytes;

use super::receiver::{Broken, Connection, ConnectionEvent, Engine, ReceivedTime, ReceivedUnit};
use super::sender_clock::SenderReport;
use super::wall_time::{sender_wall_ns, since_1900_ns};
use crate::error::VideoError;
use crate::media::MediaProgram;
use crate::media::process::{MediaProcess, START_TIMEOUT};

/// A process that says nothing for this long has stopped.
const MAX_SILENCE: Duration = Duration::from_millis(700);

/// The engine for one source.
pub(super) struct MediaEngine {
    pub(super) program: MediaProgram,
    pub(super) settings: SourceSettings,
    /// The address for messages.
    pub(super) shown_address: String,
    pub(super) clock: Clock,
}

impl Engine for MediaEngine {
    // The process has its own, shorter limits once it has started.
    const CONNECT_TIMEOUT: Duration = START_TIMEOUT;

    fn connect(&mut self) -> Result<impl Connection, VideoError> {
        let role = Role::Source(self.settings.clone());
        let process = MediaProcess::start(&self.program, role)?;
        Ok(MediaConnection {
            process,
            shown_address: self.shown_address.clone(),
            clock: self.clock,
            silent_after: Instant::now() + START_TIMEOUT,
            may_end: self.settings.address.may_end(),
            is_open: false,
        })
    }
}

struct MediaConnection {
    process: MediaProcess,
    shown_address: String,
    clock: Clock,
    /// When silence means that the process has stopped.
    silent_after: Instant,
    may_end: bool,
    is_open: bool,
}

impl Connection for MediaConnection {
    fn next(&mut self, until: Instant) -> ConnectionEvent {
        loop {
            let (message, payload) = match self.process.receive::<FromSource>(until) {
                Ok(Some(message)) => message,
                Ok(None) if Instant::now() >= self.silent_after => {
                    return self.broken(&ChannelError::Stopped);
                }
                Ok(None) => return ConnectionEvent::Timeout,
                Err(error) => return self.broken(&error),
            };
            self.silent_after = Instant::now() + MAX_SILENCE;
            match message {
                FromSource::Alive if Instant::now() >= until => return ConnectionEvent::Timeout,
                FromSource::Alive => {}
                FromSource::Note(note) => tracing::warn!("{}: {note}", self.shown_address),
                FromSource::Opened(what) => {
                    tracing::info!("{}: {what}", self.shown_address);
                    self.is_open = true;
                    return ConnectionEvent::Connected;
                }
                FromSource::Unit(unit) => return ConnectionEvent::Unit(self.unit(unit, payload)),
                FromSource::SenderReport(report) => {
                    return ConnectionEvent::Reports(vec![self.report(report)]);
                }
                FromSource::Ended if self.may_end => return ConnectionEvent::Broken(Broken::Ended),
                FromSource::Ended => {
                    let reason = "the stream ended".to_owned();
                    return ConnectionEvent::Broken(Broken::Temporary { reason, is_reached: self.is_open });
                }
                FromSource::Failed(failure) if failure.is_final => {
                    let address = self.shown_address.clone();
                    let (what, remedy) = (failure.what, failure.remedy);
                    let error = VideoError::Stream { address, what, remedy };
                    return ConnectionEvent::Broken(Broken::Refused(error));
                }
                FromSource::Failed(failure) => {
                    let separator = if failure.remedy.is_empty() { "" } else { ". " };
                    let reason = format!("it {}{separator}{}", failure.what, failure.remedy);
                    return ConnectionEvent::Broken(Broken::Temporary { reason, is_reached: self.is_open });
                }
            }
        }
    }
}

impl MediaConnection {
    fn broken(&mut self, error: &ChannelError) -> ConnectionEvent {
        let reason = self.process.end(error);
        ConnectionEvent::Broken(Broken::Temporary { reason, is_reached: self.is_open })
    }

    fn unit(&self, unit: SourceUnit, payload: Vec<u8>) -> ReceivedUnit {
        ReceivedUnit {
            codec: unit.codec,
            key: unit.key,
            follows_loss: unit.follows_loss,
            rotation: unit.rotation,
            time: match unit.time {
                UnitTime::Ticks(ticks) => ReceivedTime::Ticks(ticks),
                // The clock of the file's sender, in the ticks of the other clocks.
                UnitTime::SinceStart(ns) => ReceivedTime::Ticks((u128::from(ns) * 9 / 100_000) as u32),
                UnitTime::Captured(ns) => ReceivedTime::Captured(self.timestamp(ns)),
                UnitTime::Unknown => ReceivedTime::Unknown,
            },
            arrival: self.timestamp(unit.arrival_ns).min(self.clock.now()),
            payload: Bytes::from(payload),
        }
    }

    fn report(&self, report: SourceReport) -> SenderReport {
        let arrival = self.timestamp(report.arrival_ns).min(self.clock.now());
        SenderReport {
            rtp: report.rtp,
            sender_wall_ns: sender_wall_ns(report.ntp),
            arrival,
            wall_ns: since_1900_ns(self.clock.now().since(arrival)),
        }
    }

    /// A moment of `CLOCK_MONOTONIC` on the program's clock.
    fn timestamp(&self, monotonic_ns: u64) -> Timestamp {
        Timestamp::from_nanos(monotonic_ns.saturating_sub(self.clock.start_on_monotonic_ns()))
    }
}
