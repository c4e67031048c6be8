//! The camera's own time. A message is refused whose time differs from the camera's, and cameras' clocks are
//! often wrong.

use barrelman_vocab::Timestamp;
use jiff::Timestamp as UtcTime;
use jiff::civil::DateTime;
use jiff::tz::TimeZone;

use super::answers::DateAndTime;

/// The time on a camera's clock.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct CameraTime {
    utc: UtcTime,
    at: Timestamp,
}

impl CameraTime {
    /// The time that the camera told just now; `None`: it told none, or one that no calendar has.
    pub fn told(told: &DateAndTime, now: Timestamp) -> Option<Self> {
        let (date, time) = (told.utc.as_ref()?.date, told.utc.as_ref()?.time);
        let civil =
            DateTime::new(date.year, date.month, date.day, time.hour, time.minute, time.second.min(59), 0);
        let utc = civil.ok()?.to_zoned(TimeZone::UTC).ok()?.timestamp();
        Some(Self { utc, at: now })
    }

    /// The camera's time now, as a message states it.
    pub fn text(&self, now: Timestamp) -> String {
        let elapsed = jiff::SignedDuration::try_from(now.since(self.at)).unwrap_or_default();
        let utc = self.utc.checked_add(elapsed).unwrap_or(self.utc);
        utc.strftime("%Y-%m-%dT%H:%M:%S.%3fZ").to_string()
    }
}
