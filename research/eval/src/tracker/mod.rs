//! Measures the tracker and judges what is required of it.
//!
//! | part | data | what is measured |
//! |---|---|---|
//! | clip table | labelled real clips | success, precision, share lost, CPU time; also beside CSRT and NanoTrack |
//! | loose | labelled real clips | the same from selections that are too small or too large and beside the target |
//! | backgrounds | real clips, generated scenes | whether selections of the background are refused or lost |
//! | confidence | labelled real clips | whether the confidence is calibrated, and how often it is sure and wrong |
//! | absence | sequences cropped from clips, generated scenes | targets that leave the picture and return |
//! | gaps | labelled real clips | whether the track goes on with another object after a gap in the video |
//! | orientation | generated scenes, labelled bows | axis and heading of boats |
//! | leave one out | labelled real clips | how well settings chosen on other recordings do |
//!
//! The clips may not be redistributed. They are read from folders beside the repository. Times are the CPU
//! time of one call of `track` on a decoded frame, one call after the other on one thread.

mod clip_table;
mod selection_robustness;
mod upscale;

mod untimed;

mod backgrounds;
mod loose;
mod reliability;

mod absence;
mod gaps;
mod labelled_bows;
mod orientation;

mod leave_one_out;

mod candidates;
pub(crate) mod empty_water;
pub(crate) mod labelled_pictures;
pub(crate) mod past_selection;
mod tapped_people;
mod taps;
pub(crate) mod training_samples;

mod opencv;
mod synthetic_scenes;
pub(crate) mod tracker_run;
mod tracker_under_test;
mod tuned_settings;

pub(crate) mod clip_sets;
pub(crate) mod clips;
mod cropped_picture;
mod scoring;

mod requirements;
pub(crate) mod text_table;

mod options;

#[cfg(test)]
mod test_clip;

pub(crate) use options::Options;

use anyhow::{Context, Result, ensure};
use serde_json::json;

use requirements::Requirements;
use tracker_under_test::HeldOutWeights;

/// Measures the chosen parts. Returns whether every requirement that was judged holds.
///
/// # Errors
/// If a clip, OpenCV or an output file cannot be used.
pub(crate) fn run(options: &Options) -> Result<bool> {
    let options = options.with_implied_parts();
    let config = tuned_settings::config_with_changes(&options.set)?;
    let mut requirements = Requirements::default();
    let held_out = options.weights.as_deref().map(HeldOutWeights::load).transpose()?.unwrap_or_default();
    if options.weights.is_some() {
        let folders = options.clip_folders()?;
        let missing = held_out.missing(folders.iter().map(|folder| folder.name.as_str()));
        ensure!(missing.is_empty(), "--weights has none for the recordings of {}", missing.join(", "));
    }
    #[allow(clippy::expect_used, reason = "the tracker has accepted the settings above")]
    let factory = |clip: &str| {
        tracker_under_test::build_tracker_for(&config, &held_out, clip)
            .expect("settings that were accepted once are accepted again")
    };
    let table = options.table.then(|| clip_table::run(&options, &factory, &mut requirements)).transpose()?;
    let untimed = options
        .is_untimed_chosen()
        .then(|| untimed::run(&options, &factory, &mut requirements))
        .transpose()?
        .unwrap_or_default();
    let absence = options.absence.then(|| absence::run(&options, &config, &mut requirements)).transpose()?;
    let gaps = options.gaps.then(|| gaps::run(&options, &factory, &mut requirements)).transpose()?;
    let orientation =
        options.orientation.then(|| orientation::run(&options, &config, &mut requirements)).transpose()?;
    if options.orientation {
        labelled_bows::run(&config)?;
    }
    let leave_one_out = options.leave_one_out.then(|| leave_one_out::run(&options, &config)).transpose()?;
    let is_met = requirements.finish();
    if let Some(path) = &options.json {
        let figures = json!({
            "tracker": tracker_under_test::NAME,
            "settings": format!("{config:?}"),
            "requirements": requirements.to_json(),
            "clips": table,
            "loose": untimed.loose,
            "backgrounds": untimed.backgrounds,
            "confidence": untimed.confidence,
            "absence": absence,
            "gaps": gaps,
            "orientation": orientation,
            "leave_one_out": leave_one_out,
        });
        std::fs::write(path, serde_json::to_string(&figures)? + "\n")
            .with_context(|| format!("{} cannot be written", path.display()))?;
    }
    Ok(is_met)
}
