//! The renderer: the same bits on all threads and vector levels, and the truth about its pictures.

use std::sync::atomic::{AtomicUsize, Ordering};

use barrelman_sim::render::{
    ENCODING, Effects, ParallelFor, RenderSettings, RenderedTruth, Renderer, Serial, WaveGrid,
};
use barrelman_sim::snapshot::{Boat, Ground, Light, ObjectKind, SceneObject, SensorState, Target};
use barrelman_sim::{BodyPose, CameraPose, Optics, Sea, SeaState, Snapshot, Wind, WorldPoint, noise};
use barrelman_simd::{Simd, SimdLevel};
use barrelman_vocab::{Angle, Picture, PictureSize};

/// Two threads that share the indices.
struct TwoThreads;

impl ParallelFor for TwoThreads {
    fn run(&self, count: usize, work: &(dyn Fn(usize) + Sync)) {
        let next = AtomicUsize::new(0);
        let worker = || {
            loop {
                let index = next.fetch_add(1, Ordering::Relaxed);
                if index >= count {
                    break;
                }
                work(index);
            }
        };
        std::thread::scope(|scope| {
            scope.spawn(worker);
            worker();
        });
    }
}

#[derive(Debug, Clone, Copy, PartialEq)]
enum Scene {
    Arena,
    Sea,
    Pier,
    Floor,
}

const SIZE: PictureSize = PictureSize::new(208, 118);

fn degrees(value: f64) -> Angle {
    Angle::from_degrees(value)
}

fn at(x: f64, y: f64, z: f64) -> WorldPoint {
    WorldPoint { x, y, z }
}

fn pose_at(position: WorldPoint, heading: f64) -> BodyPose {
    BodyPose { position, heading: degrees(heading), pitch: Angle::ZERO, roll: Angle::ZERO }
}

fn sea(number: u8) -> Sea {
    let state = SeaState::ALL[usize::from(number)];
    Sea::new(state, Wind { speed_mps: state.wind_mps(), towards: degrees(-70.0) }, 77)
}

fn settings(size: PictureSize, sea: Sea) -> RenderSettings {
    let optics = Optics { picture: size, focal_px: 0.8 * f64::from(size.width), barrel: 0.08 };
    RenderSettings { grid: WaveGrid::Coarse, ..RenderSettings::new(optics, Some(sea), 5) }
}

fn boat(pose: BodyPose, speed: f64) -> Target {
    let (sin, cos) = libm::sincos(pose.heading.radians());
    Target::Boat(Boat { pose, velocity: (speed * cos, speed * sin), thrust: 0.4, nozzle: degrees(8.0) })
}

fn snapshot(scene: Scene, sea: &Sea, frame: u64) -> Snapshot {
    let tick = 400 + 4 * frame;
    let float = |x: f64, y: f64, heading| pose_at(at(x, y, sea.surface_at(x, y, tick).elevation), heading);
    let object = |kind, pose| SceneObject { kind, pose, seed: 3 };
    let target = boat(float(0.2, 9.0 + 0.06 * frame as f64, 70.0), 1.8);
    let mut objects = vec![
        object(ObjectKind::Buoy, float(-2.0, 11.0, 0.0)),
        object(ObjectKind::Swimmer, float(1.8, 10.0, 200.0)),
        object(ObjectKind::LifeJacket, float(1.0, 7.5, 40.0)),
    ];
    let (mut down, mut ground, mut overcast, mut target) = (24.0, Ground::Water, 0.0, target);
    match scene {
        Scene::Arena => objects.push(object(ObjectKind::RedCraft, float(-1.0, 15.0, 20.0))),
        Scene::Sea => overcast = 0.4,
        Scene::Pier => {
            down = 9.0;
            let pier = ObjectKind::Pier { length_m: 8.0, breadth_m: 1.6 };
            objects.push(object(pier, pose_at(at(-5.0, 14.0, 0.0), 10.0)));
            objects.push(object(ObjectKind::Shore, pose_at(at(-4.0, 12.0, 0.0), 85.0)));
        }
        Scene::Floor => {
            (ground, overcast) = (Ground::Floor, 1.0);
            target = Target::FloorTarget(pose_at(at(0.1, 8.0, 0.0), 30.0));
            objects = vec![object(ObjectKind::FloorMark, pose_at(at(0.6, 8.5, 0.0), 0.0))];
        }
    }
    let camera = |pan: f64| CameraPose {
        position: at(0.0, 0.0, 4.5),
        pan: degrees(pan),
        tilt: degrees(-down),
        roll: degrees(1.5),
    };
    Snapshot {
        tick,
        first_row: camera(0.0),
        last_row: camera(0.2 * frame as f64),
        zoom: 1.0,
        light: Light { sun_bearing: degrees(30.0), sun_elevation: degrees(40.0), overcast },
        ground,
        target,
        objects,
        sensor: SensorState { exposure: 1.05, red: 1.02, blue: 0.97, exposure_s: 0.01 },
    }
}

