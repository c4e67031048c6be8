//! From what a scenario's file says to what a world is made of. Every value is held to its range.

mod axes;
mod target;

use barrelman_sim::Optics;
use barrelman_sim::electronics::ElectronicsModel;
use barrelman_sim::random::OrnsteinUhlenbeck;
use barrelman_sim::scenario::{
    BeyondBorder, CameraSetup, FirstView, Platform, Scenario, SensorModel, TargetScript, Water,
};
use barrelman_sim::scenery::ObjectScript;
use barrelman_sim::sea::{SeaState, Wind};
use barrelman_sim::snapshot::{Light, ObjectKind};
use barrelman_sim::sway::Sway;
use barrelman_sim::tick::TICKS_PER_SECOND;
use barrelman_sim::video_link::VideoLinkModel;
use barrelman_vocab::{Angle, PictureSize};

use super::error::ScenarioError;
use super::file::{
    CameraSection, LightSection, ScenarioFile, SceneObjectName, SceneObjectSection, SensingSection,
    SwaySection, WaterSection,
};
use super::loaded::{LoadedScenario, ScenarioOverrides};
use super::range::within;

/// Reads a scenario from its text.
///
/// # Errors
/// If it has a mistake.
pub fn read(text: &str, changes: &ScenarioOverrides) -> Result<LoadedScenario, ScenarioError> {
    let file: ScenarioFile = toml::from_str(text).map_err(|error| ScenarioError::Form(error.to_string()))?;
    let (scenario, setting) = resolve(&file, changes)?;
    Ok(LoadedScenario { scenario, setting, hash: xxhash_rust::xxh3::xxh3_64(text.as_bytes()) })
}

fn resolve(file: &ScenarioFile, changes: &ScenarioOverrides) -> Result<(Scenario, String), ScenarioError> {
    if file.name.is_empty() || !file.name.chars().all(|c| c.is_ascii_alphanumeric() || c == '-' || c == '_') {
        return Err(ScenarioError::value(
            "name",
            "use letters, digits, - and _ only: it becomes part of file names",
        ));
    }
    let camera = camera(&file.camera, changes)?;
    let latency_s = camera.video.latency_s;
    let (setting, platform) = platform(file, changes)?;
    let water = water(file.water.as_ref(), changes)?;
    let target = target::target(file, changes)?;
    let scenario = Scenario {
        name: file.name.clone(),
        mount: axes::mount(file, latency_s)?,
        ranges: axes::ranges(&file.drawn, latency_s)?,
        camera,
        platform,
        water,
        light: light(&file.light)?,
        objects: things(file, &target)?,
        target,
        sensing: sensing(&file.sensing)?,
        max_s: within("longest_s", file.longest_s, 1.0, 3600.0, "seconds")?,
    };
    Ok((scenario, setting))
}

