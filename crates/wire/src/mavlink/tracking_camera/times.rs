//! Times of the tracking camera.

use core::time::Duration;

/// Time between two heartbeats.
pub const HEARTBEAT_INTERVAL: Duration = Duration::from_secs(1);
/// Time between two statuses of the track, unless a ground station asks for another one.
pub const STATUS_INTERVAL: Duration = Duration::from_millis(200);
/// Least time between two statuses of the track.
pub const LEAST_STATUS_INTERVAL: Duration = Duration::from_millis(20);
/// Within this time a track command is answered.
pub const ANSWER_WITHIN: Duration = Duration::from_millis(400);
