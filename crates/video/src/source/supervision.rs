//! Decides when to connect to a live source, when to disconnect, and when to try again.
//!
//! The state machine has no clock and no thread. It receives events with their times, returns actions, and
//! states the time of the next tick that it needs ([`Supervision::wake_at`]). The end of a stream, an error
//! and silence all count as a loss: a disconnected tether causes neither an end nor an error.

use std::time::Duration;

use barrelman_vocab::time::Timestamp;

/// Maximum duration of an attempt to connect, up to the server's answer to PLAY. That takes 4 to 7 round
/// trips (TCP, TLS, DESCRIBE, again with the login, SETUP, PLAY), and over a cellular or satellite link a
/// round trip takes up to 0.6 s.
pub const CONNECT_TIMEOUT: Duration = Duration::from_secs(5);

/// Maximum silence of a connected source: 60 pictures at 30 per second.
pub const MAX_SILENCE: Duration = Duration::from_secs(2);

/// Maximum wait for a key frame while other units arrive. Cameras commonly send one every 1 to 5 s, some
/// every 10 s.
pub const KEY_FRAME_TIMEOUT: Duration = Duration::from_secs(12);

/// First pause before a new attempt. The pause doubles with each attempt without a picture.
pub const MIN_RETRY_PAUSE: Duration = Duration::from_millis(250);

/// Pictures that are late for this long come out of a queue that a new connection drops. A burst after a gap
/// is over by then.
pub const MAX_LATENESS: Duration = Duration::from_secs(4);

/// Minimum time from one disconnection for late pictures to the next: the delay may lie before the server. It
/// doubles with each of them, up to the maximum, and begins anew after a longer time without.
pub const MIN_LATE_PAUSE: Duration = Duration::from_secs(30);

/// Maximum of the same.
pub const MAX_LATE_PAUSE: Duration = Duration::from_secs(600);

/// Maximum pause before a new attempt.
pub const MAX_RETRY_PAUSE: Duration = Duration::from_secs(1);

/// The state of a live source.
///
/// ```text
///             tick at `until`: Connect                 connected
///   Resting ------------------------> Connecting -----------------> AwaitingKey
///    ^ ^ ^                             |                             |  ^   |
///    | | +---- broken, or tick --------+                     picture |  |   |
///    | |       at since + 5 s: Disconnect                            v  |   |
///    | +------ broken, or tick at last_picture + 2 s: Disconnect ---- Up    |
///    | +------ late for 4 s, once: Disconnect --------------------- Up      |
///    |                                             Up -- key needed --> AwaitingKey
///    +---- broken, or tick at last_unit + 2 s or since + 12 s: Disconnect --+
/// ```
/// A unit in `AwaitingKey` and a picture in `Up` only update `last_unit` and `last_picture`. An event without
/// an arrow is ignored.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum State {
    /// Waiting before the next attempt.
    Resting {
        /// Start of the next attempt.
        until: Timestamp,
    },
    /// An attempt to connect.
    Connecting {
        /// Start of the attempt.
        since: Timestamp,
    },
    /// Connected, without a decodable picture.
    AwaitingKey {
        /// Start of this state.
        since: Timestamp,
        /// Arrival of the last unit; at first, the time of the connection.
        last_unit: Timestamp,
    },
    /// Pictures arrive.
    Up {
        /// Time of the last picture.
        last_picture: Timestamp,
    },
}

/// An event.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Event {
    /// Time has passed.
    Tick,
    /// The connection was made.
    Connected,
    /// An encoded unit arrived.
    Unit,
    /// A picture was decoded.
    Picture,
    /// A unit was damaged: the next picture needs a key frame.
    KeyNeeded,
    /// Every picture since then has been late.
    Late {
        /// Arrival of the first of them.
        since: Timestamp,
    },
    /// The stream ended, or failed.
    Broken,
}

/// An action of the caller.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Action {
    /// Start an attempt to connect (a new epoch).
    Connect,
    /// Close the connection, or cancel the attempt.
    Disconnect(Loss),
}

/// The reason for the end of a connection.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Loss {
    /// The server did not answer in time.
    NoAnswer,
    /// Units arrive without a key frame.
    NoKey,
    /// No unit arrives.
    Silence,
    /// The pictures are late.
    Late,
    /// The stream ended, or failed.
    Broken,
}

/// The supervision of one live source.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Supervision {
    state: State,
    connect_timeout: Duration,
    pause: Duration,
    /// The newest disconnection for late pictures.
    late: Option<LateDisconnection>,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct LateDisconnection {
    at: Timestamp,
    /// Minimum time to the next.
    pause: Duration,
}

