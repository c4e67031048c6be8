//! What is measured on one clip, and the means over clips.

use anyhow::Result;
use barrelman_vision::SelectionError;
use barrelman_vocab::PictureSize;
use serde_json::Value;

use super::frames_json::frames_to_json;
use crate::statistics::mean;
use crate::tracker::clips::ClipFolder;
use crate::tracker::csrt::{CsrtProcess, CsrtRun};
use crate::tracker::options::Options;
use crate::tracker::reliability::{self, Sample};
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
    pub(super) size: PictureSize,
    pub(super) score: Score,
    /// CPU time of each tracked frame, milliseconds; empty where the selection was refused.
    pub(super) cpu_ms: Vec<f64>,
    pub(super) selection_error: Option<SelectionError>,
    pub(super) samples: Vec<Sample>,
    pub(super) csrt: Option<CsrtRun>,
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
        csrt: Option<&mut CsrtProcess>,
    ) -> Result<Self> {
        let clip = folder.load()?;
        let run = run_tracker(factory().as_mut(), &clip, clip.selection);
        let csrt = csrt.map(|csrt| csrt.run(folder, &clip)).transpose()?;
        let perturbed = options.jitter.then(|| score_perturbed_selections(factory, &clip));
        let upscaled = (options.upscaled && clip.size() == HD).then(|| {
            let clip = upscale::enlarged(&clip);
            let run = run_tracker(factory().as_mut(), &clip, clip.selection);
            (run.score(&clip), run.cpu_ms())
        });
        Ok(Self {
            name: clip.name.clone(),
            size: clip.size(),
            score: run.score(&clip),
            cpu_ms: run.cpu_ms(),
            samples: reliability::samples(&clip, &run),
            csrt,
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

/// The mean of a figure of the score over clips.
pub(super) fn mean_score(clips: &[ClipMeasurement], value: impl Fn(&Score) -> f64) -> f64 {
    mean(&clips.iter().map(|clip| value(&clip.score)).collect::<Vec<_>>())
}

/// Means over clips of the mean CPU time of a frame, milliseconds.
pub(super) struct MeanCpuMs {
    pub(super) tracker: f64,
    pub(super) csrt: f64,
    pub(super) lean_camshift: f64,
}

impl MeanCpuMs {
    /// Over the timed clips that `includes` accepts.
    pub(super) fn over_clips(clips: &[ClipMeasurement], includes: impl Fn(&ClipMeasurement) -> bool) -> Self {
        let mean_of = |value: &dyn Fn(&ClipMeasurement) -> Option<f64>| {
            let included = clips.iter().filter(|clip| clip.is_timed() && includes(clip));
            mean(&included.filter_map(value).collect::<Vec<_>>())
        };
        Self {
            tracker: mean_of(&|clip| Some(mean(&clip.cpu_ms))),
            csrt: mean_of(&|clip| clip.csrt.as_ref().map(|csrt| mean(&csrt.cpu_ms))),
            lean_camshift: mean_of(&|clip| clip.csrt.as_ref().map(|csrt| mean(&csrt.lean_camshift_cpu_ms))),
        }
    }
}
