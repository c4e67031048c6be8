//! The rows of a frame: shaded in bands as linear light, then developed into samples.

use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Mutex, PoisonError, RwLock};

use barrelman_simd::{Simd, at_level};
use barrelman_vocab::{Picture, PictureSize};

use super::camera::Camera;
use super::chunk::{CHUNK, Chunk};
use super::light::Lighting;
use super::nodes::Nodes;
use super::raster::Tile;
use super::rays::{HORIZON, Rays, cast_nodes, cast_pixels};
use super::sensor::{self, Development, NoiseTable, TAPS};
use super::shading::{FoamTexture, WaterBody, prepare_reflection, shade_sky, shade_water, texture_foam};
use super::surface::{ElevationMap, TileLookup, Water, fill_node_variance, sample_surface};
use super::texture::ROUNDING;
use super::wake::{Wake, add_wake};
use super::{FrameObjects, ParallelFor, RenderSettings, Textures, WaterColour, floor, lock, waves};
use crate::noise;
use crate::sea::Sea;
use crate::snapshot::{Ground, Snapshot};

/// Rows of a band; even, so that chroma rows stay within one.
const ROWS: usize = 8;
/// Sea states from here on are drawn with relief.
const MIN_RELIEF_STATE: u8 = 2;
/// A picture moves by less than this during the exposure: no blur, pixels.
const STILL_PX: f64 = 0.6;
/// What the lens gives to each neighbour.
const SOFTNESS: f32 = 0.085;

/// Everything a frame is drawn from.
pub(super) struct View<'a> {
    pub(super) settings: &'a RenderSettings,
    pub(super) sea: &'a Sea,
    pub(super) camera: &'a Camera,
    pub(super) textures: &'a Textures,
    pub(super) tiles: [&'a waves::Tile; 3],
    pub(super) unresolved_variance: f32,
    pub(super) wake: Option<&'a Wake>,
    pub(super) objects: &'a FrameObjects,
    pub(super) light: &'a Lighting,
    pub(super) snapshot: &'a Snapshot,
}

/// Memory for the rows of one size of picture.
#[derive(Debug)]
pub(super) struct Frame {
    size: PictureSize,
    seed: u64,
    noise: NoiseTable,
    light: Vec<RwLock<Light>>,
    strips: Vec<Mutex<Strip>>,
    /// For each band, how many bands are still to be shaded before it can be developed.
    missing: Vec<AtomicUsize>,
}

/// Linear light of a band: red, green and blue of each row, one behind the other, each padded to whole chunks.
#[derive(Debug)]
struct Light {
    values: Vec<f32>,
    chunk: Box<Chunk>,
    nodes: Nodes,
    images: Vec<ImageNear>,
}

/// An image that a row may see.
#[derive(Debug, Clone, Copy)]
struct ImageNear {
    /// Number of the thing.
    index: usize,
    is_reflection: bool,
    /// Pixels by which a slope of 1 moves it.
    reach: f32,
    /// Pixels by which it is moved at most, and some.
    spare: i32,
}

/// Samples of a band, and two rows at work.
#[derive(Debug)]
struct Strip {
    y: Vec<u8>,
    u: Vec<u8>,
    v: Vec<u8>,
    rows: [Vec<f32>; 6],
    scratch: Vec<f32>,
}

impl Frame {
    pub(super) fn new(size: PictureSize, seed: u64) -> Self {
        let (width, height) = (size.width as usize, size.height as usize);
        let padded = width.next_multiple_of(CHUNK);
        let bands = height.div_ceil(ROWS);
        let light = || {
            let values = vec![0.0; ROWS * 3 * padded];
            let (chunk, nodes) = (Box::new(Chunk::new()), Nodes::new(width));
            RwLock::new(Light { values, chunk, nodes, images: Vec::new() })
        };
        let strip = || {
            Mutex::new(Strip {
                y: vec![0; ROWS * width],
                u: vec![0; ROWS * width / 4],
                v: vec![0; ROWS * width / 4],
                rows: core::array::from_fn(|_| vec![0.0; width]),
                scratch: vec![0.0; width],
            })
        };
        Self {
            size,
            seed,
            noise: NoiseTable::new(seed),
            light: (0..bands).map(|_| light()).collect(),
            strips: (0..bands).map(|_| strip()).collect(),
            missing: (0..bands).map(|_| AtomicUsize::new(0)).collect(),
        }
    }

