//! Loops over many values with the widest vector instructions that the machine has, and the same bits: the macro of
//! `barrelman-simd`, and the tests that hold this crate's kernels to it.
//!
//! A function within [`simd_kernel!`] is compiled for each level from the same scalar source. None fuses a multiplication
//! with an addition, none changes the order of a sum, so all round alike.

/// Wraps free functions whose loops are worth it.
macro_rules! simd_kernel {
    ($($function:tt)*) => { barrelman_simd::multiversion! { crate::simd::level(); $($function)* } };
}
pub(crate) use simd_kernel;

/// The widest that there is, but in a test that compares two.
#[cfg(not(test))]
#[inline(always)]
pub(crate) fn level() -> barrelman_simd::Simd {
    barrelman_simd::Simd::widest()
}

#[cfg(test)]
pub(crate) use tests::level;

#[cfg(test)]
mod tests {
    use std::cell::Cell;
    use std::sync::Arc;

    use barrelman_simd::{Simd, SimdLevel};
    use barrelman_vocab::video::{Capture, CaptureQuality, ColourEncoding};
    use barrelman_vocab::{Picture, PictureSize, PixelBox, Timestamp, VideoFrame};

    use crate::colour_model::{ColourModel, TargetEllipse, count_colours};
    use crate::correlation::{CorrelationFilter, desired_response_spectrum};
    use crate::crop::Crop;
    use crate::decimation::decimate;
    use crate::fourier::{AREA, Fourier, Map, Spectrum};
    use crate::gradients::{CELL, GradientHistograms, MARGIN, unit_directions};
    use crate::sampling::SamplingGrid;
    use crate::{FusedConfig, FusedTracker, Tracker};

    thread_local! {
        static LEVEL: Cell<SimdLevel> = const { Cell::new(SimdLevel::Avx512) };
    }

    /// What the comparison below asks for on this thread.
    pub(crate) fn level() -> Simd {
        Simd::at_most(LEVEL.get())
    }

    /// Holds the bits that some work gives at every level that the machine has to those of the baseline.
    fn check(work: impl Fn() -> Vec<f32>) {
        if Simd::widest() == Simd::BASELINE {
            println!("not compared: this machine has the baseline alone");
        }
        let bits = |level| {
            LEVEL.set(level);
            work().into_iter().map(f32::to_bits).collect::<Vec<_>>()
        };
        let plain = bits(SimdLevel::Baseline);
        let wider = SimdLevel::ALL
            .into_iter()
            .filter(|&level| level > SimdLevel::Baseline && Simd::at_most(level).level() == level);
        for level in wider {
            compare(&plain, &bits(level));
        }
        LEVEL.set(SimdLevel::Avx512);
    }

    fn compare(plain: &[u32], wide: &[u32]) {
        assert!(plain.len() > 1 && plain.iter().any(|&value| value != plain[0]), "nothing to compare");
        assert_eq!(plain.len(), wide.len());
        if let Some(at) = plain.iter().zip(wide).position(|(plain, wide)| plain != wide) {
            panic!("value {at}: {} and {}", f32::from_bits(plain[at]), f32::from_bits(wide[at]));
        }
    }

    fn noise(seed: u32) -> impl FnMut() -> u8 {
        let mut state = seed;
        move || {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            (state >> 24) as u8
        }
    }

    fn map(seed: u32) -> Box<Map> {
        let mut sample = noise(seed);
        let mut map = Box::new([0.0; AREA]);
        map.iter_mut().for_each(|value| *value = f32::from(sample()) / 7.0 - 18.0);
        map
    }

    fn picture(size: (u32, u32), seed: u32) -> Picture {
        let size = PictureSize::new(size.0, size.1);
        let mut picture = Picture::black(size, ColourEncoding::assumed_for(size));
        let mut sample = noise(seed);
        picture.planes_mut().into_iter().flatten().for_each(|slot| *slot = sample());
        picture
    }

    fn spectra(fourier: &mut Fourier, seeds: [u32; 2]) -> [Spectrum; 2] {
        let [mut first, mut second] = [Spectrum::default(), Spectrum::default()];
        fourier.forward_pair((&map(seeds[0]), &map(seeds[1])), (&mut first, &mut second));
        [first, second]
    }

    fn values(spectrum: &Spectrum) -> Vec<f32> {
        spectrum.re.iter().chain(spectrum.im.iter()).copied().collect()
    }

    #[test]
    fn transforms_give_the_same_bits_with_and_without_wide_instructions() {
        check(|| {
            let mut fourier = Fourier::new();
            let [first, second] = spectra(&mut fourier, [1, 2]);
            let (mut a, mut b, mut c) = (map(3), map(4), map(5));
            fourier.inverse_pair((&first, &second), (&mut a, &mut b));
            fourier.inverse(&first, &mut c);
            [values(&first), values(&second), a.to_vec(), b.to_vec(), c.to_vec()].concat()
        });
    }

