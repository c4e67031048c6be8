//! Generated scenes, as video frames with their truth.

use std::sync::Arc;
use std::time::Duration;

use barrelman_sim::water_scene::{SceneScript, SceneTruth, TargetPaint, WaterScene};
use barrelman_vision::Tracker;
use barrelman_vocab::video::{Capture, CaptureQuality, ColourEncoding};
use barrelman_vocab::{MotionPrior, Picture, PictureSize, Timestamp, Track, VideoFrame};

use super::chance::Chance;

/// What the pilot's cameras send.
pub(crate) const SIZE: PictureSize = PictureSize::new(1280, 720);

/// Paints of the scenes, one after the other: mostly the red that the boats of the publication had.
const PAINTS: [TargetPaint; 5] =
    [TargetPaint::Red, TargetPaint::Red, TargetPaint::Orange, TargetPaint::Red, TargetPaint::White];

/// The paint of the scene with this number.
pub(crate) fn paint(number: u64) -> TargetPaint {
    PAINTS[(number % PAINTS.len() as u64) as usize]
}

/// Its name.
pub(crate) const fn name_of(paint: TargetPaint) -> &'static str {
    match paint {
        TargetPaint::Red => "red",
        TargetPaint::Orange => "orange",
        TargetPaint::White => "white",
        TargetPaint::Grey => "grey",
    }
}

/// How well the camera's motion is told where it is told, pixels: the deviation of each of both shifts.
const PRIOR_DEVIATION_PX: f64 = 1.0;

/// A tracker that is shown a scene.
pub(crate) struct Watcher {
    /// The tracker.
    pub(crate) tracker: Box<dyn Tracker>,
    /// Whether it is told how the camera moved, as well as a camera model would know.
    pub(crate) told: bool,
}

/// Shows a tracker a scene, selected by the truth in its first frame, without telling it how the camera moved. What was
/// true of each frame after that, and what the tracker said.
pub(crate) fn watch(tracker: Box<dyn Tracker>, script: SceneScript, seed: u64) -> Vec<(SceneTruth, Track)> {
    watch_together(&mut [Watcher { tracker, told: false }], script, seed).pop().unwrap_or_default()
}

/// The same for some trackers at once: drawing a scene takes longer than watching it.
pub(crate) fn watch_together(
    watchers: &mut [Watcher],
    script: SceneScript,
    seed: u64,
) -> Vec<Vec<(SceneTruth, Track)>> {
    let mut scene = WaterScene::new(script, seed);
    let mut said = vec![Vec::new(); watchers.len()];
    let mut selected = vec![false; watchers.len()];
    // One picture is used again and again where the tracker does not keep it.
    let mut picture = Arc::new(Picture::black(script.size, ColourEncoding::assumed_for(script.size)));
    let mut chance = Chance::named("motion prior", seed);
    let over = Duration::from_secs_f64(1.0 / f64::from(scene.frames_per_second()));
    for index in 0..scene.frames() {
        let truth = scene.render(index, Arc::make_mut(&mut picture));
        let capture = Capture { at: Timestamp::from_secs_f64(truth.time_s), quality: CaptureQuality::Sensor };
        let frame = VideoFrame { sequence: index, capture, picture: Arc::clone(&picture) };
        let prior = MotionPrior {
            shift_u_px: truth.camera_shift.0 + PRIOR_DEVIATION_PX * bell(&mut chance),
            shift_v_px: truth.camera_shift.1 + PRIOR_DEVIATION_PX * bell(&mut chance),
            std_dev_px: PRIOR_DEVIATION_PX,
            interval: over,
        };
        for ((watcher, selected), said) in watchers.iter_mut().zip(&mut selected).zip(&mut said) {
            if index == 0 {
                *selected = watcher.tracker.select(&frame, scene.selection()).is_ok();
                continue;
            }
            let prior = watcher.told.then_some(&prior);
            let track = if *selected { watcher.tracker.track(&frame, prior) } else { Track::Unseeded };
            said.push((truth, track));
        }
    }
    said
}

/// Close to a normal deviate: the sum of twelve uniform ones has variance 1.
fn bell(chance: &mut Chance) -> f64 {
    (0..12).map(|_| chance.between(0.0, 1.0)).sum::<f64>() - 6.0
}
