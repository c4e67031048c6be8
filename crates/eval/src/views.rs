//! Views to judge the renderer by with one's eyes: the same boat on lakes and seas, from heights and angles at which it
//! will be followed, and the laboratory's floor.

use std::fs::File;
use std::io::BufWriter;
use std::path::{Path, PathBuf};
use std::time::Instant;

use anyhow::{Context, Result};
use barrelman_sim::render::{RenderSettings, Renderer, Serial, WaterColour};
use barrelman_sim::snapshot::{Boat, Ground, Light, ObjectKind, SceneObject, SensorState, Target};
use barrelman_sim::tick::TICKS_PER_SECOND;
use barrelman_sim::{BodyPose, CameraPose, Optics, Sea, SeaState, Snapshot, Wind, WorldPoint};
use barrelman_vocab::{Angle, Picture, PictureSize};

#[derive(Debug, clap::Args)]
pub(crate) struct Options {
    /// Folder for the pictures; made if it is not there
    #[arg(long, value_name = "DIR")]
    output: PathBuf,
    /// Draw only views whose name contains this
    #[arg(long, value_name = "TEXT", default_value = "")]
    only: String,
    /// Width of the pictures in pixels; the height is 9/16 of it
    #[arg(long, value_name = "PIXELS", default_value_t = 1280)]
    width: u32,
}

/// One view.
struct View {
    name: &'static str,
    height_m: f64,
    down_deg: f64,
    state: u8,
    water: WaterColour,
    overcast: f64,
    /// Bearing and elevation of the sun, degrees; the camera looks along 0.
    sun_deg: (f64, f64),
    crowd: Crowd,
    /// Rate of pan, degrees a second.
    pan_deg_per_s: f64,
}

/// What is about the boat.
enum Crowd {
    People,
    PierAndShore,
    Arena,
    Floor,
}

const PLAIN: View = View {
    name: "",
    height_m: 10.0,
    down_deg: 30.0,
    state: 1,
    water: WaterColour::Lake,
    overcast: 0.0,
    sun_deg: (140.0, 42.0),
    crowd: Crowd::People,
    pan_deg_per_s: 0.0,
};

fn views() -> Vec<View> {
    vec![
        View { name: "1_lake_10m_p30", ..PLAIN },
        View {
            name: "2_sea_20m_p45",
            height_m: 20.0,
            down_deg: 45.0,
            state: 3,
            water: WaterColour::Sea,
            ..PLAIN
        },
        View { name: "3_nadir_8m", height_m: 8.0, down_deg: 88.0, sun_deg: (-60.0, 66.0), ..PLAIN },
        View { name: "4_low_3m_p8_pier", height_m: 3.0, down_deg: 8.0, crowd: Crowd::PierAndShore, ..PLAIN },
        View { name: "5_glint_12m_p25", height_m: 12.0, down_deg: 25.0, sun_deg: (-4.0, 36.0), ..PLAIN },
        View {
            name: "6_overcast_30m_p60",
            height_m: 30.0,
            down_deg: 60.0,
            state: 2,
            water: WaterColour::Green,
            overcast: 1.0,
            ..PLAIN
        },
        View {
            name: "8_sea_6m_p15",
            height_m: 6.0,
            down_deg: 15.0,
            state: 3,
            water: WaterColour::Sea,
            ..PLAIN
        },
        View { name: "9_arena_5m5_p24", height_m: 5.5, down_deg: 24.0, crowd: Crowd::Arena, ..PLAIN },
        View {
            name: "10_arena_panning",
            height_m: 5.5,
            down_deg: 24.0,
            crowd: Crowd::Arena,
            pan_deg_per_s: 14.0,
            ..PLAIN
        },
        View { name: "11_close_2m_p25", height_m: 2.0, down_deg: 25.0, ..PLAIN },
        View {
            name: "12_floor_1m83_p24",
            height_m: 1.83,
            down_deg: 24.0,
            overcast: 1.0,
            crowd: Crowd::Floor,
            ..PLAIN
        },
    ]
}

