//! How well a tracker's boxes agree with the labels of a clip.
//!
//! Scored are all labelled frames with the target, except the selection's. Both boxes are clipped to the
//! picture; their IoU is the intersection over the union. The *success AUC* is the mean over the 21
//! thresholds 0, 0.05 .. 1 of the share of scored frames with an IoU strictly above the threshold: the area
//! under the success curve of Wu, Lim and Yang (Online object tracking: a benchmark, 2013). The *precision*
//! is the share with a centre error of at most 20 px, the *lost* share that with an IoU below 0.1. Where the
//! tracker reports no box, the IoU is 0 and the centre imprecise. Frames labelled as without the target count
//! only in the share of them in which a box was reported.

use barrelman_vocab::{PictureSize, PixelBox};

/// Steps of the thresholds of the success curve: 0, 1/20 .. 20/20.
const THRESHOLD_STEPS: u32 = 20;

/// Largest centre error that counts as precise, pixels: that of the benchmark above.
const MAX_PRECISE_PX: f64 = 20.0;

/// With an IoU below this the target is lost.
const MIN_IOU: f64 = 0.1;

/// The label of a frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Label {
    /// The target's box.
    Visible(PixelBox),
    /// The target is not in the picture, or wholly occluded.
    Absent,
}

/// The scores of one run over one clip; shares are 0 to 1, and 0 where nothing was scored.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct Score {
    /// Area under the success curve.
    pub(crate) auc: f64,
    /// Share of scored frames with the centre within 20 px.
    pub(crate) precision: f64,
    /// Share of scored frames with an IoU below 0.1, or nothing reported.
    pub(crate) lost: f64,
    /// Frames labelled with the target in them.
    pub(crate) scored: usize,
    /// Frames labelled as without the target.
    pub(crate) absent: usize,
    /// Of those, the frames in which a box was reported.
    pub(crate) absent_reported: usize,
}

impl Score {
    /// Share of the frames without the target in which a box was reported; `None` where no frame is without
    /// it.
    pub(crate) fn absent_share(&self) -> Option<f64> {
        (self.absent > 0).then(|| self.absent_reported as f64 / self.absent as f64)
    }
}

/// Scores boxes against labels, frame by frame, both without the selection's.
pub(crate) fn score_boxes(
    labels: &[Option<Label>],
    boxes: &[Option<PixelBox>],
    picture: PictureSize,
) -> Score {
    let mut score = Score::default();
    let (mut above, mut precise, mut lost) = (0_usize, 0_usize, 0_usize);
    for (label, reported) in labels.iter().zip(boxes) {
        match label {
            None => {}
            Some(Label::Absent) => {
                score.absent += 1;
                score.absent_reported += usize::from(reported.is_some());
            }
            Some(Label::Visible(truth)) => {
                let iou = iou(*truth, *reported, picture);
                score.scored += 1;
                above += (0..=THRESHOLD_STEPS)
                    .filter(|step| iou > f64::from(*step) / f64::from(THRESHOLD_STEPS))
                    .count();
                precise += usize::from(
                    centre_error_px(*truth, *reported, picture).is_some_and(|error| error <= MAX_PRECISE_PX),
                );
                lost += usize::from(iou < MIN_IOU);
            }
        }
    }
    if score.scored > 0 {
        let scored = score.scored as f64;
        score.auc = above as f64 / (scored * f64::from(THRESHOLD_STEPS + 1));
        score.precision = precise as f64 / scored;
        score.lost = lost as f64 / scored;
    }
    score
}

/// Intersection over union of both boxes, each clipped to the picture; 0 where no box was reported.
pub(crate) fn iou(truth: PixelBox, reported: Option<PixelBox>, picture: PictureSize) -> f64 {
    reported.map_or(0.0, |reported| truth.clipped(picture).iou(reported.clipped(picture)))
}

/// Distance between the centres of both boxes, each clipped to the picture; `None` where no box is in the
/// picture.
fn centre_error_px(truth: PixelBox, reported: Option<PixelBox>, picture: PictureSize) -> Option<f64> {
    let reported =
        reported.map(|reported| reported.clipped(picture)).filter(|clipped| !clipped.is_empty())?;
    let (a, b) = (truth.clipped(picture).centre(), reported.centre());
    Some((a.u - b.u).hypot(a.v - b.v))
}

