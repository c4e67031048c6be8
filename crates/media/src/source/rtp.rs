//! Streams of RTP packets: the times of their packets pass through the depayloader as time stamps of the
//! buffers.

use std::sync::{Arc, Mutex, PoisonError};

use barrelman_media_protocol::failure::SourceFailure;
use barrelman_media_protocol::source::{FromSource, SourceReport};
use gst::prelude::*;
use gstreamer as gst;

use super::autoplug;
use super::failure::{self, unlinked};
use super::play::{Play, Times, Way};
use super::rtp_repair::{Nal, RepeatedSets};
use super::rtp_times::{MAX_PICTURE_BYTES, RtpHead, RtpTimes, to_ns};
use super::units;
use crate::monotonic;

/// The caps of the metadata that carries a packet's arrival through the jitter buffer.
const ARRIVAL: &str = "timestamp/x-barrelman-arrival";

/// One stream of packets.
pub(super) type Stream = Arc<Mutex<RtpTimes>>;

/// Takes a pad of RTP packets behind a jitter buffer, if it is video. `way`: "RTP over UDP".
pub(super) fn take(
    play: &Arc<Play>,
    pad: &gst::Pad,
    way: &str,
    stream: &Stream,
) -> Result<(), SourceFailure> {
    let caps = pad.current_caps().unwrap_or_else(|| pad.query_caps(None));
    let field = |name| caps.structure(0).and_then(|structure| structure.get::<String>(name).ok());
    if field("media").is_some_and(|media| media != "video") {
        return Ok(());
    }
    let encoding = field("encoding-name").unwrap_or_default();
    take_encoding(play, pad, &encoding, way, stream)
}

/// The same, for packets of this encoding.
pub(super) fn take_encoding(
    play: &Arc<Play>,
    pad: &gst::Pad,
    encoding: &str,
    way: &str,
    stream: &Stream,
) -> Result<(), SourceFailure> {
    let rtp = Way { name: format!("by {way}"), times: Times::Rtp(stream.clone()) };
    let (depay, caps) = match encoding {
        "H264" => ("rtph264depay", "video/x-h264,stream-format=byte-stream,alignment=au"),
        "H265" => ("rtph265depay", "video/x-h265,stream-format=byte-stream,alignment=au"),
        "VP9" => ("rtpvp9depay", "video/x-vp9"),
        "JPEG" => ("rtpjpegdepay", "image/jpeg"),
        "MP2T" => return take_transport_stream(play, pad, way),
        _ => {
            watch_packets(play, pad, stream, None);
            return autoplug::decode(play, pad, &rtp);
        }
    };
    if play.takes_video() {
        return Ok(());
    }
    watch_packets(play, pad, stream, Nal::of(encoding));
    let depay = play.add(depay)?;
    let filter = play.add("capsfilter")?;
    filter.set_property("caps", caps.parse::<gst::Caps>().map_err(unlinked)?);
    depay.link(&filter).map_err(unlinked)?;
    let out = filter.static_pad("src").ok_or_else(|| unlinked("capsfilter has no source"))?;
    open_segments(&out);
    let name = caps.split(',').next().unwrap_or_default();
    units::attach(play, &out, name, &rtp)?;
    filter.sync_state_with_parent().map_err(unlinked)?;
    depay.sync_state_with_parent().map_err(unlinked)?;
    let sink = depay.static_pad("sink").ok_or_else(|| unlinked("a depayloader has no sink"))?;
    pad.link(&sink).map_err(unlinked)?;
    Ok(())
}

