//! Packets to a UDP port, with and without loss.

use std::net::{SocketAddr, UdpSocket};
use std::time::Duration;

use barrelman_media_protocol::format::CodedFormat;
use barrelman_media_protocol::role::Role;
use barrelman_media_protocol::source::{FromSource, SourceAddress, SourceSettings, SourceUnit, UnitTime};
use barrelman_vocab::unit::UnitCodec;
use gst::prelude::*;
use gstreamer as gst;
use gstreamer_app::AppSink;

use crate::clip::Unit;
use crate::media::Media;

const PICTURES: usize = 40;

/// The encoder and the payloader of RTP packets in a format.
fn line(format: CodedFormat) -> &'static str {
    match format {
        CodedFormat::H264 => {
            "x264enc tune=zerolatency key-int-max=10 ! rtph264pay config-interval=-1 pt=96 mtu=400"
        }
        CodedFormat::H265 => {
            "x265enc tune=zerolatency speed-preset=ultrafast key-int-max=10 ! rtph265pay config-interval=-1 pt=97 mtu=400"
        }
        CodedFormat::Vp9 => {
            "vp9enc deadline=1 cpu-used=8 lag-in-frames=0 keyframe-max-dist=10 ! rtpvp9pay pt=98 mtu=400"
        }
        CodedFormat::Av1 => unreachable!(),
    }
}

/// The RTP packets of a short video, with their time stamps.
fn packets(line: &str) -> Vec<(u32, Vec<u8>)> {
    buffers(line)
        .into_iter()
        .map(|packet| (u32::from_be_bytes(packet[4..8].try_into().unwrap()), packet))
        .collect()
}

pub(crate) fn buffers(line: &str) -> Vec<Vec<u8>> {
    gst::init().unwrap();
    let text = format!(
        "videotestsrc pattern=ball num-buffers={PICTURES} ! video/x-raw,width=320,height=240,framerate=25/1 ! {line} \
         ! appsink name=end sync=false"
    );
    let pipeline = gst::parse::launch(&text).unwrap().downcast::<gst::Pipeline>().unwrap();
    let sink = pipeline.by_name("end").unwrap().downcast::<AppSink>().unwrap();
    pipeline.set_state(gst::State::Playing).unwrap();
    let mut buffers = Vec::new();
    while let Ok(sample) = sink.pull_sample() {
        match sample.buffer() {
            Some(buffer) => buffers.push(buffer.map_readable().unwrap().to_vec()),
            None => {
                let list = sample.buffer_list().unwrap();
                buffers.extend(list.iter().map(|buffer| buffer.map_readable().unwrap().to_vec()));
            }
        }
    }
    pipeline.set_state(gst::State::Null).unwrap();
    buffers
}

/// A port of this machine that nothing uses.
pub(crate) fn free_port() -> SocketAddr {
    UdpSocket::bind("127.0.0.1:0").unwrap().local_addr().unwrap()
}

/// A source that listens to a port, and what sends to it.
struct Listening {
    media: Media,
    sender: UdpSocket,
    notes: Vec<String>,
    opened: Option<String>,
    units: Vec<(SourceUnit, Vec<u8>)>,
}

impl Listening {
    fn new(format: Option<CodedFormat>) -> Self {
        let bind = free_port();
        let address = SourceAddress::Udp { bind, format };
        let mut media = Media::start(Role::Source(SourceSettings { address, is_live: true }));
        let first = media.receive::<FromSource>().unwrap().unwrap().0;
        assert_eq!(first, FromSource::Alive);
        let sender = UdpSocket::bind("127.0.0.1:0").unwrap();
        let mut listening = Self { media, sender, notes: Vec::new(), opened: None, units: Vec::new() };
        listening.await_port(bind);
        listening.sender.connect(bind).unwrap();
        listening
    }

    /// Waits until the port is open. (A packet to a closed one is refused, which the next call tells.)
    fn await_port(&mut self, port: SocketAddr) {
        let probe = UdpSocket::bind("127.0.0.1:0").unwrap();
        probe.connect(port).unwrap();
        for _ in 0..1000 {
            let is_open = UdpSocket::bind(port).is_err();
            if is_open {
                return;
            }
            std::thread::sleep(Duration::from_millis(5));
        }
        panic!("the port is not opened");
    }

