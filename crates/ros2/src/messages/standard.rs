//! `builtin_interfaces` and `std_msgs`.

use serde::Serialize;

/// `builtin_interfaces/Time`: since 1970, UTC.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize)]
pub struct Time {
    /// Whole seconds.
    pub sec: i32,
    /// Nanoseconds of the second.
    pub nanosec: u32,
}

impl Time {
    /// Nanoseconds since 1970. A time that the message cannot hold becomes the nearest one.
    pub fn from_nanos(nanos: i128) -> Self {
        const SECOND: i128 = 1_000_000_000;
        let whole = nanos.div_euclid(SECOND);
        let sec = i32::try_from(whole).unwrap_or(if whole < 0 { i32::MIN } else { i32::MAX });
        // A remainder of a second is below 2^30.
        Self { sec, nanosec: nanos.rem_euclid(SECOND) as u32 }
    }
}

/// `std_msgs/Header`.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize)]
pub struct Header {
    /// The time.
    pub stamp: Time,
    /// The frame of reference.
    pub frame_id: String,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_time_has_seconds_and_the_rest() {
        for (nanos, sec, nanosec) in [
            (0, 0, 0),
            (1_764_000_000_123_456_789, 1_764_000_000, 123_456_789),
            (-1, -1, 999_999_999),
            (i128::from(i32::MAX) * 1_000_000_000 + 1_000_000_000, i32::MAX, 0),
        ] {
            assert_eq!(Time::from_nanos(nanos), Time { sec, nanosec }, "{nanos}");
        }
    }
}
