//! Samples for fitting the refinement network: what the network reads, beside the labelled box.
//!
//! The tracker runs from many selections of each clip, exact ones and loose ones, so that the samples show
//! the windows that it sees in use, wrong ones among them. Every second frame gives another sample with a box
//! that is moved and scaled at random, from which the network learns to return. Selections of the background
//! have no target: their boxes are never right.
//!
//! A sample is a record of fixed length, little-endian: four integers of 32 bits (frame of the selection,
//! frame, state, kind), 17 numbers of 32 bits (confidence; centre u, v, width and height of the window; width
//! and height of the box; left, top, width and height of the label, 0 where there is none; the same of the
//! reported box; width and height of the picture), the measurements, and the cells in signed bytes of 1/60.
//! `research/training/train_refinement.py` reads them.

use std::path::{Path, PathBuf};

use anyhow::{Context, Result};
use barrelman_vision::{FusedConfig, FusedTracker, RefinementWeights, RefinementWindow, Tracker};
use barrelman_vocab::rng::SplitMix64;
use barrelman_vocab::{PixelBox, Track};
use clap::Args;

use super::backgrounds::draw_selections;
use super::clips::{Clip, ClipFolder, list_clips};
use super::scoring::Label;
use super::tracker_run::confidence;
use crate::output::print_line;
use crate::parallel;
use crate::rng_of_name::rng_of_name;

/// Cells are multiplied by this and rounded to a byte.
const CELL_SCALE: f32 = 60.0;
/// Smallest sides of a label that is selected, pixels.
const MIN_LABEL_PX: f64 = 6.0;
/// Every third selection is exact.
const EXACT_INTERVAL: usize = 3;
/// Range of the sizes of loose selections, of their proportions, and their largest distance, in sides.
const LOOSE_SIZES: (f64, f64) = (0.8, 1.5);
const LOOSE_PROPORTIONS: (f64, f64) = (0.85, 1.18);
const LOOSE_DISTANCE: f64 = 0.2;
/// Standard deviations of the boxes moved at random: logarithm of the size and of the proportions, and place
/// in sizes; and the largest logarithm of the size.
const SIZE_DEVIATION: f64 = 0.35;
const PROPORTIONS_DEVIATION: f64 = 0.2;
const PLACE_DEVIATION: f64 = 0.3;
const MAX_SIZE_LOGARITHM: f64 = 0.8;
/// Frames followed after a selection of the background.
const BACKGROUND_FRAMES: usize = 30;

/// Options of `training-samples`.
#[derive(Debug, Args)]
pub(crate) struct TrainingOptions {
    /// A folder of clips: a folder each with video.mp4, and gt.csv or truth.csv of `barrelman render`
    /// (repeatable).
    #[arg(long, value_name = "DIR", required = true)]
    clips: Vec<PathBuf>,
    /// Write a file NAME.samples for each clip into this folder.
    #[arg(long, value_name = "DIR")]
    output: PathBuf,
    /// Selections of each clip.
    #[arg(long, value_name = "COUNT", default_value_t = 16)]
    selections: usize,
    /// Frames followed after each selection.
    #[arg(long, value_name = "COUNT", default_value_t = 80)]
    frames: usize,
    /// Selections of the background of each clip.
    #[arg(long, value_name = "COUNT", default_value_t = 16)]
    backgrounds: usize,
    /// Seed of the selections; 0 is that of the measured selections of the background.
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u64).range(1..))]
    seed: u64,
    /// Weights of the network that the tracker uses [default: the built-in ones].
    #[arg(long, value_name = "FILE")]
    weights: Option<PathBuf>,
}

/// What a sample rests on.
#[derive(Debug, Clone, Copy)]
enum Kind {
    Loose = 0,
    Exact = 1,
    /// A box that was moved at random.
    Moved = 2,
    Background = 3,
}

/// Writes the samples of all clips.
///
/// # Errors
/// If a clip, the weights or the folder cannot be used.
pub(crate) fn run(options: &TrainingOptions) -> Result<()> {
    std::fs::create_dir_all(&options.output).with_context(|| options.output.display().to_string())?;
    let weights = match &options.weights {
        None => RefinementWeights::built_in(),
        Some(path) => {
            let context = || path.display().to_string();
            let bytes = std::fs::read(path).with_context(context)?;
            RefinementWeights::from_bytes(&bytes).with_context(context)?.into()
        }
    };
    let folders = list_clips(&options.clips, &[])?;
    let build = || FusedTracker::with_weights(FusedConfig::default(), weights.clone());
    let counts = parallel::map(&folders, |folder| write_clip(options, folder, &build));
    let mut total = 0;
    for count in counts {
        total += count?;
    }
    print_line(&format!("{total} samples of {} clips in {}", folders.len(), options.output.display()));
    Ok(())
}

