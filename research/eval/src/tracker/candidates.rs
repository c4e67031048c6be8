//! Candidates: how often the labelled object is among the objects that are found in a single picture, and how many others
//! are.
//!
//! Labelled frames of each clip, evenly spread. *Found*: the box of a candidate has an IoU with the label of at least 0.5.
//! *Place*: a place that stands out lies within the label. *Others*: candidates that do not touch the label; many of them
//! are objects, too (other boats, people, the shore), which have no label.

use std::path::{Path, PathBuf};

use anyhow::Result;
use barrelman_vision::{ObjectSizes, Proposer, Saliency};
use barrelman_vocab::video::ColourEncoding;
use barrelman_vocab::{Picture, PixelBox};
use barrelman_water_scene::{SceneKind, SceneScript, WaterScene};

use super::clip_sets::{TUNED_ON, UNSEEN, hidden_frames, is_on_water};
use super::clips::{Clip, list_clips};
use super::scoring::Label;
use super::synthetic_scenes::{SIZE, paint_name, paint_of_scene};
use crate::output::print_line;
use crate::parallel;
use crate::workspace::workspace_root;

/// Least IoU of a candidate with the label.
const FOUND_IOU: f64 = 0.5;
/// Generated scenes: their number, length and boats.
const SCENES: u64 = 8;
const SCENE_S: f64 = 10.0;
const BOATS_PX: [f64; 4] = [20.0, 45.0, 90.0, 180.0];
/// Largest IoU of two candidates that are counted apart.
const SAME_IOU: f64 = 0.2;

/// What the frames of one clip gave.
#[derive(Debug, Clone, Copy, Default)]
struct Found {
    frames: usize,
    places: usize,
    found: usize,
    others: usize,
}

/// Measures the candidates on the clips of this folder, or else of all.
///
/// # Errors
/// If a clip cannot be used.
pub(super) fn run(folder: Option<&Path>, names: &[String], frames: usize) -> Result<bool> {
    let data = workspace_root()?.join("../shared/data");
    let folders: Vec<PathBuf> =
        folder.map_or_else(|| vec![data.join(TUNED_ON), data.join(UNSEEN)], |folder| vec![folder.to_owned()]);
    let clips = list_clips(&folders, names)?;
    let measured = parallel::map(&clips, |clip| Ok((clip.name.clone(), search_clip(&clip.load()?, frames))));
    let measured = measured.into_iter().collect::<Result<Vec<(String, Found)>>>()?;
    for (name, found) in &measured {
        print_row(name, &[*found]);
    }
    let scenes: Vec<u64> = (0..SCENES).collect();
    for (name, found) in parallel::map(&scenes, |number| search_scene(*number, frames)) {
        print_row(&name, &[found]);
    }
    let of = |is_meant: &dyn Fn(&str) -> bool| -> Vec<Found> {
        measured.iter().filter(|(name, _)| is_meant(name)).map(|(_, found)| *found).collect()
    };
    print_row("on water", &of(&is_on_water));
    print_row("elsewhere", &of(&|name| !is_on_water(name)));
    Ok(true)
}

/// Frames of a generated scene: whatever is found beside the boat is water.
fn search_scene(number: u64, frames: usize) -> (String, Found) {
    let target = paint_of_scene(number);
    let boat_px = BOATS_PX[number as usize % BOATS_PX.len()];
    let script = SceneScript { kind: SceneKind::Manoeuvre, size: SIZE, boat_px, seconds: SCENE_S, target };
    let mut scene = WaterScene::new(script, number);
    let mut picture = Picture::black(SIZE, ColourEncoding::assumed_for(SIZE));
    let (mut found, mut saliency, mut proposer) =
        (Found::default(), Saliency::default(), Proposer::default());
    for index in 0..frames as u64 {
        let truth = scene.render(index * scene.frames() / frames as u64, &mut picture);
        if !truth.bounds.is_empty() {
            found.add(&picture, truth.bounds, &mut saliency, &mut proposer);
        }
    }
    (format!("scene {number}, {} boat of {boat_px} px", paint_name(target)), found)
}

/// The mean shares of some clips.
fn print_row(name: &str, clips: &[Found]) {
    let mean = |count: fn(&Found) -> usize| {
        let shares = clips.iter().map(|found| count(found) as f64 / found.frames.max(1) as f64);
        shares.sum::<f64>() / clips.len().max(1) as f64
    };
    print_line(&format!(
        "{name:<30} {:>5.1} % place  {:>5.1} % found  {:>4.1} others a picture",
        100.0 * mean(|found| found.places),
        100.0 * mean(|found| found.found),
        mean(|found| found.others),
    ));
}

fn search_clip(clip: &Clip, frames: usize) -> Found {
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
    let (mut found, mut saliency, mut proposer) =
        (Found::default(), Saliency::default(), Proposer::default());
    for index in 0..count {
        let (frame, label) = labelled[(2 * index + 1) * labelled.len() / (2 * count)];
        found.add(&clip.frames[frame].picture, label, &mut saliency, &mut proposer);
    }
    found
}

impl Found {
    fn add(&mut self, picture: &Picture, label: PixelBox, saliency: &mut Saliency, proposer: &mut Proposer) {
        let sizes = ObjectSizes::in_picture_of_height(picture.size().height);
        let mut boxes: Vec<PixelBox> = Vec::new();
        let mut is_placed = false;
        for place in saliency.places(picture) {
            is_placed |= label.contains(place);
            if let Ok(proposed) = proposer.propose(picture, place, sizes)
                && boxes.iter().all(|other| other.iou(proposed.bounds) <= SAME_IOU)
            {
                boxes.push(proposed.bounds);
            }
        }
        self.frames += 1;
        self.places += usize::from(is_placed);
        self.found += usize::from(boxes.iter().any(|bounds| bounds.iou(label) >= FOUND_IOU));
        self.others += boxes.iter().filter(|bounds| bounds.iou(label) == 0.0).count();
    }
}
