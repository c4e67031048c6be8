//! Simulated worlds in the program's own time.
//!
//! ```text
//! run:  --link sim: -> CameraLink -> thread `world` (ticks) -> thread `eye` (draws) -> thread `video` -> LatestFrame
//! demo: page -> inputs, each at a tick -> Drive: trial's Simulation, one tick after the other -> pictures -> page
//! ```
//! In [`live`] the world goes its own way, as a real one does, and the pilot sees what arrives in time. A demo's world
//! waits for the pilot, so that the same inputs at the same ticks give the same drive, bit for bit.

pub mod url;

pub mod live;
pub mod rtsp_server;

pub mod drive;
pub mod drive_shadow;
pub mod stored_drive;

pub mod pacing;

pub mod page;
pub mod painter;
pub mod server;

pub mod camera_link;
pub mod coded_eye;
pub mod jpeg;
pub mod render_threads;

pub use drive::{Cast, Drive, DriveInput};
pub use stored_drive::{DriveReader, DriveWriter};

pub use camera_link::CameraLink;
pub use live::LiveWorld;
pub use url::{WorldUrl, WorldUrlError};