fn camera(section: &CameraSection, changes: &ScenarioOverrides) -> Result<CameraSetup, ScenarioError> {
    let size = |key: &str, [width, height]: [u32; 2]| {
        let even = |side: u32| (64..=4096).contains(&side) && side.is_multiple_of(2);
        if even(width) && even(height) {
            Ok(PictureSize::new(width, height))
        } else {
            Err(ScenarioError::value(
                key,
                format!("{width} x {height}: use even numbers of pixels from 64 to 4096"),
            ))
        }
    };
    let written = size("camera.picture", section.picture)?;
    let written_frame = section.frame.map_or(Ok(written), |frame| size("camera.frame", frame))?;
    // Another size shows the same view: focal length and frame grow with the width.
    let picture = changes.size.map_or(Ok(written), |to| size("camera.picture", [to.width, to.height]))?;
    let factor = f64::from(picture.width) / f64::from(written.width);
    let stretched = |side: u32| 2 * ((f64::from(side) * factor / 2.0).round() as u32);
    let frame = if changes.size.is_some() && written_frame == written {
        picture
    } else {
        PictureSize::new(stretched(written_frame.width), stretched(written_frame.height))
    };
    if frame.width < picture.width || frame.height < picture.height {
        return Err(ScenarioError::value(
            "camera.frame",
            "it is smaller than the picture that it should hold",
        ));
    }
    let rate = section.pictures_per_second;
    if rate == 0 || !TICKS_PER_SECOND.is_multiple_of(rate) {
        return Err(ScenarioError::value(
            "camera.pictures_per_second",
            format!("{rate}: use a whole number that {TICKS_PER_SECOND} can be divided by, such as 30"),
        ));
    }
    let first_view = |key: &str, [pan, tilt]: [f64; 2], least: f64| {
        let key = format!("camera.{key}");
        Ok::<_, ScenarioError>((
            within(&key, pan, least, 1.5, "radians")?,
            within(&key, tilt, least, 1.5, "radians")?,
        ))
    };
    let drift = |what: &str, deviation: f64, time_s: f64| {
        Ok::<_, ScenarioError>(OrnsteinUhlenbeck {
            std_dev: within(&format!("camera.{what}_drift"), deviation, 0.0, 0.5, "a share")?,
            time_constant_s: within(&format!("camera.{what}_time_s"), time_s, 0.01, 1000.0, "seconds")?,
        })
    };
    let share = |key: &str, value: f64| within(&format!("camera.loss.{key}"), value, 0.0, 1.0, "a share");
    let steady = VideoLinkModel {
        jitter_s: 0.5 * within("camera.latency_jitter_s", section.latency_jitter_s, 0.0, 1.0, "seconds")?,
        ..VideoLinkModel::steady(within("camera.latency_s", section.latency_s, 0.0, 5.0, "seconds")?)
    };
    let video = match &section.loss {
        None => steady,
        Some(loss) => VideoLinkModel {
            good_to_bad: share("to_bad", loss.to_bad)?,
            bad_to_good: share("to_good", loss.to_good)?,
            impaired_share: share("spoilt", loss.spoilt)?,
            frozen_share: share("frozen", loss.frozen)?,
            ..steady
        },
    };
    Ok(CameraSetup {
        height_m: within("camera.height_m", section.height_m, 0.2, 500.0, "metres")?,
        optics: Optics {
            picture,
            focal_px: factor * within("camera.focal_px", section.focal_px, 10.0, 100_000.0, "pixels")?,
            barrel: within("camera.barrel", section.barrel, 0.0, 1.0, "a number")?,
        },
        frame,
        pictures_per_second: rate,
        rolling_shutter_s: within(
            "camera.rolling_shutter_s",
            section.rolling_shutter_s,
            0.0,
            0.1,
            "seconds",
        )?,
        video,
        first_view: FirstView {
            mean: first_view("first_view_rad", section.first_view_rad, -1.5)?,
            std_dev: first_view("first_view_deviation_rad", section.first_view_deviation_rad, 0.0)?,
        },
        electronics: ElectronicsModel {
            brightness: drift("brightness", section.brightness_drift, section.brightness_time_s)?,
            white_balance: drift("white_balance", section.white_balance_drift, section.white_balance_time_s)?,
            exposure_s: within("camera.exposure_s", section.exposure_s, 0.0, 0.1, "seconds")?,
        },
    })
}

/// What the camera hangs on, by the name of a setting.
fn platform(file: &ScenarioFile, changes: &ScenarioOverrides) -> Result<(String, Platform), ScenarioError> {
    let name = changes.setting.as_ref().unwrap_or(&file.setting);
    let platform = match (file.sway.get(name), file.kite.get(name)) {
        (Some(section), None) => Platform::Swaying(sway(name, section)?),
        (None, Some(section)) if file.water.is_some() => Platform::Kite {
            gustiness: within(&format!("kite.{name}.gustiness"), section.gustiness, 0.0, 10.0, "a factor")?,
        },
        (None, Some(_)) => return Err(ScenarioError::value("kite", "a kite in the wind needs [water]")),
        (Some(_), Some(_)) => {
            return Err(ScenarioError::value(format!("kite.{name}"), "there is a sway of that name too"));
        }
        (None, None) => {
            let names: Vec<&str> = file.sway.keys().chain(file.kite.keys()).map(String::as_str).collect();
            return Err(ScenarioError::value(
                "setting",
                format!("{} has no setting {name:?}: use one of {}", file.name, names.join(", ")),
            ));
        }
    };
    Ok((name.clone(), platform))
}