    /// Sends packets a little apart, so that none is lost in a queue, and takes what comes meanwhile.
    fn send<'a>(&mut self, packets: impl IntoIterator<Item = &'a [u8]>) {
        for packet in packets {
            self.sender.send(packet).unwrap();
            std::thread::sleep(Duration::from_micros(300));
        }
    }

    /// Takes messages until there are that many units.
    fn await_units(&mut self, count: usize) {
        while self.units.len() < count {
            self.take();
        }
    }

    fn take(&mut self) {
        let (message, payload) = self.media.receive::<FromSource>().unwrap().expect("the source is silent");
        match message {
            FromSource::Alive => {}
            FromSource::Unit(unit) => self.units.push((unit, payload)),
            FromSource::Opened(text) => self.opened = Some(text),
            FromSource::Note(text) => self.notes.push(text),
            other => panic!("{other:?}"),
        }
    }

    /// The units as input of a decoder.
    fn decodable(&self) -> Vec<Unit> {
        let unit = |(index, (unit, payload)): (usize, &(SourceUnit, Vec<u8>))| Unit {
            payload: payload.clone(),
            pts_ns: index as u64,
            key: unit.key,
        };
        self.units.iter().enumerate().map(unit).collect()
    }
}

fn monotonic_ns() -> u64 {
    let now = rustix::time::clock_gettime(rustix::time::ClockId::Monotonic);
    now.tv_sec as u64 * 1_000_000_000 + now.tv_nsec as u64
}

fn check_rtp(format: CodedFormat, told: Option<CodedFormat>, codec: UnitCodec) {
    let packets = packets(line(format));
    let mut times: Vec<u32> = packets.iter().map(|(ticks, _)| *ticks).collect();
    times.dedup();
    let mut listening = Listening::new(told);
    let began_ns = monotonic_ns();
    listening.send(packets.iter().map(|(_, packet)| &packet[..]));
    listening.await_units(PICTURES);
    assert_eq!(listening.opened, Some(format!("{} by RTP over UDP", format.name())));
    let got: Vec<u32> = listening.units.iter().map(|(unit, _)| ticks(unit)).collect();
    assert_eq!(got, times);
    let keys = listening.units.iter().filter(|(unit, _)| unit.key).count();
    assert!(keys >= 4 && listening.units[0].0.key, "{keys} keys");
    let ended_ns = monotonic_ns();
    for (unit, _) in &listening.units {
        assert_eq!((unit.codec, unit.follows_loss), (codec, false));
        assert!((began_ns..=ended_ns).contains(&unit.arrival_ns));
    }
    assert!(listening.units.is_sorted_by_key(|(unit, _)| unit.arrival_ns));
    let pictures = Media::decoder(format, true).decode_all(&listening.decodable());
    assert_eq!(pictures.len(), PICTURES);
    assert!(listening.media.close().success());
}

#[test]
fn h264_is_recognised_and_keeps_its_times() {
    check_rtp(CodedFormat::H264, None, UnitCodec::H264AnnexB);
}

#[test]
fn h265_is_recognised_and_keeps_its_times() {
    check_rtp(CodedFormat::H265, None, UnitCodec::H265AnnexB);
}

#[test]
fn vp9_keeps_its_times() {
    check_rtp(CodedFormat::Vp9, Some(CodedFormat::Vp9), UnitCodec::Vp9);
}

/// What comes of the video without the packet at this place of picture 14.
fn without_packet(place: usize) -> (Vec<u32>, Listening) {
    let packets = packets(line(CodedFormat::H264));
    let mut times: Vec<u32> = packets.iter().map(|(ticks, _)| *ticks).collect();
    times.dedup();
    let lost = packets.iter().position(|(ticks, _)| *ticks == times[14]).unwrap() + place;
    let mut listening = Listening::new(None);
    let kept = packets.iter().enumerate().filter(|(index, _)| *index != lost);
    listening.send(kept.map(|(_, (_, packet))| &packet[..]));
    (times, listening)
}

