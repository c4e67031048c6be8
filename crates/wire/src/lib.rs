//! Vehicle protocols: commands to bytes and bytes to telemetry, each behind the trait [`Session`]. Each
//! protocol has both ends: the client, and the ground station as a separate state machine.
//!
//! What must not be here: ports, sockets, threads, clocks (the time is the argument `now`; code that must
//! wait returns the time of the next call), sign conversions (all rates are in the vehicle's own signs).
//! Sentinel values of a protocol are converted here to options and enums.
#![forbid(unsafe_code)]

pub mod session;

pub mod byte_protocol;

pub mod http;

pub mod fotokite_pro;
pub mod fotokite_sigma;
pub mod lab_udp;
pub mod mavlink;
pub mod onvif;

pub mod vessel_protocol;

mod attitude_rate;
mod closing_zeros;

pub mod framing;

pub use byte_protocol::{ByteProtocol, ByteProtocolName, ByteSession, OpenSession, ReportReader};
pub use framing::Framing;
pub use mavlink::signing::{Signing, SigningKey};
pub use session::{LinkHistory, NextAction, RestEvidence, Session, WillStep};
pub use vessel_protocol::VesselProtocol;
