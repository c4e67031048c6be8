//! Packets that are sent to a UDP port: RTP, an MPEG transport stream, or H.264 and H.265 without either,
//! found by their content.
//!
//! Not handled: RTCP, which has a port of its own; forward error correction.

mod content;

mod gate;

use std::net::{IpAddr, Ipv4Addr, SocketAddr, UdpSocket};
use std::sync::Arc;
use std::time::Instant;

use barrelman_media_protocol::failure::SourceFailure;
use barrelman_media_protocol::format::CodedFormat;
use barrelman_media_protocol::source::FromSource;
use gst::prelude::*;
use gstreamer as gst;
use gstreamer_app::{AppSrc, AppStreamType};
use rustix::net::{AddressFamily, SocketType, sockopt};

use super::autoplug;
use super::failure::{permanent, temporary, unlinked};
use super::play::{Play, Times, Way};
use super::rtp::{self, Stream};
use super::rtp_times::RtpHead;
use super::units;
use crate::monotonic;
use content::{Content, Detector};
use gate::{Gate, Verdict};

/// Size of the socket's buffer: a key frame of 4K video arrives at once. The system may allow less.
const RECEIVE_BUFFER: usize = 8 << 20;

/// Longest packet.
const MAX_PACKET: usize = 65_536;

/// Longest wait for a packet that is missing, milliseconds.
const LATENCY_MS: u32 = 60;

/// Bytes that wait in front of the first element. More: the oldest are dropped.
const QUEUED_BYTES: u64 = 8 << 20;

/// One packet.
struct Packet {
    bytes: Vec<u8>,
    arrival_ns: u64,
}

pub(super) fn open(
    play: &Arc<Play>,
    bind: SocketAddr,
    format: Option<CodedFormat>,
) -> Result<(), SourceFailure> {
    let socket = bound(bind).map_err(|error| not_bound(bind, &error))?;
    let play = play.clone();
    std::thread::spawn(move || {
        if let Err(failure) = receive(&play, &socket, format) {
            play.outbox.fail(failure);
        }
    });
    Ok(())
}

fn bound(bind: SocketAddr) -> std::io::Result<UdpSocket> {
    let family = if bind.is_ipv4() { AddressFamily::INET } else { AddressFamily::INET6 };
    let socket = rustix::net::socket(family, SocketType::DGRAM, None)?;
    let is_group = bind.ip().is_multicast();
    if is_group {
        // Several programs may listen to a group.
        sockopt::set_socket_reuseaddr(&socket, true)?;
    }
    let _ = sockopt::set_socket_recv_buffer_size(&socket, RECEIVE_BUFFER);
    rustix::net::bind(&socket, &bind)?;
    let socket = UdpSocket::from(socket);
    match bind.ip() {
        IpAddr::V4(group) if is_group => socket.join_multicast_v4(&group, &Ipv4Addr::UNSPECIFIED)?,
        IpAddr::V6(group) if is_group => socket.join_multicast_v6(&group, 0)?,
        _ => {}
    }
    Ok(socket)
}

fn not_bound(bind: SocketAddr, error: &std::io::Error) -> SourceFailure {
    match error.kind() {
        std::io::ErrorKind::AddrInUse => temporary(
            format!("cannot be opened: another program uses port {}", bind.port()),
            "End that program",
        ),
        std::io::ErrorKind::AddrNotAvailable => permanent(
            format!("cannot be opened: this machine has no address {}", bind.ip()),
            "Use 0.0.0.0 to listen on all networks",
        ),
        _ => temporary(format!("cannot be opened: {error}"), ""),
    }
}

/// Receives until the process ends.
fn receive(play: &Arc<Play>, socket: &UdpSocket, format: Option<CodedFormat>) -> Result<(), SourceFailure> {
    let mut reception = Reception {
        play,
        gate: Gate::default(),
        detector: Detector::new(format),
        first: Vec::new(),
        has_told_doubt: false,
        line: None,
    };
    let mut buffer = vec![0; MAX_PACKET];
    loop {
        let (length, from) = match socket.recv_from(&mut buffer) {
            Ok(received) => received,
            Err(error) if error.kind() == std::io::ErrorKind::Interrupted => continue,
            Err(error) => return Err(temporary(format!("cannot be received: {error}"), "")),
        };
        let packet = Packet { bytes: buffer[..length].to_vec(), arrival_ns: monotonic::now_ns() };
        reception.on_packet(packet, from)?;
    }
}

/// The packets of a port.
struct Reception<'a> {
    play: &'a Arc<Play>,
    gate: Gate,
    detector: Detector,
    /// Packets whose content is not known yet.
    first: Vec<Packet>,
    has_told_doubt: bool,
    line: Option<Line>,
}

/// Where packets of known content go.
struct Line {
    input: AppSrc,
    is_rtp: bool,
}

