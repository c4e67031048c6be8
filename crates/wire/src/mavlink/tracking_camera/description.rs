//! What the camera is: CAMERA_INFORMATION (259) and the messages that ground stations ask for beside it.

use barrelman_vocab::{PictureSize, Timestamp};
use mavlink::MessageData as _;
use mavlink::dialects::common::{
    CAMERA_CAPTURE_STATUS_DATA, CAMERA_INFORMATION_DATA, CAMERA_SETTINGS_DATA, CameraCapFlags, CameraMode,
    STORAGE_INFORMATION_DATA, StorageStatus, StorageType, StorageUsageFlag, VIDEO_STREAM_INFORMATION_DATA,
    VIDEO_STREAM_STATUS_DATA, VideoStreamEncoding, VideoStreamStatusFlags, VideoStreamType,
};
use mavlink::types::CharArray;

use crate::mavlink::frame::FrameWriter;

/// Who made the camera, as ground stations show it.
const VENDOR: &str = "Barrelman";
/// The number of the one stream.
const STREAM: u8 = 1;
/// The longest address of a stream, bytes: one is left for the end.
const MAX_URI_BYTES: usize = 159;

/// The camera.
#[derive(Debug, Clone, PartialEq)]
pub struct CameraDescription {
    /// Its name: that of the vehicle's profile.
    pub model: String,
    /// Version of this program: major, minor, patch.
    pub version: [u8; 3],
    /// The video stream that ground stations can open themselves; `None`: there is none.
    pub stream: Option<VideoStream>,
}

/// The video stream of the camera.
#[derive(Debug, Clone, PartialEq)]
pub struct VideoStream {
    uri: String,
    field_of_view_deg: Option<u16>,
}

impl VideoStream {
    /// The stream at an address (`rtsp://`, without a login), with its horizontal field of view, if that is
    /// known; `None`: the address is longer than the 159 bytes that the message has.
    pub fn new(uri: &str, field_of_view_deg: Option<u16>) -> Option<Self> {
        (uri.len() <= MAX_URI_BYTES).then(|| Self { uri: uri.to_owned(), field_of_view_deg })
    }
}

/// A request for a message.
#[derive(Debug, Clone, Copy)]
pub(super) struct Asked {
    /// The number of the message.
    pub(super) message: u32,
    pub(super) picture: PictureSize,
    pub(super) frames_per_second: f32,
    pub(super) now: Timestamp,
}

impl CameraDescription {
    /// Whether the camera has this message.
    pub(super) const fn has(&self, message: u32) -> bool {
        match message {
            CAMERA_INFORMATION_DATA::ID
            | CAMERA_SETTINGS_DATA::ID
            | STORAGE_INFORMATION_DATA::ID
            | CAMERA_CAPTURE_STATUS_DATA::ID => true,
            VIDEO_STREAM_INFORMATION_DATA::ID | VIDEO_STREAM_STATUS_DATA::ID => self.stream.is_some(),
            _ => false,
        }
    }

    /// Whether the second parameter of a request names what there is: for messages of a stream its number, or
    /// 0 or NaN for all.
    pub(super) fn has_index(message: u32, index: f32) -> bool {
        let is_of_stream =
            matches!(message, VIDEO_STREAM_INFORMATION_DATA::ID | VIDEO_STREAM_STATUS_DATA::ID);
        !is_of_stream || Self::is_stream(index)
    }

    /// Whether a number names the stream: its own, or 0 or NaN for all.
    pub(super) fn is_stream(id: f32) -> bool {
        id.is_nan() || id == 0.0 || id == f32::from(STREAM)
    }

    /// Appends the message that was asked for. Behind CAMERA_INFORMATION comes VIDEO_STREAM_INFORMATION:
    /// MAVSDK asks for it 20 s later.
    pub(super) fn write(&self, asked: &Asked, writer: &mut FrameWriter, out: &mut Vec<Vec<u8>>) {
        // Milliseconds of 49 days: the field's own range.
        let time_boot_ms = (asked.now.as_nanos() / 1_000_000) as u32;
        match asked.message {
            CAMERA_INFORMATION_DATA::ID => {
                out.push(writer.write(&self.information(asked.picture, time_boot_ms)));
                out.extend(self.stream.as_ref().map(|stream| writer.write(&information(stream, asked))));
            }
            CAMERA_SETTINGS_DATA::ID => out.push(writer.write(&CAMERA_SETTINGS_DATA {
                time_boot_ms,
                mode_id: CameraMode::CAMERA_MODE_VIDEO,
                zoomLevel: f32::NAN,
                focusLevel: f32::NAN,
                camera_device_id: 0,
            })),
            STORAGE_INFORMATION_DATA::ID => out.push(writer.write(&no_storage(time_boot_ms))),
            CAMERA_CAPTURE_STATUS_DATA::ID => out.push(writer.write(&CAMERA_CAPTURE_STATUS_DATA {
                time_boot_ms,
                image_interval: 0.0,
                recording_time_ms: 0,
                available_capacity: 0.0,
                image_status: 0,
                video_status: 0,
                image_count: 0,
                camera_device_id: 0,
            })),
            VIDEO_STREAM_INFORMATION_DATA::ID => {
                out.extend(self.stream.as_ref().map(|stream| writer.write(&information(stream, asked))));
            }
            VIDEO_STREAM_STATUS_DATA::ID => {
                out.extend(self.stream.as_ref().map(|stream| writer.write(&status(stream, asked))));
            }
            _ => {}
        }
    }

