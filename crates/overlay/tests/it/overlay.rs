//! Scenes drawn on copies of frames.

use std::ops::Range;
use std::sync::Arc;

use barrelman_control::{MotorSchema, Percept, Region, Sector};
use barrelman_overlay::{Overlay, Scene};
use barrelman_pilot::{Advice, Mode};
use barrelman_sim::practice::PracticeClip;
use barrelman_vision::{Explanation, GreyMap, TrackerState};
use barrelman_vocab::track::Shape;
use barrelman_vocab::video::{Capture, CaptureQuality, ColourEncoding, ColourMatrix, SampleRange};
use barrelman_vocab::{
    Angle, AngularRate, CameraCommand, HoldCause, ImagePoint, Localisation, Picture, PictureSize, PixelBox,
    PixelPoint, StopCause, Timestamp, Track, VehicleProfile, VideoFrame,
};

const HD: PictureSize = PictureSize::new(1280, 720);

fn framed(picture: Picture) -> VideoFrame {
    let capture = Capture { at: Timestamp::from_secs_f64(4.2), quality: CaptureQuality::Sensor };
    VideoFrame { sequence: 126, capture, picture: Arc::new(picture) }
}

/// A uniformly grey frame, on which all drawing is visible.
fn grey(size: PictureSize, colour: ColourEncoding) -> VideoFrame {
    let mut picture = Picture::black(size, colour);
    picture.planes_mut()[0].fill(90);
    framed(picture)
}

fn region_of(size: PictureSize) -> Region {
    Region::from_shares(VehicleProfile::fotokite_pro().region, size)
}

/// A target of a tenth of the picture's size. Its centre is given in image coordinates as shares of half the
/// picture.
fn target_at(size: PictureSize, x: f64, y: f64) -> Localisation {
    let (width, height) = (f64::from(size.width), f64::from(size.height));
    let centre = ImagePoint { x: x * width / 2.0, y: y * height / 2.0 }.in_pixels(size);
    let (w, h) = (width / 10.0, height / 10.0);
    Localisation {
        captured: Timestamp::from_secs_f64(4.2),
        picture: size,
        centre,
        bounds: PixelBox { u: centre.u - w / 2.0, v: centre.v - h / 2.0, w, h }.clipped(size),
        shape: Some(Shape { major_px: w, minor_px: h / 2.0, axis: Angle::from_degrees(20.0) }),
        heading: Some(Angle::from_degrees(200.0)),
        confidence: 0.8,
    }
}

fn explanation_of(size: PictureSize) -> Explanation {
    let bounds = PixelBox { u: 0.0, v: 0.0, w: 8.0, h: 6.0 };
    Explanation {
        search_window: Some(target_at(size, 0.2, 0.2).bounds),
        back_projection: GreyMap { bounds, width: 8, height: 6, samples: (0..48).map(|n| n * 5).collect() },
        histogram: (0..32).map(|bin| bin * 8).collect(),
        ..Explanation::default()
    }
}

/// The explanation of the fused tracker: maps coarser than the picture, and a state.
fn fused_explanation_of(size: PictureSize, state: TrackerState, confidence: f64) -> Explanation {
    let window = PixelBox { u: -9.0, v: 12.0, w: 64.0, h: 64.0 };
    let map = |side: usize| GreyMap {
        bounds: window,
        width: side,
        height: side,
        samples: (0..side * side).map(|index| (index % 251) as u8).collect(),
    };
    Explanation {
        back_projection: map(16),
        response: map(32),
        histogram: Vec::new(),
        state: Some(state),
        confidence,
        ..explanation_of(size)
    }
}

/// The scene of a pilot in this mode, with all elements.
fn scene_of<'a>(
    size: PictureSize,
    track: &'a Track,
    mode: Option<Mode>,
    explanation: Option<&'a Explanation>,
) -> Scene<'a> {
    let profile = VehicleProfile::fotokite_pro();
    let region = region_of(size);
    let percept = track.localisation().map(|seen| Percept::new(seen.centre.in_image(size), region));
    let advice = percept.map(|percept| Advice {
        command: MotorSchema::new(profile.motor_schema_rates).command(&percept),
        sector: MotorSchema::is_released(&percept).then(|| Sector::from_point(percept.position)),
    });
    let servoing = mode == Some(Mode::Servoing);
    let command = advice.filter(|_| servoing).map_or(CameraCommand::REST, |advice| advice.command);
    Scene {
        percept,
        advice,
        command,
        rates: mode.map(|_| profile.to_vehicle(command)),
        mode,
        link: Some("up"),
        explanation,
        ..Scene::from_track(track, region)
    }
}

