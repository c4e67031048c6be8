//! The times and counts of a session.

use core::time::Duration;

/// Interval of this program's heartbeats.
pub const HEARTBEAT_INTERVAL: Duration = Duration::from_secs(1);
/// Interval of repeated requests and claims.
pub const ASK_SPACING: Duration = Duration::from_millis(500);
/// So many requests for a gimbal manager's information are sent alone; later ones go with a request for its
/// status.
pub const ASKS_FOR_INFORMATION: u32 = 3;
/// Longest time from the opened port to a gimbal manager's information. The port is then opened again, which
/// ends an engagement. On a line that loses three packets of ten, each way, one search of 26,000 hears no
/// heartbeat within 10 s (one of 265 within 6 s): simulated, 2,000,000 searches each.
pub const SEARCH_TIMEOUT: Duration = Duration::from_secs(10);
/// Longest wait for the word who has the control before the claim: a manager may send its status at changes
/// only. Six requests fit in: with fewer, a line that loses packets would often keep it unknown that another
/// commander has the control, and the claim would take it away unasked.
pub const STATUS_TIMEOUT: Duration = Duration::from_secs(3);
/// A claim that was accepted counts after this time without a status.
pub const CLAIM_GRACE: Duration = Duration::from_millis(600);
/// Longest wait, after the operator took the control back, until another commander's claim ends.
pub const CLAIM_TIMEOUT: Duration = Duration::from_secs(3);
/// Interval of the attitude reports that are asked for: 20 Hz.
pub const ATTITUDE_INTERVAL: Duration = Duration::from_millis(50);
/// Interval of the vehicle's positions that are asked for: 4 Hz.
pub const POSITION_INTERVAL: Duration = Duration::from_millis(250);
/// Interval of the vehicle's attitudes that are asked for: 10 Hz.
pub const VEHICLE_ATTITUDE_INTERVAL: Duration = Duration::from_millis(100);
/// Longest wait for a gimbal that can be moved, from the first one that cannot.
pub const DESCRIPTION_TIMEOUT: Duration = Duration::from_secs(3);
/// Interval of the status reports that are asked for: 5 Hz.
pub const STATUS_INTERVAL: Duration = Duration::from_millis(200);
/// Interval of the camera's field of view that is asked for, where the camera zooms.
pub const FIELD_OF_VIEW_INTERVAL: Duration = Duration::from_millis(200);
/// Interval at which the camera is asked what it is.
pub const CAMERA_INTERVAL: Duration = Duration::from_secs(5);
/// Reports that are missing for this time are asked for again.
pub const ASK_AGAIN: Duration = Duration::from_secs(1);
/// The link counts as lost if the gimbal manager is silent for this time.
pub const SILENCE: Duration = Duration::from_secs(3);
/// Interval between releases of the control that were not answered.
pub const RELEASE_SPACING: Duration = Duration::from_millis(150);
/// Number of releases of the control.
pub const RELEASES: u32 = 3;
/// Largest number of components that are asked for a gimbal.
pub const MAX_CANDIDATES: usize = 16;
/// Attitudes of the gimbal are compared if they were reported at least this far apart: the noise of a
/// gimbal's sensors is then below what counts as motion.
pub const LEAST_ATTITUDE_SPACING: Duration = Duration::from_millis(90);
/// A gimbal manager that was heard this long after the last rate has the zeros that followed it. What is
/// heard earlier may have left the manager before they arrived, or come over a line that loses one direction
/// for a while.
pub const HAS_ZEROS_AFTER: Duration = Duration::from_secs(5);
