//! The test scenes and their truth.

use barrelman_vocab::video::ColourEncoding;
use barrelman_vocab::{Picture, PictureSize, PixelBox};
use barrelman_water_scene::{SceneKind, SceneScript, SceneTruth, TargetPaint, WaterScene};

const HD: PictureSize = PictureSize::new(1280, 720);
const KINDS: [SceneKind; 3] =
    [SceneKind::Manoeuvre, SceneKind::ExitAndReturn, SceneKind::ExitAndReturnWithDistractor];
const PAINTS: [TargetPaint; 3] = [TargetPaint::Red, TargetPaint::Orange, TargetPaint::White];

fn script(kind: SceneKind, boat_px: f64) -> SceneScript {
    SceneScript { kind, size: HD, boat_px, seconds: 45.0, target: TargetPaint::Red }
}

fn blank() -> Picture {
    Picture::black(PictureSize::new(2, 2), ColourEncoding::JPEG)
}

fn truths(scene: &WaterScene) -> Vec<SceneTruth> {
    (0..scene.frames()).map(|frame| scene.truth(frame)).collect()
}

/// Whether a box is empty or lies in a picture, but for rounding.
fn lies_in(bounds: PixelBox, size: PictureSize) -> bool {
    bounds == PixelBox::default() || bounds.clipped(size).iou(bounds) > 1.0 - 1e-9
}

/// Runs of frames in which the boat shows, or does not: (shows, first frame, frames).
fn runs(truths: &[SceneTruth]) -> Vec<(bool, usize, usize)> {
    let mut runs: Vec<(bool, usize, usize)> = Vec::new();
    for (frame, truth) in truths.iter().enumerate() {
        let shows = truth.visible_share > 0.0;
        match runs.last_mut() {
            Some((same, _, frames)) if *same == shows => *frames += 1,
            _ => runs.push((shows, frame, 1)),
        }
    }
    runs
}

/// Boats of several lengths, several seeds of each.
fn scenes(kind: SceneKind) -> impl Iterator<Item = (String, WaterScene)> {
    [20.0, 60.0, 120.0, 200.0].into_iter().flat_map(move |boat_px| {
        (0..2).map(move |seed| {
            (format!("{kind:?}, {boat_px} px, seed {seed}"), WaterScene::new(script(kind, boat_px), seed))
        })
    })
}

#[test]
fn the_same_seed_draws_the_same_bits_in_any_order() {
    let script = SceneScript {
        size: PictureSize::new(320, 180),
        ..script(SceneKind::ExitAndReturnWithDistractor, 40.0)
    };
    let (mut one, mut other) = (WaterScene::new(script, 5), WaterScene::new(script, 5));
    let (mut first, mut second) = (blank(), blank());
    let truth = one.render(70, &mut first);
    other.render(300, &mut second);
    assert_ne!(first, second);
    assert_eq!(other.render(70, &mut second), truth);
    assert_eq!(first, second);
    assert_eq!(other.truth(70), truth);
    WaterScene::new(script, 6).render(70, &mut second);
    assert_ne!(first, second);
}

#[test]
fn a_scene_is_drawn_in_any_size() {
    for (width, height) in [(321, 181), (64, 48), (180, 321), (17, 9), (1, 1), (1921, 1081)] {
        for kind in KINDS {
            let size = PictureSize::new(width, height);
            let mut scene = WaterScene::new(SceneScript { size, seconds: 16.0, ..script(kind, 200.0) }, 2);
            let mut picture = blank();
            let frames = if width > 1000 { 1 } else { 5 };
            for frame in 0..frames {
                let truth = scene.render(frame * 100, &mut picture);
                assert_eq!(picture.size(), size);
                assert!(lies_in(truth.bounds, size), "{size} {kind:?}: {truth:?}");
            }
        }
    }
}

#[test]
fn a_clip_is_as_long_as_asked_and_never_empty() {
    for (seconds, frames) in [(20.0, 600), (0.5, 15), (0.0, 1), (-3.0, 1), (f64::NAN, 1)] {
        let scene = WaterScene::new(SceneScript { seconds, ..script(SceneKind::Manoeuvre, 60.0) }, 1);
        assert_eq!(scene.frames(), frames);
        assert_eq!(scene.frames_per_second(), 30);
        assert_eq!(scene.truth(frames + 50), scene.truth(frames - 1));
    }
}

