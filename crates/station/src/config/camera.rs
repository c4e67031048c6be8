//! The section `[camera]` of a configuration file: optics and dynamics of the camera.

use core::time::Duration;
use std::path::PathBuf;

use anyhow::{Result, bail};
use barrelman_vocab::profile::{AxisDynamics, CameraDynamics};
use barrelman_vocab::{Angle, AngularRate, Lens, VehicleProfile};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::lens::{self, LensSection};
use super::zoom::ZoomSection;

/// Focal lengths that differ by less than this share of the picture's width are the same.
const SAME_FOCAL_SHARE: f64 = 1e-9;

/// Optics and dynamics of the camera. The optimal law predicts with them; with every law, the tracker's
/// motion prior is computed from them.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct CameraSection {
    /// Focal length as a share of the picture's width.
    #[schemars(range(min = 0.1, max = 20.0), extend("unit" = "a share of the picture's width"))]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub focal_share: Option<f64>,
    /// A file with the keys of `camera.lens`. A relative path starts in the current folder.
    #[schemars(example = "/etc/barrelman/lens.toml")]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub lens_file: Option<PathBuf>,
    /// The calibrated lens, for points on the water; default: a pinhole of `focal_share`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub lens: Option<LensSection>,
    /// Elevation of the camera at the start, radians, without telemetry; negative looks down.
    #[schemars(range(min = -1.571, max = 1.571))]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub first_tilt_rad: Option<f64>,
    /// Lower end stop of the elevation, radians.
    #[schemars(range(min = -1.571, max = 1.571))]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub lowest_tilt_rad: Option<f64>,
    /// Upper end stop of the elevation, radians.
    #[schemars(range(min = -1.571, max = 1.571))]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub highest_tilt_rad: Option<f64>,
    /// The pan axis.
    pub pan: AxisSection,
    /// The tilt axis.
    pub tilt: AxisSection,
    /// The zoom. Zoom by hand and keeping the size need it; `focal_share` is that of the widest view.
    pub zoom: ZoomSection,
}

/// Dynamics of an axis.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct AxisSection {
    /// Dead time of a command that moves, without the video's latency, seconds.
    #[schemars(range(min = 0.0, max = 2.0))]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub start_dead_time_s: Option<f64>,
    /// Dead time of a stop command, seconds, at least `start_dead_time_s`.
    #[schemars(range(min = 0.0, max = 2.0))]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub stop_dead_time_s: Option<f64>,
    /// Time constant of the rate after the dead time, seconds.
    #[schemars(range(min = 0.0, max = 2.0))]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub lag_s: Option<f64>,
    /// Lowest rate above zero at which the axis turns, rad/s. On a vehicle at most 0.2: nudges and searches
    /// would not move the axis otherwise.
    #[schemars(range(min = 0.0, max = 1.0))]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub least_rad_per_s: Option<f64>,
    /// Rate that the axis reaches, divided by the rate that is sent. `barrelman calibrate axes` measures it.
    #[schemars(range(min = 0.2, max = 5.0), extend("unit" = "a ratio"))]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub gain: Option<f64>,
}

impl CameraSection {
    /// The complete section.
    pub fn of(profile: &VehicleProfile) -> Self {
        let camera = &profile.camera;
        let axis = |axis: &AxisDynamics| AxisSection {
            start_dead_time_s: Some(axis.start_dead_time.as_secs_f64()),
            stop_dead_time_s: Some(axis.stop_dead_time.as_secs_f64()),
            lag_s: Some(axis.lag.as_secs_f64()),
            least_rad_per_s: Some(axis.min_rate.radians_per_second()),
            gain: Some(axis.gain),
        };
        Self {
            focal_share: Some(camera.focal_share),
            lens_file: None,
            lens: camera.lens.as_ref().and_then(LensSection::from_lens),
            first_tilt_rad: Some(camera.initial_tilt.radians()),
            lowest_tilt_rad: Some(camera.tilt_stops.0.radians()),
            highest_tilt_rad: Some(camera.tilt_stops.1.radians()),
            pan: axis(&camera.pan),
            tilt: axis(&camera.tilt),
            zoom: ZoomSection::of(profile),
        }
    }

    /// Replaces the name of a lens file by its contents.
    ///
    /// # Errors
    /// If the file cannot be read or its lens cannot be used, or if the section has a lens already.
    pub(super) fn read_lens(&mut self) -> Result<()> {
        let Some(path) = self.lens_file.take() else { return Ok(()) };
        if self.lens.is_some() {
            bail!("camera.lens_file and camera.lens are both given: omit one");
        }
        self.lens = Some(lens::read(&path)?);
        Ok(())
    }

    /// The focal length: that of the lens, where there is one.
    fn focal_share(&self, base: &CameraDynamics, lens: Option<&Lens>) -> Result<f64> {
        let calibrated = lens.map(|lens| lens.focal_px.0 / f64::from(lens.picture.width));
        if let (Some(calibrated), Some(given)) = (calibrated, self.focal_share)
            && (given - calibrated).abs() > SAME_FOCAL_SHARE
        {
            bail!(
                "camera.focal_share = {given} is not that of camera.lens, {calibrated} (fx / width): omit camera.focal_share"
            );
        }
        Ok(calibrated.or(self.focal_share).unwrap_or(base.focal_share))
    }

    /// The profile `base` with the values of the section.
    ///
    /// # Errors
    /// If a value is out of range; the message names the key and the range.
    pub fn apply_to(&self, base: VehicleProfile) -> Result<VehicleProfile> {
        let camera = self.dynamics(&base.camera)?;
        self.zoom.apply_to(VehicleProfile { camera, ..base })
    }

    fn dynamics(&self, base: &CameraDynamics) -> Result<CameraDynamics> {
        let tilt = |value: Option<f64>, base: Angle| value.map_or(base, Angle::from_radians);
        let stops =
            (tilt(self.lowest_tilt_rad, base.tilt_stops.0), tilt(self.highest_tilt_rad, base.tilt_stops.1));
        if stops.0.radians() >= stops.1.radians() {
            bail!("camera.lowest_tilt_rad is not below camera.highest_tilt_rad: correct one of them");
        }
        if let Some(path) = &self.lens_file {
            bail!("camera.lens_file = {path:?} was not read: only a configuration file may name a lens file");
        }
        let lens = self.lens.as_ref().map(LensSection::to_lens).transpose()?.or(base.lens);
        Ok(CameraDynamics {
            focal_share: self.focal_share(base, lens.as_ref())?,
            lens,
            initial_tilt: tilt(self.first_tilt_rad, base.initial_tilt),
            tilt_stops: stops,
            pan: self.pan.apply_to("camera.pan", &base.pan)?,
            tilt: self.tilt.apply_to("camera.tilt", &base.tilt)?,
        })
    }
}

impl AxisSection {
    fn apply_to(&self, section: &str, base: &AxisDynamics) -> Result<AxisDynamics> {
        let seconds = |value: Option<f64>, base: Duration| value.map_or(base, Duration::from_secs_f64);
        let axis = AxisDynamics {
            start_dead_time: seconds(self.start_dead_time_s, base.start_dead_time),
            stop_dead_time: seconds(self.stop_dead_time_s, base.stop_dead_time),
            lag: seconds(self.lag_s, base.lag),
            min_rate: self.least_rad_per_s.map_or(base.min_rate, AngularRate::from_radians_per_second),
            gain: self.gain.unwrap_or(base.gain),
        };
        if axis.stop_dead_time < axis.start_dead_time {
            bail!("{section}.stop_dead_time_s is less than {section}.start_dead_time_s: correct one of them");
        }
        Ok(axis)
    }
}