/// The scenes whose pictures are compared, each with the number of its sea state and the expected hash of
/// each frame. A hash covers samples, visible share and mask. It changes whenever its picture does; look at
/// the picture before replacing it.
#[rustfmt::skip]
const EXPECTED: [(Scene, u8, [u64; 4]); 4] = [
    (Scene::Arena, 1, [0x745a_1520_91d4_4fe6, 0x1924_cfff_9296_6176, 0x480d_f45c_3272_feae, 0xae0f_eb8b_30e6_7862]),
    (Scene::Sea,   3, [0x0cb5_bbe0_9acc_a95b, 0x00eb_182f_7bc3_5953, 0x1328_4209_a7a9_1899, 0xbf28_e2bd_be4c_6bf0]),
    (Scene::Pier,  0, [0x9384_b203_b7e8_0f1f, 0x6699_b186_68c4_81ba, 0x7d63_894f_f4d2_ca08, 0xfda3_a25a_0d33_8bfe]),
    (Scene::Floor, 0, [0x8549_def5_21a9_12fd, 0x5ff7_c542_c964_caba, 0xd403_63c4_e388_3de5, 0x11f0_d84b_41a1_3caf]),
];

/// FNV-1a, 64 bits.
fn fnv(hash: u64, bytes: &[u8]) -> u64 {
    bytes.iter().fold(hash, |hash, byte| (hash ^ u64::from(*byte)).wrapping_mul(0x0100_0000_01B3))
}

const FNV_OFFSET: u64 = 0xCBF2_9CE4_8422_2325;

/// The hash of each frame of a scene.
fn frame_hashes(simd: Simd, parallel: &dyn ParallelFor, (scene, state): (Scene, u8)) -> [u64; 4] {
    let sea = sea(state);
    let mut renderer = Renderer::new(RenderSettings { simd, ..settings(SIZE, sea.clone()) });
    let mut picture = Picture::black(SIZE, ENCODING);
    core::array::from_fn(|frame| {
        let truth = renderer.render(&snapshot(scene, &sea, frame as u64), &mut picture, parallel).clone();
        let mut hash = FNV_OFFSET;
        for bytes in [
            picture.samples(),
            &truth.visible_share.to_bits().to_le_bytes(),
            &(truth.mask.count() as u64).to_le_bytes(),
        ] {
            hash = fnv(hash, bytes);
        }
        hash
    })
}

/// Compares each picture with its expected hash; the failure names every picture that differs.
fn check_pictures(simd: Simd, parallel: &dyn ParallelFor, how: &str) {
    let mut differing = Vec::new();
    for (scene, state, expected) in EXPECTED {
        let found = frame_hashes(simd, parallel, (scene, state));
        for (frame, (found, expected)) in found.into_iter().zip(expected).enumerate() {
            if found != expected {
                differing.push(format!("{scene:?} frame {frame}: {found:#018x}, expected {expected:#018x}"));
            }
        }
    }
    assert!(differing.is_empty(), "rendered with {how}:\n{}", differing.join("\n"));
}

