//! Size, position and orientation of the target from the moments of its colour.
//!
//! The target probability of each sample inside an ellipse around the target becomes a weight between 0 and
//! 1: 0 up to a quarter of the way from the ring's mean probability to the target's, 1 from three quarters
//! on, linear between. With the weights' sum m, centroid c and covariance C, the axis is the eigenvector of
//! the larger eigenvalue of C, and the full axes are 4 times the roots of the eigenvalues, as for a uniform
//! ellipse.

use crate::crop::Crop;
use crate::probability_view::ColourContrast;
use crate::vector::Rotation;

/// Shape of the target by its colour.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Silhouette {
    /// Area, square pixels.
    pub(crate) area: f32,
    /// Centroid, pixels.
    pub(crate) centroid: (f32, f32),
    /// Direction of the major axis, radians clockwise from image right as seen, -pi/2 to pi/2.
    pub(crate) axis: f32,
    /// Full length of the major axis, pixels.
    pub(crate) major: f32,
    /// Full length of the minor axis, pixels.
    pub(crate) minor: f32,
    /// Midpoint between the ends along and across the axis, pixels.
    pub(crate) midpoint: (f32, f32),
}

impl Silhouette {
    /// Measures the silhouette inside the ellipse of half axes `half` (pixels), turned clockwise by `angle`;
    /// `contrast` gives the mean target probabilities. `None` where the contrast or the area is too small.
    pub(crate) fn measure(
        crop: &Crop,
        centre: (f32, f32),
        half: (f32, f32),
        angle: f32,
        contrast: ColourContrast,
    ) -> Option<Self> {
        let ring = contrast.ring;
        let contrast = contrast.difference();
        if contrast < MIN_CONTRAST {
            return None;
        }
        let (low, high) = (255.0 * (ring + 0.25 * contrast), 255.0 * (ring + 0.75 * contrast));
        let scale = 1.0 / (high - low);
        let step = f64::from(crop.probability_step());
        // A sample is a square with a variance of its own.
        Self::from_weights(step, step * step / 12.0, MIN_MASS, (centre, half), |visit| {
            crop.for_each_probability(centre, half, angle, |du, dv, probability| {
                visit(du, dv, ((f32::from(probability) - low) * scale).clamp(0.0, 1.0));
            });
        })
    }

    /// The silhouette of weighted samples of this step (pixels) inside an ellipse of this centre and these
    /// half axes. `for_each` passes each sample's distance right and down of the centre and its weight, 0
    /// to 1. `own_variance` is added to the samples' variance along each axis, square pixels. `None` where
    /// the weights sum up to less than `min_mass`.
    pub(crate) fn from_weights(
        step: f64,
        own_variance: f64,
        min_mass: f64,
        (centre, half): ((f32, f32), (f32, f32)),
        for_each: impl Fn(&mut dyn FnMut(f32, f32, f32)),
    ) -> Option<Self> {
        let (mut m, mut mu, mut mv, mut muu, mut muv, mut mvv) = (0.0_f64, 0.0, 0.0, 0.0, 0.0, 0.0);
        for_each(&mut |du, dv, weight| {
            let weight = f64::from(weight);
            let (du, dv) = (f64::from(du), f64::from(dv));
            m += weight;
            mu += weight * du;
            mv += weight * dv;
            muu += weight * du * du;
            muv += weight * du * dv;
            mvv += weight * dv * dv;
        });
        if m < min_mass {
            return None;
        }
        let (u, v) = (mu / m, mv / m);
        let (a, b, c) = (muu / m - u * u + own_variance, muv / m - u * v, mvv / m - v * v + own_variance);
        let root = (0.25 * (a - c) * (a - c) + b * b).sqrt();
        let mean_variance = 0.5 * (a + c);
        let axis = (0.5 * libm::atan2(2.0 * b, a - c)) as f32;
        let turn = Rotation::by(axis);
        // The ends: a hundredth of the weight lies beyond each.
        let reach = 2.0 * half.0.max(half.1);
        let (mut along, mut across) = ([0.0_f32; BINS], [0.0_f32; BINS]);
        for_each(&mut |du, dv, weight| {
            let bin = |x: f32| (((x / reach + 0.5) * BINS as f32) as usize).min(BINS - 1);
            let (forward, aside) = turn.undo((du, dv));
            along[bin(forward)] += weight;
            across[bin(aside)] += weight;
        });
        let halfway = |bins: &[f32; BINS]| {
            (0.5 * (mass_quantile_bin(bins.iter()) + BINS as f32 - mass_quantile_bin(bins.iter().rev()))
                / BINS as f32
                - 0.5)
                * reach
        };
        // Thinner than a quarter of a sample cannot be told.
        let least = step * step / 192.0;
        Some(Self {
            midpoint: turn.place_from(centre, (halfway(&along), halfway(&across))),
            area: (m * step * step) as f32,
            centroid: (centre.0 + u as f32, centre.1 + v as f32),
            axis,
            major: 4.0 * (mean_variance + root).max(least).sqrt() as f32,
            minor: 4.0 * (mean_variance - root).max(least).sqrt() as f32,
        })
    }

