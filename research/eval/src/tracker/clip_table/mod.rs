//! The table of clips: quality and CPU time of the tracker on labelled real clips.
//!
//! Judged are the means of success AUC, precision and share lost over the clips of each folder and over all
//! clips, the CPU times at 1280x720 and 1920x1080, and, beside OpenCV's trackers, the AUC of each clip and
//! the CPU times.

mod beside_opencv;
mod clip_json;
mod frames_json;
mod judgement;
mod measurement;
mod tables;

use anyhow::Result;
use serde_json::Value;

use super::clip_sets::clip_sets;
use super::opencv::OpencvProcess;
use super::options::Options;
use super::reliability::{self, Curve, LabelledFrame};
use super::requirements::Requirements;
use super::selection_robustness;
use super::tracker_under_test::TrackerFactory;
use crate::output::print_line;
use measurement::ClipMeasurement;

/// Measures the chosen clips, prints the tables, judges the requirements, and returns the figures.
///
/// # Errors
/// If a clip or OpenCV cannot be used.
pub(crate) fn run(
    options: &Options,
    factory: TrackerFactory<'_>,
    requirements: &mut Requirements,
) -> Result<Value> {
    let mut opencv =
        options.opencv.then(|| OpencvProcess::start(&options.python()?, &options.models()?)).transpose()?;
    let folders = options.clip_folders()?;
    let mut clips = Vec::new();
    for folder in &folders {
        clips.push(ClipMeasurement::measure(options, folder, factory, opencv.as_mut())?);
    }
    if let Some(opencv) = opencv {
        opencv.end()?;
    }
    let sets = clip_sets(&folders);
    tables::print_clips(&clips);
    tables::print_means(&clips, &sets);
    if options.opencv {
        beside_opencv::print(&clips, &sets);
    }
    if options.jitter {
        selection_robustness::print_table(clips.iter().filter_map(|clip| {
            clip.perturbed.as_ref().map(|scores| (clip.name.as_str(), clip.score.auc, scores.as_slice()))
        }));
    }
    if options.upscaled {
        tables::print_upscaled(&clips);
    }
    let labelled: Vec<LabelledFrame> = clips.iter().flat_map(|clip| clip.labelled.iter().copied()).collect();
    reliability::print_curve(&Curve::from_frames(&labelled));
    print_line("");
    judgement::judge(options, &clips, &sets, requirements);
    if !options.is_complete() {
        print_line("        not judged on a selection of clips: the means over all of them");
    }
    Ok(Value::Array(clips.into_iter().map(clip_json::clip_to_json).collect()))
}
