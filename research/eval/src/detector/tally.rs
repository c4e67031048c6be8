//! Which detections are right, at one score threshold.

use barrelman_detector::Object;
use barrelman_vocab::PixelBox;

/// Least IoU of a detection that is right, and the least of one that is near.
pub(super) const RIGHT_IOU: f64 = 0.5;
pub(super) const NEAR_IOU: f64 = 0.3;

/// A box that should be detected, with the index of its class; `None`: a class that the model does not have.
pub(super) type Wanted = (PixelBox, Option<usize>);

/// Counts over pictures.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(super) struct Tally {
    pub(super) pictures: usize,
    /// Labelled objects.
    pub(super) wanted: usize,
    /// Labelled objects with a detection of their class, of [`RIGHT_IOU`] and [`NEAR_IOU`].
    pub(super) right: usize,
    pub(super) near: usize,
    pub(super) detections: usize,
}

impl Tally {
    /// Counts a picture: of each detection of at least this score, the highest first, the free label of its
    /// class that it overlaps most.
    pub(super) fn add(&mut self, found: &[Object], wanted: &[Wanted], score: f32) {
        self.pictures += 1;
        self.wanted += wanted.len();
        let found: Vec<&Object> = found.iter().filter(|object| object.score >= score).collect();
        self.detections += found.len();
        self.right += matches(&found, wanted, RIGHT_IOU);
        self.near += matches(&found, wanted, NEAR_IOU);
    }

    /// Labelled objects that were detected, as a share; NaN without any.
    pub(super) fn recall(&self) -> f64 {
        self.right as f64 / self.wanted as f64
    }

    /// The same of detections that are near.
    pub(super) fn near_recall(&self) -> f64 {
        self.near as f64 / self.wanted as f64
    }

    /// Detections that are right, as a share; NaN without any.
    pub(super) fn precision(&self) -> f64 {
        self.right as f64 / self.detections as f64
    }

    pub(super) fn detections_a_picture(&self) -> f64 {
        self.detections as f64 / self.pictures as f64
    }
}

fn matches(found: &[&Object], wanted: &[Wanted], least: f64) -> usize {
    let mut free: Vec<&Wanted> = wanted.iter().collect();
    for object in found {
        let overlap = |label: &&Wanted| {
            if label.1 == Some(object.class) { object.bounds.iou(label.0) } else { 0.0 }
        };
        let best = free.iter().map(overlap).enumerate().max_by(|(_, one), (_, other)| one.total_cmp(other));
        if let Some((index, iou)) = best
            && iou >= least
        {
            free.swap_remove(index);
        }
    }
    wanted.len() - free.len()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn bounds(u: f64) -> PixelBox {
        PixelBox { u, v: 0.0, w: 10.0, h: 10.0 }
    }

    fn object(u: f64, class: usize, score: f32) -> Object {
        Object { bounds: bounds(u), class, score }
    }

    fn tally(found: &[Object], wanted: &[Wanted]) -> Tally {
        let mut tally = Tally::default();
        tally.add(found, wanted, 0.5);
        tally
    }

    #[test]
    fn a_label_counts_once_and_only_with_its_class() {
        let label = [(bounds(0.0), Some(1))];
        let two = tally(&[object(0.0, 1, 0.9), object(1.0, 1, 0.8)], &label);
        assert_eq!((two.right, two.near, two.detections), (1, 1, 2));
        assert_eq!(tally(&[object(0.0, 0, 0.9)], &label).right, 0);
        assert_eq!(tally(&[object(0.0, 0, 0.9)], &[(bounds(0.0), None)]).right, 0);
    }

    #[test]
    fn a_detection_may_be_near_without_being_right() {
        // The boxes share half of their sides: IoU 1/3.
        let near = tally(&[object(5.0, 1, 0.9)], &[(bounds(0.0), Some(1))]);
        assert_eq!((near.right, near.near), (0, 1));
    }

    #[test]
    fn scores_below_the_threshold_do_not_count() {
        let none = tally(&[object(0.0, 1, 0.4)], &[(bounds(0.0), Some(1))]);
        assert_eq!((none.detections, none.recall()), (0, 0.0));
        assert!(none.precision().is_nan());
    }
}
