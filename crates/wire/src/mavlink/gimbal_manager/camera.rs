//! The camera of the vehicle: what it says of itself, and its zoom.

use barrelman_vocab::Timestamp;
use mavlink::dialects::common::{
    CAMERA_INFORMATION_DATA, COMMAND_LONG_DATA, CameraCapFlags, HEARTBEAT_DATA, MavAutopilot, MavCmd,
    MavModeFlag, MavResult, MavState, MavType, VIDEO_STREAM_INFORMATION_DATA, VideoStreamEncoding,
    VideoStreamStatusFlags, VideoStreamType,
};
use mavlink::types::CharArray;

use super::{CameraKind, GimbalManager, stream_of};
use crate::mavlink::command::{CONTINUOUS_ZOOM, Wanted};

impl GimbalManager {
    /// Carries a command to the camera out.
    pub(super) fn on_camera_command(
        &mut self,
        command: &COMMAND_LONG_DATA,
        now: Timestamp,
        out: &mut Vec<Vec<u8>>,
    ) -> MavResult {
        let wanted = |message: Wanted| command.param1 == message.id() as f32;
        let zooms = self.settings.camera == CameraKind::Zooming;
        match command.command {
            MavCmd::MAV_CMD_REQUEST_MESSAGE if wanted(Wanted::CameraInformation) => {
                self.camera_writer.set_time(now);
                let information = self.camera_information(now);
                out.push(self.camera_writer.write(&information));
                MavResult::MAV_RESULT_ACCEPTED
            }
            MavCmd::MAV_CMD_REQUEST_MESSAGE if wanted(Wanted::StreamInformation) => {
                let Some(stream) = self.stream_information() else {
                    return MavResult::MAV_RESULT_UNSUPPORTED;
                };
                self.camera_writer.set_time(now);
                out.push(self.camera_writer.write(&stream));
                MavResult::MAV_RESULT_ACCEPTED
            }
            MavCmd::MAV_CMD_SET_MESSAGE_INTERVAL if wanted(Wanted::FieldOfView) => {
                self.field_of_view_stream = stream_of(command.param2, now);
                MavResult::MAV_RESULT_ACCEPTED
            }
            MavCmd::MAV_CMD_SET_CAMERA_ZOOM if !zooms => MavResult::MAV_RESULT_DENIED,
            MavCmd::MAV_CMD_SET_CAMERA_ZOOM
                if command.param1 == CONTINUOUS_ZOOM && command.param2.is_finite() =>
            {
                // The speed is kept until the next one.
                self.rates.zoom = f64::from(command.param2.clamp(-1.0, 1.0));
                MavResult::MAV_RESULT_ACCEPTED
            }
            _ => MavResult::MAV_RESULT_UNSUPPORTED,
        }
    }

    fn camera_information(&self, now: Timestamp) -> CAMERA_INFORMATION_DATA {
        let has_video = CameraCapFlags::CAMERA_CAP_FLAGS_CAPTURE_VIDEO;
        CAMERA_INFORMATION_DATA {
            time_boot_ms: self.time_boot_ms(now),
            firmware_version: 0,
            focal_length: f32::NAN,
            sensor_size_h: f32::NAN,
            sensor_size_v: f32::NAN,
            flags: match self.settings.camera {
                CameraKind::Zooming => has_video | CameraCapFlags::CAMERA_CAP_FLAGS_HAS_BASIC_ZOOM,
                CameraKind::Fixed | CameraKind::Silent => has_video,
            },
            resolution_h: 0,
            resolution_v: 0,
            cam_definition_version: 0,
            vendor_name: text("Barrelman"),
            model_name: text("Emulated"),
            lens_id: 0,
            cam_definition_uri: CharArray::from([0; 140]),
            gimbal_device_id: 0,
            camera_device_id: 0,
        }
    }

    fn stream_information(&self) -> Option<VIDEO_STREAM_INFORMATION_DATA> {
        Some(VIDEO_STREAM_INFORMATION_DATA {
            framerate: 0.0,
            bitrate: 0,
            flags: VideoStreamStatusFlags::VIDEO_STREAM_STATUS_FLAGS_RUNNING,
            resolution_h: 0,
            resolution_v: 0,
            rotation: 0,
            hfov: 0,
            stream_id: 1,
            count: 1,
            mavtype: VideoStreamType::VIDEO_STREAM_TYPE_RTSP,
            name: CharArray::from(text("main")),
            uri: CharArray::from(text(self.video.as_deref()?)),
            encoding: VideoStreamEncoding::VIDEO_STREAM_ENCODING_H264,
            camera_device_id: 0,
        })
    }

    /// The camera's heartbeat, where it says anything.
    pub(super) fn send_camera_heartbeat(&mut self, now: Timestamp, out: &mut Vec<Vec<u8>>) {
        if self.settings.camera == CameraKind::Silent {
            return;
        }
        self.camera_writer.set_time(now);
        out.push(self.camera_writer.write(&HEARTBEAT_DATA {
            custom_mode: 0,
            mavtype: MavType::MAV_TYPE_CAMERA,
            autopilot: MavAutopilot::MAV_AUTOPILOT_INVALID,
            base_mode: MavModeFlag::empty(),
            system_status: MavState::MAV_STATE_ACTIVE,
            mavlink_version: 3,
        }));
    }
}

/// A text with zeros behind it.
fn text<const N: usize>(text: &str) -> [u8; N] {
    let mut bytes = [0; N];
    bytes.iter_mut().zip(text.bytes()).for_each(|(to, byte)| *to = byte);
    bytes
}
