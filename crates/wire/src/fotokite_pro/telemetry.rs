//! The ground station's telemetry lines, `!Name v1,v2,...`.
//!
//! The parser ignores invalid lines: unknown names, wrong field counts, invalid numbers, shell echo.

use barrelman_vocab::Angle;
use barrelman_vocab::telemetry::{ControlState, FlightState, Quaternion, Report};

/// Metres of tether per encoder count.
pub const TETHER_METRES_PER_COUNT: f64 = 0.002_85;

/// `!GSStatus` mode number of a ground station under remote control.
pub const MODE_REMOTE_CONTROLLED: u32 = 10;

/// Parses one received line. `None` if it is not a known telemetry line.
pub fn parse(line: &str) -> Option<Report> {
    let (name, fields) = line.strip_prefix('!')?.split_once(' ')?;
    match name {
        "GSStatus" => {
            let [mode, uptime_s, battery_v, counts] = numbers(fields)?;
            let control = match whole(mode)? {
                MODE_REMOTE_CONTROLLED => ControlState::Ours,
                _ => ControlState::Elsewhere,
            };
            Some(Report::Ground { control, uptime_s, battery_v, tether_m: counts * TETHER_METRES_PER_COUNT })
        }
        "Attitude" => Some(Report::VehicleAttitude(quaternion(fields)?)),
        "Gimbal" => Some(Report::GimbalAttitude(quaternion(fields)?)),
        "Pos" => {
            let [elevation, azimuth, altitude_m] = numbers(fields)?;
            Some(Report::Tether {
                elevation: Angle::from_radians(elevation),
                azimuth: Angle::from_radians(azimuth),
                altitude_m,
            })
        }
        "FlightStatus" => {
            let [mode, on_time_s, backup_battery_v, warnings] = numbers(fields)?;
            let (mode, warnings) = (whole(mode)?, whole(warnings)?);
            Some(Report::Flight {
                state: flight_state(mode),
                on_time_s,
                backup_battery_v,
                warnings,
                is_battery_low: warnings & LOW_BATTERY_BITS != 0 || mode == BATTERY_TOO_LOW_TO_START,
            })
        }
        _ => None,
    }
}

/// Exactly `N` finite decimal numbers, separated by commas.
fn numbers<const N: usize>(fields: &str) -> Option<[f64; N]> {
    let mut values = [0.0; N];
    let mut parts = fields.split(',');
    for value in &mut values {
        *value = parts.next()?.trim().parse().ok().filter(|number: &f64| number.is_finite())?;
    }
    parts.next().is_none().then_some(values)
}

fn whole(number: f64) -> Option<u32> {
    (number.fract() == 0.0 && (0.0..=f64::from(u32::MAX)).contains(&number)).then_some(number as u32)
}

fn quaternion(fields: &str) -> Option<Quaternion> {
    let [w, x, y, z] = numbers(fields)?;
    // Four zeros are not a rotation: the sensor has no value yet.
    ([w, x, y, z] != [0.0; 4]).then_some(Quaternion { w, x, y, z })
}

/// Warning bits: 2 CRIT_LOW_BATT, 6 LOW_BATT, 7 LOW_BACKUP_BATT.
const LOW_BATTERY_BITS: u32 = 1 << 2 | 1 << 6 | 1 << 7;
const BATTERY_TOO_LOW_TO_START: u32 = 53;

/// Flight modes: 1 IDLE, 2 ANGLE, 3 ANGLE_RATE; 48 EMERGENCY_LAND, 49 MOTOR_STOP_RESTART, 50 TIMEOUT,
/// 52 MOTOR_STOP_DISABLE, 53 BATTERY_TOO_LOW_TO_START, 54 NO_TETHER_POWER, 55 HARD_KILL.
fn flight_state(mode: u32) -> FlightState {
    match mode {
        1 => FlightState::Idle,
        2 | 3 => FlightState::Flying,
        48..=50 | 52..=55 => FlightState::Emergency,
        other => FlightState::Other(other),
    }
}