    #[test]
    fn the_filter_has_the_same_bits_with_and_without_wide_instructions() {
        check(|| {
            let mut fourier = Fourier::new();
            let mut filter = CorrelationFilter::default();
            let desired = desired_response_spectrum(&mut fourier, 1.3);
            let mask = {
                let mut mask: Box<Map> = Box::new([0.0; AREA]);
                mask.iter_mut().zip(map(9).iter()).for_each(|(m, &v)| *m = (0.5 + v / 36.0).clamp(0.0, 1.0));
                mask
            };
            for seed in 0..3 {
                let trained = spectra(&mut fourier, [10 + seed, 20 + seed]);
                filter.update_model(&trained, 0.1);
                filter.solve_step(&mut fourier, &desired, &mask);
            }
            let mut response = Spectrum::default();
            filter.correlate(&spectra(&mut fourier, [30, 31]), &mut response);
            [filter.kernel().to_vec(), values(&response)].concat()
        });
    }

    #[test]
    fn gradients_have_the_same_bits_with_and_without_wide_instructions() {
        // Sizes that fill the vectors and sizes that do not.
        for (width, height) in [(1, 1), (3, 2), (5, 7), (32, 32)] {
            check(|| {
                let mut sample = noise(7);
                let samples = (width * CELL + 2 * MARGIN) * (height * CELL + 2 * MARGIN);
                let patch: Vec<f32> = (0..samples).map(|_| f32::from(sample())).collect();
                let (vectors, cos_step) = unit_directions();
                let mut gradients = GradientHistograms::default();
                gradients.compute(&patch, width, height, &vectors, cos_step);
                gradients.cells().to_vec()
            });
        }
    }

    #[test]
    fn means_of_squares_have_the_same_bits_with_and_without_wide_instructions() {
        let picture = picture((71, 45), 3);
        for (corner, step) in [((0, 0), 1), ((-9, -9), 2), ((50, 30), 3), ((-200, 4), 5), ((2, 99), 17)] {
            check(|| {
                let (mut columns, mut out) = (Vec::new(), Vec::new());
                decimate(picture.y(), corner, step, (13, 11), &mut columns, &mut out);
                // What lies wholly outside is of one value; the corner tells the cases apart.
                out.iter().map(|&value| f32::from(value)).chain([-1.0]).collect()
            });
        }
    }

    #[test]
    fn patches_have_the_same_bits_with_and_without_wide_instructions() {
        let picture = picture((90, 70), 5);
        let mut model = ColourModel::default();
        count_colours(
            &picture,
            (45.0, 35.0),
            &TargetEllipse::inscribed_in((30.0, 20.0)),
            &mut model.target,
            &mut model.surroundings,
        );
        model.update_table();
        for (centre, angle, step) in
            [((45.0, 35.0), 0.0, 1.0), ((3.0, 66.0), 0.7, 1.7), ((80.0, 9.0), 4.0, 2.9)]
        {
            check(|| {
                let mut crop = Crop::default();
                crop.extract(&picture, &model, centre, 40.0, step);
                let turn = (libm::cosf(angle), libm::sinf(angle));
                let grid = SamplingGrid { centre, step, turn, width: 21, height: 18 };
                let (mut luma, mut probability) = (Vec::new(), Vec::new());
                crop.sample_luma(&grid, &mut luma);
                crop.sample_probability(&grid, &mut probability);
                [luma, probability].concat()
            });
        }
    }

    #[test]
    fn a_track_has_the_same_bits_with_and_without_wide_instructions() {
        let still = picture((160, 120), 11);
        let frames: Vec<_> = (0..12_u64)
            .map(|index| {
                // The picture moves by two pixels a frame, and is another one in two frames.
                let mut picture =
                    if index == 7 || index == 8 { picture((160, 120), 12) } else { still.clone() };
                for plane in picture.planes_mut() {
                    plane.rotate_right(2 * index as usize);
                }
                let at = Timestamp::from_nanos(index * 33_000_000);
                let capture = Capture { at, quality: CaptureQuality::Sensor };
                VideoFrame { sequence: index, capture, picture: Arc::new(picture) }
            })
            .collect();
        check(|| {
            let mut tracker = FusedTracker::new(FusedConfig::default()).unwrap();
            let selection = PixelBox { u: 50.0, v: 40.0, w: 40.0, h: 26.0 };
            let report = tracker.select(&frames[0], selection).unwrap();
            let mut values = vec![report.coloured_share as f32, report.surroundings_probability as f32];
            for frame in &frames {
                let track = tracker.track(frame, None);
                values.push(track.localisation().map_or(-1.0, |here| here.confidence as f32));
                values.extend(track.localisation().iter().flat_map(|here| {
                    let (box_, middle) = (here.bounds, here.centre);
                    [middle.u, middle.v, box_.u, box_.v, box_.w, box_.h].map(|value| value as f32)
                }));
            }
            values
        });
    }
}
