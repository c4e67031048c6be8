//! `closed-loop`: each vehicle holds the boat in the simulator, through its session and its far end, in
//! virtual time.
//!
//! ```text
//!   World --truth--> LocalisationSensor --video latency--> Pilot --rates--> Session <--packets--> far end --rates--> World
//! ```
//! Perception is the truth with the scenario's noise, and the seeds are the same for every vehicle. The first
//! table gives each vehicle the limits and the camera of the Fotokite Pro, so that what differs is the
//! protocol: how often rates are sent, and how late. The second table has the vehicles' own limits and least
//! rates.

mod far_end;

use std::collections::VecDeque;

use anyhow::{Result, anyhow};
use barrelman_control::LawSettings;
use barrelman_experiments::law_choice::LawChoice;
use barrelman_experiments::scenario::{self, ScenarioOverrides};
use barrelman_experiments::tracker_choice::{TrackerName, TrackerSettings};
use barrelman_pilot::{CommandPath, Input, Outcome, Pilot, PilotSettings};
use barrelman_sim::{LocalisationSensor, World};
use barrelman_vocab::telemetry::{LinkState, Report};
use barrelman_vocab::{CameraRequest, OperatorRequest, Timestamp, Track, VehicleProfile};
use clap::Args;

use self::far_end::Line;
use crate::output::print_line;
use crate::parallel;
use crate::statistics::mean;

/// Time outside of each vehicle, with the limits of the Fotokite Pro, divided by that of the Fotokite Pro.
const REQUIRED_RATIO: core::ops::RangeInclusive<f64> = 0.8..=1.25;
/// The link of every vehicle is up by then; the time outside counts from here, seconds.
const COUNTS_FROM_S: f64 = 5.0;

/// Options of `closed-loop`.
#[derive(Debug, Clone, Args)]
pub(crate) struct Options {
    /// The scenario.
    #[arg(long, value_name = "NAME", default_value = "arena1")]
    scenario: String,
    /// Trials of each vehicle.
    #[arg(long, value_name = "N", default_value_t = 400)]
    seeds: u64,
    /// The first seed.
    #[arg(long, value_name = "SEED", default_value_t = 60_000)]
    first_seed: u64,
    /// Length of a trial, seconds.
    #[arg(long, value_name = "S", default_value_t = 120.0)]
    seconds: f64,
}

/// Whose limits and least rates hold.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Limits {
    OfFotokitePro,
    Own,
}

/// Prints the tables. Returns whether the time outside is that of the Fotokite Pro where the limits are.
///
/// # Errors
/// If the scenario cannot be used.
pub(crate) fn run(options: &Options) -> Result<bool> {
    let mut holds = true;
    for (law, law_name) in [(LawChoice::MOTOR_SCHEMA, "motor schema"), (LawChoice::OPTIMAL, "optimal")] {
        for limits in [Limits::OfFotokitePro, Limits::Own] {
            let whose = if limits == Limits::Own { "the vehicle's own" } else { "the Fotokite Pro's" };
            print_line(&format!("law {law_name}, {whose} limits and least rates:"));
            let shares = shares_outside(options, law, limits)?;
            for (name, share) in &shares {
                let ratio = share / shares[0].1;
                let percent = 100.0 * share;
                print_line(&format!("  {name:16} outside {percent:6.3} % of the time, ratio {ratio:.3}"));
                holds &= limits == Limits::Own || REQUIRED_RATIO.contains(&ratio);
            }
        }
    }
    print_line(&format!(
        "{} trials of {} s of {} for each vehicle; required ratio {} to {}",
        options.seeds,
        options.seconds,
        options.scenario,
        REQUIRED_RATIO.start(),
        REQUIRED_RATIO.end()
    ));
    Ok(holds)
}

/// For each vehicle, the first being the Fotokite Pro: its name, and the share of the time outside of the
/// region.
fn shares_outside(options: &Options, law: LawChoice, limits: Limits) -> Result<Vec<(&'static str, f64)>> {
    let seeds: Vec<u64> = (options.first_seed..options.first_seed + options.seeds).collect();
    VehicleProfile::NAMES
        .into_iter()
        .map(|name| {
            let shares: Vec<f64> = parallel::map(&seeds, |seed| trial(name, law, limits, options, *seed))
                .into_iter()
                .collect::<Result<_>>()?;
            Ok((name, mean(&shares)))
        })
        .collect()
}