/// Draws them all; always true.
pub(crate) fn render(options: &Options) -> Result<bool> {
    std::fs::create_dir_all(&options.output).with_context(|| options.output.display().to_string())?;
    for view in views().iter().filter(|view| view.name.contains(&options.only)) {
        let size = PictureSize::new(options.width, options.width * 9 / 16 / 2 * 2);
        let optics = Optics { picture: size, focal_px: 0.83 * f64::from(size.width), barrel: 0.06 };
        let state = SeaState::new(view.state).context("a sea state from 0 to 4")?;
        let wind = Wind { speed_mps: state.wind_mps(), towards: Angle::from_degrees(-115.0) };
        let sea = Sea::new(state, wind, 4);
        let mut renderer = Renderer::new(RenderSettings {
            water: view.water,
            ..RenderSettings::new(optics, Some(sea.clone()), 11)
        });
        let mut picture = Picture::black(size, barrelman_sim::render::ENCODING);
        let end = u64::from(TICKS_PER_SECOND) * 20;
        for tick in (0..end).step_by(4) {
            renderer.advance_wake(&snapshot(view, &sea, tick));
        }
        let last = snapshot(view, &sea, end);
        renderer.render(&last, &mut picture, &Serial);
        let started = Instant::now();
        let truth = renderer.render(&last, &mut picture, &Serial);
        let took = started.elapsed();
        let path = options.output.join(format!("{}.png", view.name));
        write(&path, &picture).with_context(|| path.display().to_string())?;
        let line = format!(
            "{:22} {:5.1} ms, target {:5} pixels, {:3.0} % visible, heading {}, range {:.1} m",
            view.name,
            1e3 * took.as_secs_f64(),
            truth.mask.count(),
            100.0 * truth.visible_share,
            truth.heading.map_or("none".into(), |heading| format!("{:.0}", heading.degrees())),
            truth.range_m,
        );
        super::say(&line);
    }
    Ok(true)
}

fn place(x: f64, y: f64, z: f64) -> WorldPoint {
    WorldPoint { x, y, z }
}

fn afloat(sea: &Sea, x: f64, y: f64, heading_deg: f64, tick: u64) -> BodyPose {
    let surface = sea.surface_at(x, y, tick);
    let heading = Angle::from_degrees(heading_deg);
    let (sin, cos) = (heading.radians().sin(), heading.radians().cos());
    let along = surface.slope.0 * cos + surface.slope.1 * sin;
    let across = surface.slope.1 * cos - surface.slope.0 * sin;
    BodyPose {
        position: place(x, y, surface.elevation),
        heading,
        pitch: Angle::from_radians(0.6 * along),
        roll: Angle::from_radians(0.6 * across),
    }
}

/// The boat comes from the lower right and bears to the left as it goes away.
fn boat(sea: &Sea, ahead_m: f64, tick: u64, end: u64) -> Boat {
    let left_s = (end as f64 - tick as f64) / f64::from(TICKS_PER_SECOND);
    let (speed, rate) = (1.9, 0.055_f64);
    let heading = 118.0_f64.to_radians() - rate * left_s;
    // Back along a circle from where it ends.
    let radius = speed / rate;
    let last = 118.0_f64.to_radians();
    let x = -radius * (last.sin() - heading.sin());
    let y = ahead_m + radius * (last.cos() - heading.cos());
    let mut pose = afloat(sea, x, y, heading.to_degrees(), tick);
    pose.pitch = Angle::from_radians(pose.pitch.radians() + 0.05);
    let velocity = (speed * heading.cos(), speed * heading.sin());
    Boat { pose, velocity, thrust: 0.5, nozzle: Angle::from_degrees(5.0) }
}

