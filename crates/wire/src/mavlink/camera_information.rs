//! What a camera says of itself, and of its video streams.

use barrelman_vocab::mavlink::Address;
use barrelman_vocab::{Equipment, EquipmentKind, ZoomAbility};
use mavlink::dialects::common::{CAMERA_INFORMATION_DATA, CameraCapFlags, VIDEO_STREAM_INFORMATION_DATA};

use super::frame::Frame;

/// What a camera says of itself (CAMERA_INFORMATION).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct CameraInformation {
    /// The camera.
    pub camera: Address,
    /// Its address, vendor and model.
    pub equipment: Equipment,
    /// Whether it zooms.
    pub zoom: ZoomAbility,
}

impl CameraInformation {
    /// Of a frame; `None`: the frame is another message.
    pub fn of(frame: &Frame<'_>) -> Option<Self> {
        let told = frame.read::<CAMERA_INFORMATION_DATA>()?;
        let zooms = told.flags.contains(CameraCapFlags::CAMERA_CAP_FLAGS_HAS_BASIC_ZOOM);
        let names = [frame.from.to_string(), text(&told.vendor_name), text(&told.model_name)];
        let name = names.map(|name| name.trim().to_owned()).join(" ");
        Some(Self {
            camera: frame.from,
            equipment: Equipment::new(EquipmentKind::Camera, name.trim_end()),
            zoom: ZoomAbility::told(zooms),
        })
    }
}

/// What a camera says of a video stream (VIDEO_STREAM_INFORMATION).
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct StreamInformation {
    /// The camera.
    pub camera: Address,
    /// The number of the stream.
    pub number: u8,
    /// Its name.
    pub name: String,
    /// Its address, as the camera states it.
    pub uri: String,
}

impl StreamInformation {
    /// Of a frame; `None`: the frame is another message.
    pub fn of(frame: &Frame<'_>) -> Option<Self> {
        let told = frame.read::<VIDEO_STREAM_INFORMATION_DATA>()?;
        let readable = |text: &str| text.chars().filter(|c| !c.is_control()).collect::<String>();
        Some(Self {
            camera: frame.from,
            number: told.stream_id,
            name: readable(told.name.to_str().unwrap_or_default()),
            uri: readable(told.uri.to_str().unwrap_or_default()),
        })
    }
}

/// A text with zeros behind it.
fn text(bytes: &[u8]) -> String {
    let end = bytes.iter().position(|byte| *byte == 0).unwrap_or(bytes.len());
    String::from_utf8_lossy(&bytes[..end]).into_owned()
}
