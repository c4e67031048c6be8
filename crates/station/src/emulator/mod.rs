//! Emulated vehicles: the vehicle's end of a protocol, a simulated camera mount, a port, and a server of simulated video.
//!
//! ```text
//! port -> GroundStation or GimbalManager (wire) -> rates -> vehicle boundary -> CameraMount (sim) -> attitude -> telemetry -> port
//! ```

pub mod emulation_loop;

pub mod emulated_vehicle;
pub mod fotokite_pro;
pub mod mavlink_gimbal;

pub mod log;

pub mod emulated_port;
mod port_link;
mod rtp_packetiser;
pub mod rtsp_server;
