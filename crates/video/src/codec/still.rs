//! Decodes JPEG and PNG files.
//!
//! Y, Cb and Cr of a JPEG file are used without a conversion to RGB; its chroma is averaged to 4:2:0. A PNG
//! file is converted by BT.601 in full range, as in JFIF: Y = 0.299 R + 0.587 G + 0.114 B, Cb = 128 + (B - Y)
//! / 1.772, Cr = 128 + (R - Y) / 1.402. Grey, palette and 16-bit PNG files are converted to 8-bit RGB first;
//! transparency is ignored. The reader of a file applies the orientation in its EXIF data. Not
//! handled: CMYK, colour profiles, animations (the first picture is used).

use std::sync::Arc;

use barrelman_vocab::image::PictureSize;
use barrelman_vocab::video::{ColourEncoding, LumaWeights, Picture};
use zune_core::bytestream::ZCursor;
use zune_core::colorspace::ColorSpace;
use zune_core::options::DecoderOptions;
use zune_jpeg::JpegDecoder;

use super::huffman;
use super::pool::PicturePool;

/// Maximum width and height of a picture, pixels: bounds the memory that a damaged header can request.
const MAX_SIDE: usize = 8192;

/// Decodes JPEG and PNG files, and reuses its buffers.
#[derive(Debug, Default)]
pub(super) struct StillDecoder {
    pixels: Vec<u8>,
    /// A JPEG file that came without Huffman tables, with them.
    completed: Vec<u8>,
}

impl StillDecoder {
    /// The picture in a JPEG file.
    pub(super) fn jpeg(&mut self, file: &[u8], pool: &mut PicturePool) -> Result<Arc<Picture>, String> {
        // Strict: a truncated picture is an error, instead of a partly grey picture.
        let options =
            DecoderOptions::default().set_strict_mode(true).set_max_width(MAX_SIDE).set_max_height(MAX_SIDE);
        let file = huffman::with_tables(file, &mut self.completed);
        let mut decoder = JpegDecoder::new_with_options(ZCursor::new(file), options);
        decoder.decode_headers().map_err(|error| error.to_string())?;
        let (stored, samples) = match decoder.input_colorspace() {
            Some(ColorSpace::Luma) => (ColorSpace::Luma, 1),
            Some(ColorSpace::RGB) => (ColorSpace::RGB, 3),
            Some(ColorSpace::YCbCr) => (ColorSpace::YCbCr, 3),
            other => {
                return Err(format!("its colours are {other:?}: convert it with `ffmpeg -i IN.jpg OUT.png`"));
            }
        };
        decoder.set_options(options.jpeg_set_out_colorspace(stored));
        let info = decoder.info().ok_or("it has no header")?;
        let size = PictureSize::new(u32::from(info.width), u32::from(info.height));
        self.pixels.resize(size.area() * samples, 0);
        decoder.decode_into(&mut self.pixels).map_err(|error| error.to_string())?;
        self.to_planes(size, samples, stored == ColorSpace::YCbCr, pool)
    }

    /// The picture in a PNG file.
    pub(super) fn png(&mut self, file: &[u8], pool: &mut PicturePool) -> Result<Arc<Picture>, String> {
        let mut decoder = png::Decoder::new(std::io::Cursor::new(file));
        decoder.set_transformations(png::Transformations::normalize_to_color8());
        let mut reader = decoder.read_info().map_err(|error| error.to_string())?;
        let info = reader.info();
        let size = PictureSize::new(info.width, info.height);
        if size.width.max(size.height) as usize > MAX_SIDE {
            return Err(format!("it is {size}, larger than {MAX_SIDE} pixels a side"));
        }
        let bytes = reader.output_buffer_size().ok_or("it is too large")?;
        self.pixels.resize(bytes, 0);
        reader.next_frame(&mut self.pixels).map_err(|error| error.to_string())?;
        let samples = reader.output_color_type().0.samples();
        self.to_planes(size, samples, false, pool)
    }

