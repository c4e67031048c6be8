//! The events of the last hour: changes of mode, track, link and video, refusals, alarms.

use std::collections::VecDeque;
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::{Duration, SystemTime, UNIX_EPOCH};

use barrelman_trial::sortie::Happening;
use barrelman_vocab::{Note, Timestamp};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use tokio::sync::broadcast;

/// How long an event is kept.
const KEPT: Duration = Duration::from_secs(3600);
/// Largest number of events that are kept: those that a page shows. A page that connects gets them all at
/// once.
const CAPACITY: usize = 300;
/// Events that a reader may be behind before it misses some.
const BACKLOG: usize = 256;

/// An entry of the event log.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct EventEntry {
    /// Number of the entry, from 0.
    pub number: u64,
    /// When it happened, in the time of the session.
    pub at_ns: u64,
    /// When it happened: Unix time, milliseconds.
    pub unix_ms: f64,
    /// How serious it is.
    pub level: Level,
    /// The key of the page's table of words; empty where there is none.
    pub key: String,
    /// What happened, in English.
    pub text: String,
}

/// How serious an event is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Level {
    /// For the record.
    Info,
    /// To be noticed.
    Warning,
    /// To be acted on.
    Alarm,
}

/// The event log. Adding never waits for a reader.
#[derive(Debug)]
pub struct EventLog {
    entries: Mutex<(u64, VecDeque<EventEntry>)>,
    readers: broadcast::Sender<EventEntry>,
}

impl Default for EventLog {
    fn default() -> Self {
        Self { entries: Mutex::default(), readers: broadcast::channel(BACKLOG).0 }
    }
}

impl EventLog {
    /// Adds an event.
    pub fn add(&self, at: Timestamp, level: Level, key: &str, text: impl Into<String>) {
        let mut entries = self.entries();
        let (number, kept) = &mut *entries;
        let unix = SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default();
        let entry = EventEntry {
            number: *number,
            at_ns: at.as_nanos(),
            unix_ms: unix.as_secs_f64() * 1e3,
            level,
            key: key.to_owned(),
            text: text.into(),
        };
        *number += 1;
        let is_old = |entry: &EventEntry| at.since(Timestamp::from_nanos(entry.at_ns)) > KEPT;
        while kept.len() >= CAPACITY || kept.front().is_some_and(is_old) {
            kept.pop_front();
        }
        kept.push_back(entry.clone());
        // Sent under the lock, so that a new reader gets each event once.
        let _ = self.readers.send(entry);
    }

    /// Adds the mark of a moment.
    pub fn add_note(&self, at: Timestamp, note: &Note) {
        let text = Happening::Noted { text: note.text.clone() }.text();
        self.add(at, Level::Info, "note", text);
    }

    /// The kept events, oldest first, and a receiver of all later ones.
    pub fn subscribe(&self) -> (Vec<EventEntry>, broadcast::Receiver<EventEntry>) {
        let entries = self.entries();
        (entries.1.iter().cloned().collect(), self.readers.subscribe())
    }

    fn entries(&self) -> MutexGuard<'_, (u64, VecDeque<EventEntry>)> {
        self.entries.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;

    #[test]
    fn the_log_keeps_an_hour_and_a_reader_gets_what_follows() {
        let log = EventLog::default();
        log.add(Timestamp::from_secs_f64(1.0), Level::Info, "a", "first");
        log.add(Timestamp::from_secs_f64(3000.0), Level::Info, "b", "second");
        let (kept, mut later) = log.subscribe();
        assert_eq!(kept.iter().map(|entry| entry.number).collect::<Vec<_>>(), [0, 1]);
        log.add(Timestamp::from_secs_f64(3700.0), Level::Alarm, "c", "third");
        assert_eq!(later.try_recv().map(|entry| entry.text).ok(), Some("third".to_owned()));
        assert_eq!(log.subscribe().0.iter().map(|entry| entry.number).collect::<Vec<_>>(), [1, 2]);
    }