#[test]
fn a_picture_has_the_same_bits_on_every_renderer() {
    check_pictures(Simd::widest(), &Serial, "one thread, the widest vector level");
    check_pictures(Simd::widest(), &TwoThreads, "two threads, the widest vector level");
    let mut narrower = 0;
    for level in SimdLevel::ALL {
        check_pictures(Simd::at_most(level), &Serial, &format!("one thread, at most {level}"));
        narrower += u32::from(Simd::at_most(level).level() != Simd::widest().level());
    }
    // Other architectures have one level.
    let is_compared = narrower > 0 || !cfg!(target_arch = "x86_64");
    assert!(is_compared, "this machine has one vector level: nothing was compared");
}

/// A boat somewhere in a view, an eighth to two thirds of the picture wide.
fn random_view(index: u64, sea: &Sea) -> Snapshot {
    let sample = |stream: u64, low: f64, high: f64| low + (high - low) * noise::unit(42, stream, index);
    let (range, down) = (sample(1, 1.6, 3.4), sample(2, 15.0, 80.0_f64).to_radians());
    let pan = sample(3, -180.0, 180.0_f64).to_radians();
    let (x, y) = (sample(4, -50.0, 50.0), sample(5, -50.0, 50.0));
    let tick = 37 * index;
    let level = range * libm::cos(down);
    let viewpoint = at(x - level * libm::sin(pan), y - level * libm::cos(pan), range * libm::sin(down));
    let camera = CameraPose {
        position: viewpoint,
        pan: Angle::from_radians(pan + sample(6, -0.15, 0.15)),
        tilt: Angle::from_radians(-down + sample(7, -0.1, 0.1)),
        roll: degrees(sample(8, -8.0, 8.0)),
    };
    let mut pose = pose_at(at(x, y, sea.surface_at(x, y, tick).elevation), sample(9, 0.0, 360.0));
    (pose.pitch, pose.roll) = (degrees(sample(10, -6.0, 6.0)), degrees(sample(11, -6.0, 6.0)));
    let (jx, jy) = (x + sample(12, -0.9, 0.9), y + sample(13, -0.9, 0.9));
    let jacket = pose_at(at(jx, jy, sea.surface_at(jx, jy, tick).elevation), sample(14, 0.0, 360.0));
    Snapshot {
        tick,
        first_row: camera,
        last_row: CameraPose {
            pan: Angle::from_radians(camera.pan.radians() + sample(15, -0.01, 0.01)),
            ..camera
        },
        zoom: 1.0,
        light: Light { sun_bearing: degrees(80.0), sun_elevation: degrees(50.0), overcast: 0.5 },
        ground: Ground::Water,
        target: boat(pose, 0.0),
        objects: vec![SceneObject { kind: ObjectKind::LifeJacket, pose: jacket, seed: 1 }],
        sensor: SensorState { exposure: 1.0, red: 1.0, blue: 1.0, exposure_s: 0.0 },
    }
}

/// The same view without its target, which is moved far below the camera.
fn without_target(view: &Snapshot) -> Snapshot {
    let mut alone = view.clone();
    if let Target::Boat(boat) = &mut alone.target {
        boat.pose.position.z = -5_000.0;
    }
    alone
}

/// Difference of each pixel between two pictures, summed over Y, U and V.
fn differences(a: &Picture, b: &Picture) -> Vec<u32> {
    let (width, height) = (a.size().width as usize, a.size().height as usize);
    let apart = |a: u8, b: u8| u32::from(a.abs_diff(b));
    let at = |row: usize, column: usize| {
        apart(a.y().row(row)[column], b.y().row(row)[column])
            + apart(a.u().row(row / 2)[column / 2], b.u().row(row / 2)[column / 2])
            + apart(a.v().row(row / 2)[column / 2], b.v().row(row / 2)[column / 2])
    };
    (0..width * height).map(|i| at(i / width, i % width)).collect()
}

/// Whether a pixel changed, and by enough compared with its neighbours to be more than half covered.
fn changed(differences: &[u32], width: usize, column: usize, row: usize) -> bool {
    let here = differences[row * width + column];
    let height = differences.len() / width;
    let around = (row.saturating_sub(1)..(row + 2).min(height))
        .flat_map(|r| &differences[r * width + column.saturating_sub(1)..r * width + (column + 2).min(width)])
        .max();
    here > MIN_CHANGE && (here > SURE_CHANGE || around.is_some_and(|around| 2 * here > *around))
}

