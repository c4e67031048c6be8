//! Emulated vehicles: wire's end of the vehicle, a simulated camera mount, a port or a server, and a server
//! of simulated video. Links to the camera and the boat of a simulated world.
//!
//! ```text
//! port -> GroundStation or GimbalManager (wire) -> rates -> vehicle boundary -> CameraMount (sim) -> attitude -> telemetry -> port
//! ```

pub mod emulation_loop;

pub mod boat;
pub mod emulated_vehicle;
pub mod fotokite_pro;
pub mod fotokite_sigma;
pub mod mavlink_gimbal;
pub mod onvif;

mod http_log;
pub mod log;

mod digest;
pub mod emulated_port;
mod http_server;
mod port_link;
mod rtp_packetiser;
pub mod rtsp_server;
mod shared_emulation;

pub mod camera_link;
mod moved_camera;
pub mod simulated_boat;