/// The times of a transport stream are in the stream itself.
fn take_transport_stream(play: &Arc<Play>, pad: &gst::Pad, way: &str) -> Result<(), SourceFailure> {
    let depay = play.add("rtpmp2tdepay")?;
    let out = depay.static_pad("src").ok_or_else(|| unlinked("a depayloader has no source"))?;
    let name = format!("by MPEG-TS in {way}");
    autoplug::decode(play, &out, &Way { name, times: Times::Sender })?;
    depay.sync_state_with_parent().map_err(unlinked)?;
    let sink = depay.static_pad("sink").ok_or_else(|| unlinked("a depayloader has no sink"))?;
    pad.link(&sink).map_err(unlinked)?;
    Ok(())
}

/// Notes the arrival of packets in front of the jitter buffer.
pub(super) fn note_arrivals(pad: &gst::Pad) {
    pad.add_probe(gst::PadProbeType::BUFFER | gst::PadProbeType::BUFFER_LIST, |_, info| {
        each_buffer(info, |mut buffer| {
            set_arrival(buffer.make_mut(), monotonic::now_ns());
            Some(buffer)
        })
    });
}

/// Notes the arrival of a packet.
pub(super) fn set_arrival(packet: &mut gst::BufferRef, arrival_ns: u64) {
    let caps = gst::Caps::new_empty_simple(ARRIVAL);
    let time = gst::ClockTime::from_nseconds(arrival_ns);
    gst::ReferenceTimestampMeta::add(packet, &caps, time, None);
}

/// Writes the time of each packet into its buffer.
fn watch_packets(play: &Arc<Play>, pad: &gst::Pad, stream: &Stream, nal: Option<Nal>) {
    let (outbox, stream) = (play.outbox.clone(), stream.clone());
    let sets = Mutex::new(nal.map(RepeatedSets::new));
    pad.add_probe(gst::PadProbeType::BUFFER | gst::PadProbeType::BUFFER_LIST, move |_, info| {
        let mut is_bounded = true;
        let mut sets = sets.lock().unwrap_or_else(PoisonError::into_inner);
        let passed = each_buffer(info, |mut buffer| {
            let head = head_of(&buffer)?;
            if let Some(sets) = sets.as_mut() {
                repair(&mut buffer, head, sets)?;
            }
            let arrival =
                buffer.meta::<gst::ReferenceTimestampMeta>().map(|meta| meta.timestamp().nseconds());
            let arrival_ns = arrival.unwrap_or_else(monotonic::now_ns);
            let mut times = stream.lock().unwrap_or_else(PoisonError::into_inner);
            let extended = times.on_packet(head, buffer.size(), arrival_ns);
            drop(times);
            is_bounded &= extended.is_some();
            let packet = buffer.make_mut();
            packet.set_pts(extended.map(|extended| gst::ClockTime::from_nseconds(to_ns(extended))));
            packet.set_dts(gst::ClockTime::NONE);
            Some(buffer)
        });
        if !is_bounded {
            let what = format!("sends a picture of more than {} MiB", MAX_PICTURE_BYTES >> 20);
            outbox.fail(failure::temporary(what, "Set the camera to a smaller size or a lower quality"));
            return gst::PadProbeReturn::Drop;
        }
        passed
    });
}

/// Replaces what would tear a picture. `None`: the packet is broken.
fn repair(packet: &mut gst::Buffer, head: RtpHead, sets: &mut RepeatedSets) -> Option<()> {
    let bytes = packet.map_readable().ok()?;
    let payload = &bytes[head.payload..head.end];
    if !sets.is_sound(payload) {
        return None;
    }
    let replaced = sets.on_packet(head.ticks, payload);
    drop(bytes);
    if let Some(replaced) = replaced {
        packet.make_mut().map_writable().ok()?[head.payload] = replaced;
    }
    Some(())
}

