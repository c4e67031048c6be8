//! The target and its path.

use barrelman_sim::boat::Steering;
use barrelman_sim::helmsman::BoatScript;
use barrelman_sim::path::Path;
use barrelman_sim::pursuit::PursuitScript;
use barrelman_sim::random::OrnsteinUhlenbeck;
use barrelman_sim::scenario::TargetScript;

use crate::scenario::file::{BoatSection, PathFile, ScenarioFile, SteeringName, TargetSection};
use crate::scenario::range::within;
use crate::scenario::{BUILT_IN_PATHS, ScenarioError, ScenarioOverrides};

/// Largest absolute value of a coordinate of the world, metres. The camera's position is the origin.
pub(super) const WORLD_M: f64 = 5000.0;

/// The target of a scenario.
pub(super) fn target(
    file: &ScenarioFile,
    overrides: &ScenarioOverrides,
) -> Result<TargetScript, ScenarioError> {
    match (&file.target, &file.boat) {
        (Some(section), None) => pursuit(section, overrides),
        (None, Some(section)) if file.water.is_some() => boat(section, overrides),
        (None, Some(_)) => Err(ScenarioError::invalid("boat", "a boat needs [water]")),
        (None, None) => Err(ScenarioError::invalid("target", "give the scenario a [target] or a [boat]")),
        (Some(_), Some(_)) => {
            Err(ScenarioError::invalid("boat", "the scenario has a [target] too: leave one of them out"))
        }
    }
}

/// The way-points of a path: `start` before the first, all scaled by `scale`, and x by `breadth` too.
fn way_points(
    table: &str,
    path: Option<&String>,
    own: Option<&Vec<[f64; 2]>>,
    start: Option<[f64; 2]>,
    scale: f64,
    breadth: f64,
) -> Result<Vec<(f64, f64)>, ScenarioError> {
    let scale = within(&format!("{table}.scale"), scale, 0.01, 1000.0, "a factor")?;
    let breadth = within(&format!("{table}.breadth"), breadth, 0.01, 100.0, "a factor")?;
    let path_key = format!("{table}.path");
    let (key, way_points) = match (path, own) {
        (Some(name), None) => (path_key.clone(), built_in_path(&path_key, name)?),
        (None, Some(way_points)) => (format!("{table}.way_points"), way_points.clone()),
        (None, None) => return Err(ScenarioError::invalid(table, "give it a path or way_points")),
        (Some(_), Some(_)) => {
            return Err(ScenarioError::invalid(path_key, "it has way_points too: leave one of them out"));
        }
    };
    let way_points: Vec<(f64, f64)> =
        start.iter().chain(&way_points).map(|[x, y]| (scale * breadth * x, scale * y)).collect();
    for (x, y) in &way_points {
        if !(x.abs() <= WORLD_M && y.abs() <= WORLD_M) {
            return Err(ScenarioError::invalid(
                key,
                format!("the way-point {x}, {y} leaves the world, which ends {WORLD_M} m from the camera"),
            ));
        }
    }
    if Path::from_way_points(way_points.iter().copied()).is_err() {
        return Err(ScenarioError::invalid(key, "a path needs two way-points in different places"));
    }
    Ok(way_points)
}

