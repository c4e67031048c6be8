//! The stage that knows the scene as it was while the target was sure: two earlier pictures, and where the
//! target was in them. An object that was already there, apart from the target, is another: a sign, a buoy, a
//! hut. What the search for a lost target has found is compared with these pictures before it is reported.
//!
//! Needs neither colours nor a model of the object. Not handled: objects that move by themselves, and a
//! camera that has turned since by more than the search allows for and nothing has told.

use std::sync::Arc;

use barrelman_vocab::{Picture, PixelBox};

use super::found_object::{FoundObject, FoundObjectSettings};
use crate::vector::{Vector, difference, distance, length, sum};

/// Number of earlier pictures.
const VIEWS: usize = 2;
/// Number of objects that are remembered as others.
const MAX_OTHERS: usize = 4;

/// Settings of the comparison with earlier pictures. As a whole, on 16 clips of `pier` that nothing was
/// chosen with, 6 of 6 returns are right instead of 3 of 6 (decision 22).
#[derive(Debug, Clone, Copy)]
pub(super) struct SceneSettings {
    /// Least time between two pictures that are kept, seconds. Not measured by itself.
    view_interval_s: f32,
    /// Confidence of the target from which on a picture is kept, 0 to 1. Not measured by itself.
    min_sure_confidence: f64,
    /// An object that is more confident by this is the target all the same: what was followed then was not, 0
    /// to 1. Not measured by itself.
    overruling_confidence: f64,
    /// Radius of the place of another object, sizes of the target. Not measured by itself.
    radius_sizes: f32,
    /// Added to that radius, pixels. Not measured by itself.
    radius_px: f32,
    /// Another object that was not found again for longer is forgotten, seconds. Not measured by itself.
    max_unseen_s: f32,
    /// Another object that has moved farther is forgotten, too, since the target may have come in its place,
    /// sizes of the target. Not measured by itself.
    max_moved_sizes: f32,
}

impl Default for SceneSettings {
    fn default() -> Self {
        Self {
            view_interval_s: 0.7,
            min_sure_confidence: 0.7,
            overruling_confidence: 0.1,
            radius_sizes: 0.6,
            radius_px: 2.0,
            max_unseen_s: 2.0,
            max_moved_sizes: 1.5,
        }
    }
}

/// What is known of the scene around a target.
#[derive(Debug, Default)]
pub(super) struct KnownScene {
    settings: SceneSettings,
    found_object: FoundObjectSettings,
    /// The newest first.
    views: [Option<View>; VIEWS],
    others: [Option<Other>; MAX_OTHERS],
}

/// An earlier picture.
#[derive(Debug, Clone)]
struct View {
    picture: Arc<Picture>,
    /// The target's box in it.
    target: PixelBox,
    confidence: f64,
    /// How the picture has moved since, pixels, as far as it is known.
    shift: Vector,
    age_s: f32,
}

/// An object that was found and is not the target.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Other {
    /// Where it was found last, pixels.
    place: Vector,
    /// Time since then, seconds.
    unseen_s: f32,
    /// How it has moved in the picture, less the picture's own motion, pixels.
    moved: Vector,
}

impl KnownScene {
    /// Forgets all pictures and objects.
    pub(super) fn clear(&mut self) {
        (self.views, self.others) = Default::default();
    }

    /// Moves what is known with the picture, `seconds` after the last frame.
    pub(super) fn predict(&mut self, shift: Vector, seconds: f32) {
        for view in self.views.iter_mut().flatten() {
            view.shift = sum(view.shift, shift);
            view.age_s += seconds;
        }
        for slot in &mut self.others {
            if let Some(other) = slot {
                other.place = sum(other.place, shift);
                other.unseen_s += seconds;
                slot.take_if(|other| other.unseen_s > self.settings.max_unseen_s);
            }
        }
    }

    /// Keeps a picture with the target in this box if the confidence is high, and if it is time for another.
    pub(super) fn keep(&mut self, picture: &Arc<Picture>, target: PixelBox, confidence: f64) {
        let [newest, _] = &self.views;
        if confidence < self.settings.min_sure_confidence {
            return;
        }
        if newest.as_ref().is_none_or(|view| view.age_s >= self.settings.view_interval_s) {
            self.views.rotate_right(1);
            let picture = Arc::clone(picture);
            self.views[0] = Some(View { picture, target, confidence, shift: (0.0, 0.0), age_s: 0.0 });
        }
    }

