//! Trackers on generated scenes, with the truth of each frame.

use std::sync::Arc;
use std::time::Duration;

use barrelman_vision::Tracker;
use barrelman_vocab::video::{Capture, CaptureQuality, ColourEncoding};
use barrelman_vocab::{MotionPrior, Picture, PictureSize, Timestamp, Track, VideoFrame};
use barrelman_water_scene::{SceneScript, SceneTruth, TargetPaint, WaterScene};

use crate::rng_of_name::rng_of_name;

/// Size of the pictures: that of the vehicles' cameras.
pub(crate) const SIZE: PictureSize = PictureSize::new(1280, 720);

/// Paints of consecutive scenes: mostly red, like the boats of the publication.
const PAINTS: [TargetPaint; 5] =
    [TargetPaint::Red, TargetPaint::Red, TargetPaint::Orange, TargetPaint::Red, TargetPaint::White];

/// The paint of the scene with this number.
pub(crate) fn paint_of_scene(number: u64) -> TargetPaint {
    PAINTS[(number % PAINTS.len() as u64) as usize]
}

/// The name of a paint.
pub(crate) const fn paint_name(paint: TargetPaint) -> &'static str {
    match paint {
        TargetPaint::Red => "red",
        TargetPaint::Orange => "orange",
        TargetPaint::White => "white",
        TargetPaint::Grey => "grey",
    }
}

/// Standard deviation of each of the motion prior's shifts, pixels.
const PRIOR_STD_DEV_PX: f64 = 1.0;

/// A tracker on a scene.
pub(crate) struct SceneTracker {
    pub(crate) tracker: Box<dyn Tracker>,
    /// Whether the tracker gets a motion prior, as exact as a camera model's.
    pub(crate) has_motion_prior: bool,
}

/// Runs a tracker over a scene without a motion prior. The truth selects the target in the first frame.
/// Returns truth and track of each later frame.
pub(crate) fn run_on_scene(
    tracker: Box<dyn Tracker>,
    script: SceneScript,
    seed: u64,
) -> Vec<(SceneTruth, Track)> {
    let mut trackers = [SceneTracker { tracker, has_motion_prior: false }];
    run_all_on_scene(&mut trackers, script, seed).pop().unwrap_or_default()
}

/// Runs several trackers over a scene at once, as [`run_on_scene`]: rendering a scene takes longer than
/// tracking in it.
pub(crate) fn run_all_on_scene(
    trackers: &mut [SceneTracker],
    script: SceneScript,
    seed: u64,
) -> Vec<Vec<(SceneTruth, Track)>> {
    let mut scene = WaterScene::new(script, seed);
    let mut results = vec![Vec::new(); trackers.len()];
    let mut selected = vec![false; trackers.len()];
    // The picture is reused unless a tracker keeps it.
    let mut picture = Arc::new(Picture::black(script.size, ColourEncoding::assumed_for(script.size)));
    let mut rng = rng_of_name("motion prior", seed);
    let frame_interval = Duration::from_secs_f64(1.0 / f64::from(scene.frames_per_second()));
    for index in 0..scene.frames() {
        let truth = scene.render(index, Arc::make_mut(&mut picture));
        let capture = Capture { at: Timestamp::from_secs_f64(truth.time_s), quality: CaptureQuality::Sensor };
        let frame = VideoFrame { sequence: index, capture, picture: Arc::clone(&picture) };
        let prior = MotionPrior {
            shift_u_px: truth.camera_shift.0 + PRIOR_STD_DEV_PX * rng.approximately_normal(),
            shift_v_px: truth.camera_shift.1 + PRIOR_STD_DEV_PX * rng.approximately_normal(),
            scale: 1.0,
            std_dev_px: PRIOR_STD_DEV_PX,
            interval: frame_interval,
        };
        for ((scene_tracker, selected), results) in trackers.iter_mut().zip(&mut selected).zip(&mut results) {
            let tracker = &mut scene_tracker.tracker;
            if index == 0 {
                *selected = tracker.select(&frame, scene.selection()).is_ok();
                continue;
            }
            let prior = scene_tracker.has_motion_prior.then_some(&prior);
            let track = if *selected { tracker.track(&frame, prior) } else { Track::Unseeded };
            results.push((truth, track));
        }
    }
    results
}
