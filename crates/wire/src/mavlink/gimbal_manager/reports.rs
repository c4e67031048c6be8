//! What a gimbal manager reports.

use barrelman_vocab::Timestamp;
use barrelman_vocab::mavlink::Address;
use mavlink::dialects::common::{
    ATTITUDE_DATA, CAMERA_FOV_STATUS_DATA, GIMBAL_DEVICE_ATTITUDE_STATUS_DATA,
    GIMBAL_MANAGER_INFORMATION_DATA, GIMBAL_MANAGER_STATUS_DATA, GLOBAL_POSITION_INT_DATA,
    GimbalDeviceErrorFlags, GimbalDeviceFlags, GimbalManagerCapFlags, GimbalManagerFlags, HEARTBEAT_DATA,
    MavAutopilot, MavModeFlag, MavState, MavType,
};

use super::{DEVICE, GimbalAngles, GimbalManager, HEARTBEAT_INTERVAL, Habits};

impl GimbalManager {
    pub(super) fn time_boot_ms(&self, now: Timestamp) -> u32 {
        now.since(self.booted).as_millis() as u32
    }

    pub(super) fn information(&self, now: Timestamp) -> GIMBAL_MANAGER_INFORMATION_DATA {
        use core::f32::consts::{FRAC_PI_2, PI};
        GIMBAL_MANAGER_INFORMATION_DATA {
            time_boot_ms: self.time_boot_ms(now),
            cap_flags: GimbalManagerCapFlags::GIMBAL_MANAGER_CAP_FLAGS_HAS_PITCH_AXIS
                | GimbalManagerCapFlags::GIMBAL_MANAGER_CAP_FLAGS_HAS_PITCH_LOCK
                | GimbalManagerCapFlags::GIMBAL_MANAGER_CAP_FLAGS_HAS_YAW_AXIS
                | GimbalManagerCapFlags::GIMBAL_MANAGER_CAP_FLAGS_HAS_YAW_FOLLOW,
            roll_min: 0.0,
            roll_max: 0.0,
            pitch_min: -FRAC_PI_2,
            pitch_max: 0.35,
            yaw_min: -PI,
            yaw_max: PI,
            gimbal_device_id: DEVICE,
        }
    }

    pub(super) fn send_status(&mut self, now: Timestamp, out: &mut Vec<Vec<u8>>) {
        if self.settings.withholds_status {
            return;
        }
        let primary = self.primary.filter(|_| !self.settings.names_nobody).unwrap_or(Address::EVERYONE);
        out.push(self.writer.write(&GIMBAL_MANAGER_STATUS_DATA {
            time_boot_ms: self.time_boot_ms(now),
            flags: GimbalManagerFlags::GIMBAL_MANAGER_FLAGS_ROLL_LOCK
                | GimbalManagerFlags::GIMBAL_MANAGER_FLAGS_PITCH_LOCK,
            gimbal_device_id: DEVICE,
            primary_control_sysid: primary.system.0,
            primary_control_compid: primary.component.0,
            secondary_control_sysid: 0,
            secondary_control_compid: 0,
        }));
    }

    /// Appends the messages that are due by themselves to `out`.
    pub fn write_telemetry(&mut self, angles: GimbalAngles, now: Timestamp, out: &mut Vec<Vec<u8>>) {
        self.writer.set_time(now);
        if self.heartbeat_at <= now {
            self.heartbeat_at = now.plus(HEARTBEAT_INTERVAL);
            out.push(self.writer.write(&HEARTBEAT_DATA {
                custom_mode: 0,
                mavtype: MavType::MAV_TYPE_QUADROTOR,
                autopilot: match self.settings.habits {
                    Habits::ArduPilot => MavAutopilot::MAV_AUTOPILOT_ARDUPILOTMEGA,
                    Habits::Px4 => MavAutopilot::MAV_AUTOPILOT_PX4,
                },
                base_mode: MavModeFlag::MAV_MODE_FLAG_CUSTOM_MODE_ENABLED,
                system_status: MavState::MAV_STATE_ACTIVE,
                mavlink_version: 3,
            }));
            self.send_camera_heartbeat(now, out);
        }
        if self.status.is_due(now) {
            self.send_status(now, out);
        }
        if self.position.is_due(now) {
            // Of a vehicle without a position.
            out.push(self.writer.write(&GLOBAL_POSITION_INT_DATA {
                time_boot_ms: self.time_boot_ms(now),
                relative_alt: (self.height_m * 1e3) as i32,
                hdg: u16::MAX,
                ..GLOBAL_POSITION_INT_DATA::DEFAULT
            }));
        }
        if self.vehicle_attitude.is_due(now) {
            let time_boot_ms = self.time_boot_ms(now);
            out.push(self.writer.write(&ATTITUDE_DATA { time_boot_ms, ..ATTITUDE_DATA::DEFAULT }));
        }
        if self.field_of_view_stream.is_due(now)
            && let Some(angle) = self.field_of_view
        {
            self.camera_writer.set_time(now);
            out.push(self.camera_writer.write(&CAMERA_FOV_STATUS_DATA {
                time_boot_ms: self.time_boot_ms(now),
                hfov: angle.degrees() as f32,
                vfov: f32::NAN,
                ..CAMERA_FOV_STATUS_DATA::DEFAULT
            }));
        }
        if self.attitude.is_due(now) {
            let time_boot_ms = self.time_boot_ms(now);
            out.push(self.writer.write(&GIMBAL_DEVICE_ATTITUDE_STATUS_DATA {
                time_boot_ms,
                q: quaternion(angles),
                angular_velocity_x: f32::NAN,
                angular_velocity_y: f32::NAN,
                angular_velocity_z: f32::NAN,
                failure_flags: GimbalDeviceErrorFlags::empty(),
                flags: GimbalDeviceFlags::GIMBAL_DEVICE_FLAGS_ROLL_LOCK
                    | GimbalDeviceFlags::GIMBAL_DEVICE_FLAGS_PITCH_LOCK
                    | GimbalDeviceFlags::GIMBAL_DEVICE_FLAGS_YAW_IN_VEHICLE_FRAME,
                target_system: 0,
                target_component: 0,
                delta_yaw: f32::NAN,
                delta_yaw_velocity: f32::NAN,
                gimbal_device_id: 0,
            }));
        }
    }
}

/// Yaw, then pitch.
fn quaternion(angles: GimbalAngles) -> [f32; 4] {
    let (yaw, pitch) = (angles.yaw.radians() / 2.0, angles.pitch.radians() / 2.0);
    let (sin_yaw, cos_yaw) = (libm::sin(yaw), libm::cos(yaw));
    let (sin_pitch, cos_pitch) = (libm::sin(pitch), libm::cos(pitch));
    [cos_yaw * cos_pitch, -sin_yaw * sin_pitch, cos_yaw * sin_pitch, sin_yaw * cos_pitch].map(|v| v as f32)
}
