//! The reliability curve: the share of correct frames in bins of the confidence.

use crate::tracker::clips::Clip;
use crate::tracker::scoring::{Label, iou};
use crate::tracker::tracker_run::TrackerRun;

/// A box with at least this IoU is correct: the usual threshold of detection benchmarks.
pub(super) const MIN_CORRECT_IOU: f64 = 0.5;

/// Bins of 0.1 over 0 to 1.
const BINS: usize = 10;

/// The bin that is judged: around 0.7, the confidence at which a pilot decides.
pub(super) const JUDGED_RANGE: (f64, f64) = (0.65, 0.75);

/// A reported and labelled frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Sample {
    pub(super) confidence: f64,
    pub(super) is_correct: bool,
}

/// The samples with a confidence in a range.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Bin {
    pub(super) low: f64,
    pub(super) high: f64,
    pub(super) frames: usize,
    correct: usize,
    confidence_sum: f64,
}

impl Bin {
    /// Counts the samples from `low` to below `high`; a bin up to 1 includes 1.
    fn from_samples(samples: &[Sample], low: f64, high: f64) -> Self {
        let mut bin = Self { low, high, frames: 0, correct: 0, confidence_sum: 0.0 };
        let is_within = |confidence: f64| confidence >= low && (confidence < high || high >= 1.0);
        for sample in samples.iter().filter(|sample| is_within(sample.confidence)) {
            bin.frames += 1;
            bin.correct += usize::from(sample.is_correct);
            bin.confidence_sum += sample.confidence;
        }
        bin
    }

    /// Share of correct frames; NaN where there are no frames.
    pub(super) fn share_correct(&self) -> f64 {
        self.correct as f64 / self.frames as f64
    }

    /// Mean confidence; NaN where there are no frames.
    pub(super) fn mean_confidence(&self) -> f64 {
        self.confidence_sum / self.frames as f64
    }
}

/// The reliability curve.
pub(crate) struct Curve {
    pub(super) bins: Vec<Bin>,
    /// The bin of [`JUDGED_RANGE`].
    pub(super) judged: Bin,
}

impl Curve {
    pub(crate) fn from_samples(samples: &[Sample]) -> Self {
        let edge = |bin: usize| bin as f64 / BINS as f64;
        Self {
            bins: (0..BINS).map(|bin| Bin::from_samples(samples, edge(bin), edge(bin + 1))).collect(),
            judged: Bin::from_samples(samples, JUDGED_RANGE.0, JUDGED_RANGE.1),
        }
    }
}

/// The reported and labelled frames of a run.
pub(crate) fn samples(clip: &Clip, run: &TrackerRun) -> Vec<Sample> {
    let mut samples = Vec::new();
    for (track, label) in run.tracks.iter().zip(clip.tracked_labels()) {
        let (Some(localisation), Some(label)) = (track.localisation(), label) else { continue };
        let is_correct = match label {
            Label::Visible(truth) => iou(*truth, Some(localisation.bounds), clip.size()) >= MIN_CORRECT_IOU,
            Label::Absent => false,
        };
        samples.push(Sample { confidence: localisation.confidence, is_correct });
    }
    samples
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sample(confidence: f64, is_correct: bool) -> Sample {
        Sample { confidence, is_correct }
    }

    #[test]
    fn every_confidence_lies_in_one_bin() {
        let samples: Vec<Sample> =
            (0..=100).map(|step| sample(f64::from(step) / 100.0, step >= 50)).collect();
        let curve = Curve::from_samples(&samples);
        let frames: Vec<usize> = curve.bins.iter().map(|bin| bin.frames).collect();
        assert_eq!(frames, [10, 10, 10, 10, 10, 10, 10, 10, 10, 11]);
        assert_eq!((curve.bins[4].share_correct(), curve.bins[5].share_correct()), (0.0, 1.0));
        assert_eq!(curve.judged.frames, 10);
    }

    #[test]
    fn a_bin_without_frames_has_no_share() {
        let curve = Curve::from_samples(&[sample(0.72, true), sample(0.68, false)]);
        assert!(curve.bins[0].share_correct().is_nan());
        assert_eq!((curve.judged.share_correct(), curve.judged.frames), (0.5, 2));
    }
}
