//! A part of the picture at the coarsest resolution that the target's size allows, worked out once per frame.
//!
//! The luma plane is averaged over squares of k x k pixels (k whole, so integers throughout), the chroma planes
//! over squares of as many pixels as make two crop samples of luma, and the colour model turns each chroma sample
//! with its luma into the probability that it is the target's. What comes after (patches at any place, size and
//! angle) samples these two small maps and never the picture. Beyond the picture's border its outermost samples go
//! on; who measures patches blanks what lies there.

use barrelman_vocab::video::Plane;
use barrelman_vocab::{Picture, PixelBox};

use crate::colour_model::ColourModel;
use crate::explanation::GreyMap;
use crate::simd::widest;

/// Most rows of the picture that one row of the crop is a mean of.
const MOST_ROWS: i32 = 4;

/// A small grey map, rows tightly packed.
#[derive(Debug, Clone, Default)]
pub(crate) struct Samples {
    pub(crate) width: usize,
    pub(crate) height: usize,
    pub(crate) values: Vec<u8>,
    /// Each sample with its neighbours to the right, below, and to the right below, a byte each: what a bilinear
    /// look needs in one load.
    quads: Vec<u32>,
}

widest! {
fn pack(samples: &mut Samples) {
    samples.quads.clear();
    for row in 0..samples.height {
        let here = &samples.values[row * samples.width..][..samples.width];
        let below = &samples.values[(row + 1).min(samples.height - 1) * samples.width..][..samples.width];
        let quad = |a: u8, b: u8, c: u8, d: u8| u32::from_le_bytes([a, b, c, d]);
        let pairs = here.windows(2).zip(below.windows(2));
        samples.quads.extend(pairs.map(|(h, b)| quad(h[0], h[1], b[0], b[1])));
        let (h, b) = (here[samples.width - 1], below[samples.width - 1]);
        samples.quads.push(quad(h, h, b, b));
    }
}
}

/// The maps of one frame's search window.
#[derive(Debug, Clone, Default)]
pub(crate) struct Crop {
    /// Left and top edge, pixels of the picture: even multiples of `decimation`.
    left: i32,
    top: i32,
    /// Pixels of the picture per luma sample.
    decimation: i32,
    pub(crate) luma: Samples,
    /// At half the resolution of `luma`: probability of the target's colour, 0 to 255.
    pub(crate) likeness: Samples,
    chroma: [Vec<u8>; 2],
    columns: Vec<u16>,
    line: Line,
    picture: (i32, i32),
}

/// A square grid of samples, turned and scaled, laid over the picture.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Grid {
    /// Its middle, pixels.
    pub(crate) centre: (f32, f32),
    /// Pixels per sample.
    pub(crate) step: f32,
    /// Cosine and sine of the angle by which it is turned clockwise as seen.
    pub(crate) turn: (f32, f32),
    /// Samples per row.
    pub(crate) width: usize,
    /// Rows.
    pub(crate) height: usize,
}

impl Crop {
    /// Takes what lies within `reach` pixels around `centre` and in the picture; each sample stands for at most
    /// `step` pixels a side.
    pub(crate) fn take(
        &mut self,
        picture: &Picture,
        model: &ColourModel,
        centre: (f32, f32),
        reach: f32,
        step: f32,
    ) {
        // A cast takes what is not a number to 0.
        let k = (step as i32).clamp(1, 64);
        let unit = 2 * k;
        let size = picture.size();
        self.picture = (size.width as i32, size.height as i32);
        let side = |middle: f32, length: i32| {
            let from = ((middle - reach) as i32).clamp(0, (length - 1).max(0)) / unit * unit;
            let to = ((middle + reach) as i32).clamp(from, length);
            (from, ((to - from + unit - 1) / unit + 1) as usize)
        };
        let ((left, across), (top, down)) = (side(centre.0, self.picture.0), side(centre.1, self.picture.1));
        (self.left, self.top, self.decimation) = (left, top, k);
        decimate(
            picture.y(),
            (left, top),
            k,
            (2 * across, 2 * down),
            &mut self.columns,
            &mut self.luma.values,
        );
        (self.luma.width, self.luma.height) = (2 * across, 2 * down);
        let [u, v] = &mut self.chroma;
        decimate(picture.u(), (left / 2, top / 2), k, (across, down), &mut self.columns, u);
        decimate(picture.v(), (left / 2, top / 2), k, (across, down), &mut self.columns, v);
        (self.likeness.width, self.likeness.height) = (across, down);
        self.likeness.values.clear();
        let table = model.table();
        for row in 0..down {
            let upper = &self.luma.values[4 * row * across..][..2 * across];
            let lower = &self.luma.values[(4 * row + 2) * across..][..2 * across];
            let (us, vs) = (&u[row * across..][..across], &v[row * across..][..across]);
            let pairs = upper.chunks_exact(2).zip(lower.chunks_exact(2)).zip(us.iter().zip(vs));
            self.likeness.values.extend(pairs.map(|((a, b), (&u, &v))| {
                let y = (u16::from(a[0]) + u16::from(a[1]) + u16::from(b[0]) + u16::from(b[1])) / 4;
                table.of(y as u8, u, v)
            }));
        }
        pack(&mut self.luma);
        pack(&mut self.likeness);
    }

