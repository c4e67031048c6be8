//! The target's paint: one chroma that sets the target apart from what is around it.
//!
//! A sample of chroma at the edge of a target shows a mixture of paint and surroundings. With the chroma p of
//! the paint and the mean chroma b of the surroundings, the share of the paint in a sample of the chroma c is
//!
//! ```text
//! share = (c - b) (p - b) / |p - b|^2        (inner product in the plane of U and V)
//! ```
//!
//! The weight of a sample is (share - q) / (1 - q), from 0 to 1, with the share q that nine tenths of the
//! surroundings do not reach. Foam has a share, too: white lies between blue water and red paint. For a
//! target that is many samples wide, q is at least the share of foam, so that its wake counts nothing.
//! Mixtures are weighed in proportion, so that the moments of a target of a few samples can be measured
//! ([`Silhouette`]). The target probability of the colour model cannot do that: a mixed colour is a colour of
//! its own there, and may be unknown.

use crate::crop::Crop;
use crate::silhouette::Silhouette;
use crate::vector::{Rotation, distance};

/// A chroma.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Paint {
    u: f32,
    v: f32,
}

/// What a share of the paint is measured against.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct PaintScale {
    /// Mean chroma of the surroundings.
    background: (f32, f32),
    /// From there to the paint, divided by the squared distance.
    direction: (f32, f32),
    /// The share that nine tenths of the surroundings do not reach.
    pub(crate) ring: f32,
    /// The share up to which a sample has no weight.
    floor: f32,
}

/// The surroundings begin beyond this multiple of the target's half axes and so many pixels, and end beyond
/// these.
const RING_INNER: (f32, f32) = (1.3, 3.0);
const RING_OUTER: (f32, f32) = (2.0, 10.0);
/// Minimum distance of the paint from the mean of the surroundings, levels of chroma.
const MIN_DISTANCE: f32 = 20.0;
/// Maximum share of the paint in the surroundings.
const MAX_FLOOR: f32 = 0.6;
/// Chroma of foam, which is white, and the maximum share of the paint in it.
const NEUTRAL: u8 = 128;
const MAX_FOAM_SHARE: f32 = 0.6;
/// The edges of a target of this breadth, in samples, are most of it, and mixed; from the second one on the
/// target is resolved.
const MIXED_BREADTH: f32 = 4.0;
const RESOLVED_BREADTH: f32 = 7.0;
/// Share of the surroundings above the floor.
const ABOVE_FLOOR: f32 = 0.1;
/// Bins of the shares, from [`FIRST_SHARE`] on.
const BINS: usize = 64;
const FIRST_SHARE: f32 = -0.5;
const BINS_PER_UNIT: f32 = 32.0;
/// Share of the samples in the selection that the paint is the mean of.
const PAINTED_SHARE: f32 = 0.3;
/// Minimum sum of the weights of a silhouette, samples.
const MIN_MASS: f64 = 2.0;

impl PaintScale {
    /// Weight of a chroma, 0 to 1.
    fn weight(&self, u: u8, v: u8) -> f32 {
        ((self.share(u, v) - self.floor) / (1.0 - self.floor)).clamp(0.0, 1.0)
    }

    fn share(&self, u: u8, v: u8) -> f32 {
        (f32::from(u) - self.background.0) * self.direction.0
            + (f32::from(v) - self.background.1) * self.direction.1
    }
}

impl Paint {
    /// The paint of a target that was selected by a box of these half sides (pixels): the mean of the samples
    /// in the box that differ most from the surroundings. `None` where the chroma does not set the target
    /// apart.
    pub(crate) fn find(crop: &Crop, centre: (f32, f32), half: (f32, f32)) -> Option<Self> {
        let background = mean_around(crop, centre, half, 0.0)?;
        let (mut u_sum, mut v_sum, mut count) = (0.0_f32, 0.0_f32, 0.0_f32);
        crop.for_each_chroma(centre, half, 0.0, |_, _, u, v| {
            (u_sum, v_sum, count) = (u_sum + f32::from(u), v_sum + f32::from(v), count + 1.0);
        });
        if count == 0.0 {
            return None;
        }
        // The direction of the mean difference tells which samples are painted.
        let mean = Self { u: u_sum / count, v: v_sum / count };
        let scale = mean.scale_without_floor(background)?;
        let mut bins = [0_u32; BINS];
        crop.for_each_chroma(centre, half, 0.0, |_, _, u, v| bins[bin(0.25 * scale.share(u, v))] += 1);
        // The bins are four times as wide here: the direction's end is a mean, which pure paint exceeds.
        let floor = 4.0 * (upper_quantile(&bins, PAINTED_SHARE) - 1.0 / BINS_PER_UNIT);
        let (mut u_sum, mut v_sum, mut count) = (0.0_f32, 0.0_f32, 0.0_f32);
        crop.for_each_chroma(centre, half, 0.0, |_, _, u, v| {
            if scale.share(u, v) >= floor {
                (u_sum, v_sum, count) = (u_sum + f32::from(u), v_sum + f32::from(v), count + 1.0);
            }
        });
        let paint = Self { u: u_sum / count.max(1.0), v: v_sum / count.max(1.0) };
        (count > 0.0 && paint.is_distinct_from(background)).then_some(paint)
    }

