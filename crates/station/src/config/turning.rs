//! The keys of the section `[vehicle]` about turns of the vehicle and reported attitudes.

use anyhow::{Result, bail};
use barrelman_vocab::Angle;
use barrelman_vocab::profile::{GimbalTilt, NetYawLimits, Sign};
use barrelman_vocab::telemetry::EulerAxis;

use super::file::{EulerName, GimbalTiltSection, SignName, VehicleSection};
use super::range::within;

/// The limits of the net yaw.
///
/// # Errors
/// If a limit is out of range, or the warning comes after the refusal.
pub(super) fn net_yaw_limits(vehicle: &VehicleSection, base: NetYawLimits) -> Result<NetYawLimits> {
    let angle = |key: &str, value: Option<f64>, base: Angle| {
        let key = format!("vehicle.{key}");
        within(&key, value, base.radians(), 0.5, 100.0, "radians").map(Angle::from_radians)
    };
    let limits = NetYawLimits {
        warn: angle("net_yaw_warn_rad", vehicle.net_yaw_warn_rad, base.warn)?,
        refuse: angle("net_yaw_limit_rad", vehicle.net_yaw_limit_rad, base.refuse)?,
    };
    if limits.warn > limits.refuse {
        bail!("vehicle.net_yaw_warn_rad is above vehicle.net_yaw_limit_rad: correct one of them");
    }
    Ok(limits)
}

/// The tilt in the gimbal's reports.
///
/// # Errors
/// If the zero is out of range.
pub(super) fn gimbal_tilt(section: &GimbalTiltSection) -> Result<GimbalTilt> {
    let key = "vehicle.gimbal_tilt.zero_rad";
    Ok(GimbalTilt {
        axis: match section.axis {
            EulerName::Roll => EulerAxis::X,
            EulerName::Pitch => EulerAxis::Y,
            EulerName::Yaw => EulerAxis::Z,
        },
        sign: match section.sign {
            SignName::Same => Sign::Same,
            SignName::Opposite => Sign::Opposite,
        },
        zero: Angle::from_radians(within(key, Some(section.zero_rad), 0.0, -1.571, 1.571, "radians")?),
    })
}

/// The section of a convention.
pub(super) fn section_of(tilt: &GimbalTilt) -> GimbalTiltSection {
    GimbalTiltSection {
        axis: match tilt.axis {
            EulerAxis::X => EulerName::Roll,
            EulerAxis::Y => EulerName::Pitch,
            EulerAxis::Z => EulerName::Yaw,
        },
        sign: match tilt.sign {
            Sign::Same => SignName::Same,
            Sign::Opposite => SignName::Opposite,
        },
        zero_rad: tilt.zero.radians(),
    }
}