/// Least change of a pixel, and change from which it belongs to the target in any case, levels.
const MIN_CHANGE: u32 = 10;
const SURE_CHANGE: u32 = 28;
/// Fine pixels along each side of a pixel.
const FINER: usize = 3;

/// The mask marks the pixels that the target covers by half. Pictures three times as fine, with the target
/// and without, show whether that is so: at least half of the fine pixels must have changed. Returns the IoU
/// of mask and changed pixels over all views.
fn overlap(views: u64) -> f64 {
    let sea = sea(1);
    let size = PictureSize::new(224, 168);
    let fine = PictureSize::new(size.width * FINER as u32, size.height * FINER as u32);
    let plain = |size| RenderSettings { effects: Effects::NONE, ..settings(size, sea.clone()) };
    let mut renderer = Renderer::new(plain(size));
    let mut finer = Renderer::new(plain(fine));
    let [mut picture, mut with, mut without] = [size, fine, fine].map(|size| Picture::black(size, ENCODING));
    let (mut both, mut either) = (0, 0);
    for index in 0..views {
        let view = random_view(index, &sea);
        let truth = renderer.render(&view, &mut picture, &Serial).clone();
        finer.render(&view, &mut with, &TwoThreads);
        finer.render(&without_target(&view), &mut without, &TwoThreads);
        let apart = differences(&with, &without);
        for row in 0..size.height as usize {
            for column in 0..size.width as usize {
                let count = (0..FINER * FINER)
                    .filter(|k| {
                        let (c, r) = (FINER * column + k % FINER, FINER * row + k / FINER);
                        changed(&apart, fine.width as usize, c, r)
                    })
                    .count();
                let (a, b) = (truth.mask.at(column, row), 2 * count >= FINER * FINER);
                both += usize::from(a && b);
                either += usize::from(a || b);
            }
        }
    }
    f64::from(both as u32) / f64::from(either as u32)
}

#[test]
fn the_mask_is_what_changes_when_the_target_is_taken_away() {
    let found = overlap(200);
    // The rest is mostly the black grab line on dark water, which the comparison cannot find.
    assert!(found >= 0.98, "overlap {found:.4}");
}

#[test]
fn the_waterline_s_middle_is_where_an_independent_projection_has_it() {
    let sea = sea(2);
    let mut renderer = Renderer::new(RenderSettings {
        effects: Effects::NONE,
        ..settings(PictureSize::new(64, 48), sea.clone())
    });
    let mut picture = Picture::black(PictureSize::new(64, 48), ENCODING);
    for index in 0..40 {
        let mut view = random_view(index, &sea);
        view.last_row = view.first_row;
        let truth: RenderedTruth = renderer.render(&view, &mut picture, &Serial).clone();
        let camera = view.first_row;
        let target = view.target.position();
        // Turn the world by pan about z, then tilt about the picture's right, then roll about the line of
        // sight.
        let (dx, dy, dz) =
            (target.x - camera.position.x, target.y - camera.position.y, target.z - camera.position.z);
        let (sp, cp) = libm::sincos(camera.pan.radians());
        let (right, forward) = (dx * cp - dy * sp, dx * sp + dy * cp);
        let (st, ct) = libm::sincos(camera.tilt.radians());
        let (ahead, up) = (forward * ct + dz * st, dz * ct - forward * st);
        let (sr, cr) = libm::sincos(camera.roll.radians());
        let (x, y) = ((right * cr - up * sr) / ahead, (-right * sr - up * cr) / ahead);
        // Undo r_pinhole = r (1 + k r^2) by bisection.
        let pinhole = (x * x + y * y).sqrt();
        let (mut low, mut high) = (0.0, pinhole);
        for _ in 0..60 {
            let middle = 0.5 * (low + high);
            if middle * (1.0 + 0.08 * middle * middle) > pinhole { high = middle } else { low = middle }
        }
        let scale = 0.8 * 64.0 * low / pinhole;
        let (u, v) = (32.0 + scale * x, 24.0 + scale * y);
        let seen = truth.waterline.unwrap();
        assert!(libm::hypot(seen.u - u, seen.v - v) < 0.5, "view {index}: {seen:?}, wanted ({u}, {v})");
        assert!((truth.range_m - (dx * dx + dy * dy + dz * dz).sqrt()).abs() < 1e-9);
    }
}

