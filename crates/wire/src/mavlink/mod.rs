//! MAVLink, version 2: a gimbal manager as the vehicle, a boat, and this program as a tracking camera.
//!
//! `docs/wire/mavlink-gimbal.md` and `docs/wire/mavlink-camera.md` describe both. [`GimbalSession`] is the
//! client of a gimbal manager: discovery, control, rates, attitude, shut-down. [`GimbalManager`] is the other
//! end, for the emulator and the tests. [`TrackingCamera`] is what ground stations find. All are plain
//! structs without I/O: bytes and times in, packets and times out.

pub mod frame;
pub mod signing;

mod autopilot_reports;
pub mod camera_information;
mod heartbeat;

pub mod command;
mod command_long;
pub mod gimbal_choice;
pub mod gimbal_information;
pub mod gimbal_reader;
pub mod pacing;
pub mod probe;
pub mod session;
mod session_times;
mod status_texts;
mod subscription;

pub mod gimbal_manager;

pub mod rover;
pub mod rover_boat;
pub mod rover_link;
pub mod rover_reader;

pub mod tracking_camera;

pub use command::{Command, Gimbal, Wanted};
pub use gimbal_choice::GimbalChoice;
pub use gimbal_manager::GimbalManager;
pub use gimbal_reader::GimbalReader;
pub use probe::Probe;
pub use rover::RoverSession;
pub use rover_boat::RoverBoat;
pub use session::GimbalSession;
pub use tracking_camera::TrackingCamera;