    /// The grid's samples of luma.
    pub(crate) fn luma_patch(&mut self, grid: &Grid, out: &mut Vec<f32>) {
        let scale = 1.0 / self.decimation as f32;
        let grid = self.within(grid, scale);
        sample(&self.luma, grid, &mut self.line, out);
    }

    /// The grid's samples of the likeness, 0 to 255.
    pub(crate) fn likeness_patch(&mut self, grid: &Grid, out: &mut Vec<f32>) {
        let scale = 0.5 / self.decimation as f32;
        let grid = self.within(grid, scale);
        sample(&self.likeness, grid, &mut self.line, out);
    }

    /// Pixels that a sample of the likeness stands for, a side.
    pub(crate) fn likeness_step(&self) -> f32 {
        (2 * self.decimation) as f32
    }

    /// Visits the samples of likeness within the ellipse of half axes `half`, turned clockwise by `angle`, around
    /// `centre`, as far as they lie in the picture: distance right and down of the centre in pixels, and likeness.
    pub(crate) fn each_likeness(
        &self,
        centre: (f32, f32),
        half: (f32, f32),
        angle: f32,
        mut visit: impl FnMut(f32, f32, u8),
    ) {
        let unit = self.likeness_step();
        let (c, s) = (libm::cosf(angle), libm::sinf(angle));
        let reach = ((half.0 * c).abs() + (half.1 * s).abs(), (half.0 * s).abs() + (half.1 * c).abs());
        // A cast takes what is below 0 or not a number to 0.
        let index = |at: f32, length: usize| ((at / unit) as usize).min(length);
        let (left, top) = (centre.0 - self.left as f32, centre.1 - self.top as f32);
        let inside = |from: i32, length: usize, whole: i32| {
            length.min(((whole - from).max(0) / (unit as i32)) as usize)
        };
        let (width, height) = (
            inside(self.left, self.likeness.width, self.picture.0),
            inside(self.top, self.likeness.height, self.picture.1),
        );
        let columns = index(left - reach.0, width)..index(left + reach.0 + unit, width);
        let inverse = (1.0 / half.0.max(1.0), 1.0 / half.1.max(1.0));
        for row in index(top - reach.1, height)..index(top + reach.1 + unit, height) {
            let dv = (row as f32 + 0.5) * unit - top;
            let line = &self.likeness.values[row * self.likeness.width..][..self.likeness.width];
            for column in columns.clone() {
                let du = (column as f32 + 0.5) * unit - left;
                let (a, b) = ((du * c + dv * s) * inverse.0, (dv * c - du * s) * inverse.1);
                if a * a + b * b <= 1.0 {
                    visit(du, dv, line[column]);
                }
            }
        }
    }

    /// Mean likeness (0 to 1) within the ellipse of half axes `half`, turned clockwise by `angle`, around `centre`,
    /// and in the ring from 1.3 to 2 times its size. 0 where nothing of them lies in the picture.
    pub(crate) fn contrast(&self, centre: (f32, f32), half: (f32, f32), angle: f32) -> (f32, f32) {
        let (mut inner, mut outer) = ((0_u32, 0_u32), (0_u32, 0_u32));
        let (c, s) = (libm::cosf(angle), libm::sinf(angle));
        let inverse = (1.0 / half.0.max(1.0), 1.0 / half.1.max(1.0));
        self.each_likeness(centre, (2.0 * half.0, 2.0 * half.1), angle, |du, dv, likeness| {
            let (a, b) = ((du * c + dv * s) * inverse.0, (dv * c - du * s) * inverse.1);
            let q = a * a + b * b;
            if q <= 1.0 {
                inner = (inner.0 + u32::from(likeness), inner.1 + 1);
            } else if q >= 1.69 {
                outer = (outer.0 + u32::from(likeness), outer.1 + 1);
            }
        });
        let mean =
            |(sum, count): (u32, u32)| if count == 0 { 0.0 } else { sum as f32 / (255 * count) as f32 };
        (mean(inner), mean(outer))
    }

