//! Where the target may be in each frame of a clip, also between labels.

use barrelman_vocab::PixelBox;

use crate::tracker::clips::Clip;
use crate::tracker::scoring::Label;

/// Where the target may be.
pub(super) struct TargetExtent {
    /// One for each frame; empty where the target is absent, `None` before the first label and after the
    /// last.
    boxes: Vec<Option<PixelBox>>,
    /// The frames in which the target is labelled as visible, with the label.
    visible: Vec<(usize, PixelBox)>,
}

impl TargetExtent {
    /// The label of each labelled frame; between two labels the box around both.
    pub(super) fn from_clip(clip: &Clip) -> Self {
        let labelled: Vec<(usize, PixelBox)> = clip
            .labels
            .iter()
            .enumerate()
            .filter_map(|(frame, label)| match (*label)? {
                Label::Visible(bounds) => Some((frame, bounds)),
                Label::Absent => Some((frame, PixelBox::default())),
            })
            .collect();
        let mut boxes = vec![None; clip.labels.len()];
        for pair in labelled.windows(2) {
            let [(from, a), (to, b)] = *pair else { continue };
            boxes[from + 1..to].fill(Some(hull(a, b)));
        }
        for (frame, bounds) in &labelled {
            boxes[*frame] = Some(*bounds);
        }
        let visible = labelled.into_iter().filter(|(_, bounds)| !bounds.is_empty()).collect();
        Self { boxes, visible }
    }

    /// Whether it is known for all these frames where the target may be.
    pub(super) fn is_known(&self, mut frames: std::ops::RangeInclusive<usize>) -> bool {
        frames.all(|frame| self.boxes[frame].is_some())
    }

    /// Whether the target may meet a box in any of these frames.
    pub(super) fn meets(&self, bounds: PixelBox, mut frames: std::ops::RangeInclusive<usize>) -> bool {
        frames.any(|frame| self.boxes[frame].is_none_or(|target| !target.intersection(bounds).is_empty()))
    }

    /// Width and height of the target in the visible label next to a frame, pixels.
    pub(super) fn size_near(&self, frame: usize) -> (f64, f64) {
        let nearest = self.visible.iter().min_by_key(|(labelled, _)| labelled.abs_diff(frame));
        nearest.map_or((0.0, 0.0), |(_, bounds)| (bounds.w, bounds.h))
    }
}

/// The box around two boxes, of which either may be empty.
fn hull(a: PixelBox, b: PixelBox) -> PixelBox {
    if a.is_empty() {
        return b;
    }
    if b.is_empty() {
        return a;
    }
    let (u, v) = (a.u.min(b.u), a.v.min(b.v));
    PixelBox { u, v, w: (a.u + a.w).max(b.u + b.w) - u, h: (a.v + a.h).max(b.v + b.h) - v }
}

#[cfg(test)]
mod tests {
    use super::*;

    const A: PixelBox = PixelBox { u: 10.0, v: 10.0, w: 20.0, h: 10.0 };
    const B: PixelBox = PixelBox { u: 50.0, v: 40.0, w: 10.0, h: 10.0 };

    fn extent(labels: &[Option<Label>]) -> TargetExtent {
        TargetExtent::from_clip(&Clip {
            name: "clip".to_owned(),
            frames: Vec::new(),
            labels: labels.to_vec(),
            start: 0,
            selection: A,
        })
    }

    #[test]
    fn between_two_labels_the_target_may_be_anywhere_between_them() {
        let extent = extent(&[Some(Label::Visible(A)), None, Some(Label::Visible(B)), None]);
        let between = PixelBox { u: 35.0, v: 25.0, w: 5.0, h: 5.0 };
        assert!(extent.meets(between, 1..=1) && !extent.meets(between, 2..=2));
        assert!(extent.is_known(0..=2) && !extent.is_known(0..=3));
        assert!(extent.meets(between, 3..=3), "nothing is known after the last label");
    }

    #[test]
    fn an_absent_target_meets_nothing_and_keeps_its_size() {
        let extent = extent(&[Some(Label::Visible(A)), Some(Label::Absent), Some(Label::Absent)]);
        assert!(!extent.meets(A, 1..=2) && extent.meets(A, 0..=2));
        assert_eq!(extent.size_near(2), (20.0, 10.0));
    }
}