    #[test]
    fn the_log_is_bounded() {
        let log = EventLog::default();
        for _ in 0..CAPACITY + 10 {
            log.add(Timestamp::ZERO, Level::Info, "", "");
        }
        assert_eq!(log.subscribe().0.len(), CAPACITY);
    }

    fn numbers(entries: &[EventEntry]) -> Vec<u64> {
        entries.iter().map(|entry| entry.number).collect()
    }

    /// The numbers of the entries that are kept after events at these times, s.
    #[track_caller]
    fn check(times_s: &[u64], expected: &[u64]) {
        let log = EventLog::default();
        for time in times_s {
            log.add(Timestamp::from_nanos(time * 1_000_000_000), Level::Info, "", "");
        }
        assert_eq!(numbers(&log.subscribe().0), expected, "{times_s:?}");
    }

    #[test]
    fn an_event_is_kept_for_one_hour() {
        check(&[], &[]);
        check(&[0], &[0]);
        check(&[0, 3600], &[0, 1]);
        check(&[0, 3601], &[1]);
        check(&[0, 1, 2, 3602], &[2, 3]);
        check(&[0, 1, 2, 9000], &[3]);
        check(&[5, 5, 5], &[0, 1, 2]);
        // A demo's next drive begins at time zero again.
        check(&[5000, 0, 10], &[0, 1, 2]);
    }

    #[test]
    fn the_newest_events_are_kept_where_there_are_too_many() {
        let log = EventLog::default();
        for _ in 0..CAPACITY + 10 {
            log.add(Timestamp::ZERO, Level::Info, "", "");
        }
        let expected: Vec<u64> = (10..CAPACITY as u64 + 10).collect();
        assert_eq!(numbers(&log.subscribe().0), expected);
    }

    #[test]
    fn an_entry_is_what_was_added() {
        let log = EventLog::default();
        log.add(Timestamp::from_nanos(7), Level::Alarm, "no-video", "no video arrives");
        let (kept, _) = log.subscribe();
        let mut json = serde_json::to_value(&kept).unwrap();
        let unix_ms = json[0].as_object_mut().and_then(|entry| entry.remove("unix_ms"));
        assert!(unix_ms.and_then(|ms| ms.as_f64()).is_some_and(|ms| ms > 1.7e12), "a time of these years");
        let expected = json!([{"number": 0, "at_ns": 7, "level": "alarm", "key": "no-video", "text": "no video arrives"}]);
        assert_eq!(json, expected);
    }

    #[test]
    fn each_reader_gets_each_later_event_once() {
        let log = EventLog::default();
        log.add(Timestamp::ZERO, Level::Info, "", "before");
        let readers = [log.subscribe(), log.subscribe(), log.subscribe()];
        let add = |text: &str| log.add(Timestamp::ZERO, Level::Info, "", text);
        add("first");
        let late = log.subscribe();
        add("second");
        for (kept, mut later) in readers {
            assert_eq!(numbers(&kept), [0]);
            let texts = std::iter::from_fn(|| later.try_recv().ok()).map(|entry| entry.text);
            assert_eq!(texts.collect::<Vec<_>>(), ["first", "second"]);
        }
        let (kept, mut later) = late;
        assert_eq!(numbers(&kept), [0, 1]);
        assert_eq!(later.try_recv().map(|entry| entry.number), Ok(2));
    }

    #[test]
    fn a_reader_that_is_slow_loses_the_oldest_events_and_delays_nobody() {
        let log = EventLog::default();
        let (_, mut slow) = log.subscribe();
        for _ in 0..BACKLOG + 3 {
            log.add(Timestamp::ZERO, Level::Info, "", "");
        }
        assert_eq!(slow.try_recv(), Err(broadcast::error::TryRecvError::Lagged(3)));
        assert_eq!(slow.try_recv().map(|entry| entry.number), Ok(3));
    }
}
