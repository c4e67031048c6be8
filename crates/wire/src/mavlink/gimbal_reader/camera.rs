//! The camera that zooms: what it is, and how much it sees.

use barrelman_vocab::Angle;
use barrelman_vocab::mavlink::Address;
use barrelman_vocab::telemetry::Report;
use mavlink::dialects::common::CAMERA_FOV_STATUS_DATA;

use super::{Facts, Received};
use crate::mavlink::camera_information::CameraInformation;
use crate::mavlink::frame::Frame;

impl Facts {
    /// The camera that zooms, of the gimbal's system.
    pub(super) fn camera(&self) -> Option<Address> {
        Some(Address { system: self.gimbal?.manager.system, component: self.peers.camera? })
    }

    /// A frame of that camera.
    pub(super) fn on_camera(&self, frame: &Frame<'_>, each: &mut impl FnMut(Received)) {
        if let Some(told) = frame.read::<CAMERA_FOV_STATUS_DATA>() {
            // An angle that is not known is NaN.
            if 0.0 < told.hfov && told.hfov < 180.0 {
                each(Received::FieldOfView(Angle::from_degrees(f64::from(told.hfov))));
            }
        }
    }

    /// A camera says what it is.
    pub(super) fn on_camera_information(
        &mut self,
        information: CameraInformation,
        each: &mut impl FnMut(Received),
    ) {
        each(Received::Camera(information));
        if self.camera() != Some(information.camera) {
            return;
        }
        let before = self.camera_information.replace(information);
        if before.map(|before| before.equipment) != Some(information.equipment) {
            each(Received::Report(Report::Equipment(information.equipment)));
        }
        if before.map(|before| before.zoom) != Some(information.zoom) {
            each(Received::Report(Report::Zoom(information.zoom)));
        }
    }
}
