//! Generated clips: boats that manoeuvre on rough water under a moving camera, and rendered views of lakes,
//! the sea and a shore.

use std::sync::Arc;

use anyhow::Result;
use barrelman_vocab::video::{Capture, CaptureQuality, ColourEncoding};
use barrelman_vocab::{Picture, PixelBox, Timestamp, VideoFrame};
use barrelman_water_scene::{SceneKind, SceneScript, WaterScene};

use crate::tracker::clips::Clip;
use crate::tracker::scoring::Label;
use crate::tracker::synthetic_scenes::{SIZE, paint_name, paint_of_scene};
use crate::views::render_sequence;

/// Seeds of the scenes on water, which no other part uses, and the length of their hulls, pixels.
const SCENES: [(u64, f64); 6] =
    [(1000, 40.0), (1001, 80.0), (1002, 140.0), (1003, 40.0), (1004, 80.0), (1005, 140.0)];
const SCENE_S: f64 = 4.0;

/// The rendered views: lakes and seas from near and far, glint, clouds, and a pier, a shore and the sky.
const VIEWS: [&str; 6] = [
    "1_lake_10m_p30",
    "2_sea_20m_p45",
    "4_low_3m_p8_pier",
    "5_glint_12m_p25",
    "6_overcast_30m_p60",
    "8_sea_6m_p15",
];
const VIEW_S: f64 = 4.0;

/// A clip that is generated.
#[derive(Debug, Clone, Copy)]
pub(super) enum GeneratedClip {
    /// A scene on water.
    Scene { seed: u64, boat_px: f64 },
    /// A rendered view.
    View(&'static str),
}

/// All generated clips.
pub(super) fn generated_clips() -> Vec<GeneratedClip> {
    let scenes = SCENES.into_iter().map(|(seed, boat_px)| GeneratedClip::Scene { seed, boat_px });
    scenes.chain(VIEWS.into_iter().map(GeneratedClip::View)).collect()
}

impl GeneratedClip {
    /// Renders the clip. Every frame is labelled.
    ///
    /// # Errors
    /// If there is no view of the name, or the target is visible in no frame.
    pub(super) fn render(self) -> Result<Clip> {
        match self {
            Self::Scene { seed, boat_px } => render_scene(seed, boat_px),
            Self::View(name) => render_view(name),
        }
    }
}

fn render_scene(seed: u64, boat_px: f64) -> Result<Clip> {
    let target = paint_of_scene(seed);
    let script = SceneScript { kind: SceneKind::Manoeuvre, size: SIZE, boat_px, seconds: SCENE_S, target };
    let mut scene = WaterScene::new(script, seed);
    let frames = (0..scene.frames()).map(|index| {
        let mut picture = Picture::black(SIZE, ColourEncoding::assumed_for(SIZE));
        let truth = scene.render(index, &mut picture);
        (truth.time_s, Arc::new(picture), Some(truth.bounds))
    });
    let name = format!("generated {seed}: {}, {boat_px} px", paint_name(target));
    clip(name, frames)
}

fn render_view(name: &str) -> Result<Clip> {
    let frames = render_sequence(name, SIZE, VIEW_S)?;
    let frames = frames.into_iter().map(|frame| (frame.time_s, frame.picture, frame.bounds));
    clip(format!("view {name}"), frames)
}

/// A clip of frames, each with its time in seconds, its picture and the target's box.
fn clip(name: String, frames: impl Iterator<Item = (f64, Arc<Picture>, Option<PixelBox>)>) -> Result<Clip> {
    let (mut video, mut labels) = (Vec::new(), Vec::new());
    for ((time_s, picture, bounds), sequence) in frames.zip(0..) {
        let capture = Capture { at: Timestamp::from_secs_f64(time_s), quality: CaptureQuality::Sensor };
        video.push(VideoFrame { sequence, capture, picture });
        let visible = bounds.filter(|bounds| !bounds.is_empty());
        labels.push(Some(visible.map_or(Label::Absent, Label::Visible)));
    }
    Clip::new(name, video, labels)
}