    /// The likeness of what was looked at, for an overlay.
    pub(crate) fn explain_likeness(&self, out: &mut GreyMap) {
        let step = f64::from(self.likeness_step());
        (out.width, out.height) = (self.likeness.width, self.likeness.height);
        out.bounds = PixelBox {
            u: f64::from(self.left),
            v: f64::from(self.top),
            w: step * out.width as f64,
            h: step * out.height as f64,
        };
        out.samples.extend_from_slice(&self.likeness.values);
    }

    fn within(&self, grid: &Grid, scale: f32) -> Grid {
        let centre = ((grid.centre.0 - self.left as f32) * scale, (grid.centre.1 - self.top as f32) * scale);
        Grid { centre, step: grid.step * scale, ..*grid }
    }
}

/// One row of samples on its way: the four neighbours of each, and how far between them it lies.
#[derive(Debug, Clone, Default)]
struct Line {
    quads: Vec<u32>,
    /// 0 to 255 to the right in the low half, downwards in the high half.
    between: Vec<u32>,
}

widest! {
/// Bilinear samples of a map, at places in fixed point of 1/256 sample; beyond the border its outermost samples go
/// on.
fn sample(map: &Samples, grid: Grid, line: &mut Line, out: &mut Vec<f32>) {
    const ONE: f32 = 65_536.0;
    out.resize(grid.width * grid.height, 0.0);
    line.quads.resize(grid.width, 0);
    line.between.resize(grid.width, 0);
    let right = (grid.turn.0 * grid.step, grid.turn.1 * grid.step);
    let down = (-right.1, right.0);
    let (half_w, half_h) = (0.5 * (grid.width as f32 - 1.0), 0.5 * (grid.height as f32 - 1.0));
    let step = ((right.0 * ONE) as i32, (right.1 * ONE) as i32);
    let limit = (((map.width as i32 - 1) << 16) | 0xff00, ((map.height as i32 - 1) << 16) | 0xff00);
    let last = grid.width as i32 - 1;
    for (row, out) in out.chunks_exact_mut(grid.width).enumerate() {
        let off = row as f32 - half_h;
        // The centre of sample (0, 0) is at (0.5, 0.5).
        let x = ((grid.centre.0 - 0.5 + off * down.0 - half_w * right.0) * ONE) as i32;
        let y = ((grid.centre.1 - 0.5 + off * down.1 - half_w * right.1) * ONE) as i32;
        let end = (x.saturating_add(step.0.saturating_mul(last)), y.saturating_add(step.1.saturating_mul(last)));
        let inside = |from: i32, to: i32, limit: i32| from.min(to) >= 0 && from.max(to) <= limit;
        let Line { quads, between } = line;
        if inside(x, end.0, limit.0) && inside(y, end.1, limit.1) {
            let (mut x, mut y) = (x as u32, y as u32);
            for (quad, between) in quads.iter_mut().zip(between.iter_mut()) {
                *quad = map.quads[(y >> 16) as usize * map.width + (x >> 16) as usize];
                *between = ((x >> 8) & 0xff) | ((y & 0xff00) << 8);
                x = x.wrapping_add(step.0 as u32);
                y = y.wrapping_add(step.1 as u32);
            }
        } else {
            let (mut x, mut y) = (x, y);
            for (quad, between) in quads.iter_mut().zip(between.iter_mut()) {
                let (cx, cy) = (x.clamp(0, limit.0), y.clamp(0, limit.1));
                *quad = map.quads[(cy >> 16) as usize * map.width + (cx >> 16) as usize];
                *between = (((cx >> 8) & 0xff) | ((cy & 0xff00) << 8)) as u32;
                x = x.saturating_add(step.0);
                y = y.saturating_add(step.1);
            }
        }
        for ((out, &quad), &between) in out.iter_mut().zip(quads.iter()).zip(between.iter()) {
            // Bytes and halves of words: the casts lose nothing, and signed ones are the quick ones.
            let byte = |shift: u32| ((quad >> shift) & 0xff) as i32 as f32;
            let (fx, fy) = ((between & 0xffff) as i32 as f32 * (1.0 / 256.0), (between >> 16) as i32 as f32 * (1.0 / 256.0));
            let (a, b, c, d) = (byte(0), byte(8), byte(16), byte(24));
            let upper = a + (b - a) * fx;
            let lower = c + (d - c) * fx;
            *out = upper + (lower - upper) * fy;
        }
    }
}
}

