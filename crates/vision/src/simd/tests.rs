//! Every kernel gives the same bits at every vector level.

use std::sync::Arc;

use barrelman_simd::{Simd, SimdLevel};
use barrelman_vocab::video::{Capture, CaptureQuality, ColourEncoding};
use barrelman_vocab::{Picture, PictureSize, PixelBox, Timestamp, VideoFrame};

use super::LEVEL_CAP;
use crate::colour_model::{ColourModel, TargetEllipse, count_colours};
use crate::correlation::{CorrelationFilter, FilterSolver};
use crate::crop::Crop;
use crate::decimation::decimate;
use crate::fourier::{AREA, Fourier, Map, Spectrum};
use crate::gradients::{CELL, GradientHistograms, MARGIN, unit_directions};
use crate::peak::desired_response_spectrum;
use crate::redetection::Redetector;
use crate::refinement::{RefinementNetwork, RefinementWeights, RefinementWindow};
use crate::sampling::SamplingGrid;
use crate::{FusedConfig, FusedTracker, Tracker};

/// Checks that `work` gives the same bits at every vector level of the machine as at the baseline. Fails on a
/// machine that supports the baseline only, since nothing would be compared.
fn check(work: impl Fn() -> Vec<f32>) {
    let bits = |level| {
        LEVEL_CAP.set(level);
        work().into_iter().map(f32::to_bits).collect::<Vec<_>>()
    };
    let baseline = bits(SimdLevel::Baseline);
    let wider: Vec<_> = SimdLevel::ALL
        .into_iter()
        .filter(|&level| level > SimdLevel::Baseline && Simd::at_most(level).level() == level)
        .collect();
    assert!(
        !wider.is_empty(),
        "nothing compared: this machine supports the baseline only; run on one with AVX2"
    );
    for level in wider {
        compare(level, &baseline, &bits(level));
    }
    LEVEL_CAP.set(SimdLevel::Avx512);
}

fn compare(level: SimdLevel, baseline: &[u32], wide: &[u32]) {
    let varies = baseline.iter().any(|&value| value != baseline[0]);
    assert!(varies, "nothing compared: all {} values are equal", baseline.len());
    assert_eq!(baseline.len(), wide.len(), "{level}");
    let values = |bits: (&u32, &u32)| (f32::from_bits(*bits.0), f32::from_bits(*bits.1));
    let mut pairs = baseline.iter().zip(wide).enumerate();
    let difference = pairs.find(|(_, (baseline, wide))| baseline != wide);
    assert_eq!(
        difference.map(|(at, bits)| (at, values(bits))),
        None,
        "{level}: index and values that differ"
    );
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
fn transforms_give_the_same_bits_at_every_vector_level() {
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
fn the_filter_has_the_same_bits_at_every_vector_level() {
    check(|| {
        let mut fourier = Fourier::new();
        let (mut filter, mut solver) = (CorrelationFilter::default(), FilterSolver::default());
        let desired = desired_response_spectrum(&mut fourier, 1.3);
        let mask = {
            let mut mask: Box<Map> = Box::new([0.0; AREA]);
            mask.iter_mut().zip(map(9).iter()).for_each(|(m, &v)| *m = (0.5 + v / 36.0).clamp(0.0, 1.0));
            mask
        };
        for seed in 0..3 {
            let trained = spectra(&mut fourier, [10 + seed, 20 + seed]);
            filter.update_model(&trained, 0.1);
            solver.step(&mut filter, &mut fourier, &desired, &mask);
        }
        let mut response = Spectrum::default();
        filter.correlate(&spectra(&mut fourier, [30, 31]), &mut response);
        [filter.kernel().to_vec(), values(&response)].concat()
    });
}

#[test]
fn gradients_have_the_same_bits_at_every_vector_level() {
    // Widths that fill whole vectors and widths that do not.
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
fn means_of_squares_have_the_same_bits_at_every_vector_level() {
    let picture = picture((71, 45), 3);
    for (corner, step) in [((0, 0), 1), ((-9, -9), 2), ((50, 30), 3), ((-200, 4), 5), ((2, 99), 17)] {
        check(|| {
            let (mut columns, mut out) = (Vec::new(), Vec::new());
            decimate(picture.y(), corner, step, (13, 11), &mut columns, &mut out);
            // A corner far outside the picture gives equal values only: add another one.
            out.iter().map(|&value| f32::from(value)).chain([-1.0]).collect()
        });
    }
}

#[test]
fn patches_have_the_same_bits_at_every_vector_level() {
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
    for (centre, angle, step) in [((45.0, 35.0), 0.0, 1.0), ((3.0, 66.0), 0.7, 1.7), ((80.0, 9.0), 4.0, 2.9)]
    {
        check(|| {
            let mut crop = Crop::default();
            crop.extract(&picture, &model, centre, 40.0, step);
            let turn = (libm::cosf(angle), libm::sinf(angle));
            let grid = SamplingGrid { centre, step, stretch: 1.0, turn, width: 21, height: 18 };
            let (mut luma, mut probability) = (Vec::new(), Vec::new());
            crop.sample_luma(&grid, &mut luma);
            crop.sample_probability(&grid, &mut probability);
            [luma, probability].concat()
        });
    }
}

#[test]
fn the_refinement_network_has_the_same_bits_at_every_vector_level() {
    check(|| {
        let mut sample = noise(17);
        let mut window = RefinementWindow::default();
        window.cells.iter_mut().for_each(|cell| *cell = f32::from(sample()) / 128.0 - 1.0);
        let refined = RefinementNetwork::new(RefinementWeights::built_in()).evaluate(&window);
        [refined.edges.to_vec(), refined.errors.to_vec(), vec![refined.probability]].concat()
    });
}

#[test]
fn candidates_by_colour_are_the_same_at_every_vector_level() {
    let picture = picture((190, 130), 13);
    let mut model = ColourModel::default();
    count_colours(
        &picture,
        (95.0, 65.0),
        &TargetEllipse::inscribed_in((24.0, 16.0)),
        &mut model.target,
        &mut model.surroundings,
    );
    model.update_table();
    for sides in [(12.0, 8.0), (24.0, 16.0), (70.0, 60.0)] {
        check(|| {
            let mut redetector = Redetector::default();
            let found = redetector.find_candidates(&picture, &model, sides).iter();
            // A search without a candidate gives no values: add two.
            found.flat_map(|c| [c.centre.0, c.centre.1, c.contrast, c.scale]).chain([0.0, 1.0]).collect()
        });
    }
}

#[test]
fn a_track_has_the_same_bits_at_every_vector_level() {
    let still = picture((160, 120), 11);
    let frames: Vec<_> = (0..12_u64)
        .map(|index| {
            // The picture moves by two pixels per frame; frames 7 and 8 show another picture.
            let mut picture = if index == 7 || index == 8 { picture((160, 120), 12) } else { still.clone() };
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
