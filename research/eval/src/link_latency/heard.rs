//! What the far end of a link tells of a command.

use std::time::{Duration, Instant};

/// A yaw rate that the vehicle received, rad/s, and when its bytes arrived.
pub(super) type Heard = (f64, Instant);

/// Longest wait for the bytes of a command, and for the link to be up.
pub(super) const PATIENCE: Duration = Duration::from_secs(10);