widest! {
/// Means over squares of `k` x `k` samples of a plane, from a corner (left, top) on, rows tightly packed; beyond the
/// border its outermost samples go on.
pub(crate) fn decimate(plane: Plane<'_>, corner: (i32, i32), k: i32, size: (usize, usize), columns: &mut Vec<u16>, out: &mut Vec<u8>) {
    let ((left, top), (width, height)) = (corner, size);
    out.clear();
    if plane.width == 0 || plane.height == 0 {
        out.resize(width * height, 0);
        return;
    }
    let (last_x, last_y) = (plane.width as i32 - 1, plane.height as i32 - 1);
    // Of a plane's row, samples `first..last` are used as they are; left and right of them the outermost go on.
    let whole = width as i32 * k;
    let (first, last) = (left.clamp(0, last_x), (left + whole).clamp(1, last_x + 1));
    let before = (first - left).clamp(0, whole) as usize;
    let count = (last - first).max(0).min(whole - before as i32) as usize;
    if k == 1 {
        for row in 0..height as i32 {
            let source = plane.row((top + row).clamp(0, last_y) as usize);
            let start = out.len();
            out.resize(start + before, source[first as usize]);
            out.extend_from_slice(&source[first as usize..first as usize + count]);
            let edge = source[(last - 1).max(0) as usize];
            out.resize(start + width, edge);
        }
        return;
    }
    // Of tall squares only some rows are read, evenly spaced: enough against aliasing, and it bounds the work.
    let lines = k.min(MOST_ROWS);
    // Sums of a column fit into 16 bits, those of a square into 32.
    let scale = (65_536 / (k * lines)) as u32;
    for row in 0..height as i32 {
        columns.clear();
        columns.resize(whole as usize, 0);
        for line in 0..lines {
            let source = plane.row((top + row * k + (2 * line + 1) * k / (2 * lines)).clamp(0, last_y) as usize);
            let middle = &mut columns[before..before + count];
            for (sum, &value) in middle.iter_mut().zip(&source[first as usize..first as usize + count]) {
                *sum += u16::from(value);
            }
        }
        if count > 0 {
            let (edge_left, edge_right) = (columns[before], columns[before + count - 1]);
            columns[..before].fill(edge_left);
            columns[before + count..].fill(edge_right);
        }
        match k {
            2 => means::<2>(columns, scale, out),
            3 => means::<3>(columns, scale, out),
            4 => means::<4>(columns, scale, out),
            5 => means::<5>(columns, scale, out),
            6 => means::<6>(columns, scale, out),
            _ => out.extend(columns.chunks_exact(k as usize).map(|cell| mean(cell, scale))),
        }
    }
}
}

#[inline(always)]
fn means<const K: usize>(columns: &[u16], scale: u32, out: &mut Vec<u8>) {
    let (cells, _) = columns.as_chunks::<K>();
    out.extend(cells.iter().map(|cell| mean(cell, scale)));
}

#[inline(always)]
fn mean(cell: &[u16], scale: u32) -> u8 {
    let sum: u32 = cell.iter().map(|&c| u32::from(c)).sum();
    ((sum * scale + 32_768) >> 16).min(255) as u8
}

#[cfg(test)]
mod tests {
    use barrelman_vocab::PictureSize;
    use barrelman_vocab::video::ColourEncoding;

    use super::*;

    /// A picture whose luma is given by column and row.
    fn picture(size: (u32, u32), luma: impl Fn(usize, usize) -> f32) -> Picture {
        let size = PictureSize::new(size.0, size.1);
        let mut picture = Picture::black(size, ColourEncoding::assumed_for(size));
        let [y, _, _] = picture.planes_mut();
        for (index, sample) in y.iter_mut().enumerate() {
            let width = size.width as usize;
            *sample = luma(index % width, index / width).clamp(0.0, 255.0) as u8;
        }
        picture
    }

    fn patch(picture: &Picture, centre: (f32, f32), step: f32, angle: f32) -> Vec<f32> {
        let mut crop = Crop::default();
        crop.take(picture, &ColourModel::default(), centre, 16.0 * step, step);
        let turn = (libm::cosf(angle), libm::sinf(angle));
        let mut out = Vec::new();
        crop.luma_patch(&Grid { centre, step, turn, width: 16, height: 12 }, &mut out);
        out
    }