fn sway(name: &str, section: &SwaySection) -> Result<Sway, ScenarioError> {
    let wander = |what: &str, unit: &str, deviation: f64, most: f64, time_s: f64| {
        let deviation = within(&format!("sway.{name}.{what}_{unit}"), deviation, 0.0, most, unit)?;
        let time_s = within(&format!("sway.{name}.{what}_time_s"), time_s, 0.01, 1000.0, "seconds")?;
        Ok::<_, ScenarioError>(OrnsteinUhlenbeck { std_dev: deviation, time_constant_s: time_s })
    };
    let turn = |what: &str, deg: f64, time_s: f64| {
        let wander = wander(what, "deg", deg, 45.0, time_s)?;
        Ok::<_, ScenarioError>(OrnsteinUhlenbeck { std_dev: wander.std_dev.to_radians(), ..wander })
    };
    Ok(Sway {
        yaw: turn("yaw", section.yaw_deg, section.yaw_time_s)?,
        pitch: turn("pitch", section.pitch_deg, section.pitch_time_s)?,
        roll: turn("roll", section.roll_deg, section.roll_time_s)?,
        position: wander("place", "m", section.place_m, 50.0, section.place_time_s)?,
    })
}

fn water(
    section: Option<&WaterSection>,
    changes: &ScenarioOverrides,
) -> Result<Option<Water>, ScenarioError> {
    let Some(section) = section else {
        if changes.sea_state.is_some() || changes.wind_m_per_s.is_some() {
            return Err(ScenarioError::value(
                "water",
                "there is no water in this scenario: it has no sea and no wind",
            ));
        }
        return Ok(None);
    };
    let number = changes.sea_state.unwrap_or(section.sea_state);
    let Some(state) = SeaState::new(number) else {
        return Err(ScenarioError::value(
            "water.sea_state",
            format!("{number}: use 0 (glassy) to 4 (moderate); rougher seas are not simulated"),
        ));
    };
    let wind = changes.wind_m_per_s.or(section.wind_m_per_s).unwrap_or_else(|| state.wind_mps());
    Ok(Some(Water {
        state,
        wind: Wind {
            speed_mps: within("water.wind_m_per_s", wind, 0.0, 30.0, "m/s")?,
            towards: angle("water.wind_towards_deg", section.wind_towards_deg, -360.0, 360.0)?,
        },
    }))
}

fn light(section: &LightSection) -> Result<Light, ScenarioError> {
    Ok(Light {
        sun_bearing: angle("light.sun_bearing_deg", section.sun_bearing_deg, -360.0, 360.0)?,
        sun_elevation: angle("light.sun_elevation_deg", section.sun_elevation_deg, 2.0, 90.0)?,
        overcast: within("light.overcast", section.overcast, 0.0, 1.0, "a share")?,
    })
}

/// The things of a scenario, and the marks of its path.
fn things(file: &ScenarioFile, target: &TargetScript) -> Result<Vec<ObjectScript>, ScenarioError> {
    let way_points = match target {
        TargetScript::Pursuit(script) => &script.way_points,
        TargetScript::Boat(script) => &script.way_points,
    };
    let mut all = if file.marks { marks(way_points, file.water.is_some()) } else { Vec::new() };
    for (index, section) in file.thing.iter().enumerate() {
        all.push(thing(&format!("thing.{index}"), section)?);
    }
    Ok(all)
}