    /// Interleaved pixels of 1 (grey), 2 (grey, alpha), 3 or 4 (with alpha) samples to planes.
    fn to_planes(
        &self,
        size: PictureSize,
        samples: usize,
        is_ycbcr: bool,
        pool: &mut PicturePool,
    ) -> Result<Arc<Picture>, String> {
        let (width, height) = (size.width as usize, size.height as usize);
        if self.pixels.len() != size.area() * samples || size.area() == 0 {
            return Err("its size does not fit its content".to_owned());
        }
        let pixels = self.pixels.chunks_exact(samples);
        pool.fill(size, ColourEncoding::JPEG, |picture| {
            let [y, u, v] = picture.planes_mut();
            if samples <= 2 {
                y.iter_mut().zip(pixels).for_each(|(y, pixel)| *y = pixel[0]);
                u.fill(128);
                v.fill(128);
                return Ok(());
            }
            let luma = |pixel: &[u8]| if is_ycbcr { pixel[0] } else { luma_of(pixel[0], pixel[1], pixel[2]) };
            y.iter_mut().zip(pixels).for_each(|(y, pixel)| *y = luma(pixel));
            let chroma_width = width.div_ceil(2);
            for (index, (u, v)) in u.iter_mut().zip(v).enumerate() {
                let (row, column) = (index / chroma_width * 2, index % chroma_width * 2);
                // The mean of four pixels. At an odd edge the last column or row is repeated.
                let mut sum = [0_u32; 3];
                for (down, right) in [(0, 0), (0, 1), (1, 0), (1, 1)] {
                    let at =
                        ((row + down).min(height - 1) * width + (column + right).min(width - 1)) * samples;
                    sum.iter_mut()
                        .zip(&self.pixels[at..])
                        .for_each(|(sum, sample)| *sum += u32::from(*sample));
                }
                let mean = sum.map(|sum| ((sum + 2) / 4) as u8);
                (*u, *v) = if is_ycbcr { (mean[1], mean[2]) } else { chroma_of(mean[0], mean[1], mean[2]) };
            }
            Ok(())
        })
    }
}

const WEIGHTS: LumaWeights = ColourEncoding::JPEG.matrix.luma_weights();

/// The rows of the matrix from red, green and blue to Y, Cb and Cr, in units of 2^-16.
const LUMA: [i32; 3] = [fixed(WEIGHTS.red), fixed(WEIGHTS.green), fixed(WEIGHTS.blue)];
const CB: [i32; 3] =
    [fixed(-WEIGHTS.red / WEIGHTS.cb_divisor()), fixed(-WEIGHTS.green / WEIGHTS.cb_divisor()), fixed(0.5)];
const CR: [i32; 3] =
    [fixed(0.5), fixed(-WEIGHTS.green / WEIGHTS.cr_divisor()), fixed(-WEIGHTS.blue / WEIGHTS.cr_divisor())];

/// A weight in units of 2^-16, rounded half away from zero.
const fn fixed(weight: f64) -> i32 {
    let scaled = weight * 65_536.0;
    if scaled < 0.0 { (scaled - 0.5) as i32 } else { (scaled + 0.5) as i32 }
}

fn weighted_sum(weights: [i32; 3], rgb: [u8; 3], offset: i32) -> u8 {
    let sum: i32 = weights.iter().zip(rgb).map(|(weight, sample)| weight * i32::from(sample)).sum();
    (((sum + (1 << 15)) >> 16) + offset).clamp(0, 255) as u8
}

fn luma_of(r: u8, g: u8, b: u8) -> u8 {
    weighted_sum(LUMA, [r, g, b], 0)
}

fn chroma_of(r: u8, g: u8, b: u8) -> (u8, u8) {
    let u = weighted_sum(CB, [r, g, b], 128);
    let v = weighted_sum(CR, [r, g, b], 128);
    (u, v)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_rows_of_the_matrix_are_those_of_jfif() {
        // JFIF 1.02, in units of 2^-16.
        assert_eq!(LUMA, [19_595, 38_470, 7_471]);
        assert_eq!(CB, [-11_058, -21_710, 32_768]);
        assert_eq!(CR, [32_768, -27_439, -5_329]);
    }

    #[test]
    fn primaries_become_the_values_of_jfif() {
        // JFIF 1.02: Y, Cb and Cr of full-range BT.601, rounded.
        for (rgb, yuv) in [
            ([0, 0, 0], (0, 128, 128)),
            ([255, 255, 255], (255, 128, 128)),
            ([255, 0, 0], (76, 85, 255)),
            ([0, 255, 0], (150, 44, 21)),
            ([0, 0, 255], (29, 255, 107)),
        ] {
            let [r, g, b] = rgb;
            let (u, v) = chroma_of(r, g, b);
            assert_eq!((luma_of(r, g, b), u, v), yuv, "{rgb:?}");
        }
    }
}