    fn is_distinct_from(self, background: (f32, f32)) -> bool {
        distance((self.u, self.v), background) >= MIN_DISTANCE
    }

    fn scale_without_floor(self, background: (f32, f32)) -> Option<PaintScale> {
        let (u, v) = (self.u - background.0, self.v - background.1);
        let squared = u * u + v * v;
        (squared > 1.0).then(|| PaintScale {
            background,
            direction: (u / squared, v / squared),
            ring: 0.0,
            floor: 0.0,
        })
    }

    /// The scale of the shares around an ellipse; `None` where the surroundings have too much of the paint.
    pub(crate) fn scale_around(
        self,
        crop: &Crop,
        centre: (f32, f32),
        half: (f32, f32),
        angle: f32,
    ) -> Option<PaintScale> {
        let background = mean_around(crop, centre, half, angle)?;
        let scale = self.scale_without_floor(background)?;
        if !self.is_distinct_from(background) {
            return None;
        }
        let mut bins = [0_u32; BINS];
        for_each_around(crop, centre, half, angle, |u, v| bins[bin(scale.share(u, v))] += 1);
        let foam = scale.share(NEUTRAL, NEUTRAL).max(0.0);
        if foam > MAX_FOAM_SHARE {
            return None;
        }
        let ring = upper_quantile(&bins, ABOVE_FLOOR).max(0.0);
        (ring <= MAX_FLOOR).then_some(PaintScale { ring, floor: ring, ..scale })
    }
}

impl PaintScale {
    /// The scale for a target of this breadth, pixels: the wake of a target that is resolved counts nothing.
    pub(crate) fn for_breadth(&self, crop: &Crop, breadth: f32) -> Self {
        let samples = breadth / crop.probability_step();
        let resolved = ((samples - MIXED_BREADTH) / (RESOLVED_BREADTH - MIXED_BREADTH)).clamp(0.0, 1.0);
        Self { floor: self.ring.max(resolved * self.share(NEUTRAL, NEUTRAL)), ..*self }
    }

    /// The silhouette of the paint inside an ellipse, pixels.
    pub(crate) fn silhouette(
        &self,
        crop: &Crop,
        centre: (f32, f32),
        half: (f32, f32),
        angle: f32,
    ) -> Option<Silhouette> {
        // A sample of a picture with mixed edges is blurred by its own size.
        let step = f64::from(crop.probability_step());
        Silhouette::from_weights(step, -step * step / 12.0, MIN_MASS, (centre, half), |visit| {
            crop.for_each_chroma(centre, half, angle, |du, dv, u, v| visit(du, dv, self.weight(u, v)));
        })
    }

    /// Mean weight inside an ellipse, 0 to 1.
    pub(crate) fn fill(&self, crop: &Crop, centre: (f32, f32), half: (f32, f32), angle: f32) -> f32 {
        let (mut sum, mut count) = (0.0_f32, 0.0_f32);
        crop.for_each_chroma(centre, half, angle, |_, _, u, v| {
            (sum, count) = (sum + self.weight(u, v), count + 1.0);
        });
        if count > 0.0 { sum / count } else { 0.0 }
    }
}

/// Mean chroma around an ellipse.
fn mean_around(crop: &Crop, centre: (f32, f32), half: (f32, f32), angle: f32) -> Option<(f32, f32)> {
    let (mut u_sum, mut v_sum, mut count) = (0_u32, 0_u32, 0_u32);
    for_each_around(crop, centre, half, angle, |u, v| {
        (u_sum, v_sum, count) = (u_sum + u32::from(u), v_sum + u32::from(v), count + 1);
    });
    (count > 0).then(|| (u_sum as f32 / count as f32, v_sum as f32 / count as f32))
}

/// Calls `visit` for the chroma of each sample in the ring around an ellipse.
fn for_each_around(
    crop: &Crop,
    centre: (f32, f32),
    half: (f32, f32),
    angle: f32,
    mut visit: impl FnMut(u8, u8),
) {
    let grown = |(factor, pixels): (f32, f32)| (factor * half.0 + pixels, factor * half.1 + pixels);
    let (inner, outer) = (grown(RING_INNER), grown(RING_OUTER));
    let turn = Rotation::by(angle);
    crop.for_each_chroma(centre, outer, angle, |du, dv, u, v| {
        let (along, across) = turn.undo((du, dv));
        let (a, b) = (along / inner.0, across / inner.1);
        if a * a + b * b > 1.0 {
            visit(u, v);
        }
    });
}

