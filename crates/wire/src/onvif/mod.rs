//! ONVIF's services for a camera that pans and tilts (profiles S and T). `docs/wire/onvif.md` describes what
//! is used of them.
//!
//! [`OnvifSession`] is the client: services, media profile, motion, status, shut-down. [`PtzCamera`] is the
//! other end, for the emulator and the tests. Both are plain structs without sockets and clocks: requests,
//! answers and times in and out.

pub mod ask;
pub mod call;
pub mod login;
pub mod soap;
pub mod velocity;

pub mod answers;
pub mod camera_time;
pub mod discovery;
mod duration;
pub mod joining;
mod joining_error;
mod move_limits;
pub mod refusal;
pub mod schedule;
pub mod session;
pub mod watch;

pub mod ptz_camera;

pub use ask::Ask;
pub use call::Call;
pub use joining::{Joined, Joining, MovingProfile};
pub use joining_error::JoiningError;
pub use login::Login;
pub use ptz_camera::{CameraFaults, CameraSettings, PtzCamera};

pub use session::{OnvifSession, OnvifSettings};
pub use velocity::{FullSpeeds, SpeedShares, Velocity};
