//! Enlarged clips: for the tracker's cost on a larger picture of the same scene.

use std::sync::Arc;

use barrelman_vocab::video::Plane;
use barrelman_vocab::{Picture, PictureSize, PixelBox, VideoFrame};

use super::clips::Clip;
use super::scoring::Label;

/// Enlarges 1280x720 to 1920x1080.
const FACTOR: f64 = 1.5;

/// A clip with both sides enlarged by [`FACTOR`].
pub(crate) fn enlarged(clip: &Clip) -> Clip {
    Clip {
        name: clip.name.clone(),
        frames: clip.frames.iter().map(enlarged_frame).collect(),
        labels: clip
            .labels
            .iter()
            .map(|label| match label {
                Some(Label::Visible(bounds)) => Some(Label::Visible(enlarged_box(*bounds))),
                other => *other,
            })
            .collect(),
        start: clip.start,
        selection: enlarged_box(clip.selection),
    }
}

fn enlarged_box(bounds: PixelBox) -> PixelBox {
    PixelBox { u: bounds.u * FACTOR, v: bounds.v * FACTOR, w: bounds.w * FACTOR, h: bounds.h * FACTOR }
}

fn enlarged_frame(frame: &VideoFrame) -> VideoFrame {
    let from = &frame.picture;
    let side = |pixels: u32| (f64::from(pixels) * FACTOR).round() as u32;
    let size = PictureSize::new(side(from.size().width), side(from.size().height));
    let mut to = Picture::black(size, from.colour());
    let chroma = to.chroma_size();
    let [y, u, v] = to.planes_mut();
    interpolate(from.y(), size, y);
    interpolate(from.u(), chroma, u);
    interpolate(from.v(), chroma, v);
    VideoFrame { picture: Arc::new(to), ..frame.clone() }
}

/// Fills a plane by bilinear interpolation. Sample centres are at half pixels; samples beyond the border
/// repeat it.
fn interpolate(from: Plane<'_>, size: PictureSize, to: &mut [u8]) {
    let columns = taps(from.width, size.width as usize);
    let rows = taps(from.height, size.height as usize);
    for (out, row) in to.chunks_exact_mut(size.width as usize).zip(rows) {
        let (above, below) = (from.row(row.low), from.row(row.high));
        for (sample, column) in out.iter_mut().zip(&columns) {
            let interpolate_row = |line: &[u8]| {
                u32::from(line[column.low]) * (256 - column.weight)
                    + u32::from(line[column.high]) * column.weight
            };
            // Two weights of 1/256 each: 32768 rounds the quotient by 65536.
            *sample =
                ((interpolate_row(above) * (256 - row.weight) + interpolate_row(below) * row.weight + 32_768)
                    >> 16) as u8;
        }
    }
}

/// The two samples that a sample is interpolated from, and the weight of the second, in 1/256.
struct Tap {
    low: usize,
    high: usize,
    weight: u32,
}

fn taps(from: usize, to: usize) -> Vec<Tap> {
    let last = from - 1;
    let tap = |index: usize| {
        let at = ((index as f64 + 0.5) * from as f64 / to as f64 - 0.5).clamp(0.0, last as f64);
        let low = at.floor() as usize;
        Tap { low, high: (low + 1).min(last), weight: (at.fract() * 256.0).round() as u32 }
    };
    (0..to).map(tap).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_plane_is_interpolated_between_its_sample_centres() {
        let data = [0, 60, 0, 60];
        let from = Plane { data: &data, width: 2, height: 2, stride: 2 };
        let mut to = [0; 9];
        interpolate(from, PictureSize::new(3, 3), &mut to);
        assert_eq!(to, [0, 30, 60, 0, 30, 60, 0, 30, 60]);
    }

    #[test]
    fn an_even_plane_stays_even() {
        let data = [77; 12];
        let from = Plane { data: &data, width: 4, height: 3, stride: 4 };
        let mut to = [0; 24];
        interpolate(from, PictureSize::new(6, 4), &mut to);
        assert_eq!(to, [77; 24]);
    }
}
