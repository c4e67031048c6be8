//! The scene as it was while the target was sure: two earlier pictures, and where the target was in them. A thing that was
//! already there, apart from the target, is another: a sign, a buoy, a hut. What the search for a lost target has found is
//! compared with these pictures before it is reported.
//!
//! Needs neither colours nor a model of the thing. Not handled: things that move by themselves, and a camera that has turned since
//! by more than the search allows for and nothing has told.

use std::sync::Arc;

use barrelman_vocab::{Picture, PictureSize, PixelBox};

use super::vector::{Vector, difference, length, sum};

/// Number of earlier pictures, and the least time between two, seconds.
const VIEWS: usize = 2;
const VIEW_INTERVAL_S: f32 = 0.7;
/// A thing was there if it differs from an earlier picture by at most this share of how it differs from what is around it.
const MAX_DIFFERENCE: f32 = 0.5;
/// A thing that looks so much more like the target, by its confidence, is the target all the same: what was followed then was not.
const OVERRULING_CONFIDENCE: f64 = 0.1;
/// How far from its place a thing is looked for, as a share of the picture's width: the kite sways.
const SEARCH_SHARE: f32 = 0.047;
/// The compared place is larger than the box by this factor, and its sides are at least so long, pixels.
const MARGIN_FACTOR: f32 = 1.15;
const MIN_SIDE_PX: f32 = 6.0;
const MAX_SIDE_PX: f32 = 65_535.0;
/// Largest number of samples along a side.
const MAX_SAMPLES: usize = 16;
/// A picture that has moved by more shows nothing of before, pixels.
const MAX_SHIFT_PX: f32 = 1.0e6;
/// What is around the place reaches so far from it, in its longer sides.
const AROUND_SIDES: f32 = 0.7;

/// Number of things that are remembered as others.
const MAX_OTHERS: usize = 4;
/// Radius of the place of another thing: sizes of the target, and pixels.
const RADIUS_SIZES: f32 = 0.6;
const RADIUS_PX: f32 = 2.0;
/// A thing that was not found again for so long is forgotten, seconds; one that has moved so far, too, since the target may have come
/// in its place, sizes of the target.
const MAX_UNSEEN_S: f32 = 2.0;
const MAX_MOVED_SIZES: f32 = 1.5;

/// What is known of the scene around a target.
#[derive(Debug, Clone, Default)]
pub(super) struct KnownScene {
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

/// A thing that was found and is not the target.
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
                slot.take_if(|other| other.unseen_s > MAX_UNSEEN_S);
            }
        }
    }

    /// Keeps a picture in which the target is sure in this box, with this confidence, if it is time for another.
    pub(super) fn keep(&mut self, picture: &Arc<Picture>, target: PixelBox, confidence: f64) {
        let [newest, _] = &self.views;
        if newest.as_ref().is_none_or(|view| view.age_s >= VIEW_INTERVAL_S) {
            self.views.rotate_right(1);
            let picture = Arc::clone(picture);
            self.views[0] = Some(View { picture, target, confidence, shift: (0.0, 0.0), age_s: 0.0 });
        }
    }

    /// The newest picture that was kept, and the target's box in it.
    pub(super) fn newest(&self) -> Option<(&Arc<Picture>, PixelBox)> {
        self.views[0].as_ref().map(|view| (&view.picture, view.target))
    }

    /// Whether what is in this box now, with this confidence, was in an earlier picture, apart from the target.
    pub(super) fn showed(&self, picture: &Picture, bounds: PixelBox, confidence: f64) -> bool {
        let found = FoundObject::new(picture, bounds);
        let is_sure_enough = |view: &&View| confidence <= view.confidence + OVERRULING_CONFIDENCE;
        self.views.iter().flatten().filter(is_sure_enough).any(|view| found.was_in(view))
    }

    /// Remembers that another thing is at a place, pixels.
    pub(super) fn exclude(&mut self, place: Vector) {
        let other = Other { place, unseen_s: 0.0, moved: (0.0, 0.0) };
        let oldest = |slot: &&mut Option<Other>| slot.map_or(f32::INFINITY, |other| other.unseen_s);
        if let Some(slot) = self.others.iter_mut().max_by(|a, b| oldest(a).total_cmp(&oldest(b))) {
            *slot = Some(other);
        }
    }

    /// Whether a place at which something was found, pixels, is that of another thing; the target has this size. The thing's
    /// place follows.
    pub(super) fn is_of_another(&mut self, place: Vector, size: f32) -> bool {
        let radius = RADIUS_SIZES * size + RADIUS_PX;
        let is_at = |other: &Other| length(difference(other.place, place)) <= radius;
        let Some(slot) = self.others.iter_mut().find(|slot| slot.as_ref().is_some_and(is_at)) else {
            return false;
        };
        if let Some(other) = slot {
            other.moved = sum(other.moved, difference(place, other.place));
            (other.place, other.unseen_s) = (place, 0.0);
        }
        slot.take_if(|other| length(other.moved) > MAX_MOVED_SIZES * size).is_none()
    }
}

