//! Options of `barrelman-eval tracker`.

use std::path::PathBuf;

use anyhow::Result;
use clap::Args;

use super::clips::{ClipFolder, list_clips};
use crate::workspace::path_or_default;

/// Options of `tracker`. The table of clips is printed unless only other parts are chosen.
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
    /// Also OpenCV's CSRT on the same clips, and the cost of its lean CamShift.
    #[arg(long)]
    pub(crate) csrt: bool,
    /// The Python with OpenCV [default: .venv/bin/python in the workspace].
    #[arg(long, value_name = "PATH")]
    pub(crate) python: Option<PathBuf>,
    /// Also the mean over five slightly moved selections.
    #[arg(long)]
    pub(crate) jitter: bool,
    /// Also the cost at 1920x1080: clips of 1280x720 enlarged.
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
    /// Fewer generated scenes: at most this many in --absence, and of each size in --orientation.
    #[arg(long, value_name = "COUNT")]
    pub(crate) scenes: Option<u64>,
    /// Every part of the measurement.
    #[arg(long)]
    pub(crate) all: bool,
    /// Change a setting of the tracker (repeatable); the names are those of the table that --leave-one-out prints.
    #[arg(long, value_name = "NAME=VALUE")]
    pub(crate) set: Vec<String>,
    /// Write all figures, and the tracker's output for every frame, to this file.
    #[arg(long, value_name = "FILE")]
    pub(crate) json: Option<PathBuf>,
}

impl Options {
    /// The options with every part set that these imply.
    pub(super) fn with_implied_parts(&self) -> Self {
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
        let is_other_part_chosen = options.absence || options.orientation || options.leave_one_out;
        options.table |= options.csrt || options.jitter || options.upscaled || !is_other_part_chosen;
        options
    }

    pub(super) fn clips_folder(&self) -> Result<PathBuf> {
        path_or_default(self.clips.as_ref(), "../shared/data/clips")
    }

    /// The chosen clips.
    pub(super) fn clip_folders(&self) -> Result<Vec<ClipFolder>> {
        list_clips(&self.clips_folder()?, &self.clip)
    }

    pub(super) fn python(&self) -> Result<PathBuf> {
        path_or_default(self.python.as_ref(), ".venv/bin/python")
    }
}