    /// Draws all rows into a picture of this size. Each band is developed by whoever has shaded the last band that it
    /// needs, while their light is still at hand.
    pub(super) fn render(&mut self, view: &View<'_>, picture: &mut Picture, bands: &dyn ParallelFor) {
        let blur = blur_px(view);
        let count = self.light.len();
        let reach = (libm::ceil(0.5 * libm::fabs(blur.1)) as usize + 1).div_ceil(ROWS);
        let about = |band: usize| band.saturating_sub(reach)..(band + reach + 1).min(count);
        for (band, missing) in self.missing.iter_mut().enumerate() {
            *missing.get_mut() = about(band).len();
        }
        let this = &*self;
        bands.run(count, &|band| {
            this.each_row(band, &|row, light| shade_row(view, row, light));
            this.each_row(band, &|row, light| this.composite_row(view, row, light));
            for ready in about(band) {
                if this.missing[ready].fetch_sub(1, Ordering::AcqRel) == 1 {
                    this.develop_band(view, blur, ready);
                }
            }
        });
        self.copy_to_picture(picture);
    }

    /// Shades all rows.
    pub(super) fn shade(&self, view: &View<'_>, bands: &dyn ParallelFor) {
        bands.run(self.light.len(), &|band| {
            self.each_row(band, &|row, light| shade_row(view, row, light));
        });
    }

    /// Lays things over the shaded rows.
    pub(super) fn composite(&self, view: &View<'_>, bands: &dyn ParallelFor) {
        bands.run(self.light.len(), &|band| {
            self.each_row(band, &|row, light| self.composite_row(view, row, light));
        });
    }

    /// Turns the rows of light into a picture of this size.
    pub(super) fn develop(&mut self, view: &View<'_>, picture: &mut Picture, bands: &dyn ParallelFor) {
        let blur = blur_px(view);
        let this = &*self;
        bands.run(this.strips.len(), &|band| this.develop_band(view, blur, band));
        self.copy_to_picture(picture);
    }

    fn each_row(&self, band: usize, work: &dyn Fn(usize, &mut Light)) {
        let mut light = self.light[band].write().unwrap_or_else(PoisonError::into_inner);
        let last = (ROWS * (band + 1)).min(self.size.height as usize);
        (ROWS * band..last).for_each(|row| work(row, &mut light));
    }

    fn composite_row(&self, view: &View<'_>, row: usize, light: &mut Light) {
        let width = self.size.width as usize;
        let padded = width.next_multiple_of(CHUNK);
        let values = &mut light.values[(row % ROWS) * 3 * padded..][..3 * padded];
        for &index in &view.objects.order {
            composite(&view.objects.drawn[index].itself, row, width, padded, values);
        }
    }

    fn develop_band(&self, view: &View<'_>, blur: (f64, f64), band: usize) {
        let mut strip = lock(&self.strips[band]);
        let last = (ROWS * (band + 1)).min(self.size.height as usize);
        for row in (ROWS * band..last).step_by(2) {
            self.develop_pair(view, blur, row, &mut strip);
        }
    }

    fn copy_to_picture(&mut self, picture: &mut Picture) {
        let [y, u, v] = picture.planes_mut();
        for (band, strip) in self.strips.iter_mut().enumerate() {
            let strip = strip.get_mut().unwrap_or_else(PoisonError::into_inner);
            let copy = |out: &mut [u8], from: &[u8]| {
                let start = (band * from.len()).min(out.len());
                let end = (start + from.len()).min(out.len());
                out[start..end].copy_from_slice(&from[..end - start]);
            };
            copy(y, &strip.y);
            copy(u, &strip.u);
            copy(v, &strip.v);
        }
    }

    /// Takes a channel of a row of light (rows outside of the picture repeat its border).
    fn with_row(&self, row: i64, channel: usize, take: impl FnOnce(&[f32])) {
        let (width, height) = (self.size.width as usize, self.size.height as usize);
        let row = row.clamp(0, height as i64 - 1) as usize;
        let padded = width.next_multiple_of(CHUNK);
        let light = self.light[row / ROWS].read().unwrap_or_else(PoisonError::into_inner);
        take(&light.values[((row % ROWS) * 3 + channel) * padded..][..width]);
    }