/// The profile of a vehicle in the scenario's camera.
fn profile_of(name: &str, limits: Limits, scenario: &VehicleProfile) -> Result<VehicleProfile> {
    let vehicle = VehicleProfile::named(name).ok_or_else(|| anyhow!("no vehicle {name}"))?;
    let mut profile = VehicleProfile {
        name: vehicle.name,
        protocol: vehicle.protocol,
        signs: vehicle.signs,
        ..scenario.clone()
    };
    if limits == Limits::Own {
        profile.limits = vehicle.limits;
        profile.camera.pan.min_rate = vehicle.camera.pan.min_rate;
        profile.camera.tilt.min_rate = vehicle.camera.tilt.min_rate;
    }
    Ok(profile)
}

/// Simulates a trial. Returns the share of the time outside.
fn trial(name: &str, law: LawChoice, limits: Limits, options: &Options, seed: u64) -> Result<f64> {
    let loaded = scenario::load(&options.scenario, &ScenarioOverrides::default())?;
    let profile = profile_of(name, limits, &loaded.profile()?)?;
    let mut scenario = loaded.scenario;
    scenario.max_s = options.seconds;
    let mut world = World::new(&scenario, seed).map_err(|_| anyhow!("the way-points make no path"))?;
    let mut sensor = LocalisationSensor::new(scenario.sensing, scenario.camera.clone(), seed);
    let law: LawSettings = law.settings();
    let tracker = TrackerSettings::new(TrackerName::Fused).build()?;
    let pilot = Pilot::new(PilotSettings { profile: profile.clone(), law }, tracker);
    let mut pilot = pilot.commanding(CommandPath::Link);
    let mut line = Line::new(&profile, limits == Limits::OfFotokitePro, world.now())?;
    let mut in_flight: VecDeque<(Timestamp, Track)> = VecDeque::new();
    let mut track = Track::Unseeded;
    let mut outcome: Option<Outcome> = None;
    let (mut frames, mut outside) = (0_u32, 0_u32);
    let mut is_engaged = false;
    while !world.is_over() {
        let now = world.now();
        if world.is_frame_due() {
            track = match sensor.measure(&world.truth()) {
                Some(localisation) => Track::Tracking(localisation),
                None => match track {
                    Track::Tracking(last) => Track::Lost { since: last.captured, confidence: 0.0 },
                    other => other,
                },
            };
            in_flight.push_back((now.plus(scenario.camera.latency()), track));
        }
        let mut reports = Vec::new();
        let pose = world.camera_pose();
        let rates = line.advance(pose, now, &mut reports);
        let mut inputs: Vec<Input<'_>> = reports.into_iter().map(Input::Telemetry).collect();
        if !is_engaged && line.link_state() == LinkState::Up {
            is_engaged = true;
            let report = Report::Link(LinkState::Up);
            inputs.push(Input::Telemetry(barrelman_vocab::Telemetry { at: now, report }));
            inputs.push(Input::Request(OperatorRequest::Camera(CameraRequest::Engage)));
        }
        while let Some((_, seen)) = in_flight.pop_front_if(|(arrives, _)| *arrives <= now) {
            inputs.push(Input::Localisation(seen));
            if now.as_secs_f64() >= COUNTS_FROM_S {
                frames += 1;
                let is_inside = outcome
                    .as_ref()
                    .and_then(|outcome| outcome.percept)
                    .is_some_and(|percept| percept.p <= 1.0);
                outside += u32::from(!is_inside);
            }
        }
        if inputs.is_empty()
            && outcome.as_ref().and_then(|outcome| outcome.wake_at).is_some_and(|at| at <= now)
        {
            inputs.push(Input::Tick);
        }
        for input in inputs {
            let stepped = pilot.step(input, now);
            line.request(profile.to_vehicle(stepped.command), stepped.wake_at);
            outcome = Some(stepped);
        }
        world.command(profile.from_vehicle(rates));
        world.advance();
    }
    Ok(f64::from(outside) / f64::from(frames.max(1)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_vehicle_holds_the_boat_as_the_fotokite_pro_does() {
        let options = Options { scenario: "arena1".to_owned(), seeds: 8, first_seed: 60_000, seconds: 90.0 };
        let shares = shares_outside(&options, LawChoice::MOTOR_SCHEMA, Limits::OfFotokitePro).unwrap();
        assert_eq!(shares.len(), VehicleProfile::NAMES.len());
        for (name, share) in &shares {
            let ratio = share / shares[0].1;
            assert!(REQUIRED_RATIO.contains(&ratio), "{name}: {share:.4}, ratio {ratio:.3}");
        }
    }
}
