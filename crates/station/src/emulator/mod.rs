//! An emulated Fotokite Pro: wire's ground station, a simulated camera mount, and a port.
//!
//! ```text
//! port -> GroundStation (wire) -> rates -> profile's signs -> CameraMount (sim) -> attitude -> telemetry -> port
//! ```

pub mod fotokite_pro;

pub mod log;

pub mod host_port;
mod port_link;
pub mod rtsp_server;
