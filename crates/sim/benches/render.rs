//! What a frame costs, on one thread: an arena on the water (boat, buoys, 5.5 m up, looking 24 degrees down, sea state
//! 1) and the laboratory's floor, by size of picture; and what is left when parts are left out.

use barrelman_sim::render::{ENCODING, Effects, RenderSettings, Renderer, Serial, WaveGrid};
use barrelman_sim::snapshot::{Boat, Ground, Light, SensorState, Target, Thing, ThingKind};
use barrelman_sim::{BodyPose, CameraPose, Optics, Sea, SeaState, Snapshot, Wind, WorldPoint};
use barrelman_vocab::{Angle, Picture, PictureSize};

fn main() {
    divan::main();
}

const SIZES: [(u32, u32); 3] = [(320, 240), (640, 480), (1280, 720)];

fn bench(
    bencher: divan::Bencher<'_, '_>,
    size: (u32, u32),
    ground: Ground,
    grid: WaveGrid,
    effects: Effects,
) {
    let picture = PictureSize::new(size.0, size.1);
    let optics = Optics { picture, focal_px: 0.83 * f64::from(size.0), barrel: 0.06 };
    let state = SeaState::ALL[1];
    let sea = Sea::new(state, Wind { speed_mps: state.wind_mps(), towards: Angle::ZERO }, 1);
    let settings = RenderSettings { grid, effects, ..RenderSettings::new(optics, Some(sea), 1) };
    let mut renderer = Renderer::new(settings);
    let mut picture = Picture::black(picture, ENCODING);
    let mut tick = 0;
    bencher.bench_local(|| {
        tick += 4;
        renderer.draw(divan::black_box(&arena(ground, tick)), &mut picture, &Serial).visible
    });
}

/// Everything on, waves on grids of 256.
#[divan::bench(args = SIZES)]
fn arena_fine(bencher: divan::Bencher<'_, '_>, size: (u32, u32)) {
    bench(bencher, size, Ground::Water, WaveGrid::Fine, Effects::ALL);
}

/// Everything on, waves on grids of 128.
#[divan::bench(args = SIZES)]
fn arena_coarse(bencher: divan::Bencher<'_, '_>, size: (u32, u32)) {
    bench(bencher, size, Ground::Water, WaveGrid::Coarse, Effects::ALL);
}

/// Without wake, mirror images, shadows, noise and blur.
#[divan::bench(args = SIZES)]
fn arena_plain(bencher: divan::Bencher<'_, '_>, size: (u32, u32)) {
    bench(bencher, size, Ground::Water, WaveGrid::Coarse, Effects::NONE);
}

/// No waves at all.
#[divan::bench(args = SIZES)]
fn floor(bencher: divan::Bencher<'_, '_>, size: (u32, u32)) {
    bench(bencher, size, Ground::Floor, WaveGrid::Coarse, Effects::ALL);
}

fn arena(ground: Ground, tick: u64) -> Snapshot {
    let lies = |x: f64, y: f64, heading: f64| BodyPose {
        place: WorldPoint { x, y, z: 0.0 },
        heading: Angle::from_degrees(heading),
        pitch: Angle::ZERO,
        roll: Angle::ZERO,
    };
    let kind = if ground == Ground::Water { ThingKind::Buoy } else { ThingKind::FloorMark };
    let things = [(-3.2, 9.0), (3.0, 9.5), (-3.6, 15.6), (3.8, 15.4), (0.2, 18.5)]
        .into_iter()
        .map(|(x, y)| Thing { kind, pose: lies(x, y, 0.0), seed: 1 })
        .collect();
    let camera = CameraPose {
        place: WorldPoint { x: 0.0, y: 0.0, z: 5.5 },
        pan: Angle::ZERO,
        tilt: Angle::from_degrees(-24.0),
        roll: Angle::ZERO,
    };
    let pose = lies(0.002 * tick as f64, 12.0, 30.0);
    let boat = Boat { pose, velocity: (0.24, 0.0), thrust: 0.3, nozzle: Angle::ZERO };
    Snapshot {
        tick,
        first_row: camera,
        last_row: camera,
        light: Light {
            sun_bearing: Angle::from_degrees(120.0),
            sun_elevation: Angle::from_degrees(45.0),
            overcast: 0.0,
        },
        ground,
        target: if ground == Ground::Water { Target::Boat(boat) } else { Target::FloorTarget(pose) },
        things,
        sensor: SensorState { exposure: 1.0, red: 1.0, blue: 1.0, exposure_s: 0.004 },
    }
}
