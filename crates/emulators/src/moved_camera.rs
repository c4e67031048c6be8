//! The camera that an emulated vehicle moves: a simulated mount, or the camera of a simulated world.

use std::time::Duration;

use barrelman_sim::tick::TICKS_PER_SECOND;
use barrelman_sim::{CameraMount, MountPlant};
use barrelman_vocab::{Angle, VehicleProfile, VehicleRates};

use crate::camera_link::{CameraLink, Pointing};

/// Depression of the camera at the start.
const START_DEPRESSION: Angle = Angle::from_degrees(24.0);
/// Height of the camera without a world, metres.
const START_HEIGHT_M: f64 = 10.0;

/// The camera.
pub(crate) struct MovedCamera {
    mount: CameraMount,
    world: Option<CameraLink>,
    profile: VehicleProfile,
    commanded: VehicleRates,
}

impl MovedCamera {
    /// A camera at rest, of a vehicle with this profile's signs.
    pub(crate) fn at_rest(profile: VehicleProfile, world: Option<CameraLink>) -> Self {
        let mount = CameraMount::at_rest(MountPlant::laboratory(), START_DEPRESSION);
        Self { mount, world, profile, commanded: VehicleRates::REST }
    }

    /// Where its mount points on the vehicle, which may sway.
    pub(crate) fn mount_angles(&self) -> (Angle, Angle) {
        (self.mount.pan.angle(), self.mount.tilt.angle())
    }

    /// Where it points.
    pub(crate) fn pointing(&self) -> Pointing {
        let (pan, tilt) = self.mount_angles();
        let own = Pointing { pan, tilt, height_m: START_HEIGHT_M, field_of_view: None };
        self.world.as_ref().and_then(CameraLink::pointing).unwrap_or(own)
    }

    /// Moves on to this time since the start.
    pub(crate) fn advance_to(&mut self, since_start: Duration) {
        let target = (since_start.as_secs_f64() * f64::from(TICKS_PER_SECOND)) as u64;
        while self.mount.tick() < target {
            self.mount.advance();
        }
    }

    /// Turns at these rates from now on. Returns whether they are new.
    pub(crate) fn turn(&mut self, rates: VehicleRates) -> bool {
        if rates == self.commanded {
            return false;
        }
        self.commanded = rates;
        self.mount.command(self.profile.from_vehicle(rates));
        if let Some(world) = &self.world {
            world.send_latched(rates);
        }
        true
    }
}