/// Builds a tracker without a selection.
type Build<'a> = &'a (dyn Fn() -> Result<FusedTracker, barrelman_vision::FusedConfigError> + Sync);

/// Writes the samples of one clip; their number.
fn write_clip(options: &TrainingOptions, folder: &ClipFolder, build: Build<'_>) -> Result<usize> {
    let clip = folder.load()?;
    let mut rng = rng_of_name(&clip.name, options.seed);
    let mut samples = Samples::default();
    let is_large = |label: &Option<Label>| matches!(label, Some(Label::Visible(bounds)) if bounds.w >= MIN_LABEL_PX && bounds.h >= MIN_LABEL_PX);
    let labelled: Vec<usize> =
        clip.labels.iter().enumerate().filter(|(_, label)| is_large(label)).map(|(frame, _)| frame).collect();
    // Between sparse labels lie many frames.
    let is_sparse = 2 * clip.labels.iter().flatten().count() < clip.frames.len();
    let frames = if is_sparse { clip.frames.len() } else { options.frames };
    for number in 0..options.selections {
        let place = (number as f64 + rng.uniform()) / options.selections as f64;
        let Some(&start) = labelled.get((place * 0.95 * labelled.len() as f64) as usize) else { continue };
        let Some(Label::Visible(label)) = clip.labels[start] else { continue };
        let (kind, selection) = if number % EXACT_INTERVAL == 0 {
            (Kind::Exact, label)
        } else {
            (Kind::Loose, loose(label, &mut rng))
        };
        let last = (start + frames).min(clip.frames.len() - 1);
        samples.add_run(&clip, build()?, selection, start..=last, kind, &mut rng);
    }
    for background in draw_selections(&clip, options.backgrounds, options.seed) {
        let last = (background.frame + BACKGROUND_FRAMES).min(clip.frames.len() - 1);
        let frames = background.frame..=last;
        samples.add_run(&clip, build()?, background.bounds, frames, Kind::Background, &mut rng);
    }
    write(&options.output, &clip.name, &samples.bytes)?;
    Ok(samples.count)
}

fn write(folder: &Path, name: &str, bytes: &[u8]) -> Result<()> {
    let path = folder.join(format!("{name}.samples"));
    std::fs::write(&path, bytes).with_context(|| format!("{} cannot be written", path.display()))
}

/// A box that is drawn loosely around a label.
fn loose(label: PixelBox, rng: &mut SplitMix64) -> PixelBox {
    let size = rng.between(LOOSE_SIZES.0, LOOSE_SIZES.1);
    let proportions = rng.between(LOOSE_PROPORTIONS.0, LOOSE_PROPORTIONS.1);
    let (w, h) = (label.w * size * proportions, label.h * size / proportions);
    let centre = label.centre();
    let u = centre.u + label.w * rng.between(-LOOSE_DISTANCE, LOOSE_DISTANCE);
    let v = centre.v + label.h * rng.between(-LOOSE_DISTANCE, LOOSE_DISTANCE);
    PixelBox { u: u - w / 2.0, v: v - h / 2.0, w, h }
}

/// Records of samples.
#[derive(Debug, Default)]
struct Samples {
    bytes: Vec<u8>,
    count: usize,
}

