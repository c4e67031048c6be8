//! The laboratory with other vehicles, and with one that is not what its profile says: the schema beside the optimal law
//! in each case.

use core::time::Duration;

use anyhow::Result;
use barrelman_control::optimal::Tuning;
use barrelman_sim::Scenario;
use barrelman_sim::camera_axis::AxisPlant;
use barrelman_sim::video_link::VideoLinkModel;
use barrelman_trial::campaign::compare::CampaignComparison;
use barrelman_trial::campaign::statistics::Bootstrap;
use barrelman_vocab::profile::AxisRates;
use barrelman_vocab::{Angle, AngularRate, VehicleProfile};

use super::conditions::{Condition, Subject, trials};
use super::table::ratio;
use crate::say;

/// What is changed of the world, of which the law knows nothing, and of what it believes.
struct Case {
    name: &'static str,
    world: fn(&mut Scenario),
    belief: fn(&mut VehicleProfile),
    /// Whether the gimbal reports the camera's tilt.
    reports: bool,
}

impl Case {
    const fn new(name: &'static str, world: fn(&mut Scenario), belief: fn(&mut VehicleProfile)) -> Self {
        Self { name, world, belief, reports: false }
    }
}

const CASES: [Case; 12] = [
    Case::new("as the profile says", |_| {}, |_| {}),
    Case::new("focal length believed 30 % short", |_| {}, |p| focal(p, 0.7)),
    Case::new("focal length believed 30 % long", |_| {}, |p| focal(p, 1.3)),
    Case::new("dead times 100 ms longer", |w| delayed(w, 0.1), |_| {}),
    Case::new("dead times 100 ms shorter", |w| delayed(w, -0.1), |_| {}),
    Case::new("axes twice as slow", slower, |_| {}),
    Case::new("drop-outs of 1 s, 6 a minute", |w| dropping(w, 1.0), |_| {}),
    Case::new("drop-outs of 2 s, 6 a minute", |w| dropping(w, 2.0), |_| {}),
    Case::new("tilt believed 45 degrees down", |_| {}, tilted),
    Case { reports: true, ..Case::new("the same, and the gimbal reports it", |_| {}, tilted) },
    Case::new("all at once, focal length short", everything, |p| both(p, 0.7)),
    Case::new("all at once, focal length long", everything, |p| both(p, 1.3)),
];

/// A vehicle whose camera answers otherwise than the laboratory's: seconds, and degrees per second.
struct Vehicle {
    /// Dead times of pan and of tilt, of starts and of stops alike, without the video's.
    dead_time_s: [f64; 2],
    lag_s: [f64; 2],
    limit_deg_per_s: f64,
    least_deg_per_s: f64,
    acceleration_rad_per_s2: Option<f64>,
    video_s: f64,
}

/// Its rates are those of its maker's document; the times are assumed: a request over the network, video over RTSP.
const SIGMA: Vehicle = Vehicle {
    dead_time_s: [0.1, 0.1],
    lag_s: [0.15, 0.15],
    limit_deg_per_s: 25.0,
    least_deg_per_s: 2.0,
    acceleration_rad_per_s2: None,
    video_s: 0.25,
};
/// From the message to the first change of attitude it takes 28 to 47 ms; lag, limit and video are assumed.
const MAVLINK_GIMBAL: Vehicle = Vehicle {
    dead_time_s: [0.04, 0.04],
    lag_s: [0.06, 0.06],
    limit_deg_per_s: 60.0,
    least_deg_per_s: 0.0,
    acceleration_rad_per_s2: None,
    video_s: 0.2,
};
/// The kite of the simulated water: pan is its yaw.
const KITE_ON_WATER: Vehicle = Vehicle {
    dead_time_s: [0.2, 0.15],
    lag_s: [0.35, 0.15],
    limit_deg_per_s: 17.2,
    least_deg_per_s: 0.57,
    acceleration_rad_per_s2: Some(0.8),
    video_s: 0.2,
};

/// The first is that of all other tables.
const VEHICLES: [Case; 4] = [
    Case::new("Fotokite Pro", |_| {}, |_| {}),
    Case::new("Fotokite Sigma, assumed times", |w| SIGMA.build(w), |p| SIGMA.describe(p)),
    Case::new("MAVLink gimbal, assumed lag", |w| MAVLINK_GIMBAL.build(w), |p| MAVLINK_GIMBAL.describe(p)),
    Case::new("kite of the simulated water", |w| KITE_ON_WATER.build(w), |p| KITE_ON_WATER.describe(p)),
];

impl Vehicle {
    fn build(&self, world: &mut Scenario) {
        let mount = &mut world.mount;
        for (index, axis) in [&mut mount.pan, &mut mount.tilt].into_iter().enumerate() {
            (axis.start_dead_time_s, axis.stop_dead_time_s) =
                (self.dead_time_s[index], self.dead_time_s[index]);
            axis.lag_s = self.lag_s[index];
            axis.max_rate = AngularRate::from_radians_per_second(self.limit_deg_per_s.to_radians());
            axis.imperfections.dead_band_rad_per_s = self.least_deg_per_s.to_radians();
            axis.imperfections.max_acceleration_rad_per_s2 = self.acceleration_rad_per_s2;
        }
        world.camera.video = VideoLinkModel::steady(self.video_s);
    }

