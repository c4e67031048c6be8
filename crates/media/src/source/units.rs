//! A stream of video to units: parser, sink, and what is sent with each unit.

use std::sync::{Arc, Mutex, PoisonError};

use barrelman_media_protocol::failure::SourceFailure;
use barrelman_media_protocol::source::{FromSource, SourceUnit, UnitTime};
use barrelman_vocab::image::PictureSize;
use barrelman_vocab::unit::{Rotation, UnitCodec};
use gst::prelude::*;
use gstreamer as gst;
use gstreamer_app::{AppSink, AppSinkCallbacks};
use gstreamer_video::{VideoFrameRef, VideoInfo};

use super::failure::unlinked;
use super::outbox::{Outbox, Payload};
use super::play::{Play, Times, Way};
use super::rtp_times::{Arrived, to_extended};
use crate::{monotonic, picture};

/// Longest time for which a parser holds a picture back, nanoseconds: that of two or three pictures.
const MAX_HELD_NS: u64 = 500_000_000;

/// The elements behind a pad with these caps, each with its properties, and the caps of the units.
fn line(name: &str, is_live: bool) -> (&'static [&'static str], &'static str) {
    const RAW: &[&str] = &["deinterlace", "videoconvert", "videoscale", "capsfilter"];
    const RAW_TO_JPEG: &[&str] = &["deinterlace", "videoconvert", "videoscale", "capsfilter", "jpegenc"];
    match name {
        "video/x-h264" => (&["h264parse"], "video/x-h264,stream-format=byte-stream,alignment=au"),
        "video/x-h265" => (&["h265parse"], "video/x-h265,stream-format=byte-stream,alignment=au"),
        "video/x-vp9" => (&["vp9parse"], "video/x-vp9,alignment=super-frame"),
        "video/x-av1" => (&["av1parse"], "video/x-av1,stream-format=obu-stream,alignment=tu"),
        "image/jpeg" => (&[], "image/jpeg"),
        _ if is_live => (RAW_TO_JPEG, "image/jpeg"),
        _ => (RAW, "video/x-raw,format=I420"),
    }
}

/// The name for people.
fn title(name: &str) -> &'static str {
    match name {
        "video/x-h264" => "H.264",
        "video/x-h265" => "H.265",
        "video/x-vp9" => "VP9",
        "video/x-av1" => "AV1",
        "image/jpeg" => "JPEG",
        _ => "video that is decoded here,",
    }
}

/// Leads the video of a pad to the outbox.
pub(super) fn attach(play: &Arc<Play>, pad: &gst::Pad, name: &str, way: &Way) -> Result<(), SourceFailure> {
    let (elements, caps) = line(name, play.is_live);
    let sink = AppSink::builder().caps(&caps.parse::<gst::Caps>().map_err(unlinked)?).sync(false).build();
    sink.set_property("qos", false);
    let mut all = Vec::new();
    for element in elements {
        all.push(play.add(element)?);
    }
    all.push(sink.clone().upcast());
    play.pipeline.add(&sink).map_err(unlinked)?;
    let raw_caps = if caps == "image/jpeg" { picture::jpeg_caps } else { picture::delivered_caps };
    for element in &all {
        set_up(element, pad, raw_caps);
    }
    gst::Element::link_many(&all).map_err(unlinked)?;
    if play.is_live && name.starts_with("video/x-raw") {
        let note = "the pictures of this source are not compressed: they are kept as JPEG";
        play.outbox.message(FromSource::Note(note.to_owned()));
    }
    let units = Arc::new(Units::new(play, way, name));
    watch_tags(pad, &units);
    let receiving = units.clone();
    sink.set_callbacks(
        AppSinkCallbacks::builder()
            .new_sample(move |sink| {
                let sample = sink.pull_sample().map_err(|_| gst::FlowError::Eos)?;
                receiving.on_sample(&sample);
                Ok(gst::FlowSuccess::Ok)
            })
            .build(),
    );
    // From the end to the beginning, so that nothing comes to an element that is not ready.
    for element in all.iter().rev() {
        element.sync_state_with_parent().map_err(unlinked)?;
    }
    let first = all[0].static_pad("sink").ok_or_else(|| unlinked("an element has no sink"))?;
    pad.link(&first).map_err(unlinked)?;
    Ok(())
}

