//! Object detectors: pictures to train them on, and what they find in real and rendered pictures.
//!
//! | part | truth | what is measured |
//! |---|---|---|
//! | clips | one labelled object a picture | its recall, precision as a lower bound, detections a picture |
//! | rendered scenes | all people and boats | recall and precision of each class |
//! | empty water | nothing is there | false detections a second |
//!
//! Times are the CPU time of one picture, one after the other on one thread. Nothing is judged.

mod measured;
mod on_clips;
mod on_scenes;
mod scene;
mod scenes;
mod tally;

pub(crate) use scenes::{ScenesOptions, write_scenes};

use std::path::PathBuf;

use anyhow::Result;

use crate::output::print_line;
use crate::statistics::TimingSummary;
use crate::tracker::labelled_pictures::chosen_clips;
use measured::MeasuredDetector;

/// Options of `detector`.
#[derive(Debug, clap::Args)]
pub(crate) struct Options {
    /// The model, in ONNX
    #[arg(long, value_name = "FILE")]
    model: PathBuf,
    /// Its settings [default: beside the model, with the ending toml]
    #[arg(long, value_name = "FILE")]
    settings: Option<PathBuf>,
    /// A folder of clips: a folder each with video.mp4 and gt.csv [default: ../shared/data/clips and
    /// ../shared/data/clips-more beside the workspace]
    #[arg(long, value_name = "DIR")]
    clips: Option<PathBuf>,
    /// Only this clip (repeatable)
    #[arg(long, value_name = "NAME")]
    clip: Vec<String>,
    /// Labelled frames of each clip, evenly spread
    #[arg(long, value_name = "COUNT", default_value_t = 30)]
    frames: usize,
    /// Seas of the rendered scenes, 8 pictures each
    #[arg(long, value_name = "COUNT", default_value_t = 40)]
    seas: u64,
    /// Empty seas of each sea state
    #[arg(long, value_name = "COUNT", default_value_t = 4)]
    empty_seas: u64,
}

/// Measures a model.
///
/// # Errors
/// If the model cannot be loaded or computed, or a clip not be used.
pub(crate) fn run(options: &Options) -> Result<()> {
    let mut detector = MeasuredDetector::load(&options.model, options.settings.as_ref())?;
    let clips = chosen_clips(options.clips.as_deref(), &options.clip)?;
    on_clips::measure(&mut detector, &clips, options.frames)?;
    on_scenes::measure_scenes(&mut detector, options.seas)?;
    on_scenes::measure_empty_water(&mut detector, options.empty_seas)?;
    let times = TimingSummary::from_times_ms(&detector.times_ms);
    print_line(&format!("\nCPU time a picture: median {:.0} ms, p99 {:.0} ms", times.median, times.p99));
    Ok(())
}