    #[test]
    fn a_patch_of_a_picture_of_one_brightness_is_of_that_brightness_everywhere() {
        let picture = picture((97, 61), |_, _| 93.0);
        for centre in [(48.0, 30.0), (0.0, 0.0), (97.0, 61.0), (96.3, 2.2), (-500.0, 900.0)] {
            for step in [0.3, 1.0, 2.7, 5.0, 9.5, 80.0] {
                for angle in [0.0, 0.6, 3.0] {
                    let patch = patch(&picture, centre, step, angle);
                    assert_eq!(patch.len(), 16 * 12);
                    assert!(patch.iter().all(|&sample| sample == 93.0), "{centre:?} {step} {angle}");
                }
            }
        }
    }

    #[test]
    fn a_turned_patch_of_a_ramp_is_a_turned_ramp() {
        // One grey level per pixel to the right: the brightness tells the place.
        let picture = picture((240, 160), |column, _| column as f32);
        let centre = (118.0, 80.0);
        for step in [1.0, 1.6, 2.0, 3.5] {
            for angle_deg in [0.0_f32, 30.0, 90.0, 180.0, -45.0] {
                let angle = angle_deg.to_radians();
                let patch = patch(&picture, centre, step, angle);
                for (index, &sample) in patch.iter().enumerate() {
                    let (right, down) = ((index % 16) as f32 - 7.5, (index / 16) as f32 - 5.5);
                    let u = centre.0 + step * (right * libm::cosf(angle) - down * libm::sinf(angle));
                    // Pixel `n` covers n to n + 1; places are in 1/256 sample, means are rounded.
                    let expected = u - 0.5;
                    assert!(
                        (sample - expected).abs() < 0.6,
                        "{step} {angle_deg} {index}: {sample}, not {expected}"
                    );
                }
            }
        }
    }

    #[test]
    fn means_of_squares_are_means() {
        let picture = picture((64, 48), |column, row| (3 * column + row) as f32);
        let (mut columns, mut out) = (Vec::new(), Vec::new());
        for step in 1..=8 {
            decimate(picture.y(), (4, 3), step, (5, 4), &mut columns, &mut out);
            for (index, &sample) in out.iter().enumerate() {
                let (left, top) = (4 + step * (index % 5) as i32, 3 + step * (index / 5) as i32);
                let middle = 0.5 * (step as f32 - 1.0);
                let mean = 3.0 * (left as f32 + middle) + top as f32 + middle;
                // Of squares more than four high four rows are read; evenly spaced, they are half a row off at most.
                assert!((f32::from(sample) - mean).abs() <= 1.0, "{step} {index}: {sample}, not {mean}");
            }
        }
    }

    #[test]
    fn beyond_the_border_the_outermost_samples_go_on() {
        let picture = picture((20, 16), |column, row| if column == 0 || row == 15 { 200.0 } else { 50.0 });
        let (mut columns, mut out) = (Vec::new(), Vec::new());
        for step in [1, 2, 7] {
            decimate(picture.y(), (-2 * step, 2), step, (3, 1), &mut columns, &mut out);
            assert_eq!(out[..2], [200; 2]);
            decimate(picture.y(), (5, 300), step, (2, 2), &mut columns, &mut out);
            assert_eq!(out, [200; 4]);
            decimate(picture.y(), (300, -300), step, (2, 2), &mut columns, &mut out);
            assert_eq!(out, [50; 4]);
        }
    }

    #[test]
    fn a_picture_of_no_pixels_gives_black() {
        let picture = picture((0, 0), |_, _| 0.0);
        assert!(patch(&picture, (3.0, 3.0), 1.0, 0.0).iter().all(|&sample| sample == 0.0));
    }

    #[test]
    fn likeness_is_visited_within_the_ellipse_and_the_picture_only() {
        let picture = picture((64, 48), |_, _| 90.0);
        let mut crop = Crop::default();
        for (centre, half, share) in [
            ((32.0, 24.0), (20.0, 12.0), 1.0),
            ((0.0, 24.0), (20.0, 12.0), 0.5),
            ((64.0, 48.0), (20.0, 12.0), 0.25),
        ] {
            crop.take(&picture, &ColourModel::default(), centre, 40.0, 1.0);
            let mut area = 0.0;
            crop.each_likeness(centre, half, 0.0, |du, dv, _| {
                assert!((0.0..=64.0).contains(&(centre.0 + du)) && (0.0..=48.0).contains(&(centre.1 + dv)));
                assert!(libm::hypotf(du / half.0, dv / half.1) <= 1.0);
                area += crop.likeness_step() * crop.likeness_step();
            });
            let expected = share * core::f32::consts::PI * half.0 * half.1;
            assert!((area / expected - 1.0).abs() < 0.05, "{centre:?}: {area}, not {expected}");
        }
    }
}
