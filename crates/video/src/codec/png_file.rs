//! Pictures as PNG files.

use std::io::{self, Write};

use barrelman_vocab::Picture;
use barrelman_vocab::video::SampleRange;

/// Writes a picture with 8 bits a channel, red, green and blue.
///
/// # Errors
/// If the output cannot be written.
pub fn write(output: impl Write, picture: &Picture) -> io::Result<()> {
    let size = picture.size();
    let mut encoder = png::Encoder::new(output, size.width, size.height);
    encoder.set_color(png::ColorType::Rgb);
    encoder.set_depth(png::BitDepth::Eight);
    let mut writer = encoder.write_header()?;
    writer.write_image_data(&rgb_of(picture))?;
    writer.finish()?;
    Ok(())
}

/// Red, green and blue of all pixels, row by row.
fn rgb_of(picture: &Picture) -> Vec<u8> {
    let size = picture.size();
    let (black, luma_range, chroma_range) = match picture.colour().range {
        SampleRange::Limited => (16.0, 219.0, 224.0),
        SampleRange::Full => (0.0, 255.0, 255.0),
    };
    let weights = picture.colour().matrix.luma_weights();
    let (to_blue, to_red) = (weights.cb_divisor(), weights.cr_divisor());
    let mut rgb = Vec::with_capacity(3 * size.area());
    for row in 0..size.height as usize {
        let (luma, u, v) = (picture.y().row(row), picture.u().row(row / 2), picture.v().row(row / 2));
        for (column, y) in luma.iter().enumerate() {
            let y = (f64::from(*y) - black) / luma_range;
            let u = (f64::from(u[column / 2]) - 128.0) / chroma_range;
            let v = (f64::from(v[column / 2]) - 128.0) / chroma_range;
            let (red, blue) = (y + to_red * v, y + to_blue * u);
            let green = (y - weights.red * red - weights.blue * blue) / weights.green;
            rgb.extend([red, green, blue].map(|value| (255.0 * value).round().clamp(0.0, 255.0) as u8));
        }
    }
    rgb
}

#[cfg(test)]
mod tests {
    use barrelman_vocab::PictureSize;
    use barrelman_vocab::video::{ColourEncoding, ColourMatrix};

    use super::*;

    #[test]
    fn colours_are_those_of_the_encoding() {
        for (matrix, range, samples, expected) in [
            (ColourMatrix::Bt709, SampleRange::Limited, [16, 128, 128], [0, 0, 0]),
            (ColourMatrix::Bt709, SampleRange::Limited, [235, 128, 128], [255, 255, 255]),
            (ColourMatrix::Bt601, SampleRange::Full, [255, 128, 128], [255, 255, 255]),
            (ColourMatrix::Bt601, SampleRange::Full, [76, 85, 255], [254, 0, 0]),
            (ColourMatrix::Bt709, SampleRange::Limited, [63, 102, 240], [255, 1, 0]),
        ] {
            let mut picture = Picture::black(PictureSize::new(2, 2), ColourEncoding { matrix, range });
            for (plane, sample) in picture.planes_mut().into_iter().zip(samples) {
                plane.fill(sample);
            }
            assert_eq!(rgb_of(&picture)[..3], expected, "{matrix:?} {range:?} {samples:?}");
        }
    }
}
