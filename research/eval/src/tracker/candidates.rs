//! Candidates: how often the labelled object is among the objects that are found in a single picture, and how
//! many others are.
//!
//! Labelled frames of each clip, evenly spread. *Found*: the box of a candidate has an IoU with the label of
//! at least 0.5. *Place*: a place that stands out lies within the label. *Others*: candidates that do not
//! touch the label; many of them are objects, too (other boats, people, the shore), which have no label.

use std::path::Path;

use anyhow::Result;
use barrelman_vision::{ObjectSizes, Proposer, Saliency};
use barrelman_vocab::{Picture, PixelBox};

use super::clip_sets::is_on_water;
use super::clips::Clip;
use super::labelled_pictures::{SCENES, chosen_clips, for_scene_pictures, labelled_pictures};
use crate::output::print_line;
use crate::parallel;

/// Least IoU of a candidate with the label.
const FOUND_IOU: f64 = 0.5;
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
    let clips = chosen_clips(folder, names)?;
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
    let (mut found, mut saliency, mut proposer) =
        (Found::default(), Saliency::default(), Proposer::default());
    let name = for_scene_pictures(number, frames, |picture, label| {
        found.add(picture, label, &mut saliency, &mut proposer);
    });
    (name, found)
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
    let (mut found, mut saliency, mut proposer) =
        (Found::default(), Saliency::default(), Proposer::default());
    for (picture, label) in labelled_pictures(clip, frames) {
        found.add(picture, label, &mut saliency, &mut proposer);
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
