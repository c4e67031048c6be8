//! The link to the vehicle: ports, their locks, and the thread that keeps a session with the ground station.
//!
//! ```text
//! pilot's rates -> Mailbox -> link thread: Session (wire) <-> Port (serial or TCP)
//!                                   \-> telemetry, link state -> events
//! ```
//! `sim:` has neither port nor thread: a [`crate::link::CameraLink`] passes the rates to the simulated world.
//!
//! The thread makes no decisions: the session decides which line is sent when. However a run ends (the program ends, this
//! or any other thread panics), zeros and the vehicle's own stop are sent last.

mod vehicle_link;

pub mod handle;
mod worker;

mod mailbox;
mod port_io;

mod dead_mans_switch;
pub mod port;
mod report;

pub mod camera_link;

pub mod url;

pub use camera_link::CameraLink;
pub use handle::LinkHandle;
pub use report::LinkReport;
pub use url::{LinkUrl, LinkUrlError};
pub use vehicle_link::{Link, VehicleLink};