    fn develop_pair(&self, view: &View<'_>, blur: (f64, f64), row: usize, strip: &mut Strip) {
        let simd = view.settings.simd;
        let (width, height) = (self.size.width as usize, self.size.height as usize);
        let sensor = &view.snapshot.sensor;
        let diagonal = libm::hypot(width as f64, height as f64);
        let moving = libm::hypot(blur.0, blur.1) > STILL_PX;
        for half in 0..2 {
            let from = (row + half) as i64;
            for channel in 0..3 {
                let out = &mut strip.rows[3 * half + channel];
                if !view.settings.effects.blur {
                    self.with_row(from, channel, |values| out.copy_from_slice(values));
                } else if moving {
                    let taps = (libm::ceil(libm::hypot(blur.0, blur.1)) as usize + 1).min(TAPS);
                    out.fill(0.0);
                    for tap in 0..taps {
                        let part = tap as f64 / (taps - 1).max(1) as f64 - 0.5;
                        let (du, dv) = (libm::rint(part * blur.0), libm::rint(part * blur.1));
                        self.with_row(from + dv as i64, channel, |values| {
                            sensor::add_shifted(simd, values, du as i32, 1.0 / taps as f32, out);
                        });
                    }
                } else {
                    let scratch = &mut strip.scratch;
                    self.with_row(from - 1, channel, |up| {
                        self.with_row(from, channel, |here| {
                            self.with_row(from + 1, channel, |down| {
                                sensor::soften(simd, [up, here, down], SOFTNESS, scratch, out);
                            });
                        });
                    });
                }
            }
        }
        let gain = sensor.exposure as f32 * EXPOSURE;
        let step = (2.0 / diagonal) as f32;
        let how = |row: usize| Development {
            gains: [gain * sensor.red as f32, gain, gain * sensor.blue as f32],
            y: (row as f32 + 0.5 - 0.5 * height as f32) * step,
            x0: (0.5 - 0.5 * width as f32) * step,
            step,
            noise: if view.settings.effects.noise { 1.0 } else { 0.0 },
        };
        let grain = |stream: u64, row: usize| {
            let random = noise::hash(self.seed ^ view.snapshot.tick, stream, row as u64);
            self.noise.row(random, width)
        };
        let [r0, g0, b0, r1, g1, b1] = &mut strip.rows;
        sensor::develop(simd, &how(row), [r0, g0, b0]);
        sensor::develop(simd, &how(row + 1), [r1, g1, b1]);
        let local = row % ROWS;
        let (upper, lower) = strip.y[local * width..][..2 * width].split_at_mut(width);
        sensor::luma(simd, &how(row), [r0, g0, b0], grain(1, row), upper);
        sensor::luma(simd, &how(row + 1), [r1, g1, b1], grain(1, row + 1), lower);
        for (sum, other) in [(&mut *r0, r1), (&mut *g0, g1), (&mut *b0, b1)] {
            sensor::add_shifted(simd, other, 0, 1.0, sum);
        }
        let at = local / 2 * (width / 2)..(local / 2 + 1) * (width / 2);
        sensor::chroma(
            simd,
            &how(row),
            [r0, g0, b0],
            [grain(2, row), grain(3, row)],
            &mut strip.u[at.clone()],
            &mut strip.v[at],
        );
    }
}

/// Gain at which a sunlit scene is well exposed.
const EXPOSURE: f32 = 1.45;

/// By how much the picture moves during the exposure, pixels.
fn blur_px(view: &View<'_>) -> (f64, f64) {
    let height = view.settings.optics.picture.height as usize;
    let (first, last) = (view.camera.row(0), view.camera.row(height - 1));
    let ahead = view.camera.row(height / 2).axes.ahead;
    let seen = |axes: &crate::pose::CameraAxes| {
        view.settings.optics.project((ahead.dot(axes.right), ahead.dot(axes.down), ahead.dot(axes.ahead)))
    };
    match (seen(&first.axes), seen(&last.axes)) {
        (Some(a), Some(b)) if view.settings.readout_s > 0.0 => {
            let part = view.snapshot.sensor.exposure_s / view.settings.readout_s;
            ((b.u - a.u) * part, (b.v - a.v) * part)
        }
        _ => (0.0, 0.0),
    }
}

