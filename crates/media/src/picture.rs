//! Decoded pictures: size, colours and rows.

use std::str::FromStr as _;

use barrelman_media_protocol::decoder::MAX_SIDE;
use barrelman_vocab::image::PictureSize;
use barrelman_vocab::video::{ColourEncoding, ColourMatrix, SampleRange};
use gstreamer as gst;
use gstreamer_video::{
    VideoColorMatrix, VideoColorRange, VideoColorimetry, VideoFrameExt as _, VideoFrameRef, VideoInfo,
};

/// The caps of a picture that is delivered: 8 bits, 4:2:0, and scaled down where its caps say that it is too
/// large.
pub(crate) fn delivered_caps(decoded: Option<&gst::CapsRef>) -> gst::Caps {
    let delivered = gst::Caps::builder("video/x-raw").field("format", "I420");
    let size = decoded.and_then(size_of).unwrap_or(PictureSize::new(1, 1));
    let fitting = fit(size);
    if fitting == size {
        return delivered.build();
    }
    delivered.field("width", fitting.width as i32).field("height", fitting.height as i32).build()
}

/// The same for a picture that becomes a JPEG file, whose samples are BT.601 in the full range (JFIF).
pub(crate) fn jpeg_caps(decoded: Option<&gst::CapsRef>) -> gst::Caps {
    // Range 0 to 255, matrix of BT.601; transfer and primaries stay open.
    let mut caps = delivered_caps(decoded);
    caps.make_mut().set("colorimetry", "1:4:0:0");
    caps
}

/// The size that caps declare.
pub(crate) fn size_of(caps: &gst::CapsRef) -> Option<PictureSize> {
    let info = VideoInfo::from_caps(caps).ok()?;
    Some(PictureSize::new(info.width(), info.height()))
}

/// One plane of a frame.
#[derive(Debug, Clone, Copy)]
pub(crate) struct FramePlane<'a> {
    pub data: &'a [u8],
    pub width: usize,
    pub height: usize,
    pub stride: usize,
}

impl<'a> FramePlane<'a> {
    pub(crate) fn row(&self, row: usize) -> &'a [u8] {
        &self.data[row * self.stride..][..self.width]
    }
}

/// The planes of a frame; `None`: its memory is shorter than its layout.
pub(crate) fn planes<'a>(
    frame: &'a VideoFrameRef<&gst::BufferRef>,
    size: PictureSize,
) -> Option<[FramePlane<'a>; 3]> {
    let chroma = PictureSize::new(size.width.div_ceil(2), size.height.div_ceil(2));
    let plane = |index: u32, size: PictureSize| {
        let (width, height) = (size.width as usize, size.height as usize);
        let data = frame.plane_data(index).ok()?;
        let stride = usize::try_from(*frame.plane_stride().get(index as usize)?).ok()?;
        let needed = stride.checked_mul(height.checked_sub(1)?)?.checked_add(width)?;
        (stride >= width && data.len() >= needed).then_some(FramePlane { data, width, height, stride })
    };
    Some([plane(0, size)?, plane(1, chroma)?, plane(2, chroma)?])
}

/// Appends the rows of planes, without padding.
pub(crate) fn append_rows(planes: &[FramePlane<'_>], joined: &mut Vec<u8>) {
    for plane in planes {
        (0..plane.height).for_each(|row| joined.extend_from_slice(plane.row(row)));
    }
}

/// The size that a picture of this size is delivered with: the same, or scaled down to [`MAX_SIDE`], with
/// even sides.
fn fit(size: PictureSize) -> PictureSize {
    let longest = size.width.max(size.height);
    if longest <= MAX_SIDE {
        return size;
    }
    let scaled = |side: u32| {
        let exact = u64::from(side) * u64::from(MAX_SIDE) / u64::from(longest);
        (exact as u32 & !1).max(2)
    };
    PictureSize::new(scaled(size.width), scaled(size.height))
}

/// The colours that caps declare; what they leave open is assumed.
pub(crate) fn colour_encoding(caps: &gst::CapsRef, size: PictureSize) -> ColourEncoding {
    let assumed = ColourEncoding::assumed_for(size);
    let declared = caps.structure(0).and_then(|structure| structure.get::<&str>("colorimetry").ok());
    let Some(declared) = declared.and_then(|text| VideoColorimetry::from_str(text).ok()) else {
        return assumed;
    };
    let matrix = match declared.matrix() {
        VideoColorMatrix::Bt709 => ColourMatrix::Bt709,
        // The samples of an RGB picture are converted with the matrix that is assumed for the size.
        VideoColorMatrix::Unknown | VideoColorMatrix::Rgb => assumed.matrix,
        _ => ColourMatrix::Bt601,
    };
    let range = match declared.range() {
        VideoColorRange::Range0_255 if declared.matrix() != VideoColorMatrix::Rgb => SampleRange::Full,
        _ => SampleRange::Limited,
    };
    ColourEncoding { matrix, range }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_picture_that_is_too_large_keeps_its_shape() {
        let sizes = [
            ((1920, 1080), (1920, 1080)),
            ((4096, 4096), (4096, 4096)),
            ((5312, 2988), (4096, 2304)),
            ((2000, 8000), (1024, 4096)),
            ((9000, 2), (4096, 2)),
        ];
        for ((width, height), (fitting_width, fitting_height)) in sizes {
            let fitting = fit(PictureSize::new(width, height));
            assert_eq!(fitting, PictureSize::new(fitting_width, fitting_height), "{width} x {height}");
        }
    }

    #[test]
    fn colours_are_those_of_the_stream_or_assumed() {
        gst::init().unwrap();
        let encoding = |matrix, range| ColourEncoding { matrix, range };
        let cases = [
            ("video/x-raw", encoding(ColourMatrix::Bt709, SampleRange::Limited)),
            ("video/x-raw, colorimetry=bt709", encoding(ColourMatrix::Bt709, SampleRange::Limited)),
            ("video/x-raw, colorimetry=bt601", encoding(ColourMatrix::Bt601, SampleRange::Limited)),
            ("video/x-raw, colorimetry=(string)1:4:0:0", encoding(ColourMatrix::Bt601, SampleRange::Full)),
            ("video/x-raw, colorimetry=(string)1:0:0:0", encoding(ColourMatrix::Bt709, SampleRange::Full)),
            ("video/x-raw, colorimetry=(string)1:3:5:1", encoding(ColourMatrix::Bt709, SampleRange::Full)),
            ("video/x-raw, colorimetry=sRGB", encoding(ColourMatrix::Bt709, SampleRange::Limited)),
            ("video/x-raw, colorimetry=bt2020", encoding(ColourMatrix::Bt601, SampleRange::Limited)),
        ];
        for (text, expected) in cases {
            let caps = gst::Caps::from_str(text).unwrap();
            assert_eq!(colour_encoding(&caps, PictureSize::new(1280, 720)), expected, "{text}");
        }
    }
}
