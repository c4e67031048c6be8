//! Telemetry, to and from its stored form.

use barrelman_vocab::drive_mode::DriveMode;
use barrelman_vocab::telemetry::{ControlState, FlightState, Quaternion, Report};
use barrelman_vocab::vehicle_text::VehicleText;
use barrelman_vocab::{Angle, Equipment, Telemetry, Timestamp};

use super::malformed::{Malformed, missing};
use crate::records::stored;

fn stored_quaternion(q: Quaternion) -> stored::Quaternion {
    stored::Quaternion { w: q.w, x: q.x, y: q.y, z: q.z }
}

fn quaternion(q: stored::Quaternion) -> Quaternion {
    Quaternion { w: q.w, x: q.x, y: q.y, z: q.z }
}

/// A flight state's stored form, and the vehicle's own mode number.
fn stored_flight_state(state: FlightState) -> (i32, u32) {
    let (state, mode) = match state {
        FlightState::Idle => (stored::FlightState::Idle, 0),
        FlightState::Flying => (stored::FlightState::Flying, 0),
        FlightState::Landing => (stored::FlightState::Landing, 0),
        FlightState::Emergency => (stored::FlightState::Emergency, 0),
        FlightState::Other(mode) => (stored::FlightState::Other, mode),
    };
    (state as i32, mode)
}

fn flight_state(state: i32, mode: u32) -> Result<FlightState, Malformed> {
    Ok(match stored::FlightState::try_from(state).map_err(|_| missing("state"))? {
        stored::FlightState::Idle => FlightState::Idle,
        stored::FlightState::Flying => FlightState::Flying,
        stored::FlightState::Landing => FlightState::Landing,
        stored::FlightState::Emergency => FlightState::Emergency,
        stored::FlightState::Other => FlightState::Other(mode),
    })
}

fn control(state: i32) -> Result<ControlState, Malformed> {
    stored::ControlState::try_from(state).map_err(|_| missing("control"))?.try_into()
}

impl From<&Telemetry> for stored::TelemetryInput {
    fn from(telemetry: &Telemetry) -> Self {
        use stored::telemetry_input::Report as Stored;
        let report = match telemetry.report {
            Report::Link(state) => Stored::Link(stored::LinkState::from(state) as i32),
            Report::Ground { control, uptime_s, battery_v, tether_m } => {
                let control = stored::ControlState::from(control) as i32;
                Stored::Ground(stored::GroundReport { control, uptime_s, battery_v, tether_m })
            }
            Report::Control { control, uptime_s } => {
                let control = stored::ControlState::from(control) as i32;
                Stored::Control(stored::ControlReport { control, uptime_s })
            }
            Report::VehicleAttitude(q) => Stored::VehicleAttitude(stored_quaternion(q)),
            Report::GimbalAttitude(q) => Stored::GimbalAttitude(stored_quaternion(q)),
            Report::CameraTilt(tilt) => Stored::CameraTiltRad(tilt.radians()),
            Report::CameraHeading(heading) => Stored::CameraHeadingRad(heading.radians()),
            Report::CameraPan(pan) => Stored::CameraPanRad(pan.radians()),
            Report::CameraHeight(height_m) => Stored::CameraHeightM(height_m),
            Report::Speed(speed_m_per_s) => Stored::SpeedMPerS(speed_m_per_s),
            Report::DriveMode(DriveMode(number)) => Stored::DriveMode(number),
            Report::Text(text) => Stored::Text(stored::VehicleText {
                severity: text.severity().into(),
                text: text.as_str().to_owned(),
            }),
            Report::Equipment(Equipment { kind, name }) => Stored::Equipment(stored::Equipment {
                kind: stored::EquipmentKind::from(kind) as i32,
                name: name.as_str().to_owned(),
            }),
            Report::Zoom(told) => Stored::Zoom(stored::ZoomAbility::from(told) as i32),
            Report::FieldOfView(angle) => Stored::FieldOfViewRad(angle.radians()),
            Report::OtherVideo(angle) => {
                Stored::OtherVideo(stored::OtherVideo { field_of_view_rad: angle.map(Angle::radians) })
            }
            Report::FlightState { state, is_battery_low } => {
                let (state, mode) = stored_flight_state(state);
                Stored::FlightState(stored::FlightStateReport { state, mode, is_battery_low })
            }
            Report::Acceptance(said) => Stored::Acceptance(stored::Acceptance::from(said) as i32),
            Report::Position { latitude, longitude, altitude_m, height_m, heading } => {
                Stored::Position(stored::PositionReport {
                    latitude_rad: latitude.radians(),
                    longitude_rad: longitude.radians(),
                    altitude_m,
                    height_m,
                    heading_rad: heading.map(Angle::radians),
                })
            }
            Report::Tether { elevation, azimuth, altitude_m } => Stored::Tether(stored::TetherReport {
                elevation_rad: elevation.radians(),
                azimuth_rad: azimuth.radians(),
                altitude_m,
            }),
            Report::Flight { state, on_time_s, backup_battery_v, warnings, is_battery_low } => {
                let (state, mode) = stored_flight_state(state);
                Stored::Flight(stored::FlightReport {
                    state,
                    mode,
                    on_time_s,
                    backup_battery_v,
                    warnings,
                    is_battery_low,
                })
            }
        };
        Self { step: 0, now_ns: 0, at_ns: telemetry.at.as_nanos(), report: Some(report), of_vessel: false }
    }
}

