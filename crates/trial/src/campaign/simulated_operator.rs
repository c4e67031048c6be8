//! The operator of a simulated trial in pixels, who selects the target once.

use barrelman_sim::random::{CounterRng, Stream};
use barrelman_vocab::{PictureSize, PixelBox};

use super::hand_drawn_box::{MIN_BOX_PX, drawn_by_hand};
use crate::target_in_picture::TargetInPicture;

/// Least visible share of a target that an operator selects.
const MIN_VISIBLE_SHARE: f64 = 0.8;

/// How the target is selected.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum SimulatedOperator {
    /// By its exact bounds, as soon as any part is visible.
    Exact,
    /// The same with a box that is not too small to be drawn: the tracker has refused the exact one.
    ExactAgain,
    /// Like a person: when the target is well visible, by a box that is drawn by hand.
    Person(CounterRng),
}

impl SimulatedOperator {
    /// A person. The box depends on the seed alone.
    pub(super) const fn person(seed: u64) -> Self {
        Self::Person(CounterRng::new(seed, Stream::Operator))
    }

    /// The box that the operator draws on a picture; `None`: the operator waits for another picture.
    pub(super) fn selection(self, target: &TargetInPicture, picture: PictureSize) -> Option<PixelBox> {
        let bounds = target.bounds?;
        match self {
            Self::Exact => Some(bounds),
            Self::ExactAgain => Some(at_least_drawable(bounds)),
            Self::Person(rng) if target.visible_share >= MIN_VISIBLE_SHARE => {
                Some(drawn_by_hand(bounds, picture, |index, range| rng.between(index, range)))
            }
            Self::Person(_) => None,
        }
    }
}

/// A box about the bounds that can be drawn by hand.
fn at_least_drawable(bounds: PixelBox) -> PixelBox {
    let (w, h) = (bounds.w.max(MIN_BOX_PX.0), bounds.h.max(MIN_BOX_PX.1));
    PixelBox { u: bounds.u - 0.5 * (w - bounds.w), v: bounds.v - 0.5 * (h - bounds.h), w, h }
}

#[cfg(test)]
mod tests {
    use super::*;

    const PICTURE: PictureSize = PictureSize::new(640, 360);
    const BOUNDS: PixelBox = PixelBox { u: 300.0, v: 200.0, w: 40.0, h: 20.0 };

    fn drawn(seed: u64, bounds: PixelBox, visible_share: f64) -> Option<PixelBox> {
        let target = TargetInPicture { bounds: Some(bounds), visible_share };
        SimulatedOperator::person(seed).selection(&target, PICTURE)
    }

    #[test]
    fn a_person_waits_until_the_target_is_well_visible() {
        assert_eq!(drawn(1, BOUNDS, 0.79), None);
        assert!(drawn(1, BOUNDS, 0.8).is_some());
        let hidden = TargetInPicture { bounds: None, visible_share: 1.0 };
        assert_eq!(SimulatedOperator::person(1).selection(&hidden, PICTURE), None);
        let target = TargetInPicture { bounds: Some(BOUNDS), visible_share: 0.1 };
        assert_eq!(SimulatedOperator::Exact.selection(&target, PICTURE), Some(BOUNDS));
    }

    #[test]
    fn a_box_drawn_by_hand_is_about_right() {
        let mut ious = Vec::new();
        for seed in 0..300 {
            let drawn = drawn(seed, BOUNDS, 1.0).unwrap();
            let (w, h) = (drawn.w / BOUNDS.w, drawn.h / BOUNDS.h);
            assert!((0.85..=1.5).contains(&w) && (0.85..=1.5).contains(&h), "{drawn:?}");
            let (u, v) = (drawn.u + 0.5 * drawn.w - 320.0, drawn.v + 0.5 * drawn.h - 210.0);
            assert!(u.abs() <= 6.0 + 1e-9 && v.abs() <= 3.0 + 1e-9, "{drawn:?}");
            ious.push(drawn.iou(BOUNDS));
        }
        ious.sort_by(f64::total_cmp);
        assert!(ious[0] < 0.55 && ious[299] > 0.85, "some boxes are loose, some are tight");
    }

    #[test]
    fn an_exact_box_that_was_refused_is_drawn_larger() {
        let target = |w, h| TargetInPicture {
            bounds: Some(PixelBox { u: 100.0, v: 100.0, w, h }),
            visible_share: 1.0,
        };
        let drawn = |w, h| SimulatedOperator::ExactAgain.selection(&target(w, h), PICTURE);
        assert_eq!(drawn(9.0, 3.0), Some(PixelBox { u: 100.0, v: 98.5, w: 9.0, h: 6.0 }));
        assert_eq!(SimulatedOperator::Exact.selection(&target(9.0, 3.0), PICTURE), target(9.0, 3.0).bounds);
    }

    #[test]
    fn a_box_is_large_enough_to_be_drawn_and_within_the_picture() {
        let tiny = drawn(5, PixelBox { w: 2.0, h: 1.0, ..BOUNDS }, 1.0).unwrap();
        assert_eq!((tiny.w, tiny.h), (8.0, 6.0));
        for seed in 0..50 {
            let drawn = drawn(seed, PixelBox { u: 0.0, v: 340.0, w: 40.0, h: 20.0 }, 1.0).unwrap();
            assert!(drawn.u >= 0.0 && drawn.v + drawn.h <= 360.0, "{drawn:?}");
        }
    }
}