    /// Half of both axes, the major one first, pixels.
    pub(crate) fn half_axes(&self) -> (f32, f32) {
        (0.5 * self.major, 0.5 * self.minor)
    }

    /// Ratio of minor to major axis, 0 to 1.
    pub(crate) fn roundness(&self) -> f32 {
        if self.major > 0.0 { self.minor / self.major } else { 1.0 }
    }

    /// Share of the ellipse of its axes that it fills: about 1 for a single object, less for several beside
    /// each other.
    pub(crate) fn fill(&self) -> f32 {
        let ellipse = 0.25 * core::f32::consts::PI * self.major * self.minor;
        if ellipse > 0.0 { self.area / ellipse } else { 0.0 }
    }
}

/// Position, in bins, up to which the bins contain a hundredth of the weight.
fn mass_quantile_bin<'a>(bins: impl Iterator<Item = &'a f32> + Clone) -> f32 {
    let wanted = 0.01 * bins.clone().sum::<f32>();
    let mut passed = 0.0;
    for (index, &mass) in bins.enumerate() {
        if passed + mass >= wanted && mass > 0.0 {
            return index as f32 + (wanted - passed) / mass;
        }
        passed += mass;
    }
    0.0
}

/// Bins along an axis of twice the target's length: 1.5 % of the length each.
const BINS: usize = 128;
/// Minimum contrast, inside less ring; with less the shape is unreliable.
const MIN_CONTRAST: f32 = 0.2;
/// Minimum sum of the weights, samples.
const MIN_MASS: f64 = 8.0;

#[cfg(test)]
mod tests {
    use barrelman_vocab::video::ColourEncoding;
    use barrelman_vocab::{Picture, PictureSize};

    use super::*;
    use crate::colour_model::{ColourModel, TargetEllipse, count_colours};

    const CENTRE: (f32, f32) = (160.0, 120.0);
    const CLEAR: ColourContrast = ColourContrast { inside: 1.0, ring: 0.0 };

    /// A red ellipse with these full axes, turned clockwise, on blue water.
    fn picture(axes: (f32, f32), turned_deg: f32) -> Picture {
        let size = PictureSize::new(320, 240);
        let mut picture = Picture::black(size, ColourEncoding::assumed_for(size));
        let (c, s) = (libm::cosf(turned_deg.to_radians()), libm::sinf(turned_deg.to_radians()));
        let inside = |u: f32, v: f32| {
            let (right, down) = (u - CENTRE.0, v - CENTRE.1);
            let (a, b) = ((right * c + down * s) * 2.0 / axes.0, (down * c - right * s) * 2.0 / axes.1);
            a * a + b * b <= 1.0
        };
        let colours = [(81, 70), (90, 190), (240, 100)];
        for ((samples, step), (red, blue)) in picture.planes_mut().into_iter().zip([1, 2, 2]).zip(colours) {
            let width = 320 / step;
            for (index, sample) in samples.iter_mut().enumerate() {
                let at = |k: usize| (k as f32 + 0.5) * step as f32;
                *sample = if inside(at(index % width), at(index / width)) { red } else { blue };
            }
        }
        picture
    }