/// Samples of a thing in the present picture.
struct FoundObject {
    /// Of the picture.
    size: PictureSize,
    /// Left, top, right, bottom, pixels; the distance of two samples, pixels.
    sides: [i32; 4],
    step: i32,
    /// Its samples, those first that differ most from what is around it: they tell soonest that a place is not like it.
    samples: [Sample; MAX_SAMPLES * MAX_SAMPLES],
    count: usize,
    /// Sum of their squared differences from what is around it.
    contrast: f32,
}

#[derive(Clone, Copy, Default)]
struct Sample {
    /// Pixels right and down.
    place: (i32, i32),
    colour: [i32; 3],
    /// Squared difference from what is around the object.
    contrast: i32,
}

impl FoundObject {
    fn new(picture: &Picture, bounds: PixelBox) -> Self {
        let size = picture.size();
        let (width, height) = (size.width as i32, size.height as i32);
        let middle = bounds.centre();
        let side = |length: f64| (MARGIN_FACTOR * length as f32).clamp(MIN_SIDE_PX, MAX_SIDE_PX);
        let (w, h) = (side(bounds.w), side(bounds.h));
        let first = |middle: f64, side: f32, length: i32| {
            (middle as f32 - 0.5 * side).round().clamp(0.0, length as f32) as i32
        };
        let (left, top) = (first(middle.u, w, width), first(middle.v, h, height));
        let (right, bottom) = ((left + w.round() as i32).min(width), (top + h.round() as i32).min(height));
        let step = (w.max(h) / MAX_SAMPLES as f32).ceil().max(1.0) as i32;
        let margin = (AROUND_SIDES * w.max(h)) as i32;
        let around = [
            (left - margin).max(0),
            (top - margin).max(0),
            (right + margin).min(width),
            (bottom + margin).min(height),
        ];
        let median = median_of(picture, around, step);
        let sides = [left, top, right, bottom];
        let mut samples = [Sample::default(); MAX_SAMPLES * MAX_SAMPLES];
        let mut count = 0;
        for (sample, (u, v)) in samples.iter_mut().zip(places(sides, step)) {
            let colour = colour_at(picture, u, v);
            *sample =
                Sample { place: (u as i32, v as i32), colour, contrast: squared_difference(colour, median) };
            count += 1;
        }
        samples[..count].sort_unstable_by_key(|sample| core::cmp::Reverse((sample.contrast, sample.place)));
        let contrast = samples[..count].iter().map(|sample| sample.contrast).sum::<i32>() as f32;
        Self { size, sides, step, samples, count, contrast }
    }

    /// Whether an earlier picture shows it, apart from the target.
    fn was_in(&self, view: &View) -> bool {
        let size = view.picture.size();
        if size != self.size || self.contrast <= 0.0 {
            return false;
        }
        let [left, top, right, bottom] = self.sides;
        let reach = (SEARCH_SHARE * size.width as f32) as i32 / self.step;
        let pixels = |shift: f32| shift.round().clamp(-MAX_SHIFT_PX, MAX_SHIFT_PX) as i32;
        let (u, v) = (-pixels(view.shift.0), -pixels(view.shift.1));
        let steps = || (-reach..=reach).map(|steps| steps * self.step);
        let is_in_picture = |right_by: i32, down_by: i32| {
            left + right_by >= 0
                && top + down_by >= 0
                && right + right_by <= size.width as i32
                && bottom + down_by <= size.height as i32
        };
        let is_apart = |right_by: i32, down_by: i32| {
            let place = PixelBox {
                u: f64::from(left + right_by),
                v: f64::from(top + down_by),
                w: f64::from(right - left),
                h: f64::from(bottom - top),
            };
            place.intersection(view.target).is_empty()
        };
        steps().any(|down| {
            steps().any(|right| {
                let (right_by, down_by) = (u + right, v + down);
                is_in_picture(right_by, down_by)
                    && is_apart(right_by, down_by)
                    && self.is_like(&view.picture, right_by, down_by)
            })
        })
    }