fn snapshot(view: &View, sea: &Sea, tick: u64) -> Snapshot {
    let end = u64::from(TICKS_PER_SECOND) * 20;
    let eye = place(0.0, 0.0, view.height_m);
    let ahead = view.height_m / view.down_deg.to_radians().tan();
    let ahead = if view.down_deg < 10.0 { 9.0 } else { ahead.min(18.0) };
    let camera = |turn: f64| CameraPose {
        position: eye,
        pan: Angle::from_radians(turn),
        tilt: Angle::from_degrees(-view.down_deg),
        roll: Angle::ZERO,
    };
    let thing = |kind, x: f64, y: f64, heading: f64, seed| SceneObject {
        kind,
        pose: afloat(sea, x, ahead + y, heading, tick),
        seed,
    };
    let mut things = Vec::new();
    let mut target = Target::Boat(boat(sea, ahead, tick, end));
    let mut ground = Ground::Water;
    match view.crowd {
        Crowd::People | Crowd::PierAndShore => {
            things.push(thing(ObjectKind::LifeJacket, 2.4, -1.1, 70.0, 1));
            things.push(thing(ObjectKind::LifeJacket, -1.9, 2.4, -100.0, 2));
            things.push(thing(ObjectKind::LifeJacket, -0.6, 9.5, 20.0, 3));
            things.push(thing(ObjectKind::Swimmer, -3.0, 1.3, -60.0, 1));
            things.push(thing(ObjectKind::Swimmer, 1.7, 2.9, -120.0, 0));
            things.push(thing(ObjectKind::Buoy, 4.2, 4.6, 0.0, 0));
            things.push(thing(ObjectKind::Buoy, -4.6, 6.4, 0.0, 1));
        }
        Crowd::Arena => {
            for (index, (x, y)) in
                [(-3.2, -3.0), (3.0, -2.6), (-3.6, 3.6), (3.8, 3.4), (0.2, 6.5)].into_iter().enumerate()
            {
                things.push(thing(ObjectKind::Buoy, x, y, 0.0, [1, 2, 1, 2, 1][index]));
            }
            things.push(thing(ObjectKind::RedCraft, -2.4, 9.0, 30.0, 0));
        }
        Crowd::Floor => {
            ground = Ground::Floor;
            target = Target::FloorTarget(BodyPose {
                position: place(0.3, ahead, 0.0),
                heading: Angle::from_degrees(140.0),
                pitch: Angle::ZERO,
                roll: Angle::ZERO,
            });
            for (index, (x, y)) in
                [(-1.5, -1.5), (1.5, -1.5), (-1.5, 1.5), (1.5, 1.5), (0.0, 0.0), (0.0, 3.0)]
                    .into_iter()
                    .enumerate()
            {
                let mut mark = thing(ObjectKind::FloorMark, x, y, 0.0, index as u64);
                mark.pose = BodyPose {
                    position: place(x, ahead + y, 0.0),
                    pitch: Angle::ZERO,
                    roll: Angle::ZERO,
                    ..mark.pose
                };
                things.push(mark);
            }
        }
    }
    if matches!(view.crowd, Crowd::PierAndShore) {
        let pier = ObjectKind::Pier { length_m: 9.0, breadth_m: 1.8 };
        let level = |x: f64, y: f64, heading: f64| BodyPose {
            position: place(x, y, 0.0),
            heading: Angle::from_degrees(heading),
            pitch: Angle::ZERO,
            roll: Angle::ZERO,
        };
        things.push(SceneObject { kind: pier, pose: level(-8.5, 19.0, 8.0), seed: 3 });
        things.push(SceneObject { kind: ObjectKind::Shore, pose: level(-6.0, 17.0, 84.0), seed: 5 });
        things.push(SceneObject { kind: ObjectKind::Shore, pose: level(0.0, 300.0, 3.0), seed: 8 });
    }
    let turn = (view.pan_deg_per_s * 0.018).to_radians();
    Snapshot {
        tick,
        first_row: camera(0.0),
        last_row: camera(turn),
        light: Light {
            sun_bearing: Angle::from_degrees(view.sun_deg.0),
            sun_elevation: Angle::from_degrees(view.sun_deg.1),
            overcast: view.overcast,
        },
        ground,
        target,
        objects: things,
        sensor: SensorState { exposure: 1.0, red: 1.0, blue: 1.0, exposure_s: 0.006 },
    }
}

fn write(path: &Path, picture: &Picture) -> Result<()> {
    let size = picture.size();
    let mut encoder = png::Encoder::new(BufWriter::new(File::create(path)?), size.width, size.height);
    encoder.set_color(png::ColorType::Rgb);
    encoder.set_depth(png::BitDepth::Eight);
    let mut rgb = Vec::with_capacity(3 * size.area());
    for row in 0..size.height as usize {
        for column in 0..size.width as usize {
            let y = (f32::from(picture.y().row(row)[column]) - 16.0) / 219.0;
            let u = (f32::from(picture.u().row(row / 2)[column / 2]) - 128.0) / 224.0;
            let v = (f32::from(picture.v().row(row / 2)[column / 2]) - 128.0) / 224.0;
            let (r, b) = (y + 1.5748 * v, y + 1.8556 * u);
            let g = (y - 0.2126 * r - 0.0722 * b) / 0.7152;
            rgb.extend([r, g, b].map(|value| (255.0 * value).round().clamp(0.0, 255.0) as u8));
        }
    }
    encoder.write_header()?.write_image_data(&rgb)?;
    Ok(())
}
