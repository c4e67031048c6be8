//! CAMERA_TRACKING_IMAGE_STATUS (275): where the target is in the picture.
//!
//! Always a rectangle: ground stations of 2025 draw points at wrong places. They draw where the status is
//! exactly ACTIVE.

use barrelman_vocab::{PictureSize, PixelBox};
use mavlink::MessageData as _;
use mavlink::dialects::common::{
    CAMERA_TRACKING_IMAGE_STATUS_DATA, CameraTrackingMode, CameraTrackingStatusFlags,
    CameraTrackingTargetData,
};

/// The number of the message.
pub(super) const ID: u32 = CAMERA_TRACKING_IMAGE_STATUS_DATA::ID;

/// The target, as ground stations are told of it.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum ShownTarget {
    /// There is none, or its selection is not confirmed yet.
    #[default]
    None,
    /// The target is seen.
    Seen(PixelBox),
    /// The place is predicted.
    Predicted(PixelBox),
    /// The target is lost, or there is no fresh picture.
    Lost,
}

/// The message. `marks_coasting`: whether a predicted place is marked.
pub(super) fn encode(
    target: ShownTarget,
    picture: PictureSize,
    marks_coasting: bool,
) -> CAMERA_TRACKING_IMAGE_STATUS_DATA {
    let active = CameraTrackingStatusFlags::CAMERA_TRACKING_STATUS_FLAGS_ACTIVE;
    let coasting = CameraTrackingStatusFlags::CAMERA_TRACKING_STATUS_FLAGS_COASTING;
    let (status, bounds) = match target {
        ShownTarget::None => (CameraTrackingStatusFlags::CAMERA_TRACKING_STATUS_FLAGS_IDLE, None),
        ShownTarget::Lost => (CameraTrackingStatusFlags::CAMERA_TRACKING_STATUS_FLAGS_ERROR, None),
        ShownTarget::Predicted(bounds) if marks_coasting => (active | coasting, Some(bounds)),
        ShownTarget::Seen(bounds) | ShownTarget::Predicted(bounds) => (active, Some(bounds)),
    };
    let (mode, data) = match bounds {
        Some(_) => (
            CameraTrackingMode::CAMERA_TRACKING_MODE_RECTANGLE,
            CameraTrackingTargetData::CAMERA_TRACKING_TARGET_DATA_IN_STATUS,
        ),
        None => (CameraTrackingMode::CAMERA_TRACKING_MODE_NONE, CameraTrackingTargetData::empty()),
    };
    let [left, top, right, bottom] =
        bounds.map_or([f32::NAN; 4], |bounds| corners(bounds.clipped(picture), picture));
    CAMERA_TRACKING_IMAGE_STATUS_DATA {
        point_x: f32::NAN,
        point_y: f32::NAN,
        radius: f32::NAN,
        rec_top_x: left,
        rec_top_y: top,
        rec_bottom_x: right,
        rec_bottom_y: bottom,
        tracking_status: status,
        tracking_mode: mode,
        target_data: data,
        camera_device_id: 0,
    }
}

/// Left, top, right, bottom in shares of the picture.
fn corners(bounds: PixelBox, picture: PictureSize) -> [f32; 4] {
    let (width, height) = (f64::from(picture.width.max(1)), f64::from(picture.height.max(1)));
    [bounds.u / width, bounds.v / height, (bounds.u + bounds.w) / width, (bounds.v + bounds.h) / height]
        .map(|share| share.clamp(0.0, 1.0) as f32)
}
