//! The keys of the section `[vehicle]` about turns of the vehicle and reported attitudes.

use anyhow::{Result, bail};
use barrelman_vocab::Angle;
use barrelman_vocab::profile::{GimbalTilt, NetYawLimits, Sign};
use barrelman_vocab::telemetry::EulerAxis;

use super::file::{EulerName, GimbalTiltSection, SignName, VehicleSection};

/// The limits of the net yaw.
///
/// # Errors
/// If the warning comes after the refusal.
pub(super) fn net_yaw_limits(vehicle: &VehicleSection, base: NetYawLimits) -> Result<NetYawLimits> {
    let limits = NetYawLimits {
        warn: vehicle.net_yaw_warn_rad.map_or(base.warn, Angle::from_radians),
        refuse: vehicle.net_yaw_limit_rad.map_or(base.refuse, Angle::from_radians),
    };
    if limits.warn > limits.refuse {
        bail!("vehicle.net_yaw_warn_rad is above vehicle.net_yaw_limit_rad: correct one of them");
    }
    Ok(limits)
}

/// The tilt in the gimbal's reports.
pub(super) const fn gimbal_tilt(section: &GimbalTiltSection) -> GimbalTilt {
    GimbalTilt {
        axis: match section.axis {
            EulerName::Roll => EulerAxis::X,
            EulerName::Pitch => EulerAxis::Y,
            EulerName::Yaw => EulerAxis::Z,
        },
        sign: match section.sign {
            SignName::Same => Sign::Same,
            SignName::Opposite => Sign::Opposite,
        },
        zero: Angle::from_radians(section.zero_rad),
    }
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
