//! Appearance of the water: waves, gusts, glints, breaking crests, flecks of foam.
//!
//! Six layers of wave tiles drift over each other at different speeds. Their sum h is the ripple of the luma.
//! Where the short layers add up, the water glints; where the long ones do, crests break. With the thresholds
//! g, c and f of the conditions (standard deviations):
//!
//! ```text
//! h     = 0.5 long + 0.8 chop + 0.45 (short + shorter)(1 + 0.3 gust), skewed: h + 0.18 (h^2 - 1)
//! glint = short + shorter + 0.5 chop + 0.4 gust - g
//! crest = 0.9 long + 0.6 chop + 0.5 gust + 0.3 shorter - c
//! fleck = resting + 0.4 gust - f
//! ```
//!
//! Not handled: waves that change their shape, reflections of objects, refraction.

use barrelman_vocab::rng::SplitMix64;

use super::canvas::{Canvas, MARGIN};
use super::conditions::Conditions;
use super::view::View;
use super::wake::Wake;
use super::waves::{Layer, LayerView, SIDE, Spectrum, Tile};

/// Luma of foam, and of the sun's glints; the sensor clips the latter.
const FOAM_LUMA: f32 = 206.0;
const GLINT_LUMA: f32 = 262.0;

#[derive(Debug, Clone)]
pub(super) struct Water {
    chop: Tile,
    pub(super) ripple: Tile,
    pub(super) gusts: Tile,
    layers: Layers,
    rows: Rows,
}

#[derive(Debug, Clone)]
struct Layers {
    long: Layer,
    chop: Layer,
    short: Layer,
    shorter: Layer,
    gust: Layer,
    resting: Layer,
}

/// One row of each layer, and what two rows of luma contribute to their row of chroma.
#[derive(Debug, Clone)]
struct Rows {
    tile: [f32; SIDE + 1],
    long: Vec<f32>,
    chop: Vec<f32>,
    short: Vec<f32>,
    shorter: Vec<f32>,
    gust: Vec<f32>,
    resting: Vec<f32>,
    white: Vec<f32>,
    tint: Vec<f32>,
}

impl Water {
    pub(super) fn new(conditions: &Conditions, relative: f64, width: usize, seed: u64, stream: u64) -> Self {
        let mut rng = SplitMix64::of_stream(seed, stream);
        let tile = |waves, cycles, spread, stream| {
            let spectrum = Spectrum { waves, cycles, direction: conditions.wind, spread };
            Tile::new(spectrum, SplitMix64::of_stream(seed, stream))
        };
        let mut layer = |scale: f64, speed: f64, aside: f64| {
            let direction = conditions.wind + aside;
            let speed = speed * relative;
            Layer {
                scale: scale * conditions.wave_scale,
                drift: (speed * libm::cos(direction), speed * libm::sin(direction)),
                offset: (rng.between(0.0, SIDE as f64), rng.between(0.0, SIDE as f64)),
            }
        };
        let layers = Layers {
            long: layer(3.1, 46.0, 0.0),
            chop: layer(0.93, 27.0, 0.3),
            short: layer(0.83, 24.0, -0.5),
            shorter: layer(1.27, -16.0, 0.4),
            gust: layer(2.6, 14.0, 0.1),
            resting: layer(1.05, 2.0, 0.0),
        };
        let row = vec![0.0; width];
        let rows = Rows {
            tile: [0.0; SIDE + 1],
            long: row.clone(),
            chop: row.clone(),
            short: row.clone(),
            shorter: row.clone(),
            gust: row.clone(),
            resting: row.clone(),
            white: row.clone(),
            tint: row,
        };
        Self {
            chop: tile(48, (8.0, 52.0), 0.35, stream + 1),
            ripple: tile(72, (34.0, 120.0), 0.9, stream + 2),
            gusts: tile(20, (1.0, 9.0), 1.5, stream + 3),
            layers,
            rows,
        }
    }