fn drawn(frame: &VideoFrame, scene: &Scene<'_>) -> Picture {
    let mut out = Picture::black(PictureSize::new(1, 1), ColourEncoding::JPEG);
    Overlay::new().draw(frame, scene, &mut out);
    out
}

fn tracks(size: PictureSize) -> Vec<Track> {
    let placement = [(0.0, 0.0), (0.1, 0.05), (0.9, 0.1), (0.0, 0.95), (-0.95, 0.0), (0.1, -0.9), (1.0, 1.0)];
    let mut tracks: Vec<Track> =
        placement.iter().map(|place| Track::Tracking(target_at(size, place.0, place.1))).collect();
    tracks.push(Track::Coasting(target_at(size, -0.7, -0.6)));
    tracks.push(Track::Lost { since: Timestamp::from_secs_f64(1.9), confidence: 0.1 });
    tracks.push(Track::Unseeded);
    tracks
}

const MODES: [Option<Mode>; 6] = [
    None,
    Some(Mode::Idle),
    Some(Mode::Servoing),
    Some(Mode::Holding(HoldCause::Coasting)),
    Some(Mode::Holding(HoldCause::TrackLost)),
    Some(Mode::Stopped(StopCause::Operator)),
];

#[test]
fn the_frame_itself_keeps_its_samples() {
    let clip = PracticeClip::new(HD, 5);
    let mut picture = Picture::black(HD, clip.colour());
    clip.render(100, &mut picture);
    let untouched = picture.clone();
    let frame = framed(picture);
    let track = Track::Tracking(target_at(HD, 0.8, 0.1));
    let out = drawn(&frame, &scene_of(HD, &track, Some(Mode::Servoing), None));
    assert_eq!(*frame.picture, untouched);
    assert_ne!(out, untouched);
    assert_eq!((out.size(), out.colour()), (untouched.size(), untouched.colour()));
}

#[test]
fn samples_far_from_anything_drawn_keep_their_bits() {
    let clip = PracticeClip::new(HD, 5);
    let mut picture = Picture::black(HD, clip.colour());
    clip.render(100, &mut picture);
    let frame = framed(picture);
    // The target is in the right half of the region: the left half holds no line and no label.
    let track = Track::Tracking(target_at(HD, 0.3, -0.1));
    let out = drawn(&frame, &scene_of(HD, &track, Some(Mode::Idle), None));
    let same = |v: usize, u: core::ops::Range<usize>| {
        let halved = u.start / 2..u.end / 2;
        out.y().row(v)[u.clone()] == frame.picture.y().row(v)[u]
            && out.u().row(v / 2)[halved.clone()] == frame.picture.u().row(v / 2)[halved.clone()]
            && out.v().row(v / 2)[halved.clone()] == frame.picture.v().row(v / 2)[halved]
    };
    for v in 300..420 {
        assert!(same(v, 300..540), "within the region, line {v}");
        assert!(same(v, 10..240), "left of the region, line {v}");
    }
}

#[test]
fn another_frame_shows_nothing_of_the_one_before() {
    let frame = grey(HD, ColourEncoding::JPEG);
    let (first, then) =
        (Track::Tracking(target_at(HD, 0.8, 0.1)), Track::Lost { since: Timestamp::ZERO, confidence: 0.0 });
    let (first, then) =
        (scene_of(HD, &first, Some(Mode::Servoing), None), scene_of(HD, &then, Some(Mode::Idle), None));
    let (mut overlay, mut out) = (Overlay::new(), Picture::black(HD, ColourEncoding::JPEG));
    overlay.draw(&frame, &first, &mut out);
    overlay.draw(&frame, &then, &mut out);
    assert_eq!(out, drawn(&frame, &then));
}

