//! The link to a vehicle: ports, their locks, the sessions on them, and the guard, a process of its own that
//! outlives the program.
//!
//! ```text
//!                       +---------------- guard (a process) -----------------+
//!   rates, time to live |                                                    |
//!   GuardedLink ----------> Gate -> LinkCore: Session (wire) <-> Port (serial, TCP, UDP)
//!       ^     <------------- state, received bytes                           |
//!   run loop            +----------------------------------------------------+
//!       v
//!   LinkHandle ----> Mailbox -> thread `link`: LinkCore: Session (wire) <-> Port
//! ```
//!
//! [`LinkCore`] decides what a link does: sessions, the dead-man's switch, reopening, closing.
//! [`guard::Gate`] decides what the guard accepts. Both are plain structs without clocks, ports and threads;
//! [`worker`] drives them. However a run ends, zeros and the vehicle's own stop are sent last.
//!
//! What must not be here: decoders, renderers, trackers, the pilot, knowledge of a vehicle's protocol. The
//! guard is linked from this crate alone.
#![forbid(unsafe_code)]

pub mod guarded;

pub mod guard;

pub mod handle;
pub mod worker;

pub mod link_core;

mod faulty_io;
pub mod mailbox;
pub mod port_io;
pub mod waker;

pub mod dead_mans_switch;
pub mod port;
pub mod report;
pub mod vehicle_lock;

pub mod url;

pub use dead_mans_switch::{DeadMansSwitch, RequestedCommand, RequestedRates};
pub use guarded::{GuardError, GuardedLink};
pub use handle::LinkHandle;
pub use link_core::{LinkAction, LinkCore};
pub use mailbox::Mailbox;
pub use port_io::PortIo;
pub use report::LinkReport;
pub use url::{LinkUrl, LinkUrlError};
pub use vehicle_lock::{VehicleLock, VehicleRole};
pub use waker::Waker;
pub use worker::Worker;
