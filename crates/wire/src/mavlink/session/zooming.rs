//! The zoom of the vehicle's camera: what is sent of it beside the rates of the gimbal.
//!
//! A speed is sent with each message of rates, and zero three times after it. A camera keeps the last speed, as the gimbal does.

use barrelman_vocab::mavlink::{Address, ComponentId, SystemId};

use crate::mavlink::command::Command;
use crate::mavlink::pacing::ZERO_REPEATS;

/// The zoom of a camera; nothing is sent where there is none.
#[derive(Debug, Clone, Copy)]
pub(super) struct Zooming {
    camera: Option<ComponentId>,
    zeros_left: u8,
}

impl Zooming {
    /// What moves the zoom is not known.
    pub(super) const fn new(camera: Option<ComponentId>) -> Self {
        Self { camera, zeros_left: ZERO_REPEATS + 1 }
    }

    /// The camera of a vehicle.
    pub(super) fn camera_of(self, system: SystemId) -> Option<Address> {
        self.camera.map(|component| Address { system, component })
    }

    /// The control begins: zeros first.
    pub(super) const fn begin_with_zeros(&mut self) {
        self.zeros_left = ZERO_REPEATS + 1;
    }

    /// The command beside rates whose zoom has this speed.
    pub(super) fn due(&mut self, system: SystemId, speed: f64) -> Option<Command> {
        let camera = self.camera_of(system)?;
        if speed == 0.0 {
            self.zeros_left = self.zeros_left.checked_sub(1)?;
        } else {
            self.begin_with_zeros();
        }
        Some(Command::Zoom { camera, speed })
    }

    /// A zero.
    pub(super) fn zero(self, system: SystemId) -> Option<Command> {
        self.camera_of(system).map(|camera| Command::Zoom { camera, speed: 0.0 })
    }
}
