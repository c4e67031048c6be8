//! Searches for a boat that left the picture in a blind time: how many find the boat again, and how soon.
//!
//! Perception is the truth with the scenario's noise. The camera follows the boat; then nothing is seen for
//! some seconds, in which the camera rests and the boat goes on. In trials in which the boat is out of the
//! picture after that, the operator asks for a search as soon as one is possible. Beside it, the same trials
//! without a search: the boat may come back.

use std::collections::VecDeque;
use std::time::Duration;

use anyhow::Result;
use barrelman_control::LawSettings;
use barrelman_experiments::law_choice::LawChoice;
use barrelman_experiments::scenario::{self, ScenarioOverrides};
use barrelman_experiments::tracker_choice::{TrackerName, TrackerSettings};
use barrelman_pilot::{Input, Pilot, PilotSettings};
use barrelman_sim::boat::HelmCommand;
use barrelman_sim::scenario::BeyondBorder;
use barrelman_sim::{LocalisationSensor, World};
use barrelman_vocab::{CameraRequest, OperatorRequest, Timestamp, Track};
use clap::Args;

use crate::output::print_line;
use crate::parallel;
use crate::statistics::quantile;

/// The camera follows before the blind time for 10 to 24 seconds, by the seed: the boat is elsewhere, on
/// another course.
fn follows_s(seed: u64) -> f64 {
    10.0 + 2.0 * (seed % 8) as f64
}

/// A trial ends this long after the blind time, seconds.
const WATCHED_S: f64 = 70.0;
/// Least share of the trials that a search must find again.
const REQUIRED_SHARE: f64 = 0.8;

/// Options of `search`.
#[derive(Debug, Clone, Args)]
pub(crate) struct Options {
    /// Scenarios.
    #[arg(long, value_name = "NAME", default_values = ["arena1", "arena2", "distractors", "glint", "gusts"])]
    scenario: Vec<String>,
    /// Trials of each scenario.
    #[arg(long, value_name = "N", default_value_t = 200)]
    seeds: u64,
    /// The first seed.
    #[arg(long, value_name = "SEED", default_value_t = 50_000)]
    first_seed: u64,
    /// The blind time, seconds.
    #[arg(long, value_name = "S", default_value_t = 20.0)]
    blind: f64,
}

/// What came of a trial.
#[derive(Debug, Clone, Copy, PartialEq)]
enum End {
    /// The boat was in the picture after the blind time.
    NeverLeft,
    /// Seen again so many seconds after the blind time.
    Found(f64),
    NotFound,
}

/// Prints the table. Returns whether enough searches find the boat.
///
/// # Errors
/// If a scenario cannot be loaded.
pub(crate) fn run(options: &Options) -> Result<bool> {
    print_line(&format!(
        "{} trials a scenario, seeds from {}; blind for {} s",
        options.seeds, options.first_seed, options.blind
    ));
    print_line(
        "scenario      left the picture   found by search   median s   90 % s   back without a search",
    );
    let seeds: Vec<u64> = (options.first_seed..options.first_seed + options.seeds).collect();
    let (mut left, mut found) = (0, 0);
    for name in &options.scenario {
        let ends = |searches: bool| -> Result<Vec<End>> {
            parallel::map(&seeds, |seed| trial(name, *seed, options.blind, searches)).into_iter().collect()
        };
        let (with, without) = (ends(true)?, ends(false)?);
        let times = |ends: &[End]| -> Vec<f64> {
            ends.iter().filter_map(|end| if let End::Found(s) = end { Some(*s) } else { None }).collect()
        };
        let gone = with.iter().filter(|end| **end != End::NeverLeft).count();
        let (searched, waited) = (times(&with), times(&without));
        left += gone;
        found += searched.len();
        let at = |share: f64| {
            if searched.is_empty() { "-".to_owned() } else { format!("{:.1}", quantile(&searched, share)) }
        };
        print_line(&format!(
            "{name:12} {gone:>17} {:>17} {:>10} {:>8} {:>23}",
            searched.len(),
            at(0.5),
            at(0.9),
            waited.len()
        ));
    }
    let share = found as f64 / (left.max(1)) as f64;
    print_line(&format!(
        "found by search: {found} of {left} ({:.0} %; required {:.0} %)",
        100.0 * share,
        100.0 * REQUIRED_SHARE
    ));
    Ok(left > 0 && share >= REQUIRED_SHARE)
}