    fn information(&self, picture: PictureSize, time_boot_ms: u32) -> CAMERA_INFORMATION_DATA {
        let mut flags = CameraCapFlags::CAMERA_CAP_FLAGS_HAS_TRACKING_POINT
            | CameraCapFlags::CAMERA_CAP_FLAGS_HAS_TRACKING_RECTANGLE;
        if self.stream.is_some() {
            flags |= CameraCapFlags::CAMERA_CAP_FLAGS_HAS_VIDEO_STREAM;
        }
        let [major, minor, patch] = self.version;
        CAMERA_INFORMATION_DATA {
            time_boot_ms,
            firmware_version: u32::from_le_bytes([major, minor, patch, 0]),
            focal_length: f32::NAN,
            sensor_size_h: f32::NAN,
            sensor_size_v: f32::NAN,
            flags,
            resolution_h: side(picture.width),
            resolution_v: side(picture.height),
            cam_definition_version: 0,
            vendor_name: bytes(VENDOR),
            model_name: bytes(&self.model),
            lens_id: 0,
            cam_definition_uri: CharArray::from([0; 140]),
            gimbal_device_id: 0,
            camera_device_id: 0,
        }
    }
}

fn information(stream: &VideoStream, asked: &Asked) -> VIDEO_STREAM_INFORMATION_DATA {
    VIDEO_STREAM_INFORMATION_DATA {
        framerate: asked.frames_per_second,
        bitrate: 0,
        flags: VideoStreamStatusFlags::VIDEO_STREAM_STATUS_FLAGS_RUNNING,
        resolution_h: side(asked.picture.width),
        resolution_v: side(asked.picture.height),
        rotation: 0,
        hfov: stream.field_of_view_deg.unwrap_or(0),
        stream_id: STREAM,
        count: 1,
        mavtype: VideoStreamType::VIDEO_STREAM_TYPE_RTSP,
        name: CharArray::from(bytes(VENDOR)),
        uri: CharArray::from(bytes(&stream.uri)),
        encoding: VideoStreamEncoding::VIDEO_STREAM_ENCODING_H264,
        camera_device_id: 0,
    }
}

fn status(stream: &VideoStream, asked: &Asked) -> VIDEO_STREAM_STATUS_DATA {
    VIDEO_STREAM_STATUS_DATA {
        framerate: asked.frames_per_second,
        bitrate: 0,
        flags: VideoStreamStatusFlags::VIDEO_STREAM_STATUS_FLAGS_RUNNING,
        resolution_h: side(asked.picture.width),
        resolution_v: side(asked.picture.height),
        rotation: 0,
        hfov: stream.field_of_view_deg.unwrap_or(0),
        stream_id: STREAM,
        camera_device_id: 0,
    }
}

/// The camera stores nothing.
fn no_storage(time_boot_ms: u32) -> STORAGE_INFORMATION_DATA {
    STORAGE_INFORMATION_DATA {
        time_boot_ms,
        total_capacity: 0.0,
        used_capacity: 0.0,
        available_capacity: 0.0,
        read_speed: 0.0,
        write_speed: 0.0,
        storage_id: 1,
        storage_count: 0,
        status: StorageStatus::STORAGE_STATUS_NOT_SUPPORTED,
        mavtype: StorageType::STORAGE_TYPE_UNKNOWN,
        name: CharArray::from([0; 32]),
        storage_usage: StorageUsageFlag::STORAGE_USAGE_FLAG_SET,
    }
}

/// A side of the picture, pixels.
fn side(pixels: u32) -> u16 {
    u16::try_from(pixels).unwrap_or(u16::MAX)
}

/// A text with a zero at its end.
fn bytes<const N: usize>(text: &str) -> [u8; N] {
    let mut bytes = [0; N];
    let length = text.len().min(N.saturating_sub(1));
    bytes[..length].copy_from_slice(&text.as_bytes()[..length]);
    bytes
}
