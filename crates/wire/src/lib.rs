//! Commands to bytes and bytes to telemetry, for every vehicle's protocol, and both ends of each: the client's
//! and, as a state machine of its own, the ground station's.
//!
//! What must not be here: ports, sockets, threads, clocks (time comes in as `now`, and whoever must wait
//! returns when to call again), vehicle signs (what comes in is in the vehicle's own), and any command that
//! moves the vehicle itself. Sentinels of a protocol end here: inwards go options and enums.
#![forbid(unsafe_code)]

pub mod fotokite_pro;