#[test]
fn the_first_frame_offers_a_boat_to_select() {
    let inner = PixelBox { u: 64.0, v: 36.0, w: 1152.0, h: 648.0 };
    for (name, scene) in KINDS.into_iter().flat_map(scenes) {
        let selection = scene.selection();
        assert_eq!(selection, scene.truth(0).bounds, "{name}");
        assert!(selection.area() > 0.0 && selection.intersection(inner).iou(selection) > 0.999, "{name}");
    }
}

#[test]
fn a_manoeuvring_boat_stays_in_view_turns_and_changes_its_size() {
    for (name, scene) in scenes(SceneKind::Manoeuvre) {
        let truths = truths(&scene);
        assert!(truths.iter().all(|truth| truth.visible_share > 0.999), "{name}");
        let turned: f64 = truths
            .windows(2)
            .map(|pair| wrap_angle(pair[1].heading.degrees() - pair[0].heading.degrees()).abs())
            .sum();
        // A hull that points away from the camera looks shorter: compare hulls across the picture.
        let across = truths.iter().filter(|truth| libm::sin(truth.heading.radians()).abs() < 0.3);
        let lengths: Vec<f64> = across.map(|truth| truth.major_px).collect();
        let longest = lengths.iter().copied().fold(0.0, f64::max);
        let shortest = lengths.iter().copied().fold(f64::INFINITY, f64::min);
        assert!(turned > 180.0 && longest < 2.1 * shortest, "{name}: {turned}, {shortest} to {longest}");
        let is_under_way = truths.iter().filter(|truth| truth.is_under_way).count();
        assert!(is_under_way > truths.len() / 2, "{name}: {is_under_way}");
    }
}

#[test]
fn a_boat_that_leaves_is_gone_for_3_to_8_s_and_back_for_3_s() {
    for kind in [SceneKind::ExitAndReturn, SceneKind::ExitAndReturnWithDistractor] {
        for (name, scene) in scenes(kind) {
            let runs = runs(&truths(&scene));
            assert!(runs.len() >= 5 && runs.len() % 2 == 1, "{name}: {runs:?}");
            for (shows, first, frames) in runs {
                let fits = if shows { frames >= 90 || first == 0 } else { (90..=240).contains(&frames) };
                assert!(fits, "{name}: {frames} frames from {first}, visible: {shows}");
            }
        }
    }
}

#[test]
fn boats_leave_across_every_border_because_they_drive_or_the_camera_pans() {
    let mut borders = [0; 4];
    let (mut drives, mut pans) = (0, 0);
    for seed in 0..10 {
        let truths = truths(&WaterScene::new(script(SceneKind::ExitAndReturn, 60.0), seed));
        for (_, gone, _) in runs(&truths).into_iter().filter(|run| !run.0) {
            let at = truths[gone].centre;
            let beyond = [-at.u, at.u - 1280.0, -at.v, at.v - 720.0];
            let border = (0..4).max_by(|a, b| beyond[*a].total_cmp(&beyond[*b])).unwrap();
            borders[border] += 1;
            // Shift of a resting object in the second before.
            let shifts = truths[gone - 30..gone].iter().map(|truth| truth.camera_shift);
            let (u, v) = shifts.fold((0.0, 0.0), |sum, shift| (sum.0 + shift.0, sum.1 + shift.1));
            if libm::hypot(u, v) > 250.0 { pans += 1 } else { drives += 1 }
        }
    }
    assert!(borders.iter().all(|exits| *exits >= 2), "left, right, top, bottom: {borders:?}");
    assert!(drives >= 5 && pans >= 5, "{drives} drives, {pans} pans");
}

#[test]
fn distractors_are_in_view_while_the_boat_is_not() {
    let (mut absent, mut with_distractor) = (0, 0);
    for (name, scene) in scenes(SceneKind::ExitAndReturnWithDistractor) {
        let truths = truths(&scene);
        let mut here = 0;
        for truth in truths.iter().filter(|truth| truth.visible_share == 0.0) {
            absent += 1;
            here += usize::from(!truth.distractors[0].is_empty());
        }
        assert!(here > 0, "{name}");
        with_distractor += here;
        for truth in truths {
            for distractor in truth.distractors {
                assert!(lies_in(distractor, HD), "{name}: {distractor}");
                // Boxes of slanted objects may overlap where the objects do not.
                assert!(distractor.iou(truth.bounds) < 0.2, "{name} at {} s", truth.time_s);
            }
        }
    }
    assert!(with_distractor * 10 > absent * 8, "{with_distractor} of {absent} frames");
    for (name, scene) in scenes(SceneKind::ExitAndReturn) {
        let none = |truth: &SceneTruth| truth.distractors == [PixelBox::default(); 2];
        assert!(truths(&scene).iter().all(none), "{name}");
    }
}