/// Replaces each buffer that a probe sees, or leaves it out.
fn each_buffer(
    info: &mut gst::PadProbeInfo<'_>,
    mut replace: impl FnMut(gst::Buffer) -> Option<gst::Buffer>,
) -> gst::PadProbeReturn {
    match info.data.take() {
        Some(gst::PadProbeData::Buffer(buffer)) => {
            let Some(replaced) = replace(buffer) else { return gst::PadProbeReturn::Handled };
            info.data = Some(gst::PadProbeData::Buffer(replaced));
        }
        Some(gst::PadProbeData::BufferList(list)) => {
            let replaced: gst::BufferList = list.iter_owned().filter_map(replace).collect();
            info.data = Some(gst::PadProbeData::BufferList(replaced));
        }
        other => info.data = other,
    }
    gst::PadProbeReturn::Ok
}

fn head_of(packet: &gst::BufferRef) -> Option<RtpHead> {
    RtpHead::parse(&packet.map_readable().ok()?)
}

/// Extended time stamps lie outside of the range that a server announces: the segment becomes one without
/// bounds.
fn open_segments(pad: &gst::Pad) {
    pad.add_probe(gst::PadProbeType::EVENT_DOWNSTREAM, |_, info| {
        if let Some(gst::PadProbeData::Event(event)) = &info.data
            && event.type_() == gst::EventType::Segment
        {
            let segment = gst::FormattedSegment::<gst::ClockTime>::new();
            info.data = Some(gst::PadProbeData::Event(gst::event::Segment::new(&segment)));
        }
        gst::PadProbeReturn::Ok
    });
}

/// Passes on the sender reports (RFC 3550, 6.4.1) of the stream among the RTCP packets of a pad.
pub(super) fn watch_reports(play: &Arc<Play>, pad: &gst::Pad, stream: &Stream) {
    let (outbox, stream) = (play.outbox.clone(), stream.clone());
    pad.add_probe(gst::PadProbeType::BUFFER, move |_, info| {
        if let Some(gst::PadProbeData::Buffer(buffer)) = &info.data
            && let Ok(bytes) = buffer.map_readable()
        {
            let ssrc = stream.lock().unwrap_or_else(PoisonError::into_inner).ssrc();
            for report in sender_reports(&bytes, ssrc, monotonic::now_ns()) {
                outbox.message(FromSource::SenderReport(report));
            }
        }
        gst::PadProbeReturn::Ok
    });
}

/// The sender reports of `ssrc` in a compound packet.
fn sender_reports(mut bytes: &[u8], ssrc: Option<u32>, arrival_ns: u64) -> Vec<SourceReport> {
    const SENDER_REPORT: u8 = 200;
    let mut reports = Vec::new();
    while let Some(head) = bytes.first_chunk::<4>() {
        let length = 4 * (1 + usize::from(u16::from_be_bytes([head[2], head[3]])));
        if let Some(packet) = bytes.first_chunk::<20>()
            && length >= 20
            && head[1] == SENDER_REPORT
        {
            let word = |at: usize| u32::from_be_bytes([0, 1, 2, 3].map(|byte| packet[at + byte]));
            if Some(word(4)) == ssrc {
                let ntp = u64::from(word(8)) << 32 | u64::from(word(12));
                reports.push(SourceReport { rtp: word(16), ntp, arrival_ns });
            }
        }
        bytes = bytes.get(length..).unwrap_or_default();
    }
    reports
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn reports_of_the_stream_are_found_among_others() {
        let mut compound = Vec::new();
        compound.extend([0x80, 201, 0, 1, 0, 0, 0, 7]);
        for ssrc in [8, 7] {
            compound.extend([0x80, 200, 0, 6, 0, 0, 0, ssrc]);
            compound.extend([0, 0, 0, 1, 0x80, 0, 0, 0, 0, 0, 0x0b, 0xb8]);
            compound.extend([0; 8]);
        }
        let report = SourceReport { rtp: 3000, ntp: 1 << 32 | 0x8000_0000, arrival_ns: 5 };
        assert_eq!(sender_reports(&compound, Some(7), 5), [report]);
        assert_eq!(sender_reports(&compound, None, 5), []);
        assert_eq!(sender_reports(&compound[..30], Some(7), 5), []);
    }
}
