//! The table of clips: quality, confidence and CPU time of the tracker on labelled real clips.
//!
//! Judged are the means of success AUC, precision and share lost over all clips, the AUC of each clip beside CSRT's,
//! the CPU times at 1280x720 and 1920x1080, also beside CSRT's, and the reliability of the confidence.

mod clip_json;
mod frames_json;
mod judgement;
mod measurement;
mod tables;

use anyhow::Result;
use serde_json::Value;

use super::csrt::CsrtProcess;
use super::options::Options;
use super::reliability::{self, Curve, Sample};
use super::requirements::Requirements;
use super::selection_robustness;
use super::tracker_under_test::{TrackerConfig, build_tracker};
use crate::output::print_line;
use measurement::ClipMeasurement;

/// Measures the chosen clips, prints the tables, judges the requirements, and returns the figures.
///
/// # Errors
/// If a clip or OpenCV cannot be used.
pub(crate) fn run(
    options: &Options,
    config: &TrackerConfig,
    requirements: &mut Requirements,
) -> Result<Value> {
    // Settings that are out of range are reported before any clip is decoded.
    build_tracker(config)?;
    #[allow(clippy::expect_used, reason = "the same settings were accepted above")]
    let factory = || build_tracker(config).expect("settings that were accepted once are accepted again");
    let mut csrt = options.csrt.then(|| CsrtProcess::start(&options.python()?)).transpose()?;
    let mut clips = Vec::new();
    for folder in options.clip_folders()? {
        clips.push(ClipMeasurement::measure(options, &folder, &factory, csrt.as_mut())?);
    }
    if let Some(csrt) = csrt {
        csrt.end()?;
    }
    tables::print_clips(&clips);
    if options.csrt {
        tables::print_beside_csrt(&clips);
    }
    if options.jitter {
        selection_robustness::print_table(clips.iter().filter_map(|clip| {
            clip.perturbed.as_ref().map(|scores| (clip.name.as_str(), clip.score.auc, scores.as_slice()))
        }));
    }
    if options.upscaled {
        tables::print_upscaled(&clips);
    }
    let samples: Vec<Sample> = clips.iter().flat_map(|clip| clip.samples.iter().copied()).collect();
    let curve = Curve::from_samples(&samples);
    reliability::print_table(&curve);
    let is_complete = options.clip.is_empty();
    print_line("");
    judgement::judge(options, is_complete, &clips, requirements);
    if is_complete {
        reliability::judge(&curve, requirements);
    } else {
        print_line(
            "        not judged on a selection of clips: the means over all of them, and the confidence",
        );
    }
    reliability::save_plot(&curve)?;
    Ok(Value::Array(clips.into_iter().map(clip_json::clip_to_json).collect()))
}