#[test]
fn the_ellipse_passes_where_p_is_one() {
    let frame = grey(HD, ColourEncoding::JPEG);
    let track = Track::Unseeded;
    let out = drawn(&frame, &scene_of(HD, &track, None, None));
    let region = region_of(HD);
    for step in 0..72 {
        // Between the diagonals and off the axes' ends, at places that only the ellipse passes.
        let parameter = f64::from(step) * core::f64::consts::TAU / 72.0;
        let point =
            ImagePoint { x: region.a_px * libm::cos(parameter), y: region.b_px * libm::sin(parameter) };
        assert!((region.p(point) - 1.0).abs() < 1e-9);
        let luma_at = |share: f64| {
            let at = ImagePoint { x: point.x * share, y: point.y * share }.in_pixels(HD);
            out.y().row(at.v as usize)[at.u as usize]
        };
        assert!(luma_at(1.0) > 150, "no line at {point:?}: {}", luma_at(1.0));
        assert_eq!(luma_at(0.93), 90, "something within the region at {point:?}");
    }
}

#[test]
fn the_target_is_covered_by_no_strip_panel_arrow_or_label() {
    let frame = grey(HD, ColourEncoding::JPEG);
    let explanation = Explanation { search_window: None, ..explanation_of(HD) };
    for (x, y) in
        [(0.0, 0.95), (0.0, -0.95), (0.93, 0.9), (-0.93, -0.9), (0.93, 0.0), (0.3, 0.3), (0.05, 0.0)]
    {
        // Without axes and heading, the inner quarter of the box holds only the line to the centre.
        let seen = Localisation { shape: None, heading: None, ..target_at(HD, x, y) };
        let track = Track::Tracking(seen);
        let with = drawn(&frame, &scene_of(HD, &track, Some(Mode::Servoing), Some(&explanation)));
        let dark = |picture: &Picture, at: PixelPoint| picture.y().row(at.v as usize)[at.u as usize] < 60;
        let (mut plates, mut all) = (0, 0);
        for row in 1..20 {
            for column in 1..20 {
                let PixelBox { u, v, w, h } = seen.bounds;
                let at = PixelPoint { u: u + w * f64::from(column) / 20.0, v: v + h * f64::from(row) / 20.0 };
                plates += u32::from(dark(&with, at));
                all += 1;
            }
        }
        // Plates are dark, and so are the thin casings of the line to the target.
        assert!(plates * 10 < all, "{plates} of {all} places in the box are dark at {x}, {y}");
    }
}

#[test]
fn the_encoding_of_the_frame_is_kept() {
    // The accent, red 94, green 234, blue 212, at full opacity on the dot of a tracked target's strip.
    let expected = [
        (ColourMatrix::Bt601, SampleRange::Full),
        (ColourMatrix::Bt601, SampleRange::Limited),
        (ColourMatrix::Bt709, SampleRange::Full),
        (ColourMatrix::Bt709, SampleRange::Limited),
    ];
    for (matrix, range) in expected {
        let colour = ColourEncoding { matrix, range };
        let track = Track::Tracking(target_at(HD, 0.9, 0.0));
        let out = drawn(&grey(HD, colour), &scene_of(HD, &track, Some(Mode::Servoing), None));
        let (kr, kb) = if matrix == ColourMatrix::Bt601 { (0.299, 0.114) } else { (0.2126, 0.0722) };
        let (r, g, b) = (94.0 / 255.0, 234.0 / 255.0, 212.0 / 255.0);
        let luma: f64 = kr * r + (1.0 - kr - kb) * g + kb * b;
        let (pb, pr) = (0.5 * (b - luma) / (1.0 - kb), 0.5 * (r - luma) / (1.0 - kr));
        let wanted = match range {
            SampleRange::Full => [255.0 * luma, 128.0 + 255.0 * pb, 128.0 + 255.0 * pr],
            SampleRange::Limited => [16.0 + 219.0 * luma, 128.0 + 224.0 * pb, 128.0 + 224.0 * pr],
        };
        let wanted = wanted.map(|sample: f64| sample.round() as i32);
        // Somewhere a chroma sample and its four luma samples are all of the accent: in the arrow or the
        // badge.
        let near = |sample: u8, wanted: i32| (i32::from(sample) - wanted).abs() <= 1;
        let found = (0..360).any(|row| {
            (0..640).any(|column| {
                near(out.y().row(row * 2)[column * 2], wanted[0])
                    && near(out.u().row(row)[column], wanted[1])
                    && near(out.v().row(row)[column], wanted[2])
            })
        });
        assert!(found, "no sample of the accent in {colour:?}, {wanted:?}");
    }
}

