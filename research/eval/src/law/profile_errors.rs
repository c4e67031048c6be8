//! The table `robustness`: the laboratory with a vehicle that differs from its profile, and with other frame
//! rates and latencies of the video. The laboratory has 30 frames each second, 0.1 s late.

use core::time::Duration;

use anyhow::Result;
use barrelman_sim::Scenario;
use barrelman_sim::camera_axis::AxisPlant;
use barrelman_vocab::{Angle, VehicleProfile};

use super::options::Options;
use super::variants::{self, Variant};

const VARIANTS: [Variant; 25] = [
    Variant::new("as the profile says", |_| {}, |_| {}),
    Variant::new("focal length believed 30 % short", |_| {}, |p| scale_focal_length(p, 0.7)),
    Variant::new("focal length believed 30 % long", |_| {}, |p| scale_focal_length(p, 1.3)),
    Variant::new("dead times 100 ms longer", |w| lengthen_dead_times(w, 0.1), |_| {}),
    Variant::new("dead times 100 ms shorter", |w| lengthen_dead_times(w, -0.1), |_| {}),
    Variant::new("axes twice as slow", double_lags, |_| {}),
    Variant::new("drop-outs of 1 s, 6 a minute", |w| add_drop_outs(w, 1.0), |_| {}),
    Variant::new("drop-outs of 2 s, 6 a minute", |w| add_drop_outs(w, 2.0), |_| {}),
    Variant::new("tilt believed 45 degrees down", |_| {}, assume_steep_tilt),
    Variant {
        reports_tilt: true,
        ..Variant::new("the same, and the gimbal reports it", |_| {}, assume_steep_tilt)
    },
    Variant::new("all at once, focal length short", apply_all, |p| change_focal_length_and_tilt(p, 0.7)),
    Variant::new("all at once, focal length long", apply_all, |p| change_focal_length_and_tilt(p, 1.3)),
    Variant::new("5 frames/s", |w| w.camera.pictures_per_second = 5, |_| {}),
    Variant::new("10 frames/s", |w| w.camera.pictures_per_second = 10, |_| {}),
    Variant::new("15 frames/s", |w| w.camera.pictures_per_second = 15, |_| {}),
    Variant::new("60 frames/s", |w| w.camera.pictures_per_second = 60, |_| {}),
    Variant::new("video 0.0 s late", |w| w.camera.video.latency_s = 0.0, |p| set_latency(p, 0)),
    Variant::new("video 0.2 s late", |w| w.camera.video.latency_s = 0.2, |p| set_latency(p, 200)),
    Variant::new("video 0.4 s late", |w| w.camera.video.latency_s = 0.4, |p| set_latency(p, 400)),
    Variant::new("video 0.6 s late", |w| w.camera.video.latency_s = 0.6, |p| set_latency(p, 600)),
    Variant::new("video 0.8 s late", |w| w.camera.video.latency_s = 0.8, |p| set_latency(p, 800)),
    Variant {
        assumed_latency_s: ASSUMED_LATENCY_S,
        ..Variant::new(
            "video 0.0 s late, believed 0.2 s",
            |w| w.camera.video.latency_s = 0.0,
            |p| set_latency(p, 0),
        )
    },
    Variant {
        assumed_latency_s: ASSUMED_LATENCY_S,
        ..Variant::new(
            "video 0.4 s late, believed 0.2 s",
            |w| w.camera.video.latency_s = 0.4,
            |p| set_latency(p, 400),
        )
    },
    Variant {
        assumed_latency_s: ASSUMED_LATENCY_S,
        ..Variant::new(
            "video 0.6 s late, believed 0.2 s",
            |w| w.camera.video.latency_s = 0.6,
            |p| set_latency(p, 600),
        )
    },
    Variant {
        assumed_latency_s: ASSUMED_LATENCY_S,
        ..Variant::new(
            "video 0.8 s late, believed 0.2 s",
            |w| w.camera.video.latency_s = 0.8,
            |p| set_latency(p, 800),
        )
    },
];

/// The latency that is believed wrongly: the law takes the times of capture to be so much before the
/// arrivals. The pilot judges the age of a picture by its true latency: by times that are wrong in this way
/// no picture would ever be too old.
const ASSUMED_LATENCY_S: Option<f64> = Some(0.2);

/// Prints the table. Returns whether every column is within its limit in every row.
///
/// # Errors
/// If a scenario cannot be used.
pub(super) fn print(options: &Options) -> Result<bool> {
    let title = "a vehicle that is not as its profile says";
    variants::print_table(title, &VARIANTS, options)
}

fn scale_focal_length(profile: &mut VehicleProfile, share: f64) {
    profile.camera.focal_share *= share;
}

fn set_latency(profile: &mut VehicleProfile, latency_ms: u64) {
    profile.video_latency = Duration::from_millis(latency_ms);
}

fn assume_steep_tilt(profile: &mut VehicleProfile) {
    profile.camera.initial_tilt = Angle::from_degrees(-45.0);
}

fn change_focal_length_and_tilt(profile: &mut VehicleProfile, share: f64) {
    scale_focal_length(profile, share);
    assume_steep_tilt(profile);
}

fn change_axes(world: &mut Scenario, change: impl Fn(&mut AxisPlant)) {
    change(&mut world.mount.pan);
    change(&mut world.mount.tilt);
}

fn lengthen_dead_times(world: &mut Scenario, by_s: f64) {
    change_axes(world, |axis| {
        axis.start_dead_time_s = (axis.start_dead_time_s + by_s).max(0.0);
        axis.stop_dead_time_s = (axis.stop_dead_time_s + by_s).max(0.0);
    });
}

fn double_lags(world: &mut Scenario) {
    change_axes(world, |axis| axis.lag_s *= 2.0);
}

/// Six drop-outs a minute of this mean duration; durations and intervals are random.
fn add_drop_outs(world: &mut Scenario, mean_s: f64) {
    let pictures = f64::from(world.camera.pictures_per_second);
    let video = &mut world.camera.video;
    (video.good_to_bad, video.bad_to_good) = (6.0 / 60.0 / pictures, 1.0 / (mean_s * pictures));
    (video.impaired_share, video.frozen_share) = (1.0, 0.0);
}

fn apply_all(world: &mut Scenario) {
    lengthen_dead_times(world, 0.1);
    double_lags(world);
    add_drop_outs(world, 1.0);
}

#[cfg(test)]
mod tests {
    #[test]
    fn every_variant_but_the_first_changes_something() {
        super::variants::assert_all_but_the_first_change_something(&super::VARIANTS);
    }
}