    /// Whether an earlier picture is like the present one at the thing, displaced by this, pixels.
    fn is_like(&self, earlier: &Picture, right_by: i32, down_by: i32) -> bool {
        let limit = (MAX_DIFFERENCE * self.contrast) as i32;
        let mut total = 0;
        for sample in &self.samples[..self.count] {
            let (u, v) = (sample.place.0 + right_by, sample.place.1 + down_by);
            total += squared_difference(sample.colour, colour_at(earlier, u as usize, v as usize));
            if total > limit {
                return false;
            }
        }
        true
    }
}

/// Every `step`-th pixel between these sides (left, top, right, bottom).
fn places([left, top, right, bottom]: [i32; 4], step: i32) -> impl Iterator<Item = (usize, usize)> {
    let step = step as usize;
    (top..bottom)
        .step_by(step)
        .flat_map(move |v| (left..right).step_by(step).map(move |u| (u as usize, v as usize)))
}

/// Y, U and V of a pixel.
fn colour_at(picture: &Picture, u: usize, v: usize) -> [i32; 3] {
    let chroma = (u / 2, v / 2);
    [
        i32::from(picture.y().row(v)[u]),
        i32::from(picture.u().row(chroma.1)[chroma.0]),
        i32::from(picture.v().row(chroma.1)[chroma.0]),
    ]
}

fn squared_difference(a: [i32; 3], b: [i32; 3]) -> i32 {
    a.iter().zip(b).map(|(a, b)| (a - b) * (a - b)).sum()
}

/// The medians of Y, U and V of every `step`-th pixel between these sides.
fn median_of(picture: &Picture, sides: [i32; 4], step: i32) -> [i32; 3] {
    let mut counts = [[0_u32; 256]; 3];
    let mut all = 0;
    for (u, v) in places(sides, step) {
        all += 1;
        for (counts, value) in counts.iter_mut().zip(colour_at(picture, u, v)) {
            counts[value as usize] += 1;
        }
    }
    counts.map(|counts| {
        let mut below = 0;
        let is_median = |count: &u32| {
            below += count;
            2 * below >= all
        };
        counts.iter().position(is_median).unwrap_or_default() as i32
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_picture::painted;

    const SIZE: (u32, u32) = (240, 160);
    /// The target's box in the earlier pictures.
    const TARGET: PixelBox = PixelBox { u: 40.0, v: 60.0, w: 20.0, h: 8.0 };

    /// Blue water with noise that differs from picture to picture, and a red box with a white stripe at each place (left, top).
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

    /// A scene that was kept with things at these places.
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
    fn the_target_itself_is_no_other_thing() {
        let scene = scene(&[(44, 59)]);
        assert!(!scene.showed(&picture(1, &[(46, 59)]), bounds(46, 59), 0.8));
    }

    #[test]
    fn the_older_of_two_pictures_counts_too_and_a_third_replaces_it() {
        let mut scene = scene(&[(150, 40)]);
        let now = picture(1, &[(150, 40)]);
        // Too early for another picture.
        scene.predict((0.0, 0.0), 0.5 * VIEW_INTERVAL_S);
        scene.keep(&Arc::new(picture(2, &[])), TARGET, 0.8);
        for number in 3..5 {
            assert!(scene.showed(&now, bounds(150, 40), 0.8), "{number}");
            scene.predict((0.0, 0.0), VIEW_INTERVAL_S);
            scene.keep(&Arc::new(picture(number, &[])), TARGET, 0.8);
        }
        assert!(!scene.showed(&now, bounds(150, 40), 0.8));
    }

    #[test]
    fn another_thing_is_passed_over_until_it_is_gone_or_has_moved_away() {
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
        scene.predict((0.0, 0.0), 1.1 * MAX_UNSEEN_S);
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