impl Reception<'_> {
    fn on_packet(&mut self, packet: Packet, from: SocketAddr) -> Result<(), SourceFailure> {
        // The bytes of other content may look like a head of RTP.
        let ssrc = self.line.as_ref().filter(|line| line.is_rtp).and_then(|_| packet.ssrc());
        match self.gate.judge(from, ssrc, Instant::now()) {
            Verdict::Accepted => {}
            Verdict::Ignored { is_first: false } => return Ok(()),
            Verdict::Ignored { is_first: true } => {
                self.note(format!("packets of a second sender ({from}) are left out"));
                return Ok(());
            }
            Verdict::Replaced => return Err(temporary("has another sender now", "")),
        }
        match &self.line {
            Some(line) => push(&line.input, packet),
            None => self.on_first_packet(packet, from)?,
        }
        Ok(())
    }

    /// Judges a packet, and begins with the stream as soon as its content is known.
    fn on_first_packet(&mut self, packet: Packet, from: SocketAddr) -> Result<(), SourceFailure> {
        let content = self.detector.judge(&packet.bytes);
        let ssrc = packet.ssrc();
        let is_rtp = matches!(content, Content::Rtp { .. });
        match content {
            Content::Unknown => {
                self.first.push(packet);
                if self.first.len() >= content::MAX_PACKETS {
                    self.first.clear();
                    if !std::mem::replace(&mut self.has_told_doubt, true) {
                        self.note(self.detector.doubt().to_owned());
                    }
                }
                return Ok(());
            }
            Content::Rtp { .. } => {
                // Another stream of the same sender, such as sound, would tear the pictures.
                self.gate.judge(from, ssrc, Instant::now());
                self.first.retain(|packet| packet.ssrc() == ssrc);
            }
            // It begins with its first parameter set.
            Content::Elementary(_) => self.first.clear(),
            Content::TransportStream | Content::Other(_) => {}
        }
        let input = start(self.play, content)?;
        self.first.drain(..).for_each(|packet| push(&input, packet));
        push(&input, packet);
        self.line = Some(Line { input, is_rtp });
        Ok(())
    }

    fn note(&self, text: String) {
        self.play.outbox.message(FromSource::Note(text));
    }
}

impl Packet {
    /// The synchronisation source, if this is RTP.
    fn ssrc(&self) -> Option<u32> {
        RtpHead::parse(&self.bytes).map(|head| head.ssrc)
    }
}

/// Builds the line for this content.
fn start(play: &Arc<Play>, content: Content) -> Result<AppSrc, SourceFailure> {
    let input = AppSrc::builder().is_live(true).max_bytes(QUEUED_BYTES).block(false).build();
    input.set_property_from_str("leaky-type", "downstream");
    play.pipeline.add(&input).map_err(unlinked)?;
    let pad = input.static_pad("src").ok_or_else(|| unlinked("appsrc has no source"))?;
    match content {
        Content::TransportStream => {
            input.set_stream_type(AppStreamType::Stream);
            input.set_format(gst::Format::Bytes);
            let caps =
                gst::Caps::builder("video/mpegts").field("systemstream", true).field("packetsize", 188);
            input.set_caps(Some(&caps.build()));
            let way = Way { name: "by MPEG-TS over UDP".to_owned(), times: Times::Sender };
            autoplug::decode(play, &pad, &way)?;
        }
        Content::Rtp { encoding, payload_type } => {
            input.set_format(gst::Format::Time);
            // The jitter buffer measures the time between packets with it.
            input.set_do_timestamp(true);
            let caps = gst::Caps::builder("application/x-rtp")
                .field("media", "video")
                .field("clock-rate", 90_000)
                .field("encoding-name", encoding)
                .field("payload", i32::from(payload_type));
            input.set_caps(Some(&caps.build()));
            let jitter = play.add("rtpjitterbuffer")?;
            jitter.set_property("latency", LATENCY_MS);
            let sink = jitter.static_pad("sink").ok_or_else(|| unlinked("a jitter buffer has no sink"))?;
            pad.link(&sink).map_err(unlinked)?;
            let out = jitter.static_pad("src").ok_or_else(|| unlinked("a jitter buffer has no source"))?;
            rtp::take_encoding(play, &out, encoding, "RTP over UDP", &Stream::default())?;
        }
        Content::Elementary(format) => start_elementary(play, &input, &pad, format)?,
        Content::Unknown => {}
        Content::Other(what) => {
            return Err(permanent(what, "Send H.264, H.265, JPEG or MPEG-TS to this port"));
        }
    }
    play.start();
    Ok(input)
}

/// The line for Annex B without RTP. Its pictures have no times: their arrival counts.
fn start_elementary(
    play: &Arc<Play>,
    input: &AppSrc,
    pad: &gst::Pad,
    format: CodedFormat,
) -> Result<(), SourceFailure> {
    let name = if format == CodedFormat::H265 { "video/x-h265" } else { "video/x-h264" };
    input.set_format(gst::Format::Time);
    input.set_do_timestamp(true);
    input.set_caps(Some(&gst::Caps::builder(name).field("stream-format", "byte-stream").build()));
    let way = Way { name: "without RTP over UDP".to_owned(), times: Times::Arrival };
    play.takes_video();
    units::attach(play, pad, name, &way)
}

fn push(input: &AppSrc, packet: Packet) {
    let mut buffer = gst::Buffer::from_mut_slice(packet.bytes);
    rtp::set_arrival(buffer.make_mut(), packet.arrival_ns);
    // It is refused while the pipeline ends, and the bus says why.
    let _ = input.push_buffer(buffer);
}