fn shade_row(view: &View<'_>, row: usize, light: &mut Light) {
    let simd = view.settings.simd;
    let optics = &view.settings.optics;
    let width = optics.picture.width as usize;
    let padded = width.next_multiple_of(CHUNK);
    let pose = view.camera.row(row);
    let rays = Rays::new(optics, pose, row);
    let at_sea = view.snapshot.ground == Ground::Water;
    let viewpoint = pose.position;
    let part = |v: f64, size: f64| (v - libm::floor(v / size) * size) as f32;
    let water = at_sea.then(|| water_of(view, viewpoint.x, viewpoint.y));
    let wake = view.wake.and_then(|wake| wake.lookup(viewpoint.x, viewpoint.y));
    let (ws, wc) = libm::sincos(view.sea.wind().towards.radians());
    // Textures of foam repeat after 4 m along the wind and 32/3 m across; 32 m hold whole numbers of both.
    let foam = FoamTexture {
        lace: &view.textures.lace,
        origin: (
            part(viewpoint.x * wc + viewpoint.y * ws, 32.0),
            part(viewpoint.y * wc - viewpoint.x * ws, 32.0),
        ),
        wind: (wc as f32, ws as f32),
    };
    let body = water_body(view.settings.water);
    let step = (1.0 / optics.focal_px) as f32;
    let Light { values, chunk, nodes, images } = light;
    cast_nodes(simd, &rays, nodes);
    if let Some(water) = &water {
        fill_node_variance(simd, water, nodes);
        prepare_reflection(simd, view.light, nodes);
    }
    images_near(view, row, images);
    let clouds = &view.textures.clouds;
    for column in (0..width).step_by(CHUNK) {
        cast_pixels(simd, &rays, nodes, column, chunk);
        if let Some(water) = &water {
            let (low, high) = nodes.dz.range(column);
            let (sky_is_seen, water_is_seen) = (high > -HORIZON - 2.0 * step, low < 2.0 * step - HORIZON);
            if water_is_seen {
                sample_surface(simd, water, nodes, (row, column), chunk);
                let wake = wake.as_ref().filter(|wake| wake.meets(nodes, column, water.relief_m()));
                if let Some(wake) = wake {
                    add_wake(simd, wake, chunk);
                }
                let mut is_bare = true;
                for near in &*images {
                    is_bare &= !image(view, near, (row, column), chunk);
                }
                let may_foam = wake.is_some() || water.foam.is_some();
                if may_foam && chunk.foam.iter().fold(0, |bits, foam| bits | foam.to_bits()) != 0 {
                    texture_foam(simd, &foam, chunk);
                    is_bare = false;
                }
                is_bare &= wake.is_none();
                shade_water(simd, view.light, &body, clouds, nodes, (column, is_bare), chunk);
            } else {
                chunk.colour = [[0.0; CHUNK]; 3];
            }
            if sky_is_seen {
                shade_sky(simd, view.light, clouds, HORIZON, optics.focal_px as f32, chunk);
            }
            for shore in &view.objects.shores {
                shore.paint(viewpoint, view.light, &view.textures.grain, &view.textures.gusts, chunk);
            }
        } else {
            chunk.lit = [1.0; CHUNK];
            for near in &*images {
                image(view, near, (row, column), chunk);
            }
            let origin = (part(viewpoint.x, 307.2), part(viewpoint.y, 307.2));
            floor::shade_floor(simd, view.light, &view.textures.grain, &view.textures.gusts, origin, chunk);
        }
        let start = (row % ROWS) * 3 * padded + column;
        store_chunk(simd, chunk, padded, &mut values[start..]);
    }
}

at_level! { simd;
    /// Copies a chunk's colours to the front of each channel's row.
    fn store_chunk(simd: Simd, chunk: &Chunk, padded: usize, values: &mut [f32]) {
        for (channel, colour) in chunk.colour.iter().enumerate() {
            values[channel * padded..][..CHUNK].copy_from_slice(colour);
        }
    }
}

fn water_of<'a>(view: &View<'a>, x: f64, y: f64) -> Water<'a> {
    let swell = view.tiles[0].swell();
    let rough_enough = view.sea.state().number() >= MIN_RELIEF_STATE;
    // Gusts drift with the wind.
    let drift = view.snapshot.tick as f64 / f64::from(crate::camera_axis::TICKS_PER_SECOND);
    let wind = view.sea.wind();
    let (ws, wc) = libm::sincos(wind.towards.radians());
    let travel = 0.4 * wind.speed_mps * drift;
    let texels = |v: f64| (2.1 * v - libm::floor(2.1 * v / 256.0) * 256.0) as f32;
    Water {
        tiles: view.tiles.map(|tile| TileLookup::new(tile, x, y)),
        elevation: swell
            .filter(|_| rough_enough)
            .map(|swell| ElevationMap { quads: &swell.elevation.quads, step: swell.step_m }),
        foam: swell.and_then(|swell| swell.foam.as_ref()),
        gusts: &view.textures.gusts,
        gust_origin: (texels(x - travel * wc), texels(y - travel * ws)),
        unresolved_variance: view.unresolved_variance,
    }
}

