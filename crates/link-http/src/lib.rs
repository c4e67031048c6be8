//! The link to a vehicle that answers requests over HTTP: the port for sessions whose packets are requests
//! and answers.
//!
//! ```text
//!   run loop -> LinkHandle -> thread `link`: LinkCore: Session (wire)
//!                                   |  requests            ^  answers, messages (bounded; a descriptor tells of them)
//!                                   v                      |
//!                             thread `http`: one connection for each lane, one WebSocket
//! ```
//!
//! The thread `http` runs a current-thread runtime. It decides nothing: it sends what the session asks, each
//! request within the time of its lane, and returns what comes. A lane whose request was not answered in time
//! gets a new connection.
//!
//! What must not be here: knowledge of what the requests mean, the state of the link, the dead-man's switch.
//! The guard does not link this crate: TLS, HTTP and an async runtime are not for a process that must not
//! fail. Vehicles that are reached here need no guard, as their commands expire by themselves.
#![forbid(unsafe_code)]

pub mod link;
pub mod settings;

pub mod port;

pub mod fotokite_sigma;
pub mod onvif;

pub mod tls_relay;

mod authorization;
mod connection;
mod inbox;
mod inquiry;
mod lane;
mod named_video;
mod runtime;
mod socket;
mod tls;
mod vehicle_video;

pub use link::open_link;
pub use named_video::VehicleVideo;
pub use settings::{
    ClientIdentity, Credential, CredentialError, HttpProtocol, HttpSettings, SigmaAccess, Trust,
};
pub use tls::client_config;
pub use tls_relay::{RelayFailures, TlsRelay, TlsServer};
pub use vehicle_video::vehicle_video;