#[test]
fn every_size_and_state_is_drawn() {
    let sizes = [
        (0, 0),
        (0, 5),
        (1, 1),
        (1, 2),
        (2, 1),
        (3, 3),
        (1, 300),
        (300, 1),
        (17, 31),
        (97, 73),
        (200, 120),
        (321, 181),
        (481, 301),
        (640, 360),
        (301, 641),
    ];
    for (width, height) in sizes {
        let size = PictureSize::new(width, height);
        let frame = grey(size, ColourEncoding::JPEG);
        let explanations = [
            explanation_of(size),
            fused_explanation_of(size, TrackerState::Tracking, 0.8),
            fused_explanation_of(size, TrackerState::Coasting, 0.4),
            fused_explanation_of(size, TrackerState::Lost, 0.0),
            fused_explanation_of(size, TrackerState::Confirming, f64::NAN),
        ];
        let (mut overlay, mut out) = (Overlay::new(), Picture::black(size, ColourEncoding::JPEG));
        for track in tracks(size) {
            for mode in MODES {
                for explanation in [None].into_iter().chain(explanations.iter().map(Some)) {
                    overlay.draw(&frame, &scene_of(size, &track, mode, explanation), &mut out);
                    assert_eq!(out.size(), size);
                }
            }
        }
    }
}

#[test]
fn each_way_that_the_camera_turns_has_its_arrow() {
    let rate = AngularRate::from_radians_per_second;
    for size in [PictureSize::new(480, 270), HD] {
        let frame = grey(size, ColourEncoding::JPEG);
        let track = Track::Tracking(target_at(size, 0.0, 0.05));
        let scene = scene_of(size, &track, Some(Mode::Servoing), None);
        let still = drawn(&frame, &scene);
        for (pan, tilt) in [(0.1, 0.0), (-0.1, 0.0), (0.0, 0.1), (0.0, -0.1), (0.1, -0.1)] {
            let command = CameraCommand::turning(rate(pan), rate(tilt));
            let moving = drawn(&frame, &Scene { command, ..scene_of(size, &track, scene.mode, None) });
            // Differing samples near the right, left, upper and lower edge, without the strip along the
            // lowest rows.
            let (width, height) = (size.width as usize, size.height as usize);
            let near = |rows: Range<usize>, columns: Range<usize>| {
                let [a, b] = [&still, &moving].map(|picture| picture.y());
                let differ =
                    |row: usize| columns.clone().filter(|at| a.row(row)[*at] != b.row(row)[*at]).count();
                rows.map(differ).sum::<usize>()
            };
            let level = height / 3..2 * height / 3;
            let right = near(level.clone(), 4 * width / 5..width);
            let left = near(level, 0..width / 5);
            let top = near(0..height / 4, 0..width);
            let bottom = near(3 * height / 4..height - height / 20, 0..width);
            let arrow = height * height / 1000;
            let shown = [right, left, top, bottom].map(|differing| differing > arrow);
            assert_eq!(shown, [pan > 0.0, pan < 0.0, tilt > 0.0, tilt < 0.0], "{pan} {tilt} at {size}");
        }
    }
}

/// Number of luma samples that differ between two pictures.
fn differing(a: &Picture, b: &Picture) -> usize {
    let size = a.size();
    let rows = 0..size.height as usize;
    rows.map(|row| a.y().row(row).iter().zip(b.y().row(row)).filter(|(a, b)| a != b).count()).sum()
}