    fn crop(axes: (f32, f32), turned_deg: f32, step: f32) -> Crop {
        let mut model = ColourModel::default();
        let upright = picture(axes, 0.0);
        count_colours(
            &upright,
            CENTRE,
            &TargetEllipse::inscribed_in(axes),
            &mut model.target,
            &mut model.surroundings,
        );
        model.update_table();
        let mut crop = Crop::default();
        crop.extract(&picture(axes, turned_deg), &model, CENTRE, 120.0, step);
        crop
    }

    /// The silhouette measured in a circle that is slightly off the centre.
    fn seen(axes: (f32, f32), turned_deg: f32, step: f32) -> Silhouette {
        let reach = 0.6 * axes.0;
        let centre = (CENTRE.0 + 2.0, CENTRE.1 - 1.0);
        Silhouette::measure(&crop(axes, turned_deg, step), centre, (reach, reach), 0.0, CLEAR).unwrap()
    }

    fn check(axes: (f32, f32), turned_deg: f32) {
        let seen = seen(axes, turned_deg, 1.0);
        let off = (seen.axis.to_degrees() - turned_deg).rem_euclid(180.0);
        assert!(off.min(180.0 - off) < 1.0, "{axes:?} at {turned_deg}: {seen:?}");
        assert!((seen.major / axes.0 - 1.0).abs() < 0.05, "{axes:?} at {turned_deg}: {seen:?}");
        assert!((seen.minor / axes.1 - 1.0).abs() < 0.05, "{axes:?} at {turned_deg}: {seen:?}");
        let area = 0.25 * core::f32::consts::PI * axes.0 * axes.1;
        assert!((seen.area / area - 1.0).abs() < 0.05, "{axes:?} at {turned_deg}: {seen:?}");
        for place in [seen.centroid, seen.midpoint] {
            let off = libm::hypotf(place.0 - CENTRE.0, place.1 - CENTRE.1);
            assert!(off < 1.5, "{axes:?} at {turned_deg}: {seen:?}");
        }
    }

    #[test]
    fn an_ellipse_has_its_own_axes_place_and_area() {
        for turned_deg in [0.0, 15.0, 45.0, 80.0, 90.0, -30.0, -60.0] {
            check((120.0, 50.0), turned_deg);
            check((90.0, 30.0), turned_deg);
        }
    }

    #[test]
    fn a_coarser_look_sees_the_same() {
        let seen = seen((120.0, 50.0), 30.0, 3.0);
        assert!((seen.axis.to_degrees() - 30.0).abs() < 2.0, "{seen:?}");
        // Samples that lie half on the target weigh less than half; measured 3 and 9 %.
        assert!((seen.major / 120.0 - 1.0).abs() < 0.05, "{seen:?}");
        assert!((seen.minor / 50.0 - 1.0).abs() < 0.12, "{seen:?}");
    }

    #[test]
    fn a_circle_is_round() {
        assert!(seen((60.0, 60.0), 0.0, 1.0).roundness() > 0.97);
        assert!((seen((90.0, 30.0), 0.0, 1.0).roundness() - 1.0 / 3.0).abs() < 0.02);
    }

    #[test]
    fn a_single_thing_fills_its_ellipse() {
        assert!((seen((90.0, 30.0), 0.5, 1.0).fill() - 1.0).abs() < 0.05);
        let apart = Silhouette { major: 180.0, ..seen((90.0, 30.0), 0.5, 1.0) };
        assert!((apart.fill() - 0.5).abs() < 0.05);
    }

    #[test]
    fn nothing_is_seen_where_the_colour_does_not_tell_or_too_little_of_it_is_there() {
        let crop = crop((60.0, 30.0), 0.0, 1.0);
        assert_eq!(
            Silhouette::measure(&crop, CENTRE, (40.0, 40.0), 0.0, ColourContrast { inside: 0.6, ring: 0.5 }),
            None
        );
        assert_eq!(Silhouette::measure(&crop, CENTRE, (2.0, 2.0), 0.0, CLEAR), None);
        assert_eq!(Silhouette::measure(&crop, (60.0, 60.0), (20.0, 20.0), 0.0, CLEAR), None);
    }
}
