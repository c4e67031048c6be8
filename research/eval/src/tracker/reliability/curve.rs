//! The reliability curve: the share of correct frames in bins of the confidence.

use super::labelled_frame::LabelledFrame;

/// Bins of 0.1 over 0 to 1.
const BINS: usize = 10;

/// The reported frames with a confidence in a range.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Bin {
    pub(super) low: f64,
    pub(super) high: f64,
    pub(super) frames: usize,
    correct: usize,
    confidence_sum: f64,
}

impl Bin {
    /// Counts the reported frames from `low` to below `high`; a bin up to 1 includes 1.
    fn from_frames(frames: &[LabelledFrame], low: f64, high: f64) -> Self {
        let mut bin = Self { low, high, frames: 0, correct: 0, confidence_sum: 0.0 };
        for frame in frames {
            let Some(confidence) = frame.confidence else { continue };
            if confidence >= low && (confidence < high || high >= 1.0) {
                bin.frames += 1;
                bin.correct += usize::from(frame.is_correct());
                bin.confidence_sum += confidence;
            }
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

    /// Difference of the share of correct frames and the mean confidence, 0 to 1; NaN where there are no
    /// frames.
    pub(super) fn calibration_error(&self) -> f64 {
        (self.share_correct() - self.mean_confidence()).abs()
    }
}

/// The reliability curve.
pub(crate) struct Curve {
    pub(super) bins: Vec<Bin>,
}

impl Curve {
    pub(crate) fn from_frames(frames: &[LabelledFrame]) -> Self {
        let edge = |bin: usize| bin as f64 / BINS as f64;
        Self { bins: (0..BINS).map(|bin| Bin::from_frames(frames, edge(bin), edge(bin + 1))).collect() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn frame(confidence: f64, is_correct: bool) -> LabelledFrame {
        LabelledFrame { confidence: Some(confidence), iou: if is_correct { 0.6 } else { 0.4 } }
    }

    #[test]
    fn every_confidence_lies_in_one_bin() {
        let frames: Vec<LabelledFrame> =
            (0..=100).map(|step| frame(f64::from(step) / 100.0, step >= 50)).collect();
        let curve = Curve::from_frames(&frames);
        let counts: Vec<usize> = curve.bins.iter().map(|bin| bin.frames).collect();
        assert_eq!(counts, [10, 10, 10, 10, 10, 10, 10, 10, 10, 11]);
        assert_eq!((curve.bins[4].share_correct(), curve.bins[5].share_correct()), (0.0, 1.0));
    }

    #[test]
    fn a_bin_without_frames_has_no_share() {
        let silent = LabelledFrame { confidence: None, iou: 0.0 };
        let curve = Curve::from_frames(&[frame(0.72, true), frame(0.78, false), silent]);
        assert!(curve.bins[0].share_correct().is_nan());
        assert_eq!((curve.bins[7].share_correct(), curve.bins[7].frames), (0.5, 2));
        assert!((curve.bins[7].calibration_error() - 0.25).abs() < 1e-12);
    }
}