fn water_body(water: WaterColour) -> WaterBody {
    let (deep, crest) = match water {
        WaterColour::Lake => ([0.008, 0.058, 0.078], [0.008, 0.050, 0.052]),
        WaterColour::Sea => ([0.005, 0.042, 0.100], [0.006, 0.055, 0.075]),
        WaterColour::Green => ([0.030, 0.068, 0.052], [0.016, 0.036, 0.024]),
    };
    WaterBody { deep, crest, aerated: [0.16, 0.40, 0.38] }
}

/// Writes down the mirror images and shadows that a row may see, from far to near.
fn images_near(view: &View<'_>, row: usize, images: &mut Vec<ImageNear>) {
    images.clear();
    images.reserve(2 * view.objects.order.len());
    for &index in &view.objects.order {
        let drawn = &view.objects.drawn[index];
        for (tile, is_reflection) in [(&drawn.reflection, true), (&drawn.shadow, false)] {
            let reach = if is_reflection { 2.0 * drawn.reach } else { 0.5 * drawn.reach };
            let spare = (0.4 * reach) as i32 + 2;
            let row = row as i32;
            if tile.width > 0 && row >= tile.top - spare && row < tile.top + tile.height as i32 + spare {
                images.push(ImageNear { index, is_reflection, reach, spare });
            }
        }
    }
}

/// A mirror image or a shadow as a chunk of water sees it, moved by its slopes. Returns whether it may be there at all.
fn image(view: &View<'_>, near: &ImageNear, (row, column): (usize, usize), chunk: &mut Chunk) -> bool {
    let drawn = &view.objects.drawn[near.index];
    let tile = if near.is_reflection { &drawn.reflection } else { &drawn.shadow };
    let column = column as i32;
    let first = (tile.left - near.spare - column).max(0);
    let last = (tile.left + tile.width as i32 + near.spare - column).min(CHUNK as i32);
    let (reach, limit) = (near.reach, 0.4 * near.reach);
    let seen_by = first.max(0) as usize..last.max(0) as usize;
    for i in seen_by.clone() {
        let (dx, dy) = (chunk.dx[i], chunk.dy[i]);
        let level = (dx * dx + dy * dy).sqrt().max(1e-3);
        let (ax, ay) = (dx / level, dy / level);
        let away = chunk.sx[i] * ax + chunk.sy[i] * ay;
        let aside = chunk.sx[i] * ay - chunk.sy[i] * ax;
        let dv = (reach * away).clamp(-limit, limit);
        let du = (0.5 * reach * aside).clamp(-limit, limit);
        let (x, y) = (column + i as i32 - tile.left, row as i32 - tile.top);
        let (x, y) = (x + nearest(du), y + nearest(dv));
        if x < 0 || y < 0 || x as usize >= tile.width || y as usize >= tile.height {
            continue;
        }
        let pixel = tile.pixels[y as usize * tile.width + x as usize];
        let left = 1.0 - pixel[3];
        if near.is_reflection {
            for c in 0..3 {
                chunk.reflection[c][i] = chunk.reflection[c][i] * left + pixel[c];
            }
            chunk.sky_left[i] *= left;
        } else {
            chunk.lit[i] *= 1.0 - 0.85 * pixel[3];
        }
    }
    !seen_by.is_empty()
}

/// The nearest whole number.
fn nearest(v: f32) -> i32 {
    ((v + ROUNDING) - ROUNDING) as i32
}

/// Lays a thing over a row of light.
fn composite(tile: &Tile, row: usize, width: usize, padded: usize, values: &mut [f32]) {
    let y = row as i32 - tile.top;
    if y < 0 || y as usize >= tile.height {
        return;
    }
    let first = tile.left.max(0);
    let last = (tile.left + tile.width as i32).min(width as i32);
    for column in first..last {
        let pixel = tile.pixels[y as usize * tile.width + (column - tile.left) as usize];
        if pixel[3] > 0.0 {
            for c in 0..3 {
                let slot = &mut values[c * padded + column as usize];
                *slot = *slot * (1.0 - pixel[3]) + pixel[c];
            }
        }
    }
}