#[test]
fn the_boat_goes_where_its_bow_points() {
    let mut compared = 0;
    for (name, scene) in KINDS.into_iter().flat_map(scenes) {
        let truths = truths(&scene);
        for pair in truths.windows(2).filter(|pair| pair[1].is_under_way) {
            let (before, now) = (pair[0].centre, pair[1].centre);
            // Near the centre, where the zoom shifts nothing.
            if libm::hypot(now.u - 640.0, now.v - 360.0) > 60.0 {
                continue;
            }
            let du = now.u - before.u - pair[1].camera_shift.0;
            let dv = now.v - before.v - pair[1].camera_shift.1;
            if libm::hypot(du, dv) < 2.0 {
                continue;
            }
            let course = libm::atan2(-dv, du).to_degrees();
            let off = wrap_angle(course - pair[1].heading.degrees()).abs();
            // Waves make the bow yaw by 3 degrees, the squash makes up to 5 of it; the zoom adds 0.3 px,
            // which is 11 degrees of the slowest.
            assert!(off < 16.0, "{name} at {} s: off by {off:.1} degrees", pair[1].time_s);
            compared += 1;
        }
    }
    assert!(compared > 300, "{compared}");
}

/// Degrees in -180..=180.
fn wrap_angle(degrees: f64) -> f64 {
    (degrees + 180.0).rem_euclid(360.0) - 180.0
}

#[test]
fn the_truth_is_what_changes_when_the_boat_is_left_out() {
    for (at, kind) in KINDS.into_iter().cycle().take(12).enumerate() {
        let boat_px = 130.0 + 6.0 * at as f64;
        // Not grey: a grey hull on grey water changes too little.
        let script = SceneScript { target: PAINTS[at % 3], ..script(kind, boat_px) };
        let mut scene = WaterScene::new(script, at as u64);
        let in_view = |frame: &u64| scene.truth(*frame).visible_share > 0.5;
        let frame = (0..scene.frames()).skip(37 * at).find(in_view).unwrap();
        let (mut with, mut without) = (blank(), blank());
        let truth = scene.render(frame, &mut with);
        scene.render_without_target(frame, &mut without);
        let pixels = changed(&with, &without);
        let (seen, told) = (around(&pixels), truth.bounds);
        // The lens blurs edges by up to 1.5 px and motion by a few more; on a thin side that is more than 5
        // %.
        let off = [
            seen.u - told.u,
            seen.v - told.v,
            seen.u + seen.w - told.u - told.w,
            seen.v + seen.h - told.v - told.h,
        ];
        let overlap = seen.iou(told);
        let name = format!("seed {at}, {boat_px} px: {seen} for {told}, overlap {overlap}");
        assert!(off.iter().all(|px| px.abs() < 3.0), "{name}");
        assert!(overlap >= if told.w.min(told.h) < 60.0 { 0.9 } else { 0.95 }, "{name}");
        if truth.visible_share == 1.0 {
            let told = scene.silhouette_axis(frame).degrees();
            let (off, aslant) = (axis(&pixels) - told, truth.heading.degrees() - told);
            // Paint in the colour of the water is missing from the changed pixels.
            assert!(wrap_angle(2.0 * off).abs() < 6.0, "{name}: axis off by {off} degrees");
            assert!(wrap_angle(2.0 * aslant).abs() < 18.0, "{name}: heading off by {aslant} degrees");
        }
    }
}

