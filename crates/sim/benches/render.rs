//! Cost of a frame on one thread, as a whole and stage by stage, by picture size: an arena on the water
//! (boat, five buoys, 5.5 m up, looking 24 degrees down, sea state 1), a low view of a pier and a shore, and
//! the laboratory's floor.
//!
//! `cargo bench -p barrelman-sim --bench render`; an argument selects benchmarks by name.

use barrelman_sim::render::{ENCODING, Effects, RenderSettings, RenderStage, Renderer, Serial, WaveGrid};
use barrelman_sim::snapshot::{Boat, Ground, Light, ObjectKind, SceneObject, SensorState, Target};
use barrelman_sim::{BodyPose, CameraPose, Optics, Sea, SeaState, Snapshot, Wind, WorldPoint};
use barrelman_vocab::{Angle, Picture, PictureSize};

fn main() {
    divan::main();
}

const SIZES: [(u32, u32); 3] = [(320, 240), (640, 480), (1280, 720)];
const LARGE: [(u32, u32); 2] = [(640, 480), (1280, 720)];

/// What is drawn.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Scene {
    Arena,
    Pier,
    Floor,
}

fn renderer((width, height): (u32, u32), grid: WaveGrid, effects: Effects) -> (Renderer, Picture) {
    let size = PictureSize::new(width, height);
    let optics = Optics { picture: size, focal_px: 0.83 * f64::from(width), barrel: 0.06 };
    let state = SeaState::ALL[1];
    let sea = Sea::new(state, Wind { speed_mps: state.wind_mps(), towards: Angle::ZERO }, 1);
    let settings = RenderSettings { grid, effects, ..RenderSettings::new(optics, Some(sea), 1) };
    (Renderer::new(settings), Picture::black(size, ENCODING))
}

/// A frame, or one stage of it, of a boat under way.
fn bench(
    bencher: divan::Bencher<'_, '_>,
    scene: Scene,
    size: (u32, u32),
    (grid, effects): (WaveGrid, Effects),
    stage: Option<RenderStage>,
) {
    let (mut renderer, mut picture) = renderer(size, grid, effects);
    let mut tick = 0;
    // A wake needs a while.
    for _ in 0..60 {
        tick += 4;
        renderer.advance_wake(&snapshot(scene, tick));
    }
    renderer.render(&snapshot(scene, tick), &mut picture, &Serial);
    bencher.bench_local(|| {
        tick += 4;
        let snapshot = divan::black_box(snapshot(scene, tick));
        match stage {
            Some(stage) => renderer.render_stage(stage, &snapshot, &mut picture, &Serial),
            None => drop(divan::black_box(renderer.render(&snapshot, &mut picture, &Serial).visible_share)),
        }
    });
}

const USUAL: (WaveGrid, Effects) = (WaveGrid::Coarse, Effects::ALL);

macro_rules! stages {
    ($($name:ident: $stage:ident, $what:literal;)*) => {
        mod arena {
            use super::*;
            $(
                #[doc = $what]
                #[divan::bench(args = LARGE)]
                fn $name(bencher: divan::Bencher<'_, '_>, size: (u32, u32)) {
                    bench(bencher, Scene::Arena, size, USUAL, Some(RenderStage::$stage));
                }
            )*
            /// All stages.
            #[divan::bench(args = SIZES)]
            fn whole_frame(bencher: divan::Bencher<'_, '_>, size: (u32, u32)) {
                bench(bencher, Scene::Arena, size, USUAL, None);
            }
        }
        mod pier {
            use super::*;
            $(
                #[doc = $what]
                #[divan::bench(args = LARGE)]
                fn $name(bencher: divan::Bencher<'_, '_>, size: (u32, u32)) {
                    bench(bencher, Scene::Pier, size, USUAL, Some(RenderStage::$stage));
                }
            )*
            /// All stages.
            #[divan::bench(args = SIZES)]
            fn whole_frame(bencher: divan::Bencher<'_, '_>, size: (u32, u32)) {
                bench(bencher, Scene::Pier, size, USUAL, None);
            }
        }
    };
}

stages! {
    waves: Waves, "Tiles of slopes by Fourier transforms.";
    wake: Wake, "One step of the wake.";
    projection_and_mirror_images: ReflectionsAndShadows, "Camera, light, mirror images and shadows.";
    water_and_sky: Water, "Rays, surface, light.";
    objects: Objects, "Things, drawn and laid over.";
    sensor: Sensor, "From light to samples.";
}

/// Waves on grids of 256.
#[divan::bench(args = SIZES)]
fn arena_with_fine_waves(bencher: divan::Bencher<'_, '_>, size: (u32, u32)) {
    bench(bencher, Scene::Arena, size, (WaveGrid::Fine, Effects::ALL), None);
}

/// Without wake, mirror images, shadows, noise and blur.
#[divan::bench(args = SIZES)]
fn arena_plain(bencher: divan::Bencher<'_, '_>, size: (u32, u32)) {
    bench(bencher, Scene::Arena, size, (WaveGrid::Coarse, Effects::NONE), None);
}

/// No waves at all.
#[divan::bench(args = SIZES)]
fn floor(bencher: divan::Bencher<'_, '_>, size: (u32, u32)) {
    bench(bencher, Scene::Floor, size, USUAL, None);
}

fn snapshot(scene: Scene, tick: u64) -> Snapshot {
    let lies = |x: f64, y: f64, heading: f64| BodyPose {
        position: WorldPoint { x, y, z: 0.0 },
        heading: Angle::from_degrees(heading),
        pitch: Angle::ZERO,
        roll: Angle::ZERO,
    };
    let ground = if scene == Scene::Floor { Ground::Floor } else { Ground::Water };
    let kind = if scene == Scene::Floor { ObjectKind::FloorMark } else { ObjectKind::Buoy };
    let mut objects: Vec<SceneObject> = [(-3.2, 9.0), (3.0, 9.5), (-3.6, 15.6), (3.8, 15.4), (0.2, 18.5)]
        .into_iter()
        .map(|(x, y)| SceneObject { kind, pose: lies(x, y, 0.0), seed: 1 })
        .collect();
    let (mut height, mut down) = (5.5, 24.0);
    if scene == Scene::Pier {
        (height, down) = (3.0, 8.0);
        let pier = ObjectKind::Pier { length_m: 24.0, breadth_m: 1.6 };
        objects.push(SceneObject { kind: pier, pose: lies(-9.0, 16.0, 10.0), seed: 1 });
        objects.push(SceneObject { kind: ObjectKind::Shore, pose: lies(-6.0, 40.0, 5.0), seed: 1 });
    }
    let camera = CameraPose {
        position: WorldPoint { x: 0.0, y: 0.0, z: height },
        pan: Angle::ZERO,
        tilt: Angle::from_degrees(-down),
        roll: Angle::ZERO,
    };
    let pose = lies(0.002 * tick as f64, 12.0, 30.0);
    let boat = Boat { pose, velocity: (0.24, 0.0), thrust: 0.3, nozzle: Angle::ZERO };
    Snapshot {
        tick,
        first_row: camera,
        last_row: camera,
        zoom: 1.0,
        light: Light {
            sun_bearing: Angle::from_degrees(120.0),
            sun_elevation: Angle::from_degrees(45.0),
            overcast: 0.0,
        },
        ground,
        target: if ground == Ground::Water { Target::Boat(boat) } else { Target::FloorTarget(pose) },
        objects,
        sensor: SensorState { exposure: 1.0, red: 1.0, blue: 1.0, exposure_s: 0.004 },
    }
}
