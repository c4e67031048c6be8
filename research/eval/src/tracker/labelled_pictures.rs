//! Single pictures with a labelled target: frames of the clips, and of generated scenes.

use std::path::Path;

use anyhow::Result;
use barrelman_vocab::video::ColourEncoding;
use barrelman_vocab::{Picture, PixelBox};
use barrelman_water_scene::{SceneKind, SceneScript, WaterScene};

use super::clip_sets::{TUNED_ON, UNSEEN, hidden_frames};
use super::clips::{Clip, ClipFolder, list_clips};
use super::scoring::Label;
use super::synthetic_scenes::{SIZE, paint_name, paint_of_scene};
use crate::workspace::workspace_root;

/// Number of the generated scenes.
pub(super) const SCENES: u64 = 8;
/// Their length, seconds, and the lengths of their boats, pixels.
const SCENE_S: f64 = 10.0;
const BOATS_PX: [f64; 4] = [20.0, 45.0, 90.0, 180.0];

/// The clips of a folder, or else of all, with these names.
///
/// # Errors
/// If a folder cannot be read, or has no clip of a name.
pub(crate) fn chosen_clips(folder: Option<&Path>, names: &[String]) -> Result<Vec<ClipFolder>> {
    let folders = match folder {
        Some(folder) => vec![folder.to_owned()],
        None => {
            let data = workspace_root()?.join("../shared/data");
            vec![data.join(TUNED_ON), data.join(UNSEEN)]
        }
    };
    list_clips(&folders, names)
}

/// So many labelled frames of a clip, evenly spread, with the label.
pub(crate) fn labelled_pictures(clip: &Clip, frames: usize) -> impl Iterator<Item = (&Picture, PixelBox)> {
    let hidden = hidden_frames(&clip.name);
    let labelled: Vec<(usize, PixelBox)> = clip
        .labels
        .iter()
        .enumerate()
        .filter_map(|(frame, label)| match label {
            Some(Label::Visible(bounds)) if !hidden.contains(&frame) => Some((frame, *bounds)),
            _ => None,
        })
        .collect();
    let count = labelled.len().min(frames);
    (0..count).map(move |index| {
        let (frame, label) = labelled[(2 * index + 1) * labelled.len() / (2 * count)];
        (&*clip.frames[frame].picture, label)
    })
}

/// Shows so many frames of a generated scene in which the boat is visible, with its box. Returns the scene's
/// name.
pub(super) fn for_scene_pictures(
    number: u64,
    frames: usize,
    mut show: impl FnMut(&Picture, PixelBox),
) -> String {
    let target = paint_of_scene(number);
    let boat_px = BOATS_PX[number as usize % BOATS_PX.len()];
    let script = SceneScript { kind: SceneKind::Manoeuvre, size: SIZE, boat_px, seconds: SCENE_S, target };
    let mut scene = WaterScene::new(script, number);
    let mut picture = Picture::black(SIZE, ColourEncoding::assumed_for(SIZE));
    for index in 0..frames as u64 {
        let truth = scene.render(index * scene.frames() / frames as u64, &mut picture);
        if !truth.bounds.is_empty() {
            show(&picture, truth.bounds);
        }
    }
    format!("scene {number}, {} boat of {boat_px} px", paint_name(target))
}