/// The pixels (u, v) that differ by more than a third of what most of them differ by: up to the middle of the
/// blur.
fn changed(with: &Picture, without: &Picture) -> Vec<(f64, f64)> {
    let size = with.size();
    let (width, height) = (size.width as usize, size.height as usize);
    let apart = |one: u8, other: u8| i32::from(one.abs_diff(other));
    let difference = |at: usize| {
        let (u, v) = (at % width, at / width);
        apart(with.y().row(v)[u], without.y().row(v)[u])
            + apart(with.u().row(v / 2)[u / 2], without.u().row(v / 2)[u / 2])
            + apart(with.v().row(v / 2)[u / 2], without.v().row(v / 2)[u / 2])
    };
    let mut changed: Vec<(i32, usize)> = (0..width * height)
        .map(|at| (difference(at), at))
        .filter(|(difference, _)| *difference > 4)
        .collect();
    changed.sort_unstable();
    let threshold = changed[changed.len() * 3 / 4].0 / 3;
    let strong = changed.into_iter().filter(|(difference, _)| *difference > threshold);
    strong.map(|(_, at)| ((at % width) as f64, (at / width) as f64)).collect()
}

/// The box around pixels.
fn around(pixels: &[(f64, f64)]) -> PixelBox {
    let low = |side: fn(&(f64, f64)) -> f64| pixels.iter().map(side).fold(f64::INFINITY, f64::min);
    let high = |side: fn(&(f64, f64)) -> f64| pixels.iter().map(side).fold(0.0, f64::max) + 1.0;
    let (u, v) = (low(|pixel| pixel.0), low(|pixel| pixel.1));
    PixelBox { u, v, w: high(|pixel| pixel.0) - u, h: high(|pixel| pixel.1) - v }
}

/// The principal axis of pixels, degrees anticlockwise from image right.
fn axis(pixels: &[(f64, f64)]) -> f64 {
    let count = pixels.len() as f64;
    let mean_u = pixels.iter().map(|pixel| pixel.0).sum::<f64>() / count;
    let mean_v = pixels.iter().map(|pixel| pixel.1).sum::<f64>() / count;
    let moment = |part: fn(f64, f64) -> f64| -> f64 {
        pixels.iter().map(|pixel| part(pixel.0 - mean_u, mean_v - pixel.1)).sum()
    };
    let (xx, yy, xy) = (moment(|x, _| x * x), moment(|_, y| y * y), moment(|x, y| x * y));
    (0.5 * libm::atan2(2.0 * xy, xx - yy)).to_degrees()
}

#[test]
fn the_water_moves_in_the_picture_as_the_truth_says() {
    for seed in 0..6 {
        let mut scene = WaterScene::new(script(SceneKind::ExitAndReturn, 40.0), seed);
        // The fastest pan of the clip.
        let speed = |truth: &SceneTruth| libm::hypot(truth.camera_shift.0, truth.camera_shift.1);
        let fastest = (1..scene.frames())
            .map(|frame| (frame, speed(&scene.truth(frame))))
            .max_by(|a, b| a.1.total_cmp(&b.1));
        let (frame, px) = fastest.unwrap();
        assert!((10.0..32.0).contains(&px), "{px}");
        let (mut before, mut now) = (blank(), blank());
        scene.render(frame - 1, &mut before);
        let truth = scene.render(frame, &mut now);
        let (u, v) = best_shift(&before, &now, truth.camera_shift);
        // Waves run by 1.5 px from frame to frame, and shifts are tried in whole px.
        let off = libm::hypot(u - truth.camera_shift.0, v - truth.camera_shift.1);
        assert!(off < 2.5, "seed {seed}, frame {frame}: {u}, {v} instead of {:?}", truth.camera_shift);
    }
}

/// The shift of up to 6 px about a guess at which the middles of two pictures differ least.
fn best_shift(before: &Picture, now: &Picture, guess: (f64, f64)) -> (f64, f64) {
    let differs = |du: i32, dv: i32| -> u64 {
        let mut sum = 0;
        for v in (260..460).step_by(2) {
            let (line, shifted) = (now.y().row(v as usize), before.y().row((v - dv) as usize));
            for u in (500..780).step_by(2) {
                sum += u64::from(line[u as usize].abs_diff(shifted[(u - du) as usize]));
            }
        }
        sum
    };
    let about = |guess: f64| (guess.round() as i32 - 6)..=(guess.round() as i32 + 6);
    let shifts = about(guess.0).flat_map(|du| about(guess.1).map(move |dv| (du, dv)));
    let (du, dv) = shifts.min_by_key(|(du, dv)| differs(*du, *dv)).unwrap_or_default();
    (f64::from(du), f64::from(dv))
}