/// Sets the properties of an element of the line behind `pad`. `raw_caps`: those of an uncompressed picture
/// in the line, for the caps of the pad.
fn set_up(element: &gst::Element, pad: &gst::Pad, raw_caps: fn(Option<&gst::CapsRef>) -> gst::Caps) {
    let factory = element.factory().map(|factory| factory.name().to_string()).unwrap_or_default();
    match factory.as_str() {
        // The parameter sets stand before each key.
        "h264parse" | "h265parse" => element.set_property("config-interval", -1),
        "deinterlace" => {
            element.set_property_from_str("mode", "auto");
            element.set_property_from_str("method", "linear");
            element.set_property_from_str("fields", "top");
        }
        "videoconvert" => element.set_property_from_str("dither", "none"),
        "jpegenc" => element.set_property("quality", 90),
        "capsfilter" => {
            element.set_property("caps", raw_caps(None));
            let filter = element.clone();
            pad.add_probe(gst::PadProbeType::EVENT_DOWNSTREAM, move |_, info| {
                if let Some(gst::PadProbeData::Event(event)) = &info.data
                    && let gst::EventView::Caps(caps) = event.view()
                {
                    filter.set_property("caps", raw_caps(Some(caps.caps())));
                }
                gst::PadProbeReturn::Ok
            });
        }
        _ => {}
    }
}

/// Follows the tag that says how a picture is displayed upright.
fn watch_tags(pad: &gst::Pad, units: &Arc<Units>) {
    if let Some(tags) = pad.sticky_event::<gst::event::Tag>(0) {
        units.on_tags(tags.tag());
    }
    let units = units.clone();
    pad.add_probe(gst::PadProbeType::EVENT_DOWNSTREAM, move |_, info| {
        if let Some(gst::PadProbeData::Event(event)) = &info.data
            && let gst::EventView::Tag(tags) = event.view()
        {
            units.on_tags(tags.tag());
        }
        gst::PadProbeReturn::Ok
    });
}

/// Receives the samples of a stream.
struct Units {
    outbox: Arc<Outbox>,
    pipeline: gst::Pipeline,
    way: Way,
    title: &'static str,
    state: Mutex<State>,
}

#[derive(Default)]
struct State {
    is_open: bool,
    rotation: Rotation,
    /// A picture was incomplete and was left out.
    follows_loss: bool,
}

impl Units {
    fn new(play: &Play, way: &Way, name: &str) -> Self {
        let (outbox, pipeline) = (play.outbox.clone(), play.pipeline.clone());
        let mut way = way.clone();
        // The parts of a multipart stream have no times, but that the first of each connection is at 0.
        if play.is_live && play.is_endless() {
            way.times = Times::Absent;
        }
        Self { outbox, pipeline, way, title: title(name), state: Mutex::default() }
    }

    fn on_tags(&self, tags: &gst::TagListRef) {
        if let Some(orientation) = tags.get::<gst::tags::ImageOrientation>() {
            self.state.lock().unwrap_or_else(PoisonError::into_inner).rotation = rotation(orientation.get());
        }
    }

    fn on_sample(&self, sample: &gst::Sample) {
        let now_ns = monotonic::now_ns();
        let (Some(buffer), Some(caps)) = (sample.buffer_owned(), sample.caps()) else { return };
        let Some((codec, payload)) = payload(&buffer, caps) else { return };
        let mut state = self.state.lock().unwrap_or_else(PoisonError::into_inner);
        let pts_ns = buffer.pts().map(gst::ClockTime::nseconds);
        let (mut arrival_ns, mut follows_loss) = (now_ns, false);
        let time = match (&self.way.times, pts_ns) {
            (Times::Rtp(times), Some(pts_ns)) => {
                let extended = to_extended(pts_ns);
                match times.lock().unwrap_or_else(PoisonError::into_inner).on_picture(extended) {
                    Arrived::Incomplete => {
                        state.follows_loss = true;
                        return;
                    }
                    Arrived::Whole { arrival_ns: first_ns, follows_loss: lost } => {
                        arrival_ns = first_ns.unwrap_or(now_ns);
                        follows_loss = lost;
                    }
                }
                UnitTime::Ticks(extended as u32)
            }
            (Times::Sender, Some(pts_ns)) => {
                // A demultiplexer has missed a packet.
                follows_loss = state.is_open && buffer.flags().contains(gst::BufferFlags::DISCONT);
                UnitTime::Ticks(to_extended(pts_ns) as u32)
            }
            (Times::Captured, Some(pts_ns)) => UnitTime::Captured(self.captured(sample, pts_ns)),
            (Times::SinceStart, Some(pts_ns)) => UnitTime::SinceStart(since_start(sample, pts_ns)),
            (Times::Arrival, Some(pts_ns)) => {
                // The parser passes a picture on when a later one begins, and may have guessed its time.
                let earliest_ns = now_ns.saturating_sub(MAX_HELD_NS);
                arrival_ns = self.captured(sample, pts_ns).clamp(earliest_ns, now_ns);
                UnitTime::Unknown
            }
            (Times::Absent, _) | (_, None) => UnitTime::Unknown,
        };
        if !std::mem::replace(&mut state.is_open, true) {
            let opened = format!("{} {}", self.title, self.way.name);
            self.outbox.message(FromSource::Opened(opened));
        }
        let follows_loss = follows_loss | std::mem::take(&mut state.follows_loss);
        let rotation = state.rotation;
        drop(state);
        let key = is_key(codec, &buffer, payload.as_slice());
        let unit = SourceUnit { codec, key, follows_loss, rotation, time, arrival_ns };
        self.outbox.unit(FromSource::Unit(unit), payload);
    }

