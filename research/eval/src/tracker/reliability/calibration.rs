//! The figures of the confidence over labelled frames, each frame with the same weight.
//!
//! *Sure and wrong* is a frame reported with a confidence of at least 0.8 where the box has an IoU below 0.1
//! with the label, or the target is absent. *AUROC* is the area under the receiver operating characteristic
//! of the confidence as a test for a correct box: the probability that a correct reported frame has a higher
//! confidence than an incorrect one, where equal confidences count as half.

use serde_json::{Value, json};

use super::curve::{Bin, Curve};
use super::labelled_frame::LabelledFrame;

/// Largest difference of the share of correct frames and the mean confidence, in tenths with enough frames.
pub(super) const MAX_CALIBRATION_ERROR: f64 = 0.12;

/// A tenth with fewer frames is not judged.
pub(super) const MIN_JUDGED_FRAMES: usize = 100;

/// The figures of the confidence. Shares are 0 to 1, and NaN where they are of nothing.
pub(super) struct Calibration {
    /// Labelled frames.
    pub(super) labelled: usize,
    /// Of those, the frames in which a box is reported.
    pub(super) reported: usize,
    /// Of the labelled frames, those that are sure and wrong.
    pub(super) sure_and_wrong: usize,
    /// Share of the correct frames that are sure.
    pub(super) correct_sure_share: f64,
    /// Area under the receiver operating characteristic over the reported frames, 0 to 1; 0.5 tells nothing.
    pub(super) auroc: f64,
    pub(super) curve: Curve,
}

impl Calibration {
    pub(super) fn from_frames(frames: &[LabelledFrame]) -> Self {
        let correct = frames.iter().filter(|frame| frame.is_correct()).count();
        let correct_sure = frames.iter().filter(|frame| frame.is_correct() && frame.is_sure()).count();
        Self {
            labelled: frames.len(),
            reported: frames.iter().filter(|frame| frame.confidence.is_some()).count(),
            sure_and_wrong: frames.iter().filter(|frame| frame.is_sure_and_wrong()).count(),
            correct_sure_share: correct_sure as f64 / correct as f64,
            auroc: auroc(frames),
            curve: Curve::from_frames(frames),
        }
    }

    /// Share of the labelled frames that are sure and wrong.
    pub(super) fn sure_and_wrong_share(&self) -> f64 {
        self.sure_and_wrong as f64 / self.labelled as f64
    }

    /// The tenths with enough frames.
    pub(super) fn judged_bins(&self) -> impl Iterator<Item = &Bin> {
        self.curve.bins.iter().filter(|bin| bin.frames >= MIN_JUDGED_FRAMES)
    }

    pub(super) fn to_json(&self) -> Value {
        let bins = self.curve.bins.iter().map(|bin| {
            json!({
                "low": bin.low, "high": bin.high, "frames": bin.frames, "mean_confidence": bin.mean_confidence(),
                "share_right": bin.share_correct(),
            })
        });
        json!({
            "labelled": self.labelled, "reported": self.reported, "sure_and_wrong": self.sure_and_wrong,
            "sure_and_wrong_share": self.sure_and_wrong_share(), "right_sure_share": self.correct_sure_share,
            "auroc": self.auroc, "bins": bins.collect::<Vec<_>>(),
        })
    }
}

/// The area under the receiver operating characteristic over the reported frames; NaN unless some are correct
/// and some are not.
fn auroc(frames: &[LabelledFrame]) -> f64 {
    let mut reported: Vec<(f64, bool)> = frames
        .iter()
        .filter_map(|frame| frame.confidence.map(|confidence| (confidence, frame.is_correct())))
        .collect();
    reported.sort_by(|(a, _), (b, _)| a.total_cmp(b));
    let (mut incorrect_below, mut pairs) = (0_usize, 0.0);
    for equal in reported.chunk_by(|(a, _), (b, _)| a.total_cmp(b).is_eq()) {
        let correct = equal.iter().filter(|(_, is_correct)| *is_correct).count();
        let incorrect = equal.len() - correct;
        pairs += correct as f64 * (incorrect_below as f64 + incorrect as f64 / 2.0);
        incorrect_below += incorrect;
    }
    let correct = reported.len() - incorrect_below;
    pairs / (correct as f64 * incorrect_below as f64)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn frames(frames: &[(Option<f64>, f64)]) -> Vec<LabelledFrame> {
        frames.iter().map(|&(confidence, iou)| LabelledFrame { confidence, iou }).collect()
    }

    #[test]
    fn shares_are_of_labelled_and_of_correct_frames() {
        let figures = Calibration::from_frames(&frames(&[
            (Some(0.9), 0.7),
            (Some(0.5), 0.7),
            (Some(0.9), 0.0),
            (None, 0.0),
        ]));
        assert_eq!((figures.labelled, figures.reported, figures.sure_and_wrong), (4, 3, 1));
        assert_eq!((figures.sure_and_wrong_share(), figures.correct_sure_share), (0.25, 0.5));
    }

    #[test]
    fn the_auroc_is_the_share_of_pairs_in_the_right_order() {
        let of = |pairs: &[(f64, bool)]| {
            let pairs: Vec<(Option<f64>, f64)> = pairs
                .iter()
                .map(|&(confidence, is_correct)| (Some(confidence), f64::from(u8::from(is_correct))))
                .collect();
            auroc(&frames(&pairs))
        };
        assert_eq!(of(&[(0.9, true), (0.1, false)]), 1.0);
        assert_eq!(of(&[(0.9, false), (0.1, true)]), 0.0);
        assert_eq!(of(&[(0.5, false), (0.5, true)]), 0.5);
        assert_eq!(of(&[(0.2, false), (0.4, true), (0.6, false), (0.8, true)]), 0.75);
        assert!(of(&[(0.9, true)]).is_nan());
    }

    #[test]
    fn frames_without_a_report_do_not_count_in_the_auroc() {
        assert_eq!(auroc(&frames(&[(None, 0.0), (Some(0.9), 0.7), (Some(0.2), 0.2)])), 1.0);
    }
}