#[test]
fn a_target_behind_the_camera_is_not_in_the_truth() {
    let sea = sea(0);
    let mut renderer = Renderer::new(settings(SIZE, sea.clone()));
    let mut view = snapshot(Scene::Arena, &sea, 0);
    view.target = boat(pose_at(at(0.0, -20.0, 0.0), 0.0), 0.0);
    let mut picture = Picture::black(SIZE, ENCODING);
    let truth = renderer.render(&view, &mut picture, &Serial);
    assert_eq!((truth.bounds, truth.waterline, truth.heading), (None, None, None));
    assert_eq!((truth.visible_share, truth.mask.count()), (0.0, 0));
}

#[test]
fn a_boat_in_full_view_is_wholly_visible_and_heads_where_it_goes() {
    let sea = sea(0);
    let mut renderer = Renderer::new(settings(SIZE, sea.clone()));
    let mut picture = Picture::black(SIZE, ENCODING);
    for (heading, seen) in [(0.0, 0.0), (90.0, 90.0), (180.0, 180.0), (270.0, 270.0)] {
        let mut view = snapshot(Scene::Arena, &sea, 0);
        view.objects.clear();
        view.first_row.roll = Angle::ZERO;
        view.last_row = view.first_row;
        view.target = boat(pose_at(at(0.0, 9.0, 0.0), heading), 0.0);
        let truth = renderer.render(&view, &mut picture, &Serial);
        assert!(truth.visible_share > 0.93, "{heading}: {} visible", truth.visible_share);
        let apart = (truth.heading.unwrap().degrees() - seen + 180.0).rem_euclid(360.0) - 180.0;
        assert!(apart.abs() < 6.0, "{heading}: seen {apart} degrees off");
    }
}

#[test]
fn the_box_around_the_boat_leaves_mast_and_flag_out() {
    let sea = sea(0);
    let size = PictureSize::new(416, 236);
    let mut renderer = Renderer::new(settings(size, sea.clone()));
    let mut picture = Picture::black(size, ENCODING);
    let mut view = snapshot(Scene::Arena, &sea, 0);
    view.objects.clear();
    view.target = boat(pose_at(at(0.0, 5.0, 0.0), 0.0), 0.0);
    let truth = renderer.render(&view, &mut picture, &Serial);
    let (mask, bounds) = (&truth.mask, truth.bounds.unwrap());
    let rows: Vec<usize> = (mask.top..mask.top + mask.height)
        .filter(|row| (mask.left..mask.left + mask.width).any(|column| mask.at(column, *row)))
        .collect();
    let (top, bottom) = (*rows.first().unwrap() as f64, (rows.last().unwrap() + 1) as f64);
    assert!(bounds.v > top + 2.0, "{bounds}: the flag in row {top} is in the mask, not in the box");
    assert!((bounds.v + bounds.h - bottom).abs() < 1.5, "{bounds}: the hull ends in row {bottom}");
    assert!(bounds.w > 2.0 * bounds.h, "{bounds}: a hull seen from its side");
}

#[test]
fn a_frame_allocates_nothing_after_the_first_ones() {
    for (scene, state) in [(Scene::Pier, 2), (Scene::Floor, 0)] {
        let sea = sea(state);
        let mut renderer = Renderer::new(settings(SIZE, sea.clone()));
        let mut picture = Picture::black(SIZE, ENCODING);
        let views: Vec<Snapshot> = (0..6).map(|frame| snapshot(scene, &sea, frame)).collect();
        let mut render_all = || {
            allocation_counter::measure(|| {
                for view in &views {
                    renderer.render(view, &mut picture, &Serial);
                }
            })
        };
        // Tiles swap their memory with each other: all have theirs after the second frame.
        assert!(render_all().count_total > 0, "the allocator is not counted");
        assert_eq!(render_all().count_total, 0, "{scene:?}");
    }
}
