//! Where the kite is, and how it lies, as its autopilot reports: GLOBAL_POSITION_INT (33) and ATTITUDE (30).
//!
//! Both are recorded and shown, and give height, latitude and longitude. Autopilots send them up to 50 times
//! a second; each is passed on at most five times a second, by its own time since boot. Both are asked for
//! where they do not come.

use barrelman_vocab::Angle;
use barrelman_vocab::mavlink::ComponentId;
use barrelman_vocab::telemetry::{Quaternion, Report};
use mavlink::MessageData as _;
use mavlink::dialects::common::{ATTITUDE_DATA, GLOBAL_POSITION_INT_DATA};

use super::frame::Frame;

/// The component id of an autopilot.
pub(super) const AUTOPILOT: ComponentId = ComponentId(1);
/// Least time between two reports of a kind, milliseconds.
const SPACING_MS: u32 = 200;
/// A heading that is not known.
const NO_HEADING: u16 = u16::MAX;
/// A yaw that is older, or newer, than this by the vehicle's clock tells nothing of another time,
/// milliseconds.
const YAW_LASTS_MS: u32 = 400;

/// Thins the reports of one autopilot.
#[derive(Debug, Clone, Default)]
pub(super) struct AutopilotReports {
    position_ms: Option<u32>,
    attitude_ms: Option<u32>,
    heading: Option<Angle>,
    yaw: Option<TimedYaw>,
}

/// The yaw of the nose from north, with its rate, at a time since boot.
#[derive(Debug, Clone, Copy)]
struct TimedYaw {
    ms: u32,
    rad: f64,
    rad_per_s: f64,
}

impl AutopilotReports {
    /// The direction of the nose from north at a time since boot, radians; `None`: not known of that time.
    pub(super) fn nose_at(&self, ms: u32) -> Option<f64> {
        let yaw = self.yaw.filter(|yaw| ms.abs_diff(yaw.ms) <= YAW_LASTS_MS)?;
        Some(yaw.rad + yaw.rad_per_s * (f64::from(ms) - f64::from(yaw.ms)) * 1e-3)
    }

    /// Whether both reports were in a frame of the vehicle's autopilot: position, attitude.
    pub(super) fn kinds(frame: &Frame<'_>) -> [bool; 2] {
        let is_autopilots = frame.from.component == AUTOPILOT;
        [GLOBAL_POSITION_INT_DATA::ID, ATTITUDE_DATA::ID].map(|id| is_autopilots && frame.message == id)
    }

    /// The newest direction of the vehicle's nose from north, positive to the east; `None`: not known.
    pub(super) const fn heading(&self) -> Option<Angle> {
        self.heading
    }

    /// The report in a frame of the vehicle's system, if the frame has one that is due.
    pub(super) fn read(&mut self, frame: &Frame<'_>) -> Option<Report> {
        if frame.from.component != AUTOPILOT {
            return None;
        }
        if let Some(position) = frame.read::<GLOBAL_POSITION_INT_DATA>() {
            self.heading = reported_heading(&position);
            is_due(&mut self.position_ms, position.time_boot_ms)
                .then(|| reported_position(&position))
                .flatten()
        } else {
            let attitude = frame.read::<ATTITUDE_DATA>()?;
            let (rad, rad_per_s) = (f64::from(attitude.yaw), f64::from(attitude.yawspeed));
            let is_number = rad.is_finite() && rad_per_s.is_finite();
            self.yaw = is_number.then_some(TimedYaw { ms: attitude.time_boot_ms, rad, rad_per_s });
            is_due(&mut self.attitude_ms, attitude.time_boot_ms)
                .then(|| reported_attitude(&attitude))
                .flatten()
        }
    }
}

/// Whether a report of this time since boot is passed on. A time that went back is that of a restart.
fn is_due(last_ms: &mut Option<u32>, ms: u32) -> bool {
    let is_due = last_ms.is_none_or(|last| ms < last || SPACING_MS <= ms - last);
    if is_due {
        *last_ms = Some(ms);
    }
    is_due
}

/// A position; where it is 0/0, which autopilots without a fix report, the height alone. `None`: no place on
/// Earth.
fn reported_position(position: &GLOBAL_POSITION_INT_DATA) -> Option<Report> {
    let (latitude, longitude) = (f64::from(position.lat) * 1e-7, f64::from(position.lon) * 1e-7);
    let is_known = (position.lat, position.lon) != (0, 0);
    let is_possible = latitude.abs() <= 90.0 && longitude.abs() <= 180.0;
    if !is_known {
        return Some(Report::CameraHeight(f64::from(position.relative_alt) * 1e-3));
    }
    is_possible.then(|| Report::Position {
        latitude: Angle::from_degrees(latitude),
        longitude: Angle::from_degrees(longitude),
        altitude_m: f64::from(position.alt) * 1e-3,
        height_m: f64::from(position.relative_alt) * 1e-3,
        heading: reported_heading(position),
    })
}

fn reported_heading(position: &GLOBAL_POSITION_INT_DATA) -> Option<Angle> {
    (position.hdg != NO_HEADING).then(|| Angle::from_degrees(f64::from(position.hdg) * 1e-2))
}

/// Roll, pitch and yaw (frames north-east-down, forward-right-down) as a quaternion; `None`: one of them is
/// no number.
fn reported_attitude(attitude: &ATTITUDE_DATA) -> Option<Report> {
    let [roll, pitch, yaw] =
        [attitude.roll, attitude.pitch, attitude.yaw].map(|angle| f64::from(angle) / 2.0);
    if ![roll, pitch, yaw].iter().all(|angle| angle.is_finite()) {
        return None;
    }
    let [(sr, cr), (sp, cp), (sy, cy)] = [roll, pitch, yaw].map(libm::sincos);
    Some(Report::VehicleAttitude(Quaternion {
        w: cr * cp * cy + sr * sp * sy,
        x: sr * cp * cy - cr * sp * sy,
        y: cr * sp * cy + sr * cp * sy,
        z: cr * cp * sy - sr * sp * cy,
    }))
}
