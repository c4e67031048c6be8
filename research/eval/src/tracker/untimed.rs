//! One pass over the clips for the parts whose CPU time is not measured: loose selections, selections of the
//! background, and the confidence.
//!
//! The clips run on two threads. Each thread decodes one clip, measures all chosen parts on it, and drops it:
//! a picture of 1280x720 takes 1.4 MB.

use anyhow::Result;
use serde_json::Value;

use super::backgrounds::{self, BackgroundRuns};
use super::clip_sets::clip_sets;
use super::clips::ClipFolder;
use super::loose::{self, LooseClip, LooseRuns};
use super::options::Options;
use super::reliability::{self, ClipFrames, LabelledFrame, labelled_frames};
use super::requirements::Requirements;
use super::scoring::Score;
use super::tracker_run::run_tracker;
use super::tracker_under_test::TrackerFactory;
use crate::output::print_line;
use crate::parallel;

/// The figures of each part that was measured.
#[derive(Default)]
pub(crate) struct Figures {
    pub(crate) loose: Option<Value>,
    pub(crate) backgrounds: Option<Value>,
    pub(crate) confidence: Option<Value>,
}

/// What was measured on one clip.
struct UntimedClip {
    name: String,
    /// The score with the label as selection.
    exact: Score,
    labelled: Vec<LabelledFrame>,
    loose: Option<LooseRuns>,
    backgrounds: Option<BackgroundRuns>,
}

impl UntimedClip {
    fn measure(options: &Options, factory: TrackerFactory<'_>, folder: &ClipFolder) -> Result<Self> {
        let clip = folder.load()?;
        let run = run_tracker(factory(&clip.name).as_mut(), &clip, clip.selection);
        Ok(Self {
            exact: run.score(&clip),
            labelled: labelled_frames(&clip, &run),
            loose: options.loose.then(|| LooseRuns::measure(factory, &clip)),
            backgrounds: options.backgrounds.then(|| BackgroundRuns::measure(factory, &clip)),
            name: clip.name,
        })
    }
}

/// Measures the chosen parts, prints their tables, judges the requirements, and returns the figures of each
/// part.
///
/// # Errors
/// If a clip cannot be used, or the plot cannot be written.
pub(crate) fn run(
    options: &Options,
    factory: TrackerFactory<'_>,
    requirements: &mut Requirements,
) -> Result<Figures> {
    let folders = options.clip_folders()?;
    let results = parallel::map(&folders, |folder| UntimedClip::measure(options, factory, folder));
    let clips = results.into_iter().collect::<Result<Vec<_>>>()?;
    let is_judged = options.is_complete();
    let loose_clips: Vec<LooseClip<'_>> = clips.iter().filter_map(loose_clip).collect();
    let loose =
        options.loose.then(|| loose::report(&loose_clips, &clip_sets(&folders), is_judged, requirements));
    let backgrounds = if options.backgrounds {
        let generated = backgrounds::measure_generated(factory)?;
        let on_clips: Vec<&BackgroundRuns> =
            clips.iter().filter_map(|clip| clip.backgrounds.as_ref()).collect();
        Some(backgrounds::report(&on_clips, &generated, is_judged, requirements))
    } else {
        None
    };
    let confidence = if options.confidence {
        let frames: Vec<ClipFrames<'_>> = clips.iter().map(clip_frames).collect();
        Some(reliability::report(&frames, is_judged, requirements)?)
    } else {
        None
    };
    if !is_judged {
        print_line(
            "        not judged on a selection of clips: loose and background selections, and the confidence",
        );
    }
    Ok(Figures { loose, backgrounds, confidence })
}

fn loose_clip(clip: &UntimedClip) -> Option<LooseClip<'_>> {
    Some(LooseClip { name: &clip.name, exact: clip.exact, loose: clip.loose.as_ref()? })
}

fn clip_frames(clip: &UntimedClip) -> ClipFrames<'_> {
    ClipFrames {
        clip: &clip.name,
        exact: &clip.labelled,
        loose: clip.loose.as_ref().map(|loose| loose.labelled.as_slice()),
    }
}
