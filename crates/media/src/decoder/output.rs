//! The end of the line: decoded pictures to messages.

use std::str::FromStr as _;
use std::sync::Arc;

use barrelman_media_protocol::channel::{Channel, ChannelError};
use barrelman_media_protocol::decoder::{DecodedPicture, FromDecoder, MAX_SIDE};
use barrelman_vocab::image::PictureSize;
use barrelman_vocab::video::{ColourEncoding, ColourMatrix, SampleRange};
use gstreamer as gst;
use gstreamer_video::{
    VideoColorMatrix, VideoColorRange, VideoColorimetry, VideoFrameExt as _, VideoFrameFlags, VideoFrameRef,
    VideoInfo, VideoInterlaceMode,
};

use super::damage::LibavErrors;
use super::deinterlacing::keep_top_field;

/// Sends pictures as they come out of the last element.
pub(super) struct Output {
    channel: Channel,
    errors: Arc<LibavErrors>,
    /// Why the channel cannot be used any more.
    broken: Option<ChannelError>,
    /// Size and colours as the decoder puts them out.
    decoded: Option<Decoded>,
    /// The layout behind the last element.
    info: Option<VideoInfo>,
    /// Time of the unit in the line.
    unit_pts_ns: u64,
    /// The rows of a picture, joined.
    joined: Vec<u8>,
}

/// What the decoder says of its pictures.
#[derive(Debug, Clone, Copy)]
struct Decoded {
    size: PictureSize,
    colour: ColourEncoding,
}

impl Output {
    pub(super) fn new(channel: Channel, errors: Arc<LibavErrors>) -> Self {
        let (decoded, info) = (None, None);
        Self { channel, errors, broken: None, decoded, info, unit_pts_ns: 0, joined: Vec::new() }
    }

    /// A unit goes into the line.
    pub(super) fn begin(&mut self, pts_ns: u64) {
        self.unit_pts_ns = pts_ns;
    }

    /// The last message of a unit.
    pub(super) fn finish(&mut self, damage: Option<String>) -> Result<(), ChannelError> {
        match self.broken.take() {
            Some(error) => Err(error),
            None => self.channel.send(&FromDecoder::Done { damage }, &[]),
        }
    }

    /// Takes over what the decoder says, and returns the caps of what is delivered.
    pub(super) fn set_decoded(&mut self, caps: &gst::CapsRef) -> gst::Caps {
        let delivered = gst::Caps::builder("video/x-raw").field("format", "I420");
        let Ok(info) = VideoInfo::from_caps(caps) else { return delivered.build() };
        let size = PictureSize::new(info.width(), info.height());
        let colour = colour_encoding(caps, size);
        self.decoded = Some(Decoded { size, colour });
        let fitting = fit(size);
        if fitting == size {
            return delivered.build();
        }
        delivered.field("width", fitting.width as i32).field("height", fitting.height as i32).build()
    }

    pub(super) fn set_caps(&mut self, caps: &gst::CapsRef) {
        self.info = VideoInfo::from_caps(caps).ok();
    }

    /// Sends a picture, unless its unit is damaged.
    pub(super) fn picture(&mut self, buffer: &gst::BufferRef) -> Result<gst::FlowSuccess, gst::FlowError> {
        let (Some(info), Some(decoded)) = (&self.info, self.decoded) else {
            return Err(gst::FlowError::NotNegotiated);
        };
        // A parser may join a unit without a picture to the next one, which comes last.
        let time = buffer.iter_meta::<gst::ReferenceTimestampMeta>().last().map(|meta| meta.timestamp());
        let Some(time) = time.or(buffer.pts()) else { return Ok(gst::FlowSuccess::Ok) };
        let pts_ns = time.nseconds();
        if pts_ns == self.unit_pts_ns && self.errors.first().is_some() {
            return Ok(gst::FlowSuccess::Ok);
        }
        let frame =
            VideoFrameRef::from_buffer_ref_readable(buffer, info).map_err(|_| gst::FlowError::Error)?;
        let size = PictureSize::new(info.width(), info.height());
        let is_interlaced = match info.interlace_mode() {
            VideoInterlaceMode::Progressive => false,
            VideoInterlaceMode::Mixed => frame.flags().contains(VideoFrameFlags::INTERLACED),
            _ => true,
        };
        let scaled_from = (decoded.size != size).then_some(decoded.size);
        let header =
            FromDecoder::Picture(DecodedPicture { pts_ns, size, colour: decoded.colour, scaled_from });
        let planes = planes(&frame, size).ok_or(gst::FlowError::Error)?;
        let sent = if is_interlaced || planes.iter().any(|plane| plane.stride != plane.width) {
            join(&planes, is_interlaced, &mut self.joined);
            self.channel.send(&header, &self.joined)
        } else {
            self.channel.send_parts(&header, &planes.map(|plane| &plane.data[..plane.width * plane.height]))
        };
        sent.map(|()| gst::FlowSuccess::Ok).map_err(|error| {
            self.broken = Some(error);
            gst::FlowError::Error
        })
    }
}

/// One plane of a frame.
#[derive(Debug, Clone, Copy)]
pub(super) struct FramePlane<'a> {
    pub data: &'a [u8],
    pub width: usize,
    pub height: usize,
    pub stride: usize,
}

impl<'a> FramePlane<'a> {
    pub(super) fn row(&self, row: usize) -> &'a [u8] {
        &self.data[row * self.stride..][..self.width]
    }
}

/// The planes of a frame; `None`: its memory is shorter than its layout.
fn planes<'a>(frame: &'a VideoFrameRef<&gst::BufferRef>, size: PictureSize) -> Option<[FramePlane<'a>; 3]> {
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

fn join(planes: &[FramePlane<'_>], is_interlaced: bool, joined: &mut Vec<u8>) {
    joined.clear();
    for plane in planes {
        if is_interlaced {
            keep_top_field(plane, joined);
        } else {
            (0..plane.height).for_each(|row| joined.extend_from_slice(plane.row(row)));
        }
    }
}

/// The size that a picture of this size is delivered with: the same, or scaled down to [`MAX_SIDE`], with even sides.
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
fn colour_encoding(caps: &gst::CapsRef, size: PictureSize) -> ColourEncoding {
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
