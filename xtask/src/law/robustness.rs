//! The laboratory with a vehicle that is not what its profile says: the schema beside the optimal law in each case.

use anyhow::Result;
use barrelman_control::optimal::Tuning;
use barrelman_sim::Scenario;
use barrelman_sim::camera_axis::AxisPlant;
use barrelman_trial::campaign::compare::Comparison;
use barrelman_trial::campaign::statistics::Bootstrap;
use barrelman_vocab::{Angle, VehicleProfile};

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

fn focal(profile: &mut VehicleProfile, share: f64) {
    profile.camera.focal_share *= share;
}

fn tilted(profile: &mut VehicleProfile) {
    profile.camera.first_tilt = Angle::from_degrees(-45.0);
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
    (video.to_bad, video.to_good) = (6.0 / 60.0 / pictures, 1.0 / (mean_s * pictures));
    (video.spoilt, video.frozen) = (1.0, 0.0);
}

fn everything(world: &mut Scenario) {
    delayed(world, 0.1);
    slower(world);
    dropping(world, 1.0);
}

/// Prints the table; whether the law has less time outside and less energy in every row.
pub(super) fn print(first_seed: u64, seeds: u64, tuning: &Tuning) -> Result<bool> {
    let mut holds = true;
    for scenario in ["lab1", "lab2"] {
        say(&format!(
            "\n{scenario}, a vehicle that is not as its profile says: {seeds} trials, seeds from {first_seed} on; the \
             optimal law's ratios to the schema's means, 95 %"
        ));
        for case in &CASES {
            let plan = Condition { scenario, setting: "indoor" }
                .nominal_plan()?
                .in_changed_world(case.world)
                .with_profile(case.belief)
                .reporting_tilt(case.reports);
            let base = trials(&plan, &Subject::Schema, first_seed, seeds)?;
            let other = trials(&plan, &Subject::Optimal(*tuning), first_seed, seeds)?;
            let comparison = Comparison::of(&base, &other, &Bootstrap::USUAL);
            let of = |figure| comparison.figures.iter().find(|paired| paired.figure == figure);
            let (outside, energy, moves) = (of("time outside"), of("integral of rate squared"), of("moves"));
            let better = [outside, energy].iter().all(|paired| paired.is_some_and(|p| p.second < p.first));
            holds &= better;
            let cell = |paired: Option<&barrelman_trial::campaign::compare::Paired>| {
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
        for case in &CASES[1..] {
            let plan = Condition { scenario: "lab1", setting: "indoor" }.nominal_plan();
            let plan = plan.unwrap_or_else(|error| panic!("{error:#}"));
            let (mut world, mut belief) = (plan.scenario().clone(), plan.profile().clone());
            (case.world)(&mut world);
            (case.belief)(&mut belief);
            assert!(world != *plan.scenario() || belief != *plan.profile(), "{}", case.name);
        }
    }
}
