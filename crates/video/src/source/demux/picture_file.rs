//! Picture files as units: their format, and the rotation that displays them upright (EXIF).
//!
//! PNG and JPEG files are units as they are. WebP and TIFF are converted to PNG, without loss for 8-bit
//! pictures, so that a recording holds what every reader knows. Not handled: mirrored pictures (EXIF
//! orientations 2, 4, 5, 7), which are shown as stored.

use std::io::Cursor;

use barrelman_vocab::unit::{Rotation, UnitCodec};
use bytes::Bytes;
use image::metadata::Orientation;
use image::{DynamicImage, ImageDecoder as _, ImageReader};
use zune_core::bytestream::ZCursor;
use zune_jpeg::JpegDecoder;

use super::kind::FileKind;

/// Maximum width and height of a picture, pixels: bounds the memory that a damaged header can request.
const MAX_SIDE: u32 = 8192;

/// A picture file as the content of a unit.
pub(super) struct PictureFile {
    pub(super) codec: UnitCodec,
    pub(super) rotation: Rotation,
    pub(super) payload: Bytes,
}

impl PictureFile {
    /// Reads a file of this kind.
    ///
    /// # Errors
    /// A WebP or TIFF file that cannot be decoded, or another kind of file.
    pub(super) fn read(kind: FileKind, file: Vec<u8>) -> Result<Self, String> {
        let upright =
            |codec, payload| Self { codec, rotation: Rotation::None, payload: Bytes::from(payload) };
        match kind {
            FileKind::Png => Ok(upright(UnitCodec::Png, file)),
            FileKind::Jpeg => Ok(Self { rotation: jpeg_rotation(&file), ..upright(UnitCodec::Jpeg, file) }),
            FileKind::Webp | FileKind::Tiff => converted(&file),
            _ => Err("it is neither PNG, JPEG, WebP nor TIFF".to_owned()),
        }
    }
}

fn converted(file: &[u8]) -> Result<PictureFile, String> {
    let mut reader =
        ImageReader::new(Cursor::new(file)).with_guessed_format().map_err(|error| error.to_string())?;
    let mut limits = image::Limits::default();
    (limits.max_image_width, limits.max_image_height) = (Some(MAX_SIDE), Some(MAX_SIDE));
    reader.limits(limits);
    let mut decoder = reader.into_decoder().map_err(|error| error.to_string())?;
    let orientation = decoder.orientation().unwrap_or(Orientation::NoTransforms);
    let picture = DynamicImage::from_decoder(decoder).map_err(|error| error.to_string())?.into_rgb8();
    let mut payload = Vec::new();
    let mut encoder = png::Encoder::new(&mut payload, picture.width(), picture.height());
    encoder.set_color(png::ColorType::Rgb);
    encoder.set_compression(png::Compression::Fast);
    let written = encoder.write_header().and_then(|mut writer| writer.write_image_data(&picture));
    written.map_err(|error| error.to_string())?;
    Ok(PictureFile { codec: UnitCodec::Png, rotation: rotation(orientation), payload: payload.into() })
}

/// The rotation that a JPEG file asks for. A file without a readable header asks for none: its decoder tells
/// the damage.
fn jpeg_rotation(file: &[u8]) -> Rotation {
    let mut decoder = JpegDecoder::new(ZCursor::new(file));
    if decoder.decode_headers().is_err() {
        return Rotation::None;
    }
    let orientation = decoder.exif().and_then(|chunk| Orientation::from_exif_chunk(chunk));
    rotation(orientation.unwrap_or(Orientation::NoTransforms))
}

const fn rotation(orientation: Orientation) -> Rotation {
    match orientation {
        Orientation::Rotate90 => Rotation::Clockwise90,
        Orientation::Rotate180 => Rotation::Half,
        Orientation::Rotate270 => Rotation::Clockwise270,
        Orientation::NoTransforms
        | Orientation::FlipHorizontal
        | Orientation::FlipVertical
        | Orientation::Rotate90FlipH
        | Orientation::Rotate270FlipH => Rotation::None,
    }
}

#[cfg(test)]
mod tests {
    use std::fs;

    use image::{ImageFormat, RgbImage};

    use super::*;

    /// A JPEG file with an EXIF segment that holds the orientation alone.
    fn oriented_jpeg(orientation: u8) -> Vec<u8> {
        let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../../fixtures/video/jpeg/1.jpg");
        let file = fs::read(path).unwrap();
        let tiff = [
            b"Exif\0\0MM\0\x2a\0\0\0\x08\0\x01\x01\x12\0\x03\0\0\0\x01\0".as_slice(),
            &[orientation, 0, 0, 0, 0, 0, 0],
        ]
        .concat();
        let length = u16::try_from(tiff.len() + 2).unwrap().to_be_bytes();
        [&file[..2], &[0xff, 0xe1], &length, &tiff, &file[2..]].concat()
    }

    #[test]
    fn the_orientation_of_a_jpeg_file_is_its_rotation() {
        for (orientation, rotation) in [
            (1, Rotation::None),
            (2, Rotation::None),
            (3, Rotation::Half),
            (6, Rotation::Clockwise90),
            (8, Rotation::Clockwise270),
        ] {
            let read = PictureFile::read(FileKind::Jpeg, oriented_jpeg(orientation)).unwrap();
            assert_eq!((read.rotation, read.codec), (rotation, UnitCodec::Jpeg), "{orientation}");
        }
        let damaged = PictureFile::read(FileKind::Jpeg, vec![0xff, 0xd8, 0xff]).unwrap();
        assert_eq!(damaged.rotation, Rotation::None);
    }

    #[test]
    fn webp_and_tiff_become_png_with_the_same_pixels() {
        let picture = RgbImage::from_fn(5, 3, |x, y| image::Rgb([40 * x as u8, 80 * y as u8, 7]));
        for (format, kind) in [(ImageFormat::WebP, FileKind::Webp), (ImageFormat::Tiff, FileKind::Tiff)] {
            let mut file = Cursor::new(Vec::new());
            picture.write_to(&mut file, format).unwrap();
            assert_eq!(FileKind::detect(file.get_ref()), kind);
            let read = PictureFile::read(kind, file.into_inner()).unwrap();
            let mut reader = png::Decoder::new(Cursor::new(&read.payload)).read_info().unwrap();
            let mut pixels = vec![0; reader.output_buffer_size().unwrap()];
            reader.next_frame(&mut pixels).unwrap();
            assert_eq!((read.codec, pixels), (UnitCodec::Png, picture.as_raw().clone()), "{format:?}");
        }
        assert!(PictureFile::read(FileKind::Tiff, b"II\x2a\0 cut".to_vec()).is_err());
    }
}
