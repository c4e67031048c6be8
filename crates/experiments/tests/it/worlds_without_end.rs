//! Worlds without an end: an hour in which nobody does anything takes nothing away.

use barrelman_experiments::law_choice::LawChoice;
use barrelman_experiments::scenario::{BUILT_IN, LoadedScenario, ScenarioOverrides, load};
use barrelman_pilot::vessel::GuidanceLaw;
use barrelman_pilot::{CommandPath, Mode, Pilot, PilotSettings, VesselSettings};
use barrelman_sim::World;
use barrelman_sim::scenario::TargetScript;
use barrelman_sim::tick::TICKS_PER_SECOND;
use barrelman_trial::campaign::Simulation;
use barrelman_vision::{CamShift, CamShiftConfig};
use barrelman_vocab::{
    CameraRequest, DrawnMark, MarkKind, PixelPoint, Timestamp, Track, VesselProfile, VesselRequest,
};

const TICKS_PER_MINUTE: u64 = 60 * TICKS_PER_SECOND as u64;

fn loaded(name: &str) -> LoadedScenario {
    load(name, &ScenarioOverrides::default()).unwrap()
}

/// Distance of a boat from the nearest of points, metres.
fn distance_to(world: &World, points: &[(f64, f64)]) -> f64 {
    let at = world.target_pose().position;
    points.iter().map(|(x, y)| f64::hypot(at.x - x, at.y - y)).fold(f64::INFINITY, f64::min)
}

#[test]
fn a_trial_still_ends_with_its_path() {
    for (name, within_s) in [("rescue", 20.0), ("two-boats", 20.0), ("exit", 60.0), ("open", 180.0)] {
        let mut world = World::new(&loaded(name).scenario, 1).unwrap();
        while !world.is_over() {
            world.advance();
        }
        assert!(world.now().as_secs_f64() < within_s, "{name}: {}", world.now());
    }
}

#[test]
fn until_a_trial_would_end_a_world_without_an_end_is_the_same() {
    for name in ["rescue", "open", "exit", "lab1"] {
        let scenario = loaded(name).scenario;
        let mut trial = World::new(&scenario, 3).unwrap();
        let mut endless = trial.clone().without_end();
        while !trial.is_over() {
            assert_eq!(trial.truth(), endless.truth(), "{name}");
            trial.advance();
            endless.advance();
        }
        assert!(!endless.is_over(), "{name}");
    }
}

#[test]
fn a_helmsman_at_the_end_of_the_path_waits_there() {
    for name in ["rescue", "rescue-current", "rescue-surf", "rescue-four", "two-boats"] {
        let scenario = loaded(name).scenario;
        let TargetScript::Boat(script) = &scenario.target else { panic!("{name} has a boat") };
        let end = *script.way_points.last().unwrap();
        let mut world = World::new(&scenario, 2).unwrap().without_end();
        let mut farthest_m = 0.0_f64;
        for tick in 0..60 * TICKS_PER_MINUTE {
            world.advance();
            if tick > TICKS_PER_MINUTE {
                farthest_m = farthest_m.max(distance_to(&world, &[end]));
            }
        }
        assert!(!world.is_over(), "{name}");
        // It drifts 2 m from a point that is up to a metre beside the path's, and needs some metres to turn.
        assert!(farthest_m < 8.0, "{name}: {farthest_m} m");
    }
}

#[test]
fn a_helmsman_goes_round_a_path_that_is_nearly_closed() {
    for name in ["open", "exit", "pier", "gusts"] {
        let scenario = loaded(name).scenario;
        let TargetScript::Boat(script) = &scenario.target else { panic!("{name} has a boat") };
        let mut world = World::new(&scenario, 2).unwrap().without_end();
        // The farthest way-point from the start is passed in each third of the time.
        let far = script.way_points.iter().copied().max_by(|a, b| a.1.total_cmp(&b.1)).unwrap();
        for _ in 0..3 {
            let mut nearest_m = f64::INFINITY;
            for _ in 0..5 * TICKS_PER_MINUTE {
                world.advance();
                nearest_m = nearest_m.min(distance_to(&world, &[far]));
                assert!(distance_to(&world, &script.way_points) < 25.0, "{name}: it left its path");
            }
            assert!(nearest_m < 5.0, "{name}: {nearest_m} m");
        }
    }
}

#[test]
fn every_scenario_lasts() {
    for built_in in BUILT_IN {
        let mut world = World::new(&loaded(built_in.name).scenario, 1).unwrap().without_end();
        for _ in 0..12 * TICKS_PER_MINUTE {
            world.advance();
        }
        assert!(!world.is_over(), "{}", built_in.name);
    }
}

/// Marks three points as soon as the boat is tracked, and then does nothing for an hour of simulated time.
#[test]
fn an_hour_of_rescue_with_nobody_touching_it_loses_no_mark_and_no_engagement() {
    let loaded = loaded("rescue");
    let (scenario, profile) = (&loaded.scenario, loaded.profile().unwrap());
    let settings = PilotSettings { profile: profile.clone(), law: LawChoice::OPTIMAL.settings() };
    let tracker = Box::new(CamShift::new(CamShiftConfig::default()).unwrap());
    let vessel = VesselSettings {
        profile: VesselProfile::SIMULATOR,
        guidance: GuidanceLaw::LineOfSight,
        path: CommandPath::Simulated,
    };
    let pilot = Pilot::new(settings, tracker).keeping_frames().with_vessel(vessel);
    let world = World::new(scenario, 1).unwrap().without_end();
    let mut simulation = Simulation::new(scenario, world, 1, pilot, &profile)
        .with_log(false)
        .with_tilt_reports(true)
        .with_height_reports();
    simulation.request(CameraRequest::Engage.into(), &mut ());
    let mut marked: Option<Vec<u32>> = None;
    for tick in 0..60 * TICKS_PER_MINUTE {
        simulation.tick(&mut None, &mut ());
        let outcome = simulation.outcome().unwrap();
        let Track::Tracking(seen) = outcome.track else { continue };
        match &marked {
            None => {
                for (index, kind) in
                    [MarkKind::Person, MarkKind::Person, MarkKind::Place].into_iter().enumerate()
                {
                    let at = PixelPoint { u: 300.0 + 250.0 * index as f64, v: 400.0 };
                    let mark = DrawnMark { mark: kind, at, captured_ns: seen.captured };
                    simulation.request(VesselRequest::Mark(mark).into(), &mut ());
                }
                marked = Some(mark_ids(&simulation));
            }
            Some(ids) => {
                if tick % TICKS_PER_MINUTE == 0 {
                    assert_eq!(mark_ids(&simulation), *ids, "at {}", simulation.world().now());
                }
            }
        }
    }
    assert_eq!(marked.as_ref().map(Vec::len), Some(3), "three marks were set");
    assert_eq!(Some(mark_ids(&simulation)), marked);
    assert!(!simulation.is_over());
    assert!(simulation.world().now() > Timestamp::from_secs_f64(3599.0));
    let mode = simulation.outcome().unwrap().mode;
    assert!(matches!(mode, Mode::Servoing | Mode::Holding(_)), "{mode}");
}

fn mark_ids(simulation: &Simulation<'_>) -> Vec<u32> {
    simulation.outcome().unwrap().vessel.marks.iter().map(|mark| mark.id).collect()
}
