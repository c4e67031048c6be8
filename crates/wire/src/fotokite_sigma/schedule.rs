//! Which states are read when, beside the commands: one after the other on the lane of the states, and the
//! camera's on its own.

use core::time::Duration;

use barrelman_vocab::Timestamp;

use super::call::{Call, StreamId};

/// Interval at which the camera's state is read while no WebSocket tells it.
pub const CAMERA_INTERVAL: Duration = Duration::from_millis(200);
/// The same while zeros are sent, until two states show rest.
pub const CAMERA_INTERVAL_STOPPING: Duration = Duration::from_millis(100);
/// A WebSocket that was silent for this time does not replace the reading.
pub const SOCKET_SILENT: Duration = Duration::from_millis(500);
/// Pause before a WebSocket is opened again.
pub const SOCKET_RETRY: Duration = Duration::from_secs(10);

/// A state that is read again and again.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Reading {
    Streams,
    Stream,
    Flight,
    Notifications,
    System,
}

impl Reading {
    const fn interval(self) -> Duration {
        match self {
            // An operator's zoom changes the camera's model.
            Self::Stream => Duration::from_millis(500),
            Self::Flight => Duration::from_secs(1),
            Self::Notifications => Duration::from_secs(2),
            Self::System => Duration::from_secs(5),
            // Streams that come and go with the camera.
            Self::Streams => Duration::from_secs(10),
        }
    }
}

/// When which state is read next.
#[derive(Debug, Clone)]
pub struct Schedule {
    readings: [(Reading, Timestamp); 5],
    stream: Option<StreamId>,
    camera_at: Timestamp,
    socket_at: Timestamp,
    last_message: Option<Timestamp>,
}

impl Schedule {
    /// Everything is due at once.
    pub fn starting(now: Timestamp) -> Self {
        use Reading::{Flight, Notifications, Stream, Streams, System};
        Self {
            readings: [Flight, Streams, Stream, Notifications, System].map(|reading| (reading, now)),
            stream: None,
            camera_at: now,
            socket_at: now,
            last_message: None,
        }
    }

    /// The stream whose field of view is read.
    pub fn set_stream(&mut self, stream: Option<StreamId>) {
        self.stream = stream;
    }

    /// The stream whose field of view is read.
    pub const fn stream(&self) -> Option<&StreamId> {
        self.stream.as_ref()
    }

    /// A message of the WebSocket was understood.
    pub fn on_message(&mut self, now: Timestamp) {
        self.last_message = Some(now);
    }

    /// The WebSocket was not opened, or has ended.
    pub fn on_socket_end(&mut self, now: Timestamp) {
        (self.socket_at, self.last_message) = (now.plus(SOCKET_RETRY), None);
    }

    /// The WebSocket's opening, if it is due.
    pub fn due_socket(&mut self, now: Timestamp) -> Option<Call> {
        (self.socket_at <= now).then_some(())?;
        // It stays open until it ends.
        self.socket_at = Timestamp::from_nanos(u64::MAX);
        Some(Call::Subscribe)
    }

    /// The reading of the camera's state, if it is due.
    pub fn due_camera(&mut self, is_stopping: bool, now: Timestamp) -> Option<Call> {
        let is_told = self.last_message.is_some_and(|at| now.since(at) < SOCKET_SILENT);
        (self.camera_at <= now && !is_told).then_some(())?;
        self.camera_at = now.plus(if is_stopping { CAMERA_INTERVAL_STOPPING } else { CAMERA_INTERVAL });
        Some(Call::CameraState)
    }

    /// Another reading that is due.
    pub fn due_state(&mut self, now: Timestamp) -> Option<Call> {
        let stream = self.stream.clone();
        let is_due = |(reading, at): &&mut (Reading, Timestamp)| {
            *at <= now && (*reading != Reading::Stream || stream.is_some())
        };
        let (reading, at) = self.readings.iter_mut().filter(|one| is_due(one)).min_by_key(|(_, at)| *at)?;
        *at = now.plus(reading.interval());
        Some(match reading {
            Reading::Streams => Call::VideoStreams,
            Reading::Stream => Call::VideoStreamState { stream: stream? },
            Reading::Flight => Call::FlightState,
            Reading::Notifications => Call::Notifications,
            Reading::System => Call::SystemState,
        })
    }

    /// When the next reading is due. While messages arrive, the camera's is looked at again at the same
    /// interval.
    pub fn wake_at(&self, now: Timestamp) -> Timestamp {
        let states = self.readings.iter().map(|(_, at)| *at).min().unwrap_or(now);
        states.min(self.camera_at.max(now.plus(CAMERA_INTERVAL_STOPPING))).min(self.socket_at)
    }
}