fn trial(name: &str, seed: u64, blind_s: f64, searches: bool) -> Result<End> {
    let follows_s = follows_s(seed);
    let loaded = scenario::load(name, &ScenarioOverrides::default())?;
    let profile = loaded.profile()?;
    let mut scenario = loaded.scenario;
    scenario.sensing.beyond_border = BeyondBorder::Absent;
    scenario.max_s = follows_s + blind_s + WATCHED_S;
    let mut world =
        World::new(&scenario, seed).map_err(|_| anyhow::anyhow!("the way-points make no path"))?;
    let mut sensor = LocalisationSensor::new(scenario.sensing, scenario.camera.clone(), seed);
    let law: LawSettings = LawChoice::OPTIMAL.settings();
    let tracker = TrackerSettings::new(TrackerName::Fused).build()?;
    let mut pilot = Pilot::new(PilotSettings { profile: profile.clone(), law }, tracker);
    let mut outcome = pilot.step(Input::Request(OperatorRequest::Camera(CameraRequest::Engage)), world.now());
    let mut in_flight: VecDeque<(Timestamp, Timestamp, Option<Track>)> = VecDeque::new();
    let mut lost_since = None;
    let (mut has_left, mut was_seen) = (None, false);
    while !world.is_over() {
        let now = world.now();
        let seconds = now.as_secs_f64();
        let is_blind = (follows_s..follows_s + blind_s).contains(&seconds);
        let mut inputs: Vec<Input<'_>> = Vec::new();
        // The boat goes straight on, away from where it was seen last, and does not come back by itself.
        world.override_helm((seconds >= follows_s).then_some(HelmCommand { throttle: 0.5, rudder: 0.0 }));
        if world.is_frame_due() {
            let truth = world.truth();
            let seen = sensor.measure(&truth).filter(|_| !is_blind).map(Track::Tracking);
            in_flight.push_back((now.plus(scenario.camera.latency()), now, seen));
            if seconds >= follows_s + blind_s && has_left.is_none() {
                has_left = Some(!truth.in_picture);
            }
        }
        while let Some((_, captured, track)) = in_flight.pop_front_if(|(arrives, ..)| *arrives <= now) {
            was_seen |= track.is_some();
            lost_since = if track.is_some() { None } else { lost_since.or(Some(captured)) };
            let lost = || {
                if was_seen {
                    Track::Lost { since: captured_or(lost_since, captured), confidence: 0.0 }
                } else {
                    Track::Unseeded
                }
            };
            if track.is_some() && has_left == Some(true) && captured.as_secs_f64() >= follows_s + blind_s {
                return Ok(End::Found(seconds - follows_s - blind_s));
            }
            inputs.push(Input::Localisation(track.unwrap_or_else(lost)));
        }
        if has_left == Some(false) {
            return Ok(End::NeverLeft);
        }
        let may_search = searches
            && has_left == Some(true)
            && seconds < follows_s + blind_s + Duration::from_secs(2).as_secs_f64();
        if may_search && outcome.search_refusal.is_none() && outcome.mode != barrelman_pilot::Mode::Searching
        {
            inputs.push(Input::Request(OperatorRequest::Camera(CameraRequest::Search)));
        }
        if inputs.is_empty() && outcome.wake_at.is_some_and(|at| at <= now) {
            inputs.push(Input::Tick);
        }
        for input in inputs {
            outcome = pilot.step(input, now);
            world.command(profile.from_vehicle(profile.to_vehicle(outcome.command)));
        }
        world.advance();
    }
    Ok(if has_left == Some(true) { End::NotFound } else { End::NeverLeft })
}

fn captured_or(since: Option<Timestamp>, captured: Timestamp) -> Timestamp {
    since.unwrap_or(captured)
}
