//! Emulated vehicles: wire's end of the vehicle, a simulated camera mount, a port or a server, and a server of simulated video.
//!
//! ```text
//! port -> GroundStation (wire) -> rates -> vehicle boundary -> CameraMount (sim) -> attitude -> telemetry -> port
//! ```

pub mod fotokite_pro;
pub mod fotokite_sigma;

pub mod log;
mod sigma_log;

pub mod emulated_port;
mod port_link;
mod rtp_packetiser;
pub mod rtsp_server;