fn ticks(unit: &SourceUnit) -> u32 {
    let UnitTime::Ticks(ticks) = unit.time else { panic!("{unit:?}") };
    ticks
}

#[test]
fn a_packet_lost_within_a_picture_costs_it_and_is_told_with_the_next() {
    let (times, mut listening) = without_packet(1);
    listening.await_units(PICTURES - 1);
    for (unit, _) in &listening.units {
        assert_ne!(ticks(unit), times[14]);
        assert_eq!(unit.follows_loss, ticks(unit) == times[15], "{unit:?}");
    }
}

#[test]
fn a_packet_lost_between_pictures_is_told_with_the_next() {
    let (times, mut listening) = without_packet(0);
    listening.await_units(PICTURES);
    for (unit, _) in &listening.units {
        assert_eq!(unit.follows_loss, ticks(unit) == times[14], "{unit:?}");
    }
}

#[test]
fn packets_out_of_order_are_put_in_order() {
    let mut packets = packets(line(CodedFormat::H264));
    for at in (20..packets.len() - 1).step_by(7) {
        packets.swap(at, at + 1);
    }
    let mut listening = Listening::new(None);
    listening.send(packets.iter().map(|(_, packet)| &packet[..]));
    listening.await_units(PICTURES);
    assert!(listening.units.iter().all(|(unit, _)| !unit.follows_loss));
}

#[test]
fn a_second_sender_is_left_out() {
    let packets = packets(line(CodedFormat::H264));
    let mut listening = Listening::new(None);
    let port = listening.sender.peer_addr().unwrap();
    let second = UdpSocket::bind("127.0.0.1:0").unwrap();
    for (_, packet) in &packets {
        listening.send([&packet[..]]);
        second.send_to(&[0x80, 96, 0, 0, 0, 0, 0, 0, 0, 0, 0, 1, 0x65, 0xff], port).unwrap();
    }
    listening.await_units(PICTURES);
    let pictures = Media::decoder(CodedFormat::H264, true).decode_all(&listening.decodable());
    assert_eq!(pictures.len(), PICTURES);
    assert_eq!(listening.notes.len(), 1, "{:?}", listening.notes);
}

#[test]
fn a_transport_stream_keeps_the_distances_of_its_times() {
    let line =
        "x264enc tune=zerolatency key-int-max=10 ! video/x-h264,profile=baseline ! mpegtsmux alignment=7";
    let datagrams = buffers(line);
    for with_rtp in [false, true] {
        let mut listening = Listening::new(None);
        let header = |index: usize| {
            let [high, low] = (index as u16).to_be_bytes();
            [0x80, 33, high, low, 0, 0, 0, 0, 0, 0, 0, 9]
        };
        for (index, datagram) in datagrams.iter().enumerate() {
            let packet = if with_rtp { [&header(index), &datagram[..]].concat() } else { datagram.clone() };
            listening.send([&packet[..]]);
            std::thread::sleep(Duration::from_millis(3));
        }
        // The end of a transport stream cannot be known: the last picture waits for the next one.
        listening.await_units(PICTURES - 2);
        let way = if with_rtp { "H.264 by MPEG-TS in RTP over UDP" } else { "H.264 by MPEG-TS over UDP" };
        assert_eq!(listening.opened.as_deref(), Some(way));
        let ticks: Vec<u32> = listening.units.iter().map(|(unit, _)| ticks(unit)).collect();
        let distances: Vec<u32> = ticks.windows(2).map(|pair| pair[1].wrapping_sub(pair[0])).collect();
        assert!(distances.iter().all(|distance| distance.abs_diff(3600) <= 1), "{distances:?}");
        assert!(listening.units[0].0.key);
    }
}

#[test]
fn a_transport_stream_may_be_cut_into_datagrams_anywhere() {
    let line =
        "x264enc tune=zerolatency key-int-max=10 ! video/x-h264,profile=baseline ! mpegtsmux alignment=7";
    let stream = buffers(line).concat();
    let mut listening = Listening::new(None);
    // What FFmpeg sends.
    listening.send(stream.chunks(1472));
    listening.await_units(PICTURES - 2);
    assert_eq!(listening.opened.as_deref(), Some("H.264 by MPEG-TS over UDP"));
    assert!(listening.units.iter().all(|(unit, _)| !unit.follows_loss));
    let pictures = Media::decoder(CodedFormat::H264, true).decode_all(&listening.decodable());
    assert!(pictures.len() >= PICTURES - 2, "{}", pictures.len());
    assert_eq!(listening.notes, [""; 0]);
}