#[cfg(test)]
mod tests {
    use super::*;

    const PICTURE: PictureSize = PictureSize::new(200, 100);
    const TARGET: PixelBox = PixelBox { u: 20.0, v: 10.0, w: 40.0, h: 20.0 };

    fn moved(by: f64) -> Option<PixelBox> {
        Some(PixelBox { u: TARGET.u + by, ..TARGET })
    }

    fn score_in_picture(labels: &[Option<Label>], boxes: &[Option<PixelBox>]) -> Score {
        score_boxes(labels, boxes, PICTURE)
    }

    fn check(boxes: &[Option<PixelBox>], auc: f64, precision: f64, lost: f64) {
        let labels = vec![Some(Label::Visible(TARGET)); boxes.len()];
        let score = score_in_picture(&labels, boxes);
        // Sums of a few shares: rounded in the last digits only.
        let close = |a: f64, b: f64| (a - b).abs() < 1e-12;
        assert!(close(score.auc, auc), "AUC {} for {boxes:?}", score.auc);
        assert!(close(score.precision, precision), "precision {} for {boxes:?}", score.precision);
        assert!(close(score.lost, lost), "lost {} for {boxes:?}", score.lost);
    }

    #[test]
    fn thresholds_are_exceeded_strictly() {
        // The same box is above 0 .. 0.95, and not above 1.
        check(&[moved(0.0)], 20.0 / 21.0, 1.0, 0.0);
        // Half of each: an IoU of 1/3 is above 0 .. 0.3.
        check(&[moved(20.0)], 7.0 / 21.0, 1.0, 0.0);
        // Twice the width: an IoU of exactly 0.5 is above 0 .. 0.45.
        check(&[Some(PixelBox { w: 80.0, ..TARGET })], 10.0 / 21.0, 1.0, 0.0);
    }

    #[test]
    fn silence_is_a_miss_in_every_measure() {
        check(&[None], 0.0, 0.0, 1.0);
        check(&[None, moved(0.0)], 10.0 / 21.0, 0.5, 0.5);
    }

    #[test]
    fn a_box_elsewhere_is_lost() {
        check(&[moved(100.0)], 0.0, 0.0, 1.0);
        // 2 of 78 pixels' width: an IoU of 0.026 is above 0 alone, and lost.
        check(&[moved(38.0)], 1.0 / 21.0, 0.0, 1.0);
    }

    #[test]
    fn a_centre_is_precise_up_to_twenty_pixels() {
        check(&[moved(20.0), moved(20.5)], 7.0 / 21.0 / 2.0 + 7.0 / 21.0 / 2.0, 0.5, 0.0);
    }

    #[test]
    fn what_lies_outside_the_picture_is_cut_off() {
        let label = PixelBox { u: -40.0, v: 0.0, w: 80.0, h: 20.0 };
        let seen = PixelBox { u: 0.0, v: 0.0, w: 40.0, h: 20.0 };
        let score = score_in_picture(&[Some(Label::Visible(label))], &[Some(seen)]);
        assert_eq!((score.auc, score.precision), (20.0 / 21.0, 1.0));
        let score = score_in_picture(&[Some(Label::Visible(seen))], &[Some(label)]);
        assert_eq!((score.auc, score.precision), (20.0 / 21.0, 1.0));
        let outside = PixelBox { u: -90.0, ..label };
        assert_eq!(score_in_picture(&[Some(Label::Visible(seen))], &[Some(outside)]).lost, 1.0);
    }

    #[test]
    fn frames_without_a_label_do_not_count() {
        let score =
            score_in_picture(&[None, Some(Label::Visible(TARGET)), None], &[None, moved(0.0), moved(90.0)]);
        assert_eq!((score.scored, score.absent, score.auc), (1, 0, 20.0 / 21.0));
        assert_eq!(score.absent_share(), None);
    }

    #[test]
    fn an_absent_target_counts_by_itself() {
        let labels = [Some(Label::Absent), Some(Label::Absent), Some(Label::Visible(TARGET))];
        let score = score_in_picture(&labels, &[None, moved(0.0), moved(0.0)]);
        assert_eq!((score.scored, score.auc, score.lost), (1, 20.0 / 21.0, 0.0));
        assert_eq!(score.absent_share(), Some(0.5));
    }
}
