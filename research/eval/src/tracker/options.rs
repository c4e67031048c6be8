//! Options of `barrelman-eval tracker`.

use std::path::PathBuf;

use anyhow::Result;
use clap::Args;

use super::clip_sets::{TUNED_ON, UNSEEN};
use super::clips::{ClipFolder, list_clips};
use crate::workspace::{path_or_default, workspace_root};

/// The folder of the default folders of clips, relative to the workspace.
const DATA: &str = "../shared/data";

/// Options of `tracker`. The table of clips is printed unless only other parts are chosen.
#[derive(Debug, Clone, Args)]
pub(crate) struct Options {
    /// A folder of clips: a folder each with video.mp4 and gt.csv (repeatable) [default: ../shared/data/clips
    /// and ../shared/data/clips-more beside the workspace].
    #[arg(long, value_name = "DIR")]
    pub(crate) clips: Vec<PathBuf>,
    /// Only this clip (repeatable). Requirements on means over clips are then not judged.
    #[arg(long, value_name = "NAME")]
    pub(crate) clip: Vec<String>,
    /// Weights of the refinement network for each recording: a folder of files NAME.weights, each fitted
    /// without the recording of the clip NAME.
    #[arg(long, value_name = "DIR")]
    pub(crate) weights: Option<PathBuf>,
    /// The table of clips: quality and cost. The default.
    #[arg(long)]
    pub(crate) table: bool,
    /// Also OpenCV's CSRT and NanoTrack on the same clips, and the cost of its lean CamShift.
    #[arg(long)]
    pub(crate) opencv: bool,
    /// The Python with OpenCV [default: .venv/bin/python in the workspace].
    #[arg(long, value_name = "PATH")]
    pub(crate) python: Option<PathBuf>,
    /// The folder of NanoTrack's models [default: ../shared/models/nanotrack beside the workspace].
    #[arg(long, value_name = "DIR")]
    pub(crate) models: Option<PathBuf>,
    /// Also the mean over five slightly moved selections.
    #[arg(long)]
    pub(crate) jitter: bool,
    /// Also the cost at 1920x1080: clips of 1280x720 enlarged.
    #[arg(long)]
    pub(crate) upscaled: bool,
    /// Selections of 0.8 to 1.4 times the label's size, 0.1 or 0.2 of its sides beside it.
    #[arg(long)]
    pub(crate) loose: bool,
    /// Selections of the background, on clips and generated scenes.
    #[arg(long)]
    pub(crate) backgrounds: bool,
    /// Whether the confidence is calibrated; with --loose also for the loose selections.
    #[arg(long)]
    pub(crate) confidence: bool,
    /// Settings chosen on all recordings but one, scored on that one.
    #[arg(long)]
    pub(crate) leave_one_out: bool,
    /// Targets that leave the picture and come back, cut from clips and generated.
    #[arg(long)]
    pub(crate) absence: bool,
    /// Gaps in the video: clips that are cut, and go on elsewhere after some seconds.
    #[arg(long)]
    pub(crate) gaps: bool,
    /// Axes and headings of generated boats that manoeuvre.
    #[arg(long)]
    pub(crate) orientation: bool,
    /// Fewer generated scenes: at most this many in --absence, and of each size in --orientation.
    #[arg(long, value_name = "COUNT")]
    pub(crate) scenes: Option<u64>,
    /// Every part of the measurement.
    #[arg(long)]
    pub(crate) all: bool,
    /// Change a setting of the tracker (repeatable); the names are those of the table that --leave-one-out
    /// prints.
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
            &mut options.table,
            &mut options.opencv,
            &mut options.jitter,
            &mut options.upscaled,
            &mut options.loose,
            &mut options.backgrounds,
            &mut options.confidence,
            &mut options.absence,
            &mut options.gaps,
            &mut options.orientation,
            &mut options.leave_one_out,
        ];
        for part in parts {
            *part |= self.all;
        }
        let is_other_part_chosen = options.is_untimed_chosen()
            || options.absence
            || options.gaps
            || options.orientation
            || options.leave_one_out;
        options.table |= options.opencv || options.jitter || options.upscaled || !is_other_part_chosen;
        options
    }

    /// Whether a part is chosen that runs the clips without timing.
    pub(super) fn is_untimed_chosen(&self) -> bool {
        self.loose || self.backgrounds || self.confidence
    }

    /// Whether all clips of the folders are measured, so that means over them are judged.
    pub(super) fn is_complete(&self) -> bool {
        self.clip.is_empty()
    }

    /// The folders of clips.
    pub(super) fn collections(&self) -> Result<Vec<PathBuf>> {
        if !self.clips.is_empty() {
            return Ok(self.clips.clone());
        }
        let data = workspace_root()?.join(DATA);
        Ok(vec![data.join(TUNED_ON), data.join(UNSEEN)])
    }

    /// The chosen clips of all folders.
    pub(super) fn clip_folders(&self) -> Result<Vec<ClipFolder>> {
        list_clips(&self.collections()?, &self.clip)
    }

    pub(super) fn python(&self) -> Result<PathBuf> {
        path_or_default(self.python.as_ref(), ".venv/bin/python")
    }

    pub(super) fn models(&self) -> Result<PathBuf> {
        path_or_default(self.models.as_ref(), "../shared/models/nanotrack")
    }
}

#[cfg(test)]
mod tests {
    use clap::Parser;

    use super::*;

    #[derive(Parser)]
    struct Cli {
        #[command(flatten)]
        options: Options,
    }

    fn options(arguments: &[&str]) -> Options {
        let arguments = std::iter::once("tracker").chain(arguments.iter().copied());
        Cli::try_parse_from(arguments).unwrap().options.with_implied_parts()
    }

    #[test]
    fn the_table_is_the_default() {
        let chosen = |arguments| {
            let options = options(arguments);
            (options.table, options.is_untimed_chosen())
        };
        assert_eq!(chosen(&[]), (true, false));
        assert_eq!(chosen(&["--opencv"]), (true, false));
        assert_eq!(chosen(&["--loose"]), (false, true));
        assert_eq!(chosen(&["--table", "--confidence"]), (true, true));
        assert_eq!(chosen(&["--all"]), (true, true));
    }

    #[test]
    fn folders_are_repeatable_and_have_defaults() {
        assert_eq!(options(&["--clips", "a", "--clips", "b"]).collections().unwrap().len(), 2);
        let defaults = options(&[]).collections().unwrap();
        assert!(defaults[0].ends_with("data/clips") && defaults[1].ends_with("data/clips-more"));
    }
}
