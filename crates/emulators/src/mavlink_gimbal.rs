//! The emulated MAVLink gimbal: an autopilot with a gimbal manager.

use barrelman_vocab::{AngularRate, Timestamp, VehicleProfile};
use barrelman_wire::mavlink::GimbalManager;
use barrelman_wire::mavlink::frame::FrameReader;
pub use barrelman_wire::mavlink::gimbal_manager::{CameraKind, GimbalManagerSettings, Habits};
use barrelman_wire::mavlink::gimbal_manager::{GimbalAngles, OTHER_COMMANDER};

use super::emulated_vehicle::EmulatedVehicle;
use super::log::VehicleState;
use crate::camera_link::Pointing;

/// An emulated autopilot with a gimbal.
#[derive(Debug)]
pub struct MavlinkGimbal {
    manager: GimbalManager,
    settings: GimbalManagerSettings,
    video: Option<String>,
    profile: VehicleProfile,
}

impl MavlinkGimbal {
    /// An autopilot that has just been switched on, whose camera names this address of its video.
    pub fn new(settings: GimbalManagerSettings, video: Option<String>, now: Timestamp) -> Self {
        let manager = booted(settings, video.as_ref(), now);
        Self { manager, settings, video, profile: VehicleProfile::mavlink_gimbal() }
    }
}

impl EmulatedVehicle for MavlinkGimbal {
    const NAME: &'static str = "MAVLink gimbal";

    fn profile(&self) -> &VehicleProfile {
        &self.profile
    }

    fn reboot(&mut self, now: Timestamp) {
        self.manager = booted(self.settings, self.video.as_ref(), now);
    }

    fn take_over(&mut self, now: Timestamp, out: &mut Vec<Vec<u8>>) {
        self.manager.take_over(now, out);
    }

    fn receive(
        &mut self,
        bytes: &[u8],
        now: Timestamp,
        out: &mut Vec<Vec<u8>>,
        on_message: &mut dyn FnMut(String, VehicleState),
    ) {
        let name = name_of(&self.manager);
        self.manager.receive(bytes, now, out, |text, rates| {
            on_message(text.to_owned(), VehicleState { name, rates, ..VehicleState::default() });
        });
    }

    fn advance(&mut self, pointing: Pointing, now: Timestamp, out: &mut Vec<Vec<u8>>) {
        let angles = GimbalAngles { yaw: pointing.pan, pitch: pointing.tilt };
        self.manager.set_height(pointing.height_m);
        self.manager.set_field_of_view(pointing.field_of_view);
        self.manager.write_telemetry(angles, now, out);
    }

    fn state(&self) -> VehicleState {
        let name = name_of(&self.manager);
        VehicleState { name, rates: self.manager.rates(), roll: AngularRate::ZERO, lost_lines: 0 }
    }

    fn texts(&self, packet: &[u8]) -> Vec<String> {
        let mut texts = Vec::new();
        FrameReader::default().read(packet, |frame| texts.push(format!("message {}", frame.message)));
        texts
    }
}

fn booted(settings: GimbalManagerSettings, video: Option<&String>, now: Timestamp) -> GimbalManager {
    let mut manager = GimbalManager::boot(settings, now);
    manager.set_video(video.cloned());
    manager
}

/// Who has the control.
fn name_of(manager: &GimbalManager) -> &'static str {
    match manager.primary() {
        None => "unclaimed",
        Some(OTHER_COMMANDER) => "other-commander",
        Some(_) => "claimed",
    }
}