    fn describe(&self, profile: &mut VehicleProfile) {
        let camera = &mut profile.camera;
        for (index, axis) in [&mut camera.pan, &mut camera.tilt].into_iter().enumerate() {
            axis.start_dead_time = Duration::from_secs_f64(self.dead_time_s[index]);
            axis.stop_dead_time = axis.start_dead_time;
            axis.lag = Duration::from_secs_f64(self.lag_s[index]);
            axis.min_rate = AngularRate::from_radians_per_second(self.least_deg_per_s.to_radians());
        }
        let limit = AngularRate::from_radians_per_second(self.limit_deg_per_s.to_radians());
        profile.limits = AxisRates { pan: limit, tilt: limit };
        profile.video_latency = Duration::from_secs_f64(self.video_s);
    }
}

fn focal(profile: &mut VehicleProfile, share: f64) {
    profile.camera.focal_share *= share;
}

fn tilted(profile: &mut VehicleProfile) {
    profile.camera.initial_tilt = Angle::from_degrees(-45.0);
}

fn both(profile: &mut VehicleProfile, share: f64) {
    focal(profile, share);
    tilted(profile);
}

fn axes(world: &mut Scenario, change: impl Fn(&mut AxisPlant)) {
    change(&mut world.mount.pan);
    change(&mut world.mount.tilt);
}

fn delayed(world: &mut Scenario, by_s: f64) {
    axes(world, |axis| {
        axis.start_dead_time_s = (axis.start_dead_time_s + by_s).max(0.0);
        axis.stop_dead_time_s = (axis.stop_dead_time_s + by_s).max(0.0);
    });
}

fn slower(world: &mut Scenario) {
    axes(world, |axis| axis.lag_s *= 2.0);
}

/// Lengths and distances of drop-outs are drawn; these are the means.
fn dropping(world: &mut Scenario, mean_s: f64) {
    let pictures = f64::from(world.camera.pictures_per_second);
    let video = &mut world.camera.video;
    (video.good_to_bad, video.bad_to_good) = (6.0 / 60.0 / pictures, 1.0 / (mean_s * pictures));
    (video.impaired_share, video.frozen_share) = (1.0, 0.0);
}

fn everything(world: &mut Scenario) {
    delayed(world, 0.1);
    slower(world);
    dropping(world, 1.0);
}

/// Prints the table of a vehicle that is not as its profile says; whether the law has less time outside and less energy
/// in every row.
pub(super) fn print(first_seed: u64, seeds: u64, tuning: &Tuning) -> Result<bool> {
    table("a vehicle that is not as its profile says", &CASES, first_seed, seeds, tuning)
}

/// Prints that of other vehicles, each as its profile says; as above.
pub(super) fn print_vehicles(first_seed: u64, seeds: u64, tuning: &Tuning) -> Result<bool> {
    table("other vehicles", &VEHICLES, first_seed, seeds, tuning)
}

fn table(title: &str, cases: &[Case], first_seed: u64, seeds: u64, tuning: &Tuning) -> Result<bool> {
    let mut holds = true;
    for scenario in ["lab1", "lab2"] {
        say(&format!(
            "\n{scenario}, {title}: {seeds} trials, seeds from {first_seed} on; the optimal law's ratios to the \
             schema's means, 95 %"
        ));
        for case in cases {
            let plan = Condition { scenario, setting: "indoor" }
                .nominal_plan()?
                .with_changed_scenario(case.world)
                .with_changed_profile(case.belief)
                .with_tilt_reports(case.reports);
            let base = trials(&plan, &Subject::Schema, first_seed, seeds)?;
            let other = trials(&plan, &Subject::Optimal(*tuning), first_seed, seeds)?;
            let comparison = CampaignComparison::new(&base, &other, &Bootstrap::DEFAULT);
            let of = |figure| comparison.metrics.iter().find(|paired| paired.metric == figure);
            let (outside, energy, moves) = (of("time outside"), of("integral of rate squared"), of("moves"));
            let better = [outside, energy].iter().all(|paired| paired.is_some_and(|p| p.second < p.first));
            holds &= better;
            let cell = |paired: Option<&barrelman_trial::campaign::compare::PairedMetric>| {
                paired.map_or_else(String::new, |p| format!("{:7.3} {}", p.first, ratio(p.ratio)))
            };
            say(&format!(
                "  {:34} outside {}  rate2 {}  moves {}  {}",
                case.name,
                cell(outside),
                cell(energy),
                cell(moves),
                if better { "" } else { "WORSE" }
            ));
        }
    }
    Ok(holds)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_case_but_the_first_changes_something() {
        for case in CASES[1..].iter().chain(&VEHICLES[1..]) {
            let plan = Condition { scenario: "lab1", setting: "indoor" }.nominal_plan();
            let plan = plan.unwrap_or_else(|error| panic!("{error:#}"));
            let (mut world, mut belief) = (plan.scenario().clone(), plan.profile().clone());
            (case.world)(&mut world);
            (case.belief)(&mut belief);
            assert!(world != *plan.scenario() || belief != *plan.profile(), "{}", case.name);
        }
    }
}
