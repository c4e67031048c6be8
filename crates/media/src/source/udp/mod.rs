//! Packets that are sent to a UDP port: RTP, or an MPEG transport stream, found by their content.
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
    let mut gate = Gate::default();
    let mut detector = Detector::new(format);
    let mut first = Vec::new();
    let mut input = None;
    let mut buffer = vec![0; MAX_PACKET];
    loop {
        let (length, from) = match socket.recv_from(&mut buffer) {
            Ok(received) => received,
            Err(error) if error.kind() == std::io::ErrorKind::Interrupted => continue,
            Err(error) => return Err(temporary(format!("cannot be received: {error}"), "")),
        };
        let packet = Packet { bytes: buffer[..length].to_vec(), arrival_ns: monotonic::now_ns() };
        let ssrc = RtpHead::parse(&packet.bytes).map(|head| head.ssrc);
        match gate.judge(from, ssrc, Instant::now()) {
            Verdict::Accepted => {}
            Verdict::Ignored { is_first: false } => continue,
            Verdict::Ignored { is_first: true } => {
                let note = format!("packets of a second sender ({from}) are left out");
                play.outbox.message(FromSource::Note(note));
                continue;
            }
            Verdict::Replaced => return Err(temporary("has another sender now", "")),
        }
        match &input {
            Some(input) => push(input, packet),
            None => {
                let content = detector.judge(&packet.bytes);
                first.push(packet);
                match content {
                    Content::Unknown if first.len() < content::MAX_PACKETS => {}
                    Content::Unknown => first.clear(),
                    content => {
                        let started = start(play, content)?;
                        first.drain(..).for_each(|packet| push(&started, packet));
                        input = Some(started);
                    }
                }
            }
        }
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
        Content::Unknown => {}
        Content::Other(what) => {
            return Err(permanent(what, "Send H.264, H.265, JPEG or MPEG-TS to this port"));
        }
    }
    play.start();
    Ok(input)
}

fn push(input: &AppSrc, packet: Packet) {
    let mut buffer = gst::Buffer::from_mut_slice(packet.bytes);
    rtp::set_arrival(buffer.make_mut(), packet.arrival_ns);
    // It is refused while the pipeline ends, and the bus says why.
    let _ = input.push_buffer(buffer);
}