/// The marks of a path: painted on a floor at each way-point; on water, where a boat must not run over them, small
/// buoys beside the path, no closer to each other than makes sense.
fn marks(way_points: &[(f64, f64)], on_water: bool) -> Vec<ObjectScript> {
    let mark = |kind, at| ObjectScript {
        kind,
        at,
        jitter_m: 0.0,
        heading: Angle::ZERO,
        velocity_m_per_s: (0.0, 0.0),
        turns_after_s: None,
    };
    if !on_water {
        return way_points.iter().map(|at| mark(ObjectKind::FloorMark, *at)).collect();
    }
    let mut marks: Vec<ObjectScript> = Vec::new();
    for (index, at) in way_points.iter().enumerate() {
        let (before, after) =
            (way_points[index.saturating_sub(1)], way_points[(index + 1).min(way_points.len() - 1)]);
        let (dx, dy) = (after.0 - before.0, after.1 - before.1);
        let length = dx.hypot(dy).max(f64::MIN_POSITIVE);
        let beside = (at.0 - MARKS_ASIDE_M * dy / length, at.1 + MARKS_ASIDE_M * dx / length);
        let is_near =
            |mark: &ObjectScript| (mark.at.0 - beside.0).hypot(mark.at.1 - beside.1) < MARKS_APART_M;
        if !marks.iter().any(is_near) {
            marks.push(mark(ObjectKind::MarkBuoy, beside));
        }
    }
    marks
}

/// Marks on the water lie so far to the left of the path, and at least so far apart, metres.
const MARKS_ASIDE_M: f64 = 2.0;
const MARKS_APART_M: f64 = 5.0;

fn thing(at: &str, section: &SceneObjectSection) -> Result<ObjectScript, ScenarioError> {
    let key = |name: &str| format!("{at}.{name}");
    let kind = match (section.kind, section.size_m) {
        (SceneObjectName::Pier, Some([length, breadth])) => ObjectKind::Pier {
            length_m: within(&key("size_m"), length, 1.0, 500.0, "metres")?,
            breadth_m: within(&key("size_m"), breadth, 0.5, 50.0, "metres")?,
        },
        (SceneObjectName::Pier, None) => return Err(ScenarioError::value(key("size_m"), "a pier needs one")),
        (_, Some(_)) => return Err(ScenarioError::value(key("size_m"), "only a pier has one")),
        (SceneObjectName::Buoy, None) => ObjectKind::Buoy,
        (SceneObjectName::LifeJacket, None) => ObjectKind::LifeJacket,
        (SceneObjectName::Swimmer, None) => ObjectKind::Swimmer,
        (SceneObjectName::RedCraft, None) => ObjectKind::RedCraft,
        (SceneObjectName::Shore, None) => ObjectKind::Shore,
    };
    let place = |value: f64| within(&key("at"), value, -target::WORLD_M, target::WORLD_M, "metres");
    let speed = |value: f64| within(&key("velocity_m_per_s"), value, -20.0, 20.0, "m/s");
    let ([x, y], [vx, vy]) = (section.at, section.velocity_m_per_s);
    Ok(ObjectScript {
        kind,
        at: (place(x)?, place(y)?),
        jitter_m: within(&key("jitter_m"), section.jitter_m, 0.0, 1000.0, "metres")?,
        heading: angle(&key("heading_deg"), section.heading_deg, -360.0, 360.0)?,
        velocity_m_per_s: (speed(vx)?, speed(vy)?),
        turns_after_s: section
            .turns_after_s
            .map(|after| within(&key("turns_after_s"), after, 0.1, 3600.0, "seconds"))
            .transpose()?,
    })
}

fn sensing(section: &SensingSection) -> Result<SensorModel, ScenarioError> {
    let [length, breadth] = section.target_size_m;
    let size = |value: f64| within("sensing.target_size_m", value, 0.01, 100.0, "metres");
    Ok(SensorModel {
        noise: OrnsteinUhlenbeck {
            std_dev: within("sensing.noise_px", section.noise_px, 0.0, 100.0, "pixels")?,
            time_constant_s: within("sensing.noise_time_s", section.noise_time_s, 0.0, 3600.0, "seconds")?,
        },
        is_rounded: section.rounded,
        beyond_border: match section.clamped_at_px {
            None => BeyondBorder::Absent,
            Some([x_px, y_px]) => BeyondBorder::Clamped {
                x_px: within("sensing.clamped_at_px", x_px, 1.0, 8192.0, "pixels")?,
                y_px: within("sensing.clamped_at_px", y_px, 1.0, 8192.0, "pixels")?,
            },
        },
        target_size_m: (size(length)?, size(breadth)?),
    })
}

fn angle(key: &str, degrees: f64, least: f64, most: f64) -> Result<Angle, ScenarioError> {
    within(key, degrees, least, most, "degrees").map(Angle::from_degrees)
}
