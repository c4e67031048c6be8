//! The link to the vehicle: ports, their locks, and the thread that keeps a session with the ground station.
//!
//! ```text
//! pilot's rates -> Mailbox -> link thread: Session (wire) <-> Port (serial or TCP)
//!                                   \-> telemetry, link state -> events
//! ```
//! `sim:` has no port and no thread: a [`crate::link::CameraLink`] takes the rates to the world itself.
//!
//! The thread decides nothing: what goes out and when is the session's. Whatever happens (the program ends, this
//! thread or any other panics), zeros and the vehicle's own stop are the last things sent.

pub mod url;

pub mod worker;

pub mod port;

pub mod camera_link;
mod vehicle_link;

pub use camera_link::CameraLink;
pub use url::{LinkUrl, LinkUrlError};
pub use vehicle_link::{Link, VehicleLink};
pub use worker::{LinkHandle, LinkReport};
