//! Time: nanoseconds of the monotonic clock since the program's start.
//!
//! Every message carries the time at which its content was valid. An age is the difference of two timestamps
//! that were passed in as arguments; only the program reads a clock.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use core::fmt;
use core::time::Duration;

/// A point in time, in nanoseconds since the program's start. Arithmetic saturates at 0 and at `u64::MAX`.
///
/// ```
/// use core::time::Duration;
///
/// use barrelman_vocab::Timestamp;
///
/// let captured = Timestamp::from_secs_f64(1.5);
/// let now = captured.plus(Duration::from_millis(200));
/// assert_eq!(now.since(captured), Duration::from_millis(200));
/// assert_eq!(captured.since(now), Duration::ZERO);
/// ```
/// Serialised as the number of nanoseconds.
#[derive(
    Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Default, Serialize, Deserialize, JsonSchema,
)]
#[serde(transparent)]
pub struct Timestamp(u64);

impl Timestamp {
    /// The program's start.
    pub const ZERO: Self = Self(0);

    /// From nanoseconds since the start.
    pub const fn from_nanos(nanos: u64) -> Self {
        Self(nanos)
    }

    /// From seconds since the start. Negative values and NaN become 0.
    pub fn from_secs_f64(seconds: f64) -> Self {
        // A float-to-integer cast saturates and maps NaN to 0.
        Self((seconds * 1e9) as u64)
    }

    /// Nanoseconds since the start.
    pub const fn as_nanos(self) -> u64 {
        self.0
    }

    /// Seconds since the start.
    pub fn as_secs_f64(self) -> f64 {
        self.0 as f64 * 1e-9
    }

    /// Time elapsed since `earlier`; zero if `earlier` is later than this.
    pub const fn since(self, earlier: Self) -> Duration {
        Duration::from_nanos(self.0.saturating_sub(earlier.0))
    }

    /// The time `span` later; saturating.
    pub const fn plus(self, span: Duration) -> Self {
        Self(self.0.saturating_add(nanos_of(span)))
    }

    /// The time `span` earlier; saturating at the program's start.
    pub const fn minus(self, span: Duration) -> Self {
        Self(self.0.saturating_sub(nanos_of(span)))
    }
}

const fn nanos_of(span: Duration) -> u64 {
    let nanos = span.as_nanos();
    if nanos > u64::MAX as u128 { u64::MAX } else { nanos as u64 }
}

impl fmt::Display for Timestamp {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:.3} s", self.as_secs_f64())
    }
}
