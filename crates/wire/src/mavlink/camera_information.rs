//! What a camera says of itself.

use barrelman_vocab::ZoomAbility;
use barrelman_vocab::mavlink::Address;
use mavlink::dialects::common::{CAMERA_INFORMATION_DATA, CameraCapFlags};

use super::frame::Frame;

/// What a camera says of itself (CAMERA_INFORMATION).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct CameraInformation {
    /// The camera.
    pub camera: Address,
    /// Whether it zooms.
    pub zoom: ZoomAbility,
}

impl CameraInformation {
    /// Of a frame; `None`: the frame is another message.
    pub fn of(frame: &Frame<'_>) -> Option<Self> {
        let told = frame.read::<CAMERA_INFORMATION_DATA>()?;
        let zooms = told.flags.contains(CameraCapFlags::CAMERA_CAP_FLAGS_HAS_BASIC_ZOOM);
        Some(Self { camera: frame.from, zoom: ZoomAbility::told(zooms) })
    }
}