impl Supervision {
    /// A source to connect at once.
    pub const fn new(now: Timestamp) -> Self {
        Self {
            state: State::Resting { until: now },
            connect_timeout: CONNECT_TIMEOUT,
            pause: MIN_RETRY_PAUSE,
            late: None,
        }
    }

    /// The supervision of a source whose attempts to connect may take another time.
    #[must_use]
    pub const fn with_connect_timeout(self, connect_timeout: Duration) -> Self {
        Self { connect_timeout, ..self }
    }

    /// The current state.
    pub const fn state(&self) -> State {
        self.state
    }

    /// When an [`Event::Tick`] is due if no other event occurs.
    pub fn wake_at(&self) -> Timestamp {
        match self.state {
            State::Resting { until } => until,
            State::Connecting { since } => since.plus(self.connect_timeout),
            State::AwaitingKey { since, last_unit } => {
                since.plus(KEY_FRAME_TIMEOUT).min(last_unit.plus(MAX_SILENCE))
            }
            State::Up { last_picture } => last_picture.plus(MAX_SILENCE),
        }
    }

    /// Processes an event. Returns the action to take, if any.
    pub fn handle(&mut self, event: Event, now: Timestamp) -> Option<Action> {
        match (self.state, event) {
            (State::Resting { until }, Event::Tick) if now >= until => {
                self.state = State::Connecting { since: now };
                Some(Action::Connect)
            }
            (State::Resting { .. }, _) => None,
            (_, Event::Broken) => Some(self.rest(Loss::Broken, now)),
            (State::Connecting { .. }, Event::Connected) => {
                self.state = State::AwaitingKey { since: now, last_unit: now };
                None
            }
            (State::Connecting { .. }, Event::Tick) if now >= self.wake_at() => {
                Some(self.rest(Loss::NoAnswer, now))
            }
            (State::AwaitingKey { since, .. }, Event::Unit) => {
                self.state = State::AwaitingKey { since, last_unit: now };
                None
            }
            (State::AwaitingKey { .. } | State::Up { .. }, Event::Picture) => {
                self.state = State::Up { last_picture: now };
                self.pause = MIN_RETRY_PAUSE;
                None
            }
            (State::AwaitingKey { since, .. }, Event::Tick) if now >= self.wake_at() => {
                let loss = if now >= since.plus(KEY_FRAME_TIMEOUT) { Loss::NoKey } else { Loss::Silence };
                Some(self.rest(loss, now))
            }
            (State::Up { .. }, Event::KeyNeeded) => {
                self.state = State::AwaitingKey { since: now, last_unit: now };
                None
            }
            (State::Up { .. }, Event::Late { since })
                if now.since(since) >= MAX_LATENESS && self.may_drop_queue(now) =>
            {
                Some(self.rest(Loss::Late, now))
            }
            (State::Up { .. }, Event::Tick | Event::Late { .. }) if now >= self.wake_at() => {
                Some(self.rest(Loss::Silence, now))
            }
            _ => None,
        }
    }

    /// Whether late pictures may end the connection now. If so, the next time is later.
    fn may_drop_queue(&mut self, now: Timestamp) -> bool {
        let pause = match self.late {
            Some(LateDisconnection { at, pause }) if now.since(at) < pause => return false,
            Some(LateDisconnection { at, pause }) if now.since(at) < MAX_LATE_PAUSE => {
                MAX_LATE_PAUSE.min(pause * 2)
            }
            _ => MIN_LATE_PAUSE,
        };
        self.late = Some(LateDisconnection { at: now, pause });
        true
    }

    fn rest(&mut self, loss: Loss, now: Timestamp) -> Action {
        self.state = State::Resting { until: now.plus(self.pause) };
        self.pause = MAX_RETRY_PAUSE.min(self.pause * 2);
        Action::Disconnect(loss)
    }
}

impl std::fmt::Display for Loss {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Self::NoAnswer => "it does not answer",
            Self::NoKey => "it sends no key frame (set the camera to one each second)",
            Self::Silence => "nothing comes any more",
            Self::Late => "the pictures are late: a new connection drops a queue",
            Self::Broken => "the stream ended",
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(millis: u64) -> Timestamp {
        Timestamp::from_nanos(millis * 1_000_000)
    }

    const CONNECTING: State = State::Connecting { since: Timestamp::ZERO };
    const UP: State = State::Up { last_picture: Timestamp::ZERO };
    const AWAITING: State = State::AwaitingKey { since: Timestamp::ZERO, last_unit: Timestamp::ZERO };

