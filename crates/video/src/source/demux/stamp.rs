//! Times of capture of the pictures of a file.

use std::time::Duration;

use barrelman_vocab::time::Timestamp;
use barrelman_vocab::video::{Capture, CaptureQuality};

/// The time of capture of a picture with a timestamp of `ticks` / `per_second` seconds.
pub(super) fn capture_at(ticks: u64, per_second: u64) -> Capture {
    let nanos = u128::from(ticks) * 1_000_000_000 / u128::from(per_second.max(1));
    let at = Timestamp::ZERO.plus(Duration::from_nanos(u64::try_from(nanos).unwrap_or(u64::MAX)));
    Capture { at, quality: CaptureQuality::Sender }
}

/// The time of capture of picture `index` at `fps` pictures per second.
pub(super) fn capture_at_rate(index: u64, fps: f64) -> Capture {
    Capture { at: Timestamp::from_secs_f64(index as f64 / fps), quality: CaptureQuality::Sender }
}
