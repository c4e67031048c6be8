//! Measures a tracker against what is required of it.
//!
//! The clips are recordings that may not be handed on, so they lie beside the repository. Timing is the CPU time of
//! one call of `track`, one after the other on one thread, of frames that are decoded already: what the tracker
//! takes from the loop it runs in.

mod clip_table;
mod jitter;
mod reliability;
mod upscale;

mod absence;
mod orientation;

mod generated;

mod leave_one_out;

mod candidates;
mod opencv;
mod under_test;

mod clips;
mod follow;
mod scoring;

mod chance;
pub(crate) mod figures;
pub(crate) mod parallel;
mod report;

use std::path::PathBuf;

use anyhow::{Context, Result};
use clap::Args;
use serde_json::json;

use crate::root;
use report::Requirements;

/// Options of `acceptance tracker`. The table of clips is printed unless other parts alone are asked for.
#[derive(Debug, Clone, Args)]
pub(crate) struct Options {
    /// The folder of clips: a folder each with video.mp4 and gt.csv [default: ../shared/data/clips beside the
    /// workspace].
    #[arg(long, value_name = "DIR")]
    pub(crate) clips: Option<PathBuf>,
    /// Only this clip (repeatable). Requirements on means over all clips are then not judged.
    #[arg(long, value_name = "NAME")]
    pub(crate) clip: Vec<String>,
    /// The table of clips: quality, cost and confidence. The default.
    #[arg(long)]
    pub(crate) table: bool,
    /// OpenCV's CSRT on the same clips beside it, and the cost of its lean CamShift.
    #[arg(long)]
    pub(crate) csrt: bool,
    /// The Python with OpenCV [default: .venv/bin/python in the workspace].
    #[arg(long, value_name = "PATH")]
    pub(crate) python: Option<PathBuf>,
    /// The mean over five slightly moved selections, too.
    #[arg(long)]
    pub(crate) jitter: bool,
    /// The cost at 1920x1080, too: clips of 1280x720 enlarged.
    #[arg(long)]
    pub(crate) upscaled: bool,
    /// Settings chosen on all recordings but one, scored on that one.
    #[arg(long)]
    pub(crate) leave_one_out: bool,
    /// Targets that leave the picture and come back, cut from clips and generated.
    #[arg(long)]
    pub(crate) absence: bool,
    /// Axes and headings of generated boats that manoeuvre.
    #[arg(long)]
    pub(crate) orientation: bool,
    /// Fewer generated scenes: at most so many in --absence, and of each size in --orientation.
    #[arg(long, value_name = "COUNT")]
    pub(crate) scenes: Option<u64>,
    /// Every part of the measurement.
    #[arg(long)]
    pub(crate) all: bool,
    /// Change a setting of the tracker (repeatable); the names are those of the table that --leave-one-out prints.
    #[arg(long, value_name = "NAME=VALUE")]
    pub(crate) set: Vec<String>,
    /// Write all figures, and what was said of every frame, to this file.
    #[arg(long, value_name = "FILE")]
    pub(crate) json: Option<PathBuf>,
}

impl Options {
    /// The same, with every part asked for that these ask for without naming it.
    fn completed(&self) -> Self {
        let mut options = self.clone();
        let parts = [
            &mut options.csrt,
            &mut options.jitter,
            &mut options.upscaled,
            &mut options.absence,
            &mut options.orientation,
            &mut options.leave_one_out,
        ];
        for part in parts {
            *part |= self.all;
        }
        let others_alone = options.absence || options.orientation || options.leave_one_out;
        options.table |= options.csrt || options.jitter || options.upscaled || !others_alone;
        options
    }

    fn clips_folder(&self) -> Result<PathBuf> {
        Ok(match &self.clips {
            Some(folder) => folder.clone(),
            None => root()?.join("../shared/data/clips"),
        })
    }

    fn clip_folders(&self) -> Result<Vec<clips::ClipFolder>> {
        clips::list(&self.clips_folder()?, &self.clip)
    }

    fn python(&self) -> Result<PathBuf> {
        Ok(match &self.python {
            Some(python) => python.clone(),
            None => root()?.join(".venv/bin/python"),
        })
    }
}

/// Measures the tracker; whether every requirement that was judged holds.
///
/// # Errors
/// If a clip, OpenCV or an output cannot be used.
pub(crate) fn run(options: &Options) -> Result<bool> {
    let options = options.completed();
    let config = candidates::changed(&options.set)?;
    let mut requirements = Requirements::default();
    let table = options.table.then(|| clip_table::run(&options, &config, &mut requirements)).transpose()?;
    let absence = options.absence.then(|| absence::run(&options, &config, &mut requirements)).transpose()?;
    let orientation =
        options.orientation.then(|| orientation::run(&options, &config, &mut requirements)).transpose()?;
    let left_out = options.leave_one_out.then(|| leave_one_out::run(&options, &config)).transpose()?;
    let hold = requirements.finish();
    if let Some(path) = &options.json {
        let all = json!({
            "tracker": under_test::NAME,
            "settings": format!("{config:?}"),
            "requirements": requirements.to_json(),
            "clips": table,
            "absence": absence,
            "orientation": orientation,
            "leave_one_out": left_out,
        });
        std::fs::write(path, serde_json::to_string(&all)? + "\n")
            .with_context(|| format!("{} cannot be written", path.display()))?;
    }
    Ok(hold)
}
