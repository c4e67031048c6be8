//! The table `vehicles`: the laboratory with other vehicles, each as its profile says.

use core::time::Duration;

use anyhow::Result;
use barrelman_sim::Scenario;
use barrelman_sim::video_link::VideoLinkModel;
use barrelman_sim::zoom::Zoom;
use barrelman_vocab::profile::AxisRates;
use barrelman_vocab::{AngularRate, VehicleProfile};

use super::options::Options;
use super::variants::{self, Variant};

/// Prints the table. Returns whether every column is within its limit in every row.
///
/// # Errors
/// If a scenario cannot be used.
pub(super) fn print(options: &Options) -> Result<bool> {
    variants::print_table("other vehicles", &VARIANTS, options)
}

/// The camera of a vehicle.
struct Vehicle {
    /// Dead times of pan and tilt, for starts and stops alike, without the video's latency.
    dead_time_s: [f64; 2],
    /// Time constants of pan and tilt.
    lag_s: [f64; 2],
    max_rate_deg_per_s: f64,
    /// Slower commands have no effect.
    min_rate_deg_per_s: f64,
    acceleration_rad_per_s2: Option<f64>,
    video_latency_s: f64,
}

/// The rates are the manufacturer's; the times are assumed: a request over the network, video over RTSP.
const SIGMA: Vehicle = Vehicle {
    dead_time_s: [0.1, 0.1],
    lag_s: [0.15, 0.15],
    max_rate_deg_per_s: 25.0,
    min_rate_deg_per_s: 2.0,
    acceleration_rad_per_s2: None,
    video_latency_s: 0.25,
};
/// The first change of attitude follows a message after 28 to 47 ms; lag, limit and video latency are
/// assumed.
const MAVLINK_GIMBAL: Vehicle = Vehicle {
    dead_time_s: [0.04, 0.04],
    lag_s: [0.06, 0.06],
    max_rate_deg_per_s: 60.0,
    min_rate_deg_per_s: 0.0,
    acceleration_rad_per_s2: None,
    video_latency_s: 0.2,
};
/// The simulated kite of the scenarios on the water: pan is its yaw.
const KITE_ON_WATER: Vehicle = Vehicle {
    dead_time_s: [0.2, 0.15],
    lag_s: [0.35, 0.15],
    max_rate_deg_per_s: 17.2,
    min_rate_deg_per_s: 0.57,
    acceleration_rad_per_s2: Some(0.8),
    video_latency_s: 0.2,
};

/// From the laboratory's field of view to half of it in tangents, and back.
const ZOOM: Zoom = Zoom { ratio: 2.0, period_s: 20.0 };

/// The first vehicle is that of all other tables.
const VARIANTS: [Variant; 5] = [
    Variant::new("Fotokite Pro", |_| {}, |_| {}),
    Variant::new("Fotokite Sigma, assumed times", |w| SIGMA.apply_to_world(w), |p| SIGMA.apply_to_profile(p)),
    Variant::new(
        "MAVLink gimbal, assumed lag",
        |w| MAVLINK_GIMBAL.apply_to_world(w),
        |p| MAVLINK_GIMBAL.apply_to_profile(p),
    ),
    Variant::new(
        "kite of the simulated water",
        |w| KITE_ON_WATER.apply_to_world(w),
        |p| KITE_ON_WATER.apply_to_profile(p),
    ),
    Variant::new("zoom while moving, reported", |w| w.camera.zoom = Some(ZOOM), |_| {}),
];

impl Vehicle {
    fn apply_to_world(&self, world: &mut Scenario) {
        let mount = &mut world.mount;
        for (index, axis) in [&mut mount.pan, &mut mount.tilt].into_iter().enumerate() {
            (axis.start_dead_time_s, axis.stop_dead_time_s) =
                (self.dead_time_s[index], self.dead_time_s[index]);
            axis.lag_s = self.lag_s[index];
            axis.max_rate = AngularRate::from_radians_per_second(self.max_rate_deg_per_s.to_radians());
            axis.imperfections.dead_band_rad_per_s = self.min_rate_deg_per_s.to_radians();
            axis.imperfections.max_acceleration_rad_per_s2 = self.acceleration_rad_per_s2;
        }
        world.camera.video = VideoLinkModel::steady(self.video_latency_s);
    }

    fn apply_to_profile(&self, profile: &mut VehicleProfile) {
        let camera = &mut profile.camera;
        for (index, axis) in [&mut camera.pan, &mut camera.tilt].into_iter().enumerate() {
            axis.start_dead_time = Duration::from_secs_f64(self.dead_time_s[index]);
            axis.stop_dead_time = axis.start_dead_time;
            axis.lag = Duration::from_secs_f64(self.lag_s[index]);
            axis.min_rate = AngularRate::from_radians_per_second(self.min_rate_deg_per_s.to_radians());
        }
        let limit = AngularRate::from_radians_per_second(self.max_rate_deg_per_s.to_radians());
        profile.limits = AxisRates { pan: limit, tilt: limit };
        profile.video_latency = Duration::from_secs_f64(self.video_latency_s);
    }
}

#[cfg(test)]
mod tests {
    #[test]
    fn every_vehicle_but_the_first_changes_something() {
        super::variants::assert_all_but_the_first_change_something(&super::VARIANTS);
    }
}
