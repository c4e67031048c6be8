//! What is measured on one clip, and the mean scores over clips.

use anyhow::Result;
use barrelman_vision::SelectionError;
use barrelman_vocab::PictureSize;
use serde_json::Value;

use super::frames_json::frames_to_json;
use crate::tracker::clip_sets::{ClipSet, SetMean, set_mean};
use crate::tracker::clips::ClipFolder;
use crate::tracker::opencv::{OpencvProcess, OpencvRuns};
use crate::tracker::options::Options;
use crate::tracker::reliability::{LabelledFrame, labelled_frames};
use crate::tracker::scoring::Score;
use crate::tracker::selection_robustness::score_perturbed_selections;
use crate::tracker::tracker_run::run_tracker;
use crate::tracker::tracker_under_test::TrackerFactory;
use crate::tracker::upscale;

/// The size of the pictures for which CPU times are limited, and which are enlarged.
pub(super) const HD: PictureSize = PictureSize::new(1280, 720);

/// What was measured on one clip.
pub(super) struct ClipMeasurement {
    pub(super) name: String,
    /// The name of the folder of clips that holds it.
    pub(super) collection: String,
    pub(super) size: PictureSize,
    pub(super) score: Score,
    /// CPU time of each tracked frame, milliseconds; empty where the selection was refused.
    pub(super) cpu_ms: Vec<f64>,
    pub(super) selection_error: Option<SelectionError>,
    pub(super) labelled: Vec<LabelledFrame>,
    pub(super) opencv: Option<OpencvRuns>,
    /// Scores of perturbed selections.
    pub(super) perturbed: Option<Vec<Score>>,
    /// Score and CPU times on the enlarged clip.
    pub(super) upscaled: Option<(Score, Vec<f64>)>,
    /// Every tracked frame, for a file.
    pub(super) frames: Value,
}

impl ClipMeasurement {
    /// Decodes a clip and measures the chosen parts on it.
    ///
    /// # Errors
    /// If the clip or OpenCV cannot be used.
    pub(super) fn measure(
        options: &Options,
        folder: &ClipFolder,
        factory: TrackerFactory<'_>,
        opencv: Option<&mut OpencvProcess>,
    ) -> Result<Self> {
        let clip = folder.load()?;
        let run = run_tracker(factory(&clip.name).as_mut(), &clip, clip.selection);
        let opencv = opencv.map(|opencv| opencv.run(folder, &clip)).transpose()?;
        let perturbed = options.jitter.then(|| score_perturbed_selections(factory, &clip));
        let upscaled = (options.upscaled && clip.size() == HD).then(|| {
            let clip = upscale::enlarged(&clip);
            let run = run_tracker(factory(&clip.name).as_mut(), &clip, clip.selection);
            (run.score(&clip), run.cpu_ms())
        });
        Ok(Self {
            name: clip.name.clone(),
            collection: folder.collection.clone(),
            size: clip.size(),
            score: run.score(&clip),
            cpu_ms: run.cpu_ms(),
            labelled: labelled_frames(&clip, &run),
            opencv,
            perturbed,
            upscaled,
            frames: frames_to_json(&clip, &run),
            selection_error: run.selection_error,
        })
    }

    /// Whether there are CPU times: nothing is tracked where the selection was refused.
    pub(super) fn is_timed(&self) -> bool {
        !self.cpu_ms.is_empty()
    }
}

/// The clips of a set.
pub(super) fn members<'a>(set: &ClipSet, clips: &'a [ClipMeasurement]) -> Vec<&'a ClipMeasurement> {
    clips.iter().filter(|clip| set.contains(&clip.name)).collect()
}

/// The means of a figure of the score over clips and over recordings.
pub(super) fn mean_score(clips: &[&ClipMeasurement], value: impl Fn(&Score) -> f64) -> SetMean {
    set_mean(clips.iter().map(|clip| (clip.name.as_str(), value(&clip.score))))
}
