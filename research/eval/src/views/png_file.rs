//! Pictures as PNG files.

use std::fs::File;
use std::io::BufWriter;
use std::path::Path;

use anyhow::Result;
use barrelman_vocab::Picture;
use barrelman_vocab::video::ColourMatrix;

/// Writes a picture with 8 bits a channel; its colours are those of BT.709 in limited range.
///
/// # Errors
/// If the file cannot be written.
pub(super) fn write(path: &Path, picture: &Picture) -> Result<()> {
    let size = picture.size();
    let mut encoder = png::Encoder::new(BufWriter::new(File::create(path)?), size.width, size.height);
    encoder.set_color(png::ColorType::Rgb);
    encoder.set_depth(png::BitDepth::Eight);
    let mut rgb = Vec::with_capacity(3 * size.area());
    let weights = ColourMatrix::Bt709.luma_weights();
    let [red, green, blue] = [weights.red, weights.green, weights.blue].map(|weight| weight as f32);
    let (cb_divisor, cr_divisor) = (weights.cb_divisor() as f32, weights.cr_divisor() as f32);
    for row in 0..size.height as usize {
        for column in 0..size.width as usize {
            let y = (f32::from(picture.y().row(row)[column]) - 16.0) / 219.0;
            let u = (f32::from(picture.u().row(row / 2)[column / 2]) - 128.0) / 224.0;
            let v = (f32::from(picture.v().row(row / 2)[column / 2]) - 128.0) / 224.0;
            let (r, b) = (y + cr_divisor * v, y + cb_divisor * u);
            let g = (y - red * r - blue * b) / green;
            rgb.extend([r, g, b].map(|value| (255.0 * value).round().clamp(0.0, 255.0) as u8));
        }
    }
    encoder.write_header()?.write_image_data(&rgb)?;
    Ok(())
}