fn bin(share: f32) -> usize {
    (((share - FIRST_SHARE) * BINS_PER_UNIT).max(0.0) as usize).min(BINS - 1)
}

/// The share below which all but this part of the samples lies, rounded up to the end of a bin.
fn upper_quantile(bins: &[u32; BINS], part: f32) -> f32 {
    let all: u32 = bins.iter().sum();
    let mut above = 0;
    for (index, count) in bins.iter().enumerate().rev() {
        above += count;
        if above as f32 > part * all as f32 {
            return FIRST_SHARE + (index as f32 + 1.0) / BINS_PER_UNIT;
        }
    }
    FIRST_SHARE
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::colour_model::ColourModel;
    use crate::test_picture::painted;

    const CENTRE: (f32, f32) = (160.0, 120.0);
    const RED: [u8; 3] = [81, 110, 200];
    const WATER: [u8; 3] = [70, 150, 100];
    const FOAM: [u8; 3] = [220, 128, 128];

    /// A crop of water with a red boat of this size, and foam in this box (left, top, width, height).
    fn crop(boat: (usize, usize), foam: [usize; 4]) -> Crop {
        let picture = painted((320, 240), |column, row| {
            let is_inside = |[left, top, w, h]: [usize; 4]| {
                (left..left + w).contains(&column) && (top..top + h).contains(&row)
            };
            if is_inside([160 - boat.0 / 2, 120 - boat.1 / 2, boat.0, boat.1]) {
                RED
            } else if is_inside(foam) {
                FOAM
            } else {
                WATER
            }
        });
        let mut crop = Crop::default();
        crop.extract(&picture, &ColourModel::default(), CENTRE, 100.0, 1.0);
        crop
    }

    fn half(boat: (usize, usize)) -> (f32, f32) {
        (0.5 * boat.0 as f32, 0.5 * boat.1 as f32)
    }

    #[test]
    fn the_paint_is_the_colour_that_the_water_lacks() {
        let paint = Paint::find(&crop((40, 12), [0; 4]), CENTRE, (25.0, 9.0)).unwrap();
        assert!((paint.u - 110.0).abs() < 1.0 && (paint.v - 200.0).abs() < 1.0, "{paint:?}");
        assert_eq!(Paint::find(&crop((0, 0), [0; 4]), CENTRE, (25.0, 9.0)), None);
    }

    #[test]
    fn the_silhouette_of_a_few_samples_has_the_boats_axes() {
        let paint = Paint { u: 110.0, v: 200.0 };
        for boat in [(40, 12), (24, 8), (16, 6)] {
            let crop = crop(boat, [0; 4]);
            let scale = paint.scale_around(&crop, CENTRE, half(boat), 0.0).unwrap();
            let seen = scale.silhouette(&crop, CENTRE, (30.0, 15.0), 0.0).unwrap();
            // 4 / root of 12: a rectangle's axes by its moments.
            let expected = (1.1547 * boat.0 as f32, 1.1547 * boat.1 as f32);
            assert!((seen.major / expected.0 - 1.0).abs() < 0.05, "{boat:?}: {seen:?}");
            // Edges on the borders of samples have no mixture: 3, 7 and 12 % too thin.
            assert!((seen.minor / expected.1 - 1.0).abs() < 0.13, "{boat:?}: {seen:?}");
            assert!((seen.area - (boat.0 * boat.1) as f32).abs() < 1.0, "{boat:?}: {seen:?}");
        }
    }

    #[test]
    fn the_wake_of_a_resolved_boat_counts_nothing() {
        let paint = Paint { u: 110.0, v: 200.0 };
        let boat = (60, 20);
        let crop = crop(boat, [190, 116, 40, 8]);
        let scale = paint.scale_around(&crop, CENTRE, half(boat), 0.0).unwrap();
        let area = |scale: PaintScale| scale.silhouette(&crop, CENTRE, (80.0, 30.0), 0.0).unwrap().area;
        assert!(area(scale) > 1250.0, "{}", area(scale));
        let resolved = area(scale.for_breadth(&crop, 20.0));
        assert!((resolved - 1200.0).abs() < 5.0, "{resolved}");
    }

    #[test]
    fn a_paint_near_white_or_like_the_surroundings_gives_no_scale() {
        let crop = crop((40, 12), [0; 4]);
        for paint in [Paint { u: 127.0, v: 135.0 }, Paint { u: 148.0, v: 104.0 }] {
            assert_eq!(paint.scale_around(&crop, CENTRE, (20.0, 6.0), 0.0), None, "{paint:?}");
        }
    }
}