#[test]
fn small_and_large_pictures_show_the_maps_the_state_and_the_confidence() {
    for size in [PictureSize::new(320, 180), HD] {
        let frame = grey(size, ColourEncoding::JPEG);
        let track = Track::Tracking(target_at(size, 0.1, 0.1));
        let show =
            |explanation: &Explanation| drawn(&frame, &scene_of(size, &track, None, Some(explanation)));
        let whole = fused_explanation_of(size, TrackerState::Tracking, 0.8);
        let shown = show(&whole);
        let without = |change: fn(&mut Explanation)| {
            let mut changed = whole.clone();
            change(&mut changed);
            differing(&shown, &show(&changed))
        };
        let map_side = f64::from(size.height) * 0.15;
        let map_area = (map_side * map_side) as usize;
        assert!(without(|changed| changed.response.samples.fill(0)) > map_area / 2, "no response at {size}");
        assert!(without(|changed| changed.back_projection.samples.fill(0)) > map_area / 2, "{size}");
        assert!(without(|changed| changed.state = Some(TrackerState::Confirming)) > 20, "no state at {size}");
        assert!(without(|changed| changed.confidence = 0.3) > 20, "no confidence at {size}");
    }
}

#[test]
fn a_coarse_map_is_shown_where_its_bounds_say() {
    let frame = grey(HD, ColourEncoding::JPEG);
    let track = Track::Unseeded;
    let window = PixelBox { u: 100.0, v: 100.0, w: 80.0, h: 80.0 };
    let response = GreyMap { bounds: window, width: 2, height: 2, samples: vec![0; 4] };
    // One sample in the middle of the window, whatever the map's resolution: the pictures are the same.
    let of = |side: usize, bounds: PixelBox, bright: &dyn Fn(usize, usize) -> bool| {
        let sample = |index: usize| if bright(index % side, index / side) { 255 } else { 0 };
        let samples = (0..side * side).map(sample).collect();
        let back_projection = GreyMap { bounds, width: side, height: side, samples };
        let explanation = Explanation { back_projection, response: response.clone(), ..Default::default() };
        drawn(&frame, &scene_of(HD, &track, None, Some(&explanation)))
    };
    let coarse = of(4, window, &|column, row| column == 1 && row == 2);
    let fine = of(8, window, &|column, row| column / 2 == 1 && row / 2 == 2);
    let wide = PixelBox { u: 60.0, v: 60.0, w: 160.0, h: 160.0 };
    let larger = of(8, wide, &|column, row| column == 3 && row == 4);
    assert_eq!(differing(&coarse, &fine), 0);
    assert_eq!(differing(&coarse, &larger), 0);
}

#[test]
fn one_overlay_takes_frames_of_changing_size() {
    let (mut overlay, mut out) = (Overlay::new(), Picture::black(HD, ColourEncoding::JPEG));
    for size in [HD, PictureSize::new(33, 21), PictureSize::new(641, 361), HD] {
        let frame = grey(size, ColourEncoding::JPEG);
        let track = Track::Tracking(target_at(size, 0.8, 0.1));
        let scene = scene_of(size, &track, Some(Mode::Servoing), None);
        overlay.draw(&frame, &scene, &mut out);
        assert_eq!(out, drawn(&frame, &scene));
    }
}

#[test]
fn numbers_that_are_not_finite_leave_things_out() {
    let size = PictureSize::new(640, 360);
    let frame = grey(size, ColourEncoding::JPEG);
    for odd in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, 1e300, -1e300, 0.0] {
        let point = PixelPoint { u: odd, v: odd };
        let bounds = PixelBox { u: odd, v: odd, w: odd, h: odd };
        let shape = Some(Shape { major_px: odd, minor_px: odd, axis: Angle::from_radians(odd) });
        let heading = Some(Angle::from_radians(odd));
        let whole = target_at(size, 0.5, 0.2);
        let seen = [
            Localisation { centre: point, ..whole },
            Localisation { bounds, ..whole },
            Localisation { shape, heading, confidence: odd, ..whole },
            Localisation { picture: PictureSize::new(0, 0), ..whole },
        ];
        for seen in seen {
            let (track, explanation) =
                (Track::Tracking(seen), Explanation { search_window: Some(bounds), ..Default::default() });
            let scene = scene_of(size, &track, Some(Mode::Idle), Some(&explanation));
            drawn(&frame, &scene);
            drawn(&frame, &Scene { region: Region { a_px: odd, b_px: odd }, percept: None, ..scene });
            let position = ImagePoint { x: odd, y: odd };
            drawn(&frame, &Scene { percept: Some(Percept::new(position, scene.region)), ..scene });
        }
    }
}
