//! Encodes pictures as JPEG for a page.
//!
//! JPEG files hold BT.601 in the full range (JFIF). Samples of another encoding are converted by one matrix,
//! computed once a picture.

use barrelman_vocab::Picture;
use barrelman_vocab::video::{ColourEncoding, FullScale};
use jpeg_encoder::{Encoder, EncodingError, ImageBuffer, JpegColorType, SamplingFactor};
use thiserror::Error;

/// Quality of the encoder, 1 to 100: sharp pictures of about a tenth of a byte a pixel.
const QUALITY: u8 = 78;

/// A picture cannot be encoded.
#[derive(Debug, Error)]
#[error(transparent)]
pub struct JpegError(#[from] EncodingError);

/// Encodes a picture as a JPEG file.
///
/// # Errors
/// If a side of the picture is longer than 65535 pixels.
pub fn encode(picture: &Picture) -> Result<Vec<u8>, JpegError> {
    let mut bytes = Vec::with_capacity(picture.size().area() / 6);
    let mut encoder = Encoder::new(&mut bytes, QUALITY);
    encoder.set_sampling_factor(SamplingFactor::F_2_2);
    encoder.encode_image(Source { picture, conversion: conversion_from(picture.colour()) })?;
    Ok(bytes)
}

struct Source<'a> {
    picture: &'a Picture,
    /// `None` where the samples are JPEG's already.
    conversion: Option<Conversion>,
}

/// Rows for Y, Cb and Cr: weights of Y, U and V in 1/65536, and an offset.
type Conversion = [[i32; 4]; 3];

impl ImageBuffer for Source<'_> {
    fn get_jpeg_color_type(&self) -> JpegColorType {
        JpegColorType::Ycbcr
    }

    fn width(&self) -> u16 {
        u16::try_from(self.picture.size().width).unwrap_or(u16::MAX)
    }

    fn height(&self) -> u16 {
        u16::try_from(self.picture.size().height).unwrap_or(u16::MAX)
    }

    fn fill_buffers(&self, y: u16, buffers: &mut [Vec<u8>; 4]) {
        let row = usize::from(y);
        let luma = self.picture.y().row(row);
        let (u, v) = (self.picture.u().row(row / 2), self.picture.v().row(row / 2));
        let [to_y, to_cb, to_cr, _] = buffers;
        for (column, y) in luma.iter().enumerate() {
            let (u, v) = (u[column / 2], v[column / 2]);
            match &self.conversion {
                None => {
                    to_y.push(*y);
                    to_cb.push(u);
                    to_cr.push(v);
                }
                Some(conversion) => {
                    let (y, u, v) = (i32::from(*y), i32::from(u), i32::from(v));
                    let [y, cb, cr] = conversion.map(|[of_y, of_u, of_v, offset]| {
                        ((of_y * y + of_u * u + of_v * v + offset) >> 16).clamp(0, 255) as u8
                    });
                    to_y.push(y);
                    to_cb.push(cb);
                    to_cr.push(cr);
                }
            }
        }
    }
}

/// The conversion from a colour encoding to JPEG's.
fn conversion_from(colour: ColourEncoding) -> Option<Conversion> {
    if colour == ColourEncoding::JPEG {
        return None;
    }
    let FullScale { luma: luma_scale, chroma: chroma_scale, black } = colour.range.full_scale();
    let (weights, jpeg) = (colour.matrix.luma_weights(), ColourEncoding::JPEG.matrix.luma_weights());
    let converted = |y: f64, cb: f64, cr: f64| {
        let r = y + weights.cr_divisor() * cr;
        let b = y + weights.cb_divisor() * cb;
        let g = (y - weights.red * r - weights.blue * b) / weights.green;
        let luma = jpeg.red * r + jpeg.green * g + jpeg.blue * b;
        [luma, (b - luma) / jpeg.cb_divisor(), (r - luma) / jpeg.cr_divisor()]
    };
    let (of_y, of_u, of_v) = (
        converted(luma_scale, 0.0, 0.0),
        converted(0.0, chroma_scale, 0.0),
        converted(0.0, 0.0, chroma_scale),
    );
    let rows = [0, 1, 2].map(|row| {
        let middle = if row == 0 { 0.0 } else { 128.0 };
        let offset = middle + 0.5 - black * of_y[row] - 128.0 * (of_u[row] + of_v[row]);
        [of_y[row], of_u[row], of_v[row], offset].map(|share| (share * 65536.0).round() as i32)
    });
    Some(rows)
}

#[cfg(test)]
mod tests {
    use barrelman_vocab::PictureSize;
    use barrelman_vocab::video::{ColourMatrix, SampleRange};
    use zune_core::bytestream::ZCursor;

    use super::*;

    /// A uniform picture of these samples decodes to this colour, with a tolerance of 3 for quantisation.
    fn check(colour: ColourEncoding, [y, u, v]: [u8; 3], rgb: [u8; 3]) {
        let mut picture = Picture::black(PictureSize::new(34, 18), colour);
        for (plane, sample) in picture.planes_mut().into_iter().zip([y, u, v]) {
            plane.fill(sample);
        }
        let file = encode(&picture).unwrap();
        let mut decoder = zune_jpeg::JpegDecoder::new(ZCursor::new(&file));
        let pixels = decoder.decode().unwrap();
        for (got, wanted) in pixels[..3].iter().zip(rgb) {
            assert!(got.abs_diff(wanted) <= 3, "{colour:?}: {:?} for {rgb:?}", &pixels[..3]);
        }
    }

    #[test]
    fn colours_stay_what_they_were() {
        let limited = |matrix| ColourEncoding { matrix, range: SampleRange::Limited };
        check(ColourEncoding::JPEG, [76, 85, 255], [254, 0, 0]);
        check(limited(ColourMatrix::Bt709), [63, 102, 240], [255, 0, 0]);
        check(limited(ColourMatrix::Bt601), [81, 90, 240], [255, 0, 0]);
        check(limited(ColourMatrix::Bt709), [235, 128, 128], [255, 255, 255]);
        check(limited(ColourMatrix::Bt709), [173, 42, 26], [0, 255, 0]);
    }
}