/// Annex B without RTP, one picture after the other in datagrams of 1400 bytes.
fn check_elementary(format: CodedFormat, encoder: &str) {
    const PAUSE: Duration = Duration::from_millis(20);
    let pictures = buffers(encoder);
    let mut listening = Listening::new(None);
    let mut sent_ns = Vec::new();
    // The first pictures have no parameter sets: their key was sent before somebody listened.
    for picture in &pictures[1..] {
        sent_ns.push(monotonic_ns());
        listening.send(picture.chunks(1400));
        std::thread::sleep(PAUSE);
    }
    sent_ns.push(monotonic_ns());
    // The end of a picture is known from the next one, in H.265 from the one after it.
    let (skipped, count) = (9, PICTURES - 1 - 9 - 2);
    listening.await_units(count);
    assert_eq!(listening.opened, Some(format!("{} without RTP over UDP", format.name())));
    assert!(listening.units[0].0.key);
    let mut late = 0;
    for (index, (unit, _)) in listening.units.iter().take(count).enumerate() {
        assert_eq!(unit.time, UnitTime::Unknown);
        assert!(unit.arrival_ns >= sent_ns[skipped + index], "{index}");
        late += usize::from(unit.arrival_ns >= sent_ns[skipped + index + 1]);
    }
    // A picture arrives when it is sent, not with the next one, except where the machine is busy.
    assert!(late < count / 2, "{late} of {count}");
    let decoded = Media::decoder(format, true).decode_all(&listening.decodable());
    assert!(decoded.len() >= count, "{}", decoded.len());
}

#[test]
fn h264_comes_without_rtp() {
    let line =
        "x264enc tune=zerolatency key-int-max=10 ! video/x-h264,stream-format=byte-stream,alignment=au";
    check_elementary(CodedFormat::H264, line);
}

#[test]
fn h265_comes_without_rtp() {
    let line = "x265enc tune=zerolatency speed-preset=ultrafast key-int-max=10 ! \
                h265parse config-interval=-1 ! video/x-h265,stream-format=byte-stream,alignment=au";
    check_elementary(CodedFormat::H265, line);
}

#[test]
fn packets_of_no_kind_are_told_once() {
    let mut listening = Listening::new(None);
    for _ in 0..2 {
        listening.send(std::iter::repeat_n(&b"telemetry"[..], 300));
    }
    while listening.notes.is_empty() {
        listening.take();
    }
    // What is sent afterwards is found nevertheless.
    let packets = packets(line(CodedFormat::H264));
    listening.send(packets.iter().map(|(_, packet)| &packet[..]));
    listening.await_units(PICTURES);
    assert_eq!(listening.notes.len(), 1, "{:?}", listening.notes);
    assert!(listening.notes[0].starts_with("sends packets that are neither RTP nor MPEG-TS"));
}

#[test]
fn what_is_no_video_is_told() {
    let mut listening = Listening::new(None);
    listening.send([&[0x80, 8, 0, 0, 0, 0, 0, 0, 0, 0, 0, 1, 0x55][..]]);
    loop {
        match listening.media.receive::<FromSource>().unwrap().unwrap().0 {
            FromSource::Alive => {}
            FromSource::Failed(failure) => {
                assert!(failure.is_final && failure.what.contains("type 8"), "{failure:?}");
                break;
            }
            other => panic!("{other:?}"),
        }
    }
}

#[test]
fn a_port_that_is_taken_is_told() {
    let taken = UdpSocket::bind("127.0.0.1:0").unwrap();
    let address = SourceAddress::Udp { bind: taken.local_addr().unwrap(), format: None };
    let played = crate::files::play(address, true);
    let FromSource::Failed(failure) = played.end else { panic!("{:?}", played.end) };
    assert!(!failure.is_final && failure.what.contains("another program uses port"), "{failure:?}");
}