impl TryFrom<stored::TelemetryInput> for Telemetry {
    type Error = Malformed;

    fn try_from(message: stored::TelemetryInput) -> Result<Self, Malformed> {
        use stored::telemetry_input::Report as Stored;
        let report = match message.report.ok_or_else(|| missing("report"))? {
            Stored::Link(state) => {
                Report::Link(stored::LinkState::try_from(state).map_err(|_| missing("link"))?.try_into()?)
            }
            Stored::Control(report) => {
                Report::Control { control: control(report.control)?, uptime_s: report.uptime_s }
            }
            Stored::Ground(ground) => Report::Ground {
                control: control(ground.control)?,
                uptime_s: ground.uptime_s,
                battery_v: ground.battery_v,
                tether_m: ground.tether_m,
            },
            Stored::VehicleAttitude(q) => Report::VehicleAttitude(quaternion(q)),
            Stored::GimbalAttitude(q) => Report::GimbalAttitude(quaternion(q)),
            Stored::CameraTiltRad(tilt) => Report::CameraTilt(Angle::from_radians(tilt)),
            Stored::CameraHeadingRad(heading) => Report::CameraHeading(Angle::from_radians(heading)),
            Stored::CameraPanRad(pan) => Report::CameraPan(Angle::from_radians(pan)),
            Stored::CameraHeightM(height_m) => Report::CameraHeight(height_m),
            Stored::SpeedMPerS(speed_m_per_s) => Report::Speed(speed_m_per_s),
            Stored::DriveMode(number) => Report::DriveMode(DriveMode(number)),
            Stored::Text(text) => {
                let severity = u8::try_from(text.severity).map_err(|_| missing("severity"))?;
                Report::Text(VehicleText::of(severity, text.text.as_bytes()))
            }
            Stored::Equipment(used) => {
                let kind = stored::EquipmentKind::try_from(used.kind).map_err(|_| missing("equipment"))?;
                Report::Equipment(Equipment::new(kind.try_into()?, &used.name))
            }
            Stored::Zoom(told) => {
                Report::Zoom(stored::ZoomAbility::try_from(told).map_err(|_| missing("zoom"))?.try_into()?)
            }
            Stored::FieldOfViewRad(angle) => Report::FieldOfView(Angle::from_radians(angle)),
            Stored::OtherVideo(video) => Report::OtherVideo(video.field_of_view_rad.map(Angle::from_radians)),
            Stored::FlightState(flight) => Report::FlightState {
                state: flight_state(flight.state, flight.mode)?,
                is_battery_low: flight.is_battery_low,
            },
            Stored::Acceptance(said) => Report::Acceptance(
                stored::Acceptance::try_from(said).map_err(|_| missing("acceptance"))?.try_into()?,
            ),
            Stored::Position(position) => Report::Position {
                latitude: Angle::from_radians(position.latitude_rad),
                longitude: Angle::from_radians(position.longitude_rad),
                altitude_m: position.altitude_m,
                height_m: position.height_m,
                heading: position.heading_rad.map(Angle::from_radians),
            },
            Stored::Tether(tether) => Report::Tether {
                elevation: Angle::from_radians(tether.elevation_rad),
                azimuth: Angle::from_radians(tether.azimuth_rad),
                altitude_m: tether.altitude_m,
            },
            Stored::Flight(flight) => Report::Flight {
                state: flight_state(flight.state, flight.mode)?,
                on_time_s: flight.on_time_s,
                backup_battery_v: flight.backup_battery_v,
                warnings: flight.warnings,
                is_battery_low: flight.is_battery_low,
            },
        };
        Ok(Self { at: Timestamp::from_nanos(message.at_ns), report })
    }
}
