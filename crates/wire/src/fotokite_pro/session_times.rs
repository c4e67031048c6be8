//! The times and counts of a session.

use core::time::Duration;

pub use crate::closing_zeros::{MAX_ZEROS, UNREST_SPACING, ZEROS_AT_REST, ZEROS_IN_MOTION};

/// Number of zeros before the first `stop` of a session.
pub const OPENING_ZEROS: u32 = 3;
/// Time from the first `stop` to the prompt requests.
pub const PROMPT_DELAY: Duration = Duration::from_millis(500);
/// Longest time from the prompt requests to the prompt.
pub const PROMPT_TIMEOUT: Duration = Duration::from_secs(3);
/// Number of carriage returns that request the prompt.
pub const PROMPT_REQUESTS: usize = 5;
/// Time from the last zeros of the shut-down to `stop`.
pub const STOP_DELAY: Duration = Duration::from_millis(500);
/// The link counts as lost if a telemetry stream is silent for this time.
pub const TELEMETRY_TIMEOUT: Duration = Duration::from_secs(3);
/// Longest wait for the ground station's first report after the start-up: without it, the link is up all the
/// same.
pub const REPORT_TIMEOUT: Duration = Duration::from_secs(1);
/// Time after the start-up in which the ground station may still report that it is not under remote control.
pub const CONTROL_GRACE: Duration = Duration::from_secs(2);