    /// From a state that was entered at 0, one event at `millis`.
    fn check(from: State, event: Event, millis: u64, expected: State, action: Option<Action>) {
        let mut supervision = Supervision { state: from, ..Supervision::new(at(0)) };
        assert_eq!(supervision.handle(event, at(millis)), action, "{from:?} {event:?} at {millis} ms");
        assert_eq!(supervision.state, expected, "{from:?} {event:?} at {millis} ms");
    }

    fn resting(millis: u64) -> State {
        State::Resting { until: at(millis) }
    }

    #[test]
    fn a_source_at_rest_is_connected_when_its_time_has_come() {
        check(resting(250), Event::Tick, 249, resting(250), None);
        check(resting(250), Event::Tick, 250, State::Connecting { since: at(250) }, Some(Action::Connect));
        check(resting(250), Event::Broken, 300, resting(250), None);
    }

    #[test]
    fn an_attempt_ends_connected_broken_or_unanswered() {
        let key = State::AwaitingKey { since: at(500), last_unit: at(500) };
        check(CONNECTING, Event::Connected, 500, key, None);
        check(CONNECTING, Event::Broken, 500, resting(750), Some(Action::Disconnect(Loss::Broken)));
        check(CONNECTING, Event::Tick, 4999, CONNECTING, None);
        check(CONNECTING, Event::Tick, 5000, resting(5250), Some(Action::Disconnect(Loss::NoAnswer)));
    }

    #[test]
    fn waiting_for_a_key_frame_ends_with_a_picture_silence_or_impatience() {
        check(AWAITING, Event::Picture, 400, State::Up { last_picture: at(400) }, None);
        let later = State::AwaitingKey { since: at(0), last_unit: at(1500) };
        check(AWAITING, Event::Unit, 1500, later, None);
        check(later, Event::Tick, 2000, later, None);
        check(AWAITING, Event::Tick, 2000, resting(2250), Some(Action::Disconnect(Loss::Silence)));
        check(AWAITING, Event::Broken, 100, resting(350), Some(Action::Disconnect(Loss::Broken)));
        let long = State::AwaitingKey { since: at(0), last_unit: at(11_900) };
        check(long, Event::Tick, 12_000, resting(12_250), Some(Action::Disconnect(Loss::NoKey)));
    }

    #[test]
    fn a_source_that_is_up_is_lost_by_silence_or_an_end() {
        check(UP, Event::Picture, 33, State::Up { last_picture: at(33) }, None);
        check(UP, Event::Unit, 1000, UP, None);
        check(UP, Event::Tick, 1999, UP, None);
        check(UP, Event::Tick, 2000, resting(2250), Some(Action::Disconnect(Loss::Silence)));
        check(UP, Event::Broken, 10, resting(260), Some(Action::Disconnect(Loss::Broken)));
    }

    #[test]
    fn pictures_that_stay_late_end_the_connection_once() {
        let up = State::Up { last_picture: at(9000) };
        let late = Event::Late { since: at(5000) };
        check(up, late, 8999, up, None);
        check(up, late, 9000, resting(9250), Some(Action::Disconnect(Loss::Late)));
        check(AWAITING, late, 1000, AWAITING, None);
    }

    #[test]
    fn the_next_connection_with_late_pictures_lasts_longer() {
        let mut supervision = Supervision::new(at(0));
        let mut ends_s = Vec::new();
        for second in 0..4000 {
            supervision.state = State::Up { last_picture: at(second * 1000) };
            let event = Event::Late { since: at(0) };
            if supervision.handle(event, at(second * 1000)) == Some(Action::Disconnect(Loss::Late)) {
                ends_s.push(second);
            }
        }
        assert_eq!(ends_s[..7], [4, 34, 94, 214, 454, 934, 1534]);
    }

    #[test]
    fn after_damage_a_key_frame_is_awaited() {
        let key = State::AwaitingKey { since: at(50), last_unit: at(50) };
        check(UP, Event::KeyNeeded, 50, key, None);
        check(AWAITING, Event::KeyNeeded, 50, AWAITING, None);
    }

    #[test]
    fn pauses_double_up_to_a_second_and_begin_anew_after_a_picture() {
        let mut supervision = Supervision::new(at(0));
        let mut pauses = Vec::new();
        for _ in 0..5 {
            let now = supervision.wake_at();
            assert_eq!(supervision.handle(Event::Tick, now), Some(Action::Connect));
            supervision.handle(Event::Broken, now);
            pauses.push(supervision.wake_at().since(now).as_millis());
        }
        assert_eq!(pauses, [250, 500, 1000, 1000, 1000]);
        let now = supervision.wake_at();
        for event in [Event::Tick, Event::Connected, Event::Picture, Event::Broken] {
            supervision.handle(event, now);
        }
        assert_eq!(supervision.wake_at().since(now), MIN_RETRY_PAUSE);
    }
}
