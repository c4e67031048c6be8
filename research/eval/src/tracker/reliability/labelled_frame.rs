//! What a tracker reported in a labelled frame: the confidence, and how well the box agrees with the label.

use crate::tracker::clips::Clip;
use crate::tracker::scoring::{Label, iou};
use crate::tracker::tracker_run::TrackerRun;

/// A box with at least this IoU is correct: the usual threshold of detection benchmarks.
pub(super) const MIN_CORRECT_IOU: f64 = 0.5;

/// A box with an IoU below this is not on the target.
pub(super) const MIN_TARGET_IOU: f64 = 0.1;

/// A track with at least this confidence is sure.
pub(super) const SURE: f64 = 0.8;

/// A labelled frame after the selection's.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct LabelledFrame {
    /// The confidence of a track that is tracking or coasting, 0 to 1; `None` where no box is reported.
    pub(super) confidence: Option<f64>,
    /// IoU of the reported box with the label, 0 to 1; 0 where no box is reported, or the target is labelled
    /// absent.
    pub(super) iou: f64,
}

impl LabelledFrame {
    /// Whether the box is correct.
    pub(super) fn is_correct(&self) -> bool {
        self.iou >= MIN_CORRECT_IOU
    }

    /// Whether the confidence is at least [`SURE`].
    pub(super) fn is_sure(&self) -> bool {
        self.confidence.is_some_and(|confidence| confidence >= SURE)
    }

    /// Whether a box that is not on the target is reported with a confidence of at least [`SURE`].
    pub(super) fn is_sure_and_wrong(&self) -> bool {
        self.is_sure() && self.iou < MIN_TARGET_IOU
    }
}

/// The labelled frames of a run.
pub(crate) fn labelled_frames(clip: &Clip, run: &TrackerRun) -> Vec<LabelledFrame> {
    let mut frames = Vec::new();
    for (track, label) in run.tracks.iter().zip(clip.tracked_labels()) {
        let Some(label) = label else { continue };
        let localisation = track.localisation();
        let bounds = localisation.map(|localisation| localisation.bounds);
        let iou = match label {
            Label::Visible(truth) => iou(*truth, bounds, clip.size()),
            Label::Absent => 0.0,
        };
        frames.push(LabelledFrame {
            confidence: localisation.map(|localisation| localisation.confidence),
            iou,
        });
    }
    frames
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sure_and_wrong_needs_a_report_a_high_confidence_and_no_overlap() {
        let is_sure_and_wrong = |confidence, iou| LabelledFrame { confidence, iou }.is_sure_and_wrong();
        assert!(is_sure_and_wrong(Some(0.8), 0.0));
        assert!(!is_sure_and_wrong(Some(0.79), 0.0));
        assert!(!is_sure_and_wrong(Some(0.9), 0.1));
        assert!(!is_sure_and_wrong(None, 0.0));
    }
}