    /// The time of capture on the system's clock.
    fn captured(&self, sample: &gst::Sample, pts_ns: u64) -> u64 {
        let segment = sample.segment().and_then(|segment| segment.downcast_ref::<gst::ClockTime>());
        let pts = gst::ClockTime::from_nseconds(pts_ns);
        let running = segment.and_then(|segment| segment.to_running_time(pts)).unwrap_or(pts);
        let base = self.pipeline.base_time().unwrap_or_default();
        running.nseconds() + base.nseconds()
    }
}

/// Time since the start of the file.
fn since_start(sample: &gst::Sample, pts_ns: u64) -> u64 {
    let segment = sample.segment().and_then(|segment| segment.downcast_ref::<gst::ClockTime>());
    let start_ns = segment.and_then(|segment| segment.start()).map_or(0, gst::ClockTime::nseconds);
    pts_ns.saturating_sub(start_ns)
}

/// Format and bytes of a unit; `None`: the buffer cannot be read.
fn payload(buffer: &gst::Buffer, caps: &gst::CapsRef) -> Option<(UnitCodec, Payload)> {
    let codec = match caps.structure(0)?.name().as_str() {
        "video/x-h264" => UnitCodec::H264AnnexB,
        "video/x-h265" => UnitCodec::H265AnnexB,
        "video/x-vp9" => UnitCodec::Vp9,
        "video/x-av1" => UnitCodec::Av1,
        "image/jpeg" => UnitCodec::Jpeg,
        _ => {
            let info = VideoInfo::from_caps(caps).ok()?;
            let size = PictureSize::new(info.width(), info.height());
            let frame = VideoFrameRef::from_buffer_ref_readable(buffer, &info).ok()?;
            let mut samples = Vec::new();
            picture::append_rows(&picture::planes(&frame, size)?, &mut samples);
            let colour = picture::colour_encoding(caps, size);
            return Some((UnitCodec::RawYuv420 { size, colour }, Payload::Bytes(samples)));
        }
    };
    Some((codec, Payload::Buffer(buffer.clone().into_mapped_buffer_readable().ok()?)))
}

/// Whether decoding can start with a unit. Parsers take any picture for a key that needs no other one; later
/// pictures may refer to what was before it. Those that begin a stream bring its parameter sets.
fn is_key(codec: UnitCodec, buffer: &gst::BufferRef, payload: &[u8]) -> bool {
    let is_marked = !buffer.flags().contains(gst::BufferFlags::DELTA_UNIT);
    match codec {
        UnitCodec::H264AnnexB => is_marked && has_nal(payload, |head| head & 0x1f == 7),
        UnitCodec::H265AnnexB => is_marked && has_nal(payload, |head| head >> 1 & 0x3f == 33),
        UnitCodec::Vp9 | UnitCodec::Av1 => is_marked,
        UnitCodec::Jpeg | UnitCodec::Png | UnitCodec::RawYuv420 { .. } => true,
    }
}

/// Whether one of the first NAL units has such a head. Parameter sets stand before the slices, which are
/// long.
fn has_nal(payload: &[u8], is_it: impl Fn(u8) -> bool) -> bool {
    const HEADS: usize = 16 << 10;
    let heads = &payload[..payload.len().min(HEADS)];
    heads.windows(4).any(|window| window[..3] == [0, 0, 1] && is_it(window[3]))
}

/// The rotation of GStreamer's tag `image-orientation`. Mirrored pictures stay as they are.
fn rotation(orientation: &str) -> Rotation {
    match orientation {
        "rotate-90" => Rotation::Clockwise90,
        "rotate-180" => Rotation::Half,
        "rotate-270" => Rotation::Clockwise270,
        _ => Rotation::None,
    }
}
