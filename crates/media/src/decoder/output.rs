//! The end of the line: decoded pictures to messages.

use std::sync::Arc;

use barrelman_media_protocol::channel::{Channel, ChannelError};
use barrelman_media_protocol::decoder::{DecodedPicture, FromDecoder};
use barrelman_vocab::image::PictureSize;
use barrelman_vocab::video::ColourEncoding;
use gstreamer as gst;
use gstreamer_video::{VideoFrameExt as _, VideoFrameFlags, VideoFrameRef, VideoInfo, VideoInterlaceMode};

use super::damage::LibavErrors;
use super::deinterlacing::keep_top_field;
use crate::picture::{FramePlane, append_rows, colour_encoding, delivered_caps, planes, size_of};

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
        self.decoded = size_of(caps).map(|size| Decoded { size, colour: colour_encoding(caps, size) });
        delivered_caps(Some(caps))
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

fn join(planes: &[FramePlane<'_>], is_interlaced: bool, joined: &mut Vec<u8>) {
    joined.clear();
    if is_interlaced {
        planes.iter().for_each(|plane| keep_top_field(plane, joined));
    } else {
        append_rows(planes, joined);
    }
}