impl Samples {
    /// Adds the samples of one selection on the first of these frames.
    fn add_run(
        &mut self,
        clip: &Clip,
        mut tracker: FusedTracker,
        selection: PixelBox,
        frames: core::ops::RangeInclusive<usize>,
        kind: Kind,
        rng: &mut SplitMix64,
    ) {
        let start = *frames.start();
        let Ok(report) = tracker.select(&clip.frames[start], selection) else { return };
        let label = |frame: usize| match kind {
            // No box is right.
            Kind::Background => Some(PixelBox::default()),
            _ => clip.labels[frame].map(|label| match label {
                Label::Visible(bounds) => bounds.clipped(clip.size()),
                Label::Absent => PixelBox::default(),
            }),
        };
        for frame in frames {
            let track = if frame == start {
                Track::Tracking(report.localisation)
            } else {
                tracker.track(&clip.frames[frame], None)
            };
            let Some(label) = label(frame) else { continue };
            let Some(window) = tracker.refinement_window() else { continue };
            self.add(clip, [start, frame], &track, window, label, kind);
            let is_moved = (frame + start).is_multiple_of(2) && !matches!(kind, Kind::Background);
            if is_moved && track.localisation().is_some() {
                let mut deviate = |deviation: f64| rng.approximately_normal() * deviation;
                let size = deviate(SIZE_DEVIATION).clamp(-MAX_SIZE_LOGARITHM, MAX_SIZE_LOGARITHM);
                let proportions = deviate(PROPORTIONS_DEVIATION);
                let shift = (deviate(PLACE_DEVIATION) as f32, deviate(PLACE_DEVIATION) as f32);
                let factors = ((size + proportions).exp() as f32, (size - proportions).exp() as f32);
                tracker.measure_other_window(shift, factors);
                let Some(window) = tracker.refinement_window() else { continue };
                self.add(clip, [start, frame], &track, window, label, Kind::Moved);
            }
        }
    }

    /// Adds one sample.
    fn add(
        &mut self,
        clip: &Clip,
        [start, frame]: [usize; 2],
        track: &Track,
        window: &RefinementWindow,
        label: PixelBox,
        kind: Kind,
    ) {
        let state = match track {
            Track::Unseeded => 0,
            Track::Tracking(_) => 1,
            Track::Coasting(_) => 2,
            Track::Lost { .. } => 3,
        };
        let reported = track.localisation().map(|localisation| localisation.bounds).unwrap_or_default();
        for number in [start as u32, frame as u32, state, kind as u32] {
            self.bytes.extend(number.to_le_bytes());
        }
        let numbers = |bounds: PixelBox| [bounds.u, bounds.v, bounds.w, bounds.h].map(|value| value as f32);
        let size = clip.size();
        let values = [
            &[confidence(track).unwrap_or(0.0) as f32][..],
            &[window.centre.0, window.centre.1, window.sides.0, window.sides.1],
            &[window.box_size.0, window.box_size.1],
            &numbers(label),
            &numbers(reported),
            &[size.width as f32, size.height as f32],
            &window.measurements,
        ];
        for value in values.into_iter().flatten() {
            self.bytes.extend(value.to_le_bytes());
        }
        let byte = |cell: &f32| (cell * CELL_SCALE).clamp(-127.0, 127.0) as i8;
        self.bytes.extend(window.cells.iter().flat_map(|cell| byte(cell).to_le_bytes()));
        self.count += 1;
    }
}

#[cfg(test)]
mod tests {
    use barrelman_vision::{MEASUREMENTS, WINDOW_CHANNELS, WINDOW_SIDE_CELLS};

    use super::*;
    use crate::tracker::test_clip::test_clip;

    #[test]
    fn records_have_the_length_that_the_script_reads() {
        let clip = test_clip();
        let tracker = FusedTracker::new(FusedConfig::default()).unwrap();
        let mut samples = Samples::default();
        let mut rng = rng_of_name("clip", 1);
        samples.add_run(&clip, tracker, clip.selection, clip.start..=clip.start + 10, Kind::Exact, &mut rng);
        let cells = WINDOW_CHANNELS * WINDOW_SIDE_CELLS * WINDOW_SIDE_CELLS;
        let length = 4 * 4 + 4 * 17 + 4 * MEASUREMENTS + cells;
        assert!(samples.count >= 4, "{}", samples.count);
        assert_eq!(samples.bytes.len(), samples.count * length);
    }

    #[test]
    fn loose_boxes_stay_around_the_label() {
        let label = PixelBox { u: 100.0, v: 50.0, w: 40.0, h: 20.0 };
        let mut rng = rng_of_name("label", 3);
        for _ in 0..100 {
            let box_ = loose(label, &mut rng);
            assert!((box_.centre().u - label.centre().u).abs() <= 8.0, "{box_}");
            assert!(box_.w > 0.6 * label.w && box_.w < 1.8 * label.w, "{box_}");
            assert!(box_.iou(label) > 0.2, "{box_}");
        }
    }
}
