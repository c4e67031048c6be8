//! From the bodies of answers to the reports of a vehicle, and to what they tell of the camera's motion.

use core::time::Duration;

use barrelman_vocab::telemetry::{FlightState, Report};
use barrelman_vocab::{Angle, AngularRate, Timestamp};

use super::json;
use crate::session::RestEvidence;

/// A battery below this level counts as low, per cent. The API document names no level.
pub const LOW_BATTERY: f64 = 20.0;
/// A camera that turns slower than this counts as resting: the kite sways.
pub const AT_REST: AngularRate = AngularRate::from_radians_per_second(0.05);
/// A camera that turns faster than this, rad/s, does more than to sway with its kite.
pub const TURNS: AngularRate = AngularRate::from_radians_per_second(0.15);
/// Least time between two states from which a rate is computed: the angles are rounded.
const LEAST_INTERVAL: Duration = Duration::from_millis(80);
/// Older states tell nothing.
const RECENT: Duration = Duration::from_millis(600);

/// What is known of the flight. A state that has not been read is absent.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Flight {
    state: Option<FlightState>,
    is_battery_low: bool,
    is_fatal: bool,
    has_battery_notification: bool,
}

impl Flight {
    /// Takes the flight's state.
    pub fn on_state(&mut self, state: &json::FlightState) {
        self.state = Some(flight_state(&state.flight_state));
    }

    /// Takes the batteries' levels.
    pub fn on_batteries(&mut self, state: &json::SystemState) {
        let levels = [state.kite_battery_level, state.gs_battery_level];
        self.is_battery_low = levels.into_iter().flatten().any(|level| level < LOW_BATTERY);
    }

    /// Takes the notifications. A fatal one counts as an emergency, a critical one of a battery as a low
    /// battery.
    pub fn on_notifications(&mut self, list: &[json::Notification]) {
        let active =
            || list.iter().filter(|one| one.end_time.as_ref().is_none_or(serde_json::Value::is_null));
        self.is_fatal = active().any(|one| one.severity == "Fatal");
        self.has_battery_notification =
            active().any(|one| one.severity == "Critical" && one.code.to_lowercase().contains("batter"));
    }

    /// The report; `None` before the flight's state was read.
    pub fn report(&self) -> Option<Report> {
        let state = if self.is_fatal { Some(FlightState::Emergency) } else { self.state };
        let is_battery_low = self.is_battery_low || self.has_battery_notification;
        state.map(|state| Report::FlightState { state, is_battery_low })
    }
}

fn flight_state(name: &str) -> FlightState {
    match name {
        "StandBy" => FlightState::Idle,
        "Flying" => FlightState::Flying,
        "Landing" => FlightState::Landing,
        "SafetyLanding" | "SafetyDescending" => FlightState::Emergency,
        "TakingOff" => FlightState::Other(1),
        _ => FlightState::Other(0),
    }
}

/// The tilt of a state: positive above the horizon. `None`: not measured, or not an angle.
pub fn tilt_of(state: &json::CameraState) -> Option<Report> {
    let down = state.tilt_ned.filter(|angle| (-180.0..=180.0).contains(angle))?;
    Some(Report::CameraTilt(Angle::from_degrees(-down)))
}

/// The pan of a state: clockwise from north. `None`: not measured, or not an angle.
pub fn pan_of(state: &json::CameraState) -> Option<Report> {
    let right = state.pan_ned.filter(|angle| (-360.0..=360.0).contains(angle))?;
    Some(Report::CameraPan(Angle::from_degrees(right)))
}

/// The field of view of a stream's state. `None`: not measured, or not an angle that a lens can have.
pub fn field_of_view_of(state: &json::VideoStreamState) -> Option<Report> {
    let angle = state.fov_horizontal.filter(|angle| (0.1..170.0).contains(angle))?;
    Some(Report::FieldOfView(Angle::from_degrees(angle)))
}

/// Where the camera pointed, and how fast it turned between two states.
#[derive(Debug, Clone, Copy, Default)]
pub struct CameraWatch {
    last: Option<(Timestamp, f64, f64)>,
    rate: Option<(Timestamp, Timestamp, AngularRate)>,
}

impl CameraWatch {
    /// Takes a state.
    pub fn on_state(&mut self, state: &json::CameraState, now: Timestamp) {
        let (Some(pan), Some(tilt)) = (state.pan_ned, state.tilt_ned) else { return };
        if let Some((before, pan_before, tilt_before)) = self.last {
            let interval = now.since(before);
            if interval < LEAST_INTERVAL {
                return;
            }
            let turned = half_turn(pan - pan_before).abs().max((tilt - tilt_before).abs());
            let rate = AngularRate::from_radians_per_second(turned.to_radians() / interval.as_secs_f64());
            self.rate = Some((before, now, rate));
        }
        self.last = Some((now, pan, tilt));
    }

    /// What two states, both from after `since`, show of the camera's motion.
    pub fn since(&self, since: Timestamp, now: Timestamp) -> RestEvidence {
        match self.rate {
            Some((first, second, rate)) if first >= since && now.since(second) <= RECENT => {
                if rate < AT_REST { RestEvidence::AtRest } else { RestEvidence::Moving { rate } }
            }
            _ => RestEvidence::NoTelemetry,
        }
    }
}

/// An angle in -180 to 180 degrees.
fn half_turn(degrees: f64) -> f64 {
    let turns = (degrees / 360.0).round();
    degrees - turns * 360.0
}
