//! The section `[vehicle.speeds]`: how fast the camera turns, where the vehicle's speeds have no unit.

use anyhow::{Context as _, Result, bail};
use barrelman_vocab::speed_curve::{AxisSpeeds, SpeedCurve, SpeedPoint};
use barrelman_vocab::{AngularRate, VehicleProfile};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// The rates at the camera's speeds (ONVIF). Either `pan` and `tilt`, as `barrelman calibrate axes` measures
/// them, or `full_rad_per_s`.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct SpeedsSection {
    /// Points of the pan axis, each a speed above 0 to 1 and the rate there, rad/s, both rising. Below the
    /// first speed the axis rests.
    #[schemars(example = [[0.1, 0.05], [1.0, 0.5]])]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub pan: Option<Vec<[f64; 2]>>,
    /// Points of the tilt axis.
    #[schemars(example = [[0.1, 0.05], [1.0, 0.5]])]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub tilt: Option<Vec<[f64; 2]>>,
    /// Without points: the rate at the speed 1, taken for both axes, with rates in between in proportion.
    /// Give the fastest that is possible: a camera that is slower turns less than asked, and loses no boat by
    /// it.
    #[schemars(range(min = 0.05, max = 10.0))]
    #[schemars(example = 3.0)]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub full_rad_per_s: Option<f64>,
}

impl SpeedsSection {
    /// The section of measured curves.
    pub(super) fn of(speeds: &AxisSpeeds) -> Self {
        let points = |curve: &SpeedCurve| {
            let pair = |point: &SpeedPoint| [point.speed, point.rate.radians_per_second()];
            Some(curve.points().iter().map(pair).collect())
        };
        Self { pan: points(&speeds.pan), tilt: points(&speeds.tilt), full_rad_per_s: None }
    }

    /// The vehicle with these curves: its limits are at most the largest rates, and its least rates those of
    /// the curves.
    ///
    /// # Errors
    /// If the section does not suit the vehicle, or its points are no curves.
    pub(super) fn apply_to(&self, profile: VehicleProfile) -> Result<VehicleProfile> {
        if *self == Self::default() {
            return Ok(profile);
        }
        if profile.protocol.speeds_are_rates() {
            bail!(
                "vehicle.speeds is for a camera whose speeds have no unit, and {} is none: omit it, or give \
                 vehicle.profile = \"onvif-ptz\"",
                profile.name
            );
        }
        let speeds = match (&self.pan, &self.tilt, self.full_rad_per_s) {
            (Some(pan), Some(tilt), None) => {
                AxisSpeeds { pan: curve("pan", pan)?, tilt: curve("tilt", tilt)? }
            }
            (None, None, Some(full)) => {
                let linear = SpeedCurve::linear(AngularRate::from_radians_per_second(full));
                AxisSpeeds { pan: linear.clone(), tilt: linear }
            }
            _ => bail!("vehicle.speeds: give both pan and tilt, or full_rad_per_s alone"),
        };
        Ok(profile.with_speeds(speeds))
    }
}

fn curve(axis: &str, points: &[[f64; 2]]) -> Result<SpeedCurve> {
    let point = |[speed, rate]: &[f64; 2]| SpeedPoint {
        speed: *speed,
        rate: AngularRate::from_radians_per_second(*rate),
    };
    SpeedCurve::new(points.iter().map(point).collect())
        .with_context(|| format!("vehicle.speeds.{axis} is no curve"))
}