    /// Renders the whole canvas anew.
    pub(super) fn render(
        &mut self,
        canvas: &mut Canvas,
        view: &View,
        conditions: &Conditions,
        time_s: f64,
        wake: &Wake,
    ) {
        let middle = 0.5 - MARGIN as f64;
        let view_from =
            |layer: &Layer, tile| -> LayerView<'_> { layer.view_from(tile, view, time_s, (middle, middle)) };
        let Layers { long, chop, short, shorter, gust, resting } = &self.layers;
        let (long, chop) = (view_from(long, &self.chop), view_from(chop, &self.chop));
        let (short, shorter) = (view_from(short, &self.ripple), view_from(shorter, &self.ripple));
        let (gust, resting) = (view_from(gust, &self.gusts), view_from(resting, &self.ripple));
        let rows = &mut self.rows;
        let width = canvas.y.width;
        let chroma_width = canvas.u.width;
        for row in 0..canvas.y.height {
            long.row(row, &mut rows.tile, &mut rows.long);
            chop.row(row, &mut rows.tile, &mut rows.chop);
            short.row(row, &mut rows.tile, &mut rows.short);
            shorter.row(row, &mut rows.tile, &mut rows.shorter);
            gust.row(row, &mut rows.tile, &mut rows.gust);
            resting.row(row, &mut rows.tile, &mut rows.resting);
            if row % 2 == 0 {
                rows.white.fill(0.0);
                rows.tint.fill(0.0);
            }
            let from_middle = 0.5 - row as f32 / canvas.y.height as f32;
            let level = conditions.water[0] * (1.0 + 2.0 * conditions.gradient * from_middle);
            let line = &mut canvas.y.samples[row * width..][..width];
            rows.luma(conditions, level, line);
            if let Some(wake_foam) = wake.row(row / 2) {
                rows.add_wake_foam(wake_foam, line);
            }
            if row % 2 == 1 {
                let start = row / 2 * chroma_width;
                let us = &mut canvas.u.samples[start..][..chroma_width];
                let vs = &mut canvas.v.samples[start..][..chroma_width];
                rows.chroma(conditions, us, vs);
            }
        }
    }
}

impl Rows {
    /// Luma of a row without the wake, from a base level; adds what the row's chroma is made from.
    fn luma(&mut self, conditions: &Conditions, level: f32, line: &mut [f32]) {
        let contrast = conditions.contrast;
        let width = line.len();
        // Slices of one length, so that the loop needs no bounds checks.
        let (long, chop) = (&self.long[..width], &self.chop[..width]);
        let (short, shorter) = (&self.short[..width], &self.shorter[..width]);
        let (gust, resting) = (&self.gust[..width], &self.resting[..width]);
        let (whites, tints) = (&mut self.white[..width], &mut self.tint[..width]);
        for at in 0..width {
            let (long, chop, gust) = (long[at], chop[at], gust[at]);
            let (short, shorter) = (short[at], shorter[at]);
            let both = short + shorter;
            let height = 0.5 * long + 0.8 * chop + 0.45 * both * (1.0 + 0.3 * gust);
            let skewed = height + 0.18 * (height * height - 1.0);
            let glint = both + 0.5 * chop + 0.4 * gust - conditions.glint_threshold;
            let glint = glint.clamp(0.0, 1.0);
            let crest = 0.9 * long + 0.6 * chop + 0.5 * gust + 0.3 * shorter - conditions.crest_threshold;
            let fleck = resting[at] + 0.4 * gust - conditions.fleck_threshold;
            let foam = (0.9 * crest).max(1.4 * fleck).clamp(0.0, 0.85);
            let water = level + contrast * (skewed + 0.5 * gust);
            let white = water + (FOAM_LUMA - water) * foam;
            line[at] = white + (GLINT_LUMA - white) * glint;
            whites[at] += foam.max(glint);
            tints[at] += skewed;
        }
    }

    /// Adds the wake's foam to a row of luma. `wake_foam` is its density on the chroma grid, 0 to 1.
    fn add_wake_foam(&mut self, wake_foam: &[f32], line: &mut [f32]) {
        for (at, sample) in line.iter_mut().enumerate() {
            let density = wake_foam[at / 2];
            if density > 0.0 {
                let grain = 0.62 + 0.28 * self.shorter[at] + 0.2 * self.short[at] + 0.15 * self.resting[at];
                let foam = (density * grain.max(0.0)).min(0.92);
                *sample += (FOAM_LUMA - *sample) * foam;
                self.white[at] = self.white[at].max(foam);
            }
        }
    }

    /// Chroma of two rows.
    fn chroma(&self, conditions: &Conditions, us: &mut [f32], vs: &mut [f32]) {
        let [_, base_u, base_v] = conditions.water;
        let pairs = self.white.chunks_exact(2).zip(self.tint.chunks_exact(2));
        for ((u, v), (white, tint)) in us.iter_mut().zip(vs).zip(pairs) {
            let coloured = 1.0 - (0.25 * (white[0] + white[1])).min(1.0);
            let share = coloured * (1.0 - 0.02 * (tint[0] + tint[1]));
            *u = 128.0 + (base_u - 128.0) * share;
            *v = 128.0 + (base_v - 128.0) * share;
        }
    }
}
