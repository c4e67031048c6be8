//! The link of a run: to a port, behind a guard where the vehicle keeps its last rate, or to a simulated
//! camera.
//!
//! Ports, sessions and the guard are in the crate `barrelman-link`. `sim:` has neither port nor thread: a
//! [`barrelman_emulators::camera_link::CameraLink`] passes the rates to the simulated world.

mod vehicle_link;

pub mod vessel_link;

mod command_path;
pub mod named_video;
mod vehicle_over_http;

pub use barrelman_link::guarded::{GuardedLinkSettings, find_guard};
pub use barrelman_link::{GuardedLink, LinkHandle, LinkReport, LinkUrl, LinkUrlError, port, url};
pub use command_path::command_path;
pub use vehicle_link::{Link, VehicleLink};
pub use vehicle_over_http::{ensure_spoken_at, vehicle_over_http, video_of_vehicle};