    /// The newest picture that was kept, and the target's box in it.
    pub(super) fn newest(&self) -> Option<(&Arc<Picture>, PixelBox)> {
        self.views[0].as_ref().map(|view| (&view.picture, view.target))
    }

    /// Whether what is in this box now, with this confidence, was in an earlier picture, apart from the
    /// target.
    pub(super) fn showed(&self, picture: &Picture, bounds: PixelBox, confidence: f64) -> bool {
        let found = FoundObject::new(&self.found_object, picture, bounds);
        let is_sure_enough =
            |view: &&View| confidence <= view.confidence + self.settings.overruling_confidence;
        self.views
            .iter()
            .flatten()
            .filter(is_sure_enough)
            .any(|view| found.was_in(&view.picture, view.target, view.shift))
    }

    /// Remembers that another object is at a place, pixels.
    pub(super) fn exclude(&mut self, place: Vector) {
        let other = Other { place, unseen_s: 0.0, moved: (0.0, 0.0) };
        let oldest = |slot: &&mut Option<Other>| slot.map_or(f32::INFINITY, |other| other.unseen_s);
        if let Some(slot) = self.others.iter_mut().max_by(|a, b| oldest(a).total_cmp(&oldest(b))) {
            *slot = Some(other);
        }
    }

    /// Whether a place at which something was found, pixels, is that of another object; the target has this
    /// size. Its place follows.
    pub(super) fn is_of_another(&mut self, place: Vector, size: f32) -> bool {
        let settings = self.settings;
        let radius = settings.radius_sizes * size + settings.radius_px;
        let is_at = |other: &Other| distance(other.place, place) <= radius;
        let Some(slot) = self.others.iter_mut().find(|slot| slot.as_ref().is_some_and(is_at)) else {
            return false;
        };
        if let Some(other) = slot {
            other.moved = sum(other.moved, difference(place, other.place));
            (other.place, other.unseen_s) = (place, 0.0);
        }
        slot.take_if(|other| length(other.moved) > settings.max_moved_sizes * size).is_none()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_picture::painted;

    const SIZE: (u32, u32) = (240, 160);
    /// The target's box in the earlier pictures.
    const TARGET: PixelBox = PixelBox { u: 40.0, v: 60.0, w: 20.0, h: 8.0 };

    /// Blue water with noise that differs from picture to picture, and a red box with a white stripe at each
    /// place (left, top).
    fn picture(number: usize, boxes: &[(usize, usize)]) -> Picture {
        painted(SIZE, |column, row| {
            let noise = ((column * 7 + row * 13 + number * 29) * 31 % 11) as u8;
            let at = |&(left, top): &(usize, usize)| {
                ((left..left + 12).contains(&column) && (top..top + 10).contains(&row)).then(|| row - top)
            };
            match boxes.iter().find_map(at) {
                Some(4..6) => [190 + noise, 128, 128],
                Some(_) => [80 + noise, 90, 230],
                None => [90 + noise, 170, 110],
            }
        })
    }

    fn bounds(left: usize, top: usize) -> PixelBox {
        PixelBox { u: left as f64, v: top as f64, w: 12.0, h: 10.0 }
    }

    /// A scene that was kept with objects at these places.
    fn scene(boxes: &[(usize, usize)]) -> KnownScene {
        let mut scene = KnownScene::default();
        scene.keep(&Arc::new(picture(0, boxes)), TARGET, 0.8);
        scene
    }

    #[test]
    fn what_was_there_before_is_known_again_where_the_kite_has_swayed() {
        let scene = scene(&[(150, 40)]);
        for (right, down) in [(0, 0), (5, 3), (9, 10)] {
            let now = (150 + right, 40 + down);
            assert!(scene.showed(&picture(1, &[now]), bounds(now.0, now.1), 0.8), "{right},{down}");
        }
        assert!(!scene.showed(&picture(1, &[(170, 40)]), bounds(170, 40), 0.8), "beyond the search");
    }

    #[test]
    fn what_the_camera_turned_is_looked_for_where_it_was() {
        let mut scene = scene(&[(150, 40)]);
        scene.predict((-90.0, 30.0), 1.0);
        assert!(scene.showed(&picture(1, &[(62, 72)]), bounds(62, 72), 0.8));
        assert!(!scene.showed(&picture(1, &[(150, 40)]), bounds(150, 40), 0.8));
    }

    #[test]
    fn what_was_not_there_may_be_the_target() {
        let scene = scene(&[(150, 40)]);
        assert!(!scene.showed(&picture(1, &[(100, 100)]), bounds(100, 100), 0.8), "water before");
        assert!(
            !KnownScene::default().showed(&picture(1, &[(100, 100)]), bounds(100, 100), 0.8),
            "nothing is known"
        );
    }

    #[test]
    fn what_looks_much_more_like_the_target_is_the_target() {
        let scene = scene(&[(150, 40)]);
        let now = picture(1, &[(150, 40)]);
        assert!(scene.showed(&now, bounds(150, 40), 0.85));
        assert!(!scene.showed(&now, bounds(150, 40), 0.95));
    }

    #[test]
    fn the_target_itself_is_no_other_object() {
        let scene = scene(&[(44, 59)]);
        assert!(!scene.showed(&picture(1, &[(46, 59)]), bounds(46, 59), 0.8));
    }

    #[test]
    fn the_older_of_two_pictures_counts_too_and_a_third_replaces_it() {
        let mut scene = scene(&[(150, 40)]);
        let now = picture(1, &[(150, 40)]);
        let interval_s = scene.settings.view_interval_s;
        // Too early for another picture.
        scene.predict((0.0, 0.0), 0.5 * interval_s);
        scene.keep(&Arc::new(picture(2, &[])), TARGET, 0.8);
        for number in 3..5 {
            assert!(scene.showed(&now, bounds(150, 40), 0.8), "{number}");
            scene.predict((0.0, 0.0), interval_s);
            scene.keep(&Arc::new(picture(number, &[])), TARGET, 0.8);
        }
        assert!(!scene.showed(&now, bounds(150, 40), 0.8));
    }

    #[test]
    fn another_object_is_passed_over_until_it_is_gone_or_has_moved_away() {
        let mut scene = KnownScene::default();
        assert!(!scene.is_of_another((80.0, 50.0), 10.0));
        scene.exclude((80.0, 50.0));
        scene.predict((3.0, 0.0), 0.1);
        assert!(scene.is_of_another((84.0, 51.0), 10.0));
        assert!(!scene.is_of_another((120.0, 51.0), 10.0), "elsewhere");
        // It goes its own way: it may be the target.
        let passed_over =
            (0..9).take_while(|step| scene.is_of_another((88.0 + 4.0 * *step as f32, 51.0), 10.0));
        assert!((2..6).contains(&passed_over.count()));
        scene.exclude((80.0, 50.0));
        scene.predict((0.0, 0.0), 1.1 * scene.settings.max_unseen_s);
        assert!(!scene.is_of_another((80.0, 50.0), 10.0), "not found again for a while");
    }

    #[test]
    fn boxes_at_and_beyond_the_border_are_compared_without_harm() {
        let scene = scene(&[(0, 0), (228, 150)]);
        for (u, v, w, h) in [(0.0, 0.0, 12.0, 10.0), (228.0, 150.0, 12.0, 10.0)] {
            assert!(
                scene.showed(&picture(1, &[(0, 0), (228, 150)]), PixelBox { u, v, w, h }, 0.8),
                "{u},{v}"
            );
        }
        let now = picture(1, &[(100, 100)]);
        assert!(
            !scene.showed(&now, PixelBox { u: 500.0, v: 500.0, w: 9.0, h: 9.0 }, 0.8),
            "nothing to compare"
        );
        for (u, v, w, h) in
            [(-50.0, 20.0, 30.0, 30.0), (0.0, 0.0, 900.0, 900.0), (10.0, f64::NAN, 0.0, f64::INFINITY)]
        {
            scene.showed(&now, PixelBox { u, v, w, h }, 0.8);
        }
    }
}
