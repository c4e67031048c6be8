//! The section `[camera.zoom]` of a configuration file: the zoom, and the size in which it keeps the target.

use core::time::Duration;

use anyhow::{Result, bail};
use barrelman_vocab::profile::SizeKeeping;
use barrelman_vocab::{VehicleProfile, ZoomDynamics, ZoomRate};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// A camera without zoom; with another ratio, one that was not measured.
const NO_ZOOM: ZoomDynamics = ZoomDynamics::usual(1.0);

/// The zoom. Zoom by hand and keeping the size need it. `camera.focal_share` is that of the widest view.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct ZoomSection {
    /// Focal length of the closest view over that of the widest; 1: the camera does not zoom.
    #[schemars(range(min = 1.0, max = 100.0), extend("unit" = "a ratio"))]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub ratio: Option<f64>,
    /// Largest change of the focal length's logarithm in a second.
    #[schemars(range(min = 0.01, max = 10.0))]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub limit_per_s: Option<f64>,
    /// Dead time of a command, without the video's latency, seconds.
    #[schemars(range(min = 0.0, max = 2.0))]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub dead_time_s: Option<f64>,
    /// Keep the boat's size in the picture from the start, while engaged.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub keep_size: Option<bool>,
    /// Smallest size that is kept: the longer side of the boat's box over the picture's height.
    #[schemars(range(min = 0.005, max = 0.5), extend("unit" = "a share of the picture's height"))]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub smallest_size: Option<f64>,
    /// Largest size that is kept, at least twice `smallest_size`.
    #[schemars(range(min = 0.01, max = 0.9), extend("unit" = "a share of the picture's height"))]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub largest_size: Option<f64>,
}

impl ZoomSection {
    /// The complete section.
    pub(super) fn of(profile: &VehicleProfile) -> Self {
        let size = profile.size;
        let zoom = profile.zoom.unwrap_or(NO_ZOOM);
        Self {
            ratio: Some(zoom.ratio),
            limit_per_s: Some(zoom.max_rate.per_second()),
            dead_time_s: Some(zoom.dead_time.as_secs_f64()),
            keep_size: Some(size.is_on_at_start),
            smallest_size: Some(size.smallest),
            largest_size: Some(size.largest),
        }
    }

    /// The zoom of a vehicle with the values of the section.
    fn zoom(&self, base: Option<ZoomDynamics>) -> Option<ZoomDynamics> {
        let base = base.unwrap_or(NO_ZOOM);
        let zoom = ZoomDynamics {
            ratio: self.ratio.unwrap_or(base.ratio),
            max_rate: self.limit_per_s.map_or(base.max_rate, ZoomRate::from_per_second),
            dead_time: self.dead_time_s.map_or(base.dead_time, Duration::from_secs_f64),
        };
        (zoom.ratio > 1.0).then_some(zoom)
    }

    /// The profile `base` with the values of the section.
    ///
    /// # Errors
    /// If values contradict each other; the message names the keys.
    pub(super) fn apply_to(&self, base: VehicleProfile) -> Result<VehicleProfile> {
        let size = SizeKeeping {
            smallest: self.smallest_size.unwrap_or(base.size.smallest),
            largest: self.largest_size.unwrap_or(base.size.largest),
            is_on_at_start: self.keep_size.unwrap_or(base.size.is_on_at_start),
        };
        if size.largest < 2.0 * size.smallest {
            bail!(
                "camera.zoom.largest_size = {} is less than twice camera.zoom.smallest_size = {}: the zoom would never rest",
                size.largest,
                size.smallest
            );
        }
        let zoom = self.zoom(base.zoom);
        if size.is_on_at_start && zoom.is_none() {
            bail!("camera.zoom.keep_size needs a camera that zooms: give camera.zoom.ratio");
        }
        Ok(VehicleProfile { zoom, size, ..base })
    }
}
