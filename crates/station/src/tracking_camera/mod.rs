//! Barrelman as a tracking camera on a MAVLink link: ground stations see the target, select, and let go.
//!
//! ```text
//!                 newest snapshot -> view -> TrackingCamera (wire) <-> Port
//! thread mavlink  gateway <------ requests --'   ^
//!                    '---------- answers --------'
//! ```
//! A ground station selects through the operator gateway, like a page, and never engages. What must not be
//! here: a decision about the camera's motion, knowledge of messages (`wire`).

mod thread;
mod view;

use std::time::Duration;

use anyhow::{Result, bail};
use barrelman_wire::Signing;
use barrelman_wire::mavlink::tracking_camera::{CameraDescription, CameraSettings};

use crate::link::LinkUrl;
use crate::link::url::Endpoint;

pub use thread::{CameraParts, TrackingCameraThread};

/// What the thread of a tracking camera needs to know from the start.
#[derive(Debug, Clone)]
pub struct TrackingCameraSetup {
    /// Where ground stations are.
    pub endpoint: Endpoint,
    /// How the camera appears.
    pub settings: CameraSettings,
    /// What the camera is.
    pub description: CameraDescription,
    /// How packets are signed; `None`: they are not.
    pub signing: Option<Signing>,
    /// How much older the picture of a ground station is than the newest video frame here.
    pub display_delay: Duration,
}

/// The endpoint of `--mavlink`.
///
/// # Errors
/// If the address is not that of a port that carries bytes, or has faults.
pub fn endpoint(url: &str) -> Result<Endpoint> {
    let link = LinkUrl::parse(url)?;
    link.faults.require_effect("--mavlink", &[])?;
    match link.endpoint {
        Endpoint::SimulatedCamera | Endpoint::Http(_) => {
            bail!(
                "{url:?} carries no MAVLink: use udp://host:port, tcp://host:port or serial:/dev/ttyACM0?baud=57600"
            )
        }
        endpoint => Ok(endpoint),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_ports_that_carry_bytes_are_taken() {
        assert!(endpoint("udp://127.0.0.1:14550").is_ok());
        assert!(endpoint("tcp://127.0.0.1:5760").is_ok());
        assert!(endpoint("serial:/dev/ttyACM0?baud=57600").is_ok());
        for url in ["sim:", "http://sigma.example:3128/api", "udp://127.0.0.1", "127.0.0.1:14550"] {
            assert!(endpoint(url).is_err(), "{url}");
        }
    }
}
