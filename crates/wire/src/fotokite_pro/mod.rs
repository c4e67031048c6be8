//! The Fotokite Pro ground station's serial text protocol. `docs/wire/fotokite-pro.md` describes it.
//!
//! [`FotokiteProSession`] is the client: start-up, pacing of rates, telemetry, shut-down. [`GroundStation`]
//! is the other end, for the emulator and the tests. Both are plain structs without I/O: bytes and times in,
//! bytes and times out.

pub mod lines;

pub mod command;
pub mod motion;
pub mod pacing;
pub mod session;
mod session_times;
mod start_up;
pub mod telemetry;
pub mod telemetry_reader;

mod sensor_readings;

pub mod ground_station;

pub use command::Command;
pub use ground_station::GroundStation;
pub use telemetry_reader::TelemetryReader;

pub use session::{FotokiteProSession, SessionSettings};
