//! An emulated Fotokite Pro: wire's ground station, a simulated camera mount, a port, and a server of simulated video.
//!
//! ```text
//! port -> GroundStation (wire) -> rates -> vehicle boundary -> CameraMount (sim) -> attitude -> telemetry -> port
//! ```

pub mod fotokite_pro;

pub mod log;

pub mod emulated_port;
mod port_link;
mod rtp_packetiser;
pub mod rtsp_server;
