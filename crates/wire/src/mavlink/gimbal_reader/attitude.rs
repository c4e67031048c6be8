//! What a reported attitude says of the camera: its tilt, its direction, and its pan.

use barrelman_vocab::Angle;
use barrelman_vocab::telemetry::{EulerAxis, Quaternion, Report};
use mavlink::dialects::common::{GIMBAL_DEVICE_ATTITUDE_STATUS_DATA, GimbalDeviceFlags};

use super::{Facts, Received};

/// A camera that looks more steeply has no direction over the water: roll and yaw cannot be told apart.
const MAX_PITCH: Angle = Angle::from_degrees(85.0);
/// A quaternion whose squared norm is further from 1 is damaged.
const NORM_TOLERANCE: f64 = 0.1;

impl Facts {
    /// Reports an attitude of the gimbal with what it says of the camera.
    pub(super) fn on_attitude(
        &self,
        status: &GIMBAL_DEVICE_ATTITUDE_STATUS_DATA,
        each: &mut impl FnMut(Received),
    ) {
        if let Some(q) = report_attitude(status.q, each) {
            let heading = self.heading_of(q, status.flags).map(Report::CameraHeading);
            let pan = self.pan_of(q, status).map(Report::CameraPan);
            heading.into_iter().chain(pan).for_each(|report| each(Received::Report(report)));
        }
    }

    /// The direction of the camera's axis from north. The yaw counts from north or from the vehicle's nose,
    /// as the flags say; where neither flag is set, a locked yaw counts from north. `None`: the vehicle's own
    /// direction is needed and not known, or the camera looks so steeply that its axis has no direction.
    fn heading_of(&self, attitude: Quaternion, flags: GimbalDeviceFlags) -> Option<Angle> {
        let pitch = attitude.angle_about(EulerAxis::Y)?;
        if pitch.radians().abs() > MAX_PITCH.radians() {
            return None;
        }
        let yaw = attitude.angle_about(EulerAxis::Z)?.radians();
        let is_from_nose = flags.contains(GimbalDeviceFlags::GIMBAL_DEVICE_FLAGS_YAW_IN_VEHICLE_FRAME);
        let is_from_north = flags.contains(GimbalDeviceFlags::GIMBAL_DEVICE_FLAGS_YAW_IN_EARTH_FRAME)
            || flags.contains(GimbalDeviceFlags::GIMBAL_DEVICE_FLAGS_YAW_LOCK);
        let nose = if is_from_north && !is_from_nose { 0.0 } else { self.autopilot.heading()?.radians() };
        Some(whole_turn(nose + yaw))
    }

    /// The pan in the frame in which the gimbal holds a camera at rest: from north where the yaw is locked,
    /// from the nose otherwise. The two frames differ by the direction of the nose. `None`: it is needed and
    /// not known, or the camera looks so steeply that its axis has no direction.
    fn pan_of(&self, attitude: Quaternion, status: &GIMBAL_DEVICE_ATTITUDE_STATUS_DATA) -> Option<Angle> {
        let pitch = attitude.angle_about(EulerAxis::Y)?;
        if pitch.radians().abs() > MAX_PITCH.radians() {
            return None;
        }
        let yaw = attitude.angle_about(EulerAxis::Z)?.radians();
        let has = |flag| status.flags.contains(flag);
        let is_locked = has(GimbalDeviceFlags::GIMBAL_DEVICE_FLAGS_YAW_LOCK);
        // Without one of the two flags, a locked yaw counts from north.
        let is_from_north = !has(GimbalDeviceFlags::GIMBAL_DEVICE_FLAGS_YAW_IN_VEHICLE_FRAME)
            && (has(GimbalDeviceFlags::GIMBAL_DEVICE_FLAGS_YAW_IN_EARTH_FRAME) || is_locked);
        // 0 is what a sender leaves out that does not know the field.
        let stated = Some(f64::from(status.delta_yaw)).filter(|delta| delta.is_finite() && *delta != 0.0);
        let nose = || stated.or_else(|| self.autopilot.nose_at(status.time_boot_ms));
        Some(Angle::from_radians(match (is_from_north, is_locked) {
            (true, true) | (false, false) => yaw,
            (true, false) => yaw - nose()?,
            (false, true) => yaw + nose()?,
        }))
    }
}

/// Reports an attitude. Returns it, if it is one.
fn report_attitude(q: [f32; 4], each: &mut impl FnMut(Received)) -> Option<Quaternion> {
    let [w, x, y, z] = q.map(f64::from);
    let norm = w * w + x * x + y * y + z * z;
    if norm.is_nan() || (norm - 1.0).abs() > NORM_TOLERANCE {
        return None;
    }
    let attitude = Quaternion { w, x, y, z };
    each(Received::Attitude(attitude));
    each(Received::Report(Report::GimbalAttitude(attitude)));
    if let Some(tilt) = attitude.angle_about(EulerAxis::Y) {
        each(Received::Report(Report::CameraTilt(tilt)));
    }
    Some(attitude)
}

/// A direction from 0 to 2 pi.
fn whole_turn(radians: f64) -> Angle {
    use core::f64::consts::TAU;
    let turn = libm::fmod(radians, TAU);
    Angle::from_radians(if turn < 0.0 { turn + TAU } else { turn })
}