fn pursuit(section: &TargetSection, overrides: &ScenarioOverrides) -> Result<TargetScript, ScenarioError> {
    let way_points = way_points(
        "target",
        section.path.as_ref(),
        section.way_points.as_ref(),
        section.start_m,
        section.scale,
        section.breadth.unwrap_or(1.0),
    )?;
    let at = |key: &str| format!("target.{key}");
    let number =
        |key: &str, value: f64, min: f64, max: f64, unit: &str| within(&at(key), value, min, max, unit);
    let speed = overrides.boat_speed_m_per_s.unwrap_or(section.speed_m_per_s);
    Ok(TargetScript::Pursuit(PursuitScript {
        way_points,
        speed_m_per_s: number("speed_m_per_s", speed, 0.01, 50.0, "m/s")?,
        log_speed_std_dev: number("speed_spread", section.speed_spread, 0.0, 1.0, "a share")?,
        range_exponent: number("range_exponent", section.range_exponent, 0.0, 1.0, "a power")?,
        speed_variation: OrnsteinUhlenbeck {
            std_dev: number("gust_share", section.gust_share, 0.0, 1.0, "a share")?,
            time_constant_s: number("gust_time_s", section.gust_time_s, 0.01, 1000.0, "seconds")?,
        },
        weave: OrnsteinUhlenbeck {
            std_dev: number("weave_rad", section.weave_rad, 0.0, 3.0, "radians")?,
            time_constant_s: number("weave_time_s", section.weave_time_s, 0.01, 1000.0, "seconds")?,
        },
        look_ahead_m: number("look_ahead_m", section.look_ahead_m, 0.01, 1000.0, "metres")?,
        way_point_jitter_m: number("way_point_jitter_m", section.way_point_jitter_m, 0.0, 1000.0, "metres")?,
        heading_gain: number("heading_gain", section.heading_gain, 0.01, 100.0, "1/s")?,
        max_turn_rad_per_s: number("most_turn_rad_per_s", section.most_turn_rad_per_s, 0.01, 50.0, "rad/s")?,
        surge_lag_s: number("surge_lag_s", section.surge_lag_s, 0.0, 60.0, "seconds")?,
        turn_lag_s: number("turn_lag_s", section.turn_lag_s, 0.0, 60.0, "seconds")?,
        corner_slow_down: number("corner_slow_down", section.corner_slow_down, 0.0, 0.95, "a share")?,
        arrival_m: number("arrival_m", section.arrival_m, 0.0, 1000.0, "metres")?,
        stand_before_s: number("stand_before_s", section.stand_before_s, 0.0, 600.0, "seconds")?,
        stand_after_s: number("stand_after_s", section.stand_after_s, 0.0, 600.0, "seconds")?,
        pauses_per_s: number("pauses_per_s", section.pauses_per_s, 0.0, 10.0, "1/s")?,
        leg_end_slow_down: number("leg_rhythm", section.leg_rhythm, 0.0, 0.95, "a share")?,
        corner_pauses: number("corner_pauses", section.corner_pauses, 0.0, 1.0, "a share")?,
        pause_s: number("pause_s", section.pause_s, 0.0, 600.0, "seconds")?,
    }))
}

fn boat(section: &BoatSection, overrides: &ScenarioOverrides) -> Result<TargetScript, ScenarioError> {
    let number = |key: &str, value: f64, min: f64, max: f64, unit: &str| {
        within(&format!("boat.{key}"), value, min, max, unit)
    };
    let speed = overrides.boat_speed_m_per_s.unwrap_or(section.speed_m_per_s);
    Ok(TargetScript::Boat(BoatScript {
        way_points: way_points(
            "boat",
            section.path.as_ref(),
            section.way_points.as_ref(),
            None,
            section.scale,
            1.0,
        )?,
        speed_m_per_s: number("speed_m_per_s", speed, 0.1, 12.0, "m/s")?,
        log_speed_std_dev: number("speed_spread", section.speed_spread, 0.0, 1.0, "a share")?,
        steering: match section.steering {
            SteeringName::Jet => Steering::Jet,
            SteeringName::JetAndRudder => Steering::JetAndRudder,
        },
        max_throttle: number("most_throttle", section.most_throttle, 0.05, 1.0, "a share")?,
        look_ahead_m: number("look_ahead_m", section.look_ahead_m, 0.1, 1000.0, "metres")?,
        way_point_jitter_m: number("way_point_jitter_m", section.way_point_jitter_m, 0.0, 1000.0, "metres")?,
    }))
}

fn built_in_path(key: &str, name: &str) -> Result<Vec<[f64; 2]>, ScenarioError> {
    let Some((_, text)) = BUILT_IN_PATHS.iter().find(|(known, _)| *known == name) else {
        let names: Vec<&str> = BUILT_IN_PATHS.iter().map(|(known, _)| *known).collect();
        return Err(ScenarioError::invalid(
            key,
            format!("there is no path {name:?}: use one of {}, or way_points", names.join(", ")),
        ));
    };
    let file: PathFile = toml::from_str(text)
        .map_err(|error| ScenarioError::Syntax(crate::toml_message::message_of(&error)))?;
    Ok(file.way_points)
}
