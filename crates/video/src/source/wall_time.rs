//! Wall-clock time as RTCP sender reports have it (NTP, RFC 5905): since 1900.

use std::time::{Duration, SystemTime, UNIX_EPOCH};

/// Nanoseconds from 1900, where NTP time begins, to 1970, where Unix time begins.
const UNIX_EPOCH_SINCE_1900_NS: i128 = 2_208_988_800 * 1_000_000_000;

/// The machine's wall clock this long ago, nanoseconds since 1900.
pub(super) fn since_1900_ns(ago: Duration) -> i128 {
    let unix = SystemTime::now().checked_sub(ago).unwrap_or(UNIX_EPOCH);
    let unix_ns = unix.duration_since(UNIX_EPOCH).map_or(0, |unix| unix.as_nanos() as i128);
    unix_ns + UNIX_EPOCH_SINCE_1900_NS
}

/// A sender's NTP time, with the seconds in the upper 32 bits and fractions of 2^-32 s in the lower, in
/// nanoseconds. `None`: 0, which a sender without a wall clock sends.
pub(super) fn sender_wall_ns(ntp: u64) -> Option<i128> {
    (ntp != 0).then_some((i128::from(ntp) * 1_000_000_000) >> 32)
}
