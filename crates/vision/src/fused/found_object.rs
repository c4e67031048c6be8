//! An object in the present picture, and whether an earlier picture shows the same object.

use crate::vector::Vector;
use barrelman_vocab::{Picture, PictureSize, PixelBox};

/// Maximum side of the compared place, pixels.
const MAX_SIDE_PX: f32 = 65_535.0;
/// Maximum number of samples along a side.
const MAX_SAMPLES: usize = 16;
/// Maximum shift of an earlier picture, pixels.
const MAX_SHIFT_PX: f32 = 1.0e6;

/// Settings of the comparison. Settings without a figure were not measured individually.
#[derive(Debug, Clone, Copy)]
pub(super) struct FoundObjectSettings {
    /// Maximum squared difference of the object from an earlier picture that shows it, relative to its
    /// squared difference from its surroundings.
    max_difference: f32,
    /// Maximum distance from its place at which an object is looked for, relative to the picture's width: the
    /// kite sways.
    search_share: f32,
    /// Size of the compared place, relative to the object's box.
    margin_factor: f32,
    /// Minimum side of the compared place, pixels.
    min_side_px: f32,
    /// Width of the surroundings of the place, in longer sides of the place.
    around_sides: f32,
}

impl Default for FoundObjectSettings {
    fn default() -> Self {
        Self {
            max_difference: 0.5,
            search_share: 0.047,
            margin_factor: 1.15,
            min_side_px: 6.0,
            around_sides: 0.7,
        }
    }
}

/// Samples of an object in the present picture.
pub(super) struct FoundObject {
    settings: FoundObjectSettings,
    /// Size of the picture.
    size: PictureSize,
    /// Left, top, right and bottom side of the compared place, pixels.
    sides: [i32; 4],
    /// Distance of neighbouring samples, pixels.
    step: i32,
    /// The samples, in descending order of their difference from the surroundings: the first ones exclude a
    /// different place soonest.
    samples: [Sample; MAX_SAMPLES * MAX_SAMPLES],
    count: usize,
    /// Sum of the squared differences of the samples from the surroundings.
    contrast: f32,
}

#[derive(Clone, Copy, Default)]
struct Sample {
    /// Pixels right and down.
    place: (i32, i32),
    colour: [i32; 3],
    /// Squared difference from the median of the surroundings.
    contrast: i32,
}

impl FoundObject {
    pub(super) fn new(settings: &FoundObjectSettings, picture: &Picture, bounds: PixelBox) -> Self {
        let size = picture.size();
        let (width, height) = (size.width as i32, size.height as i32);
        let middle = bounds.centre();
        let side =
            |length: f64| (settings.margin_factor * length as f32).clamp(settings.min_side_px, MAX_SIDE_PX);
        let (w, h) = (side(bounds.w), side(bounds.h));
        let first = |middle: f64, side: f32, length: i32| {
            (middle as f32 - 0.5 * side).round().clamp(0.0, length as f32) as i32
        };
        let (left, top) = (first(middle.u, w, width), first(middle.v, h, height));
        let (right, bottom) = ((left + w.round() as i32).min(width), (top + h.round() as i32).min(height));
        let step = (w.max(h) / MAX_SAMPLES as f32).ceil().max(1.0) as i32;
        let margin = (settings.around_sides * w.max(h)) as i32;
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
        Self { settings: *settings, size, sides, step, samples, count, contrast }
    }

    /// Whether an earlier picture shows the object apart from the target. `target` is the target's box in
    /// that picture, `shift` the motion of the picture since, pixels.
    pub(super) fn was_in(&self, earlier: &Picture, target: PixelBox, shift: Vector) -> bool {
        let size = earlier.size();
        if size != self.size || self.contrast <= 0.0 {
            return false;
        }
        let [left, top, right, bottom] = self.sides;
        let reach = (self.settings.search_share * size.width as f32) as i32 / self.step;
        let pixels = |moved: f32| moved.round().clamp(-MAX_SHIFT_PX, MAX_SHIFT_PX) as i32;
        let (u, v) = (-pixels(shift.0), -pixels(shift.1));
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
            place.intersection(target).is_empty()
        };
        steps().any(|down| {
            steps().any(|right| {
                let (right_by, down_by) = (u + right, v + down);
                is_in_picture(right_by, down_by)
                    && is_apart(right_by, down_by)
                    && self.is_like(earlier, right_by, down_by)
            })
        })
    }

    /// Whether an earlier picture resembles the present one at the object, displaced by this, pixels.
    fn is_like(&self, earlier: &Picture, right_by: i32, down_by: i32) -> bool {
        let limit = (self.settings.max_difference * self.contrast) as i32;
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
