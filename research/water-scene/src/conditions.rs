//! Conditions of a clip: light, water and camera, sampled once from the seed.

use barrelman_vocab::PictureSize;
use barrelman_vocab::rng::SplitMix64;

use super::choices::Choices;
use super::colour::{self, Yuv};
use super::script::{FRAMES_PER_SECOND, SceneScript};

/// Water as red, green, blue: blue-green, grey, brown, dark, green, bright blue.
const WATERS: [[f64; 3]; 6] = [
    [44.0, 92.0, 104.0],
    [104.0, 114.0, 118.0],
    [96.0, 86.0, 62.0],
    [26.0, 36.0, 44.0],
    [58.0, 88.0, 66.0],
    [52.0, 104.0, 140.0],
];

#[derive(Debug, Clone)]
pub(super) struct Conditions {
    /// Sine of the camera's depression of 40 to 80 degrees.
    pub(super) foreshortening: f64,
    /// Exposure time of each picture, s.
    pub(super) exposure_s: f64,
    /// Standard deviation of the lens's blur, px.
    pub(super) blur_px: f64,
    /// Standard deviation of the sensor's noise in luma and chroma, sample values.
    pub(super) noise: [f32; 2],
    pub(super) water: Yuv,
    /// Remaining saturation of the paints after haze and sensor.
    pub(super) saturation: f32,
    /// Luma of one standard deviation of the waves.
    pub(super) contrast: f32,
    /// Standard deviations that a wave's slope must reach to glint, its height to break, and a fleck of foam
    /// to show.
    pub(super) glint_threshold: f32,
    pub(super) crest_threshold: f32,
    pub(super) fleck_threshold: f32,
    /// Direction of the wind in the plane, radians.
    pub(super) wind: f64,
    /// Picture pixels (at zoom 1) per texel of the wave tiles.
    pub(super) wave_scale: f64,
    /// Share of the luma by which the top of the picture is brighter than its middle.
    pub(super) gradient: f32,
    /// Slow variation of the light: share, rad/s, radians.
    light: [f64; 3],
    /// Direction of the sun in the plane, radians.
    pub(super) sun: f64,
}

impl Conditions {
    pub(super) fn new(script: &SceneScript, hull: f64, seed: u64, stream: u64) -> Self {
        let mut rng = SplitMix64::of_stream(seed, stream);
        let depression = rng.between(40.0, 80.0).to_radians();
        let brightness = rng.between(0.85, 1.2);
        let water = rng.choose(&WATERS).map(|sample| sample * brightness + rng.between(-8.0, 8.0));
        let water = colour::yuv(water);
        // Dark water shows less of its waves; a low sun shows more of them.
        let contrast = rng.between(0.06, 0.14) * f64::from(water[0] - 16.0) + rng.between(1.0, 3.0);
        let relative = f64::from(script.size.width) / f64::from(REFERENCE.width);
        Self {
            foreshortening: libm::sin(depression),
            exposure_s: rng.between(0.05, 0.4) / f64::from(FRAMES_PER_SECOND),
            blur_px: rng.between(0.6, 1.5),
            noise: [rng.between(0.8, 3.2) as f32, rng.between(0.6, 2.0) as f32],
            water,
            saturation: rng.between(0.6, 1.0) as f32,
            contrast: contrast as f32,
            glint_threshold: rng.between(3.0, 5.2) as f32,
            crest_threshold: rng.between(2.6, 4.2) as f32,
            fleck_threshold: rng.between(2.8, 4.0) as f32,
            wind: rng.between(-core::f64::consts::PI, core::f64::consts::PI),
            // A nearer camera sees a longer hull and longer waves; short waves exist at any distance.
            wave_scale: libm::sqrt(hull / (60.0 * relative)) * relative * rng.between(0.8, 1.3),
            gradient: rng.between(0.0, 0.18) as f32,
            light: [rng.between(0.02, 0.1), rng.between(0.1, 0.5), rng.between(0.0, 6.0)],
            sun: rng.between(-core::f64::consts::PI, core::f64::consts::PI),
        }
    }

    /// Brightness at a time, about 1.
    pub(super) fn light(&self, time_s: f64) -> f32 {
        let [share, rate, phase] = self.light;
        let slow = libm::sin(rate * time_s + phase) + 0.4 * libm::sin(2.7 * rate * time_s + 1.3 * phase);
        (1.0 + share * slow) as f32
    }
}

/// The picture size for which lengths in pixels are given; they scale with the width.
pub(super) const REFERENCE: PictureSize = PictureSize::new(1280, 720);
