//! Streams that are broken on purpose: the program answers, survives and stays small.

use std::net::{SocketAddr, UdpSocket};
use std::time::{Duration, Instant};

use barrelman_media_protocol::format::CodedFormat;
use barrelman_media_protocol::role::Role;
use barrelman_media_protocol::source::{FromSource, SourceAddress, SourceSettings};

use crate::clip::{self, Folder};
use crate::files::play;
use crate::media::Media;

const SMALL: &str = "s=320x240:r=25:d=1";

/// The same numbers in each run (SplitMix64).
struct Numbers(u64);

impl Numbers {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mixed = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let mixed = (mixed ^ (mixed >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        mixed ^ (mixed >> 31)
    }

    fn below(&mut self, bound: usize) -> usize {
        (self.next() % bound.max(1) as u64) as usize
    }

    /// Changes some bytes, or the length.
    fn break_up(&mut self, bytes: &mut Vec<u8>) {
        for _ in 0..=self.below(8) {
            let at = self.below(bytes.len());
            match self.below(4) {
                0 => bytes.truncate(at.max(1)),
                1 => bytes.extend_from_within(at..),
                _ => bytes[at] = self.next() as u8,
            }
        }
    }
}

/// Most memory that a process had, MB.
fn peak_mb(media: &Media) -> u64 {
    let status = std::fs::read_to_string(format!("/proc/{}/status", media.id())).unwrap();
    let line = status.lines().find(|line| line.starts_with("VmHWM:")).unwrap();
    line.split_whitespace().nth(1).unwrap().parse::<u64>().unwrap() / 1024
}

const MOST_MB: u64 = 300;

#[test]
fn decoders_answer_whatever_they_are_given() {
    if !clip::has_ffmpeg() {
        return;
    }
    for (format, encoder) in [
        (CodedFormat::H264, "-c:v libx264 -bf 2 -g 10 -pix_fmt yuv420p"),
        (CodedFormat::H265, "-c:v libx265 -x265-params log-level=0:keyint=10"),
        (CodedFormat::Vp9, "-c:v libvpx-vp9 -cpu-used 8 -g 10"),
        (CodedFormat::Av1, "-c:v libaom-av1 -cpu-used 8 -g 10"),
    ] {
        let folder = Folder::new();
        let file = folder.file("clip.mkv");
        clip::encode(SMALL, encoder, &file);
        let units = clip::units(&file, format);
        let mut media = Media::decoder(format, true);
        let mut numbers = Numbers(format as u64);
        for round in 0..20 {
            for unit in &units {
                let mut unit = unit.clone();
                unit.pts_ns += round * 2_000_000_000;
                if numbers.below(3) == 0 {
                    numbers.break_up(&mut unit.payload);
                }
                media.decode(&unit);
            }
        }
        let peak_mb = peak_mb(&media);
        assert!(peak_mb < MOST_MB, "{} {peak_mb} MB", format.name());
        assert!(!media.decode_all_leniently(&units).is_empty(), "{} does not go on", format.name());
    }
}

#[test]
fn broken_files_end_or_fail() {
    if !clip::has_ffmpeg() {
        return;
    }
    let folder = Folder::new();
    let mut numbers = Numbers(7);
    for (name, encoder) in [
        ("clip.mkv", "-c:v libx264 -bf 2 -pix_fmt yuv420p"),
        ("clip.mp4", "-c:v libx264 -bf 2 -pix_fmt yuv420p"),
        ("clip.ts", "-c:v libx264 -bf 2 -pix_fmt yuv420p"),
        ("clip.webm", "-c:v libvpx-vp9 -cpu-used 8"),
        ("clip.avi", "-c:v mpeg4"),
    ] {
        let file = folder.file(name);
        clip::encode(SMALL, encoder, &file);
        let whole = std::fs::read(&file).unwrap();
        for _ in 0..4 {
            let mut broken = whole.clone();
            (0..10).for_each(|_| numbers.break_up(&mut broken));
            let file = folder.file(&format!("broken-{name}"));
            std::fs::write(&file, &broken).unwrap();
            // It comes to an end, and the process ends by itself.
            play(SourceAddress::File(file), false);
        }
    }
}

/// Sends the packets again and again, after a while with broken ones among them, until `until`.
fn send_broken(packets: &[Vec<u8>], port: SocketAddr, until: Instant) {
    let sender = UdpSocket::bind("127.0.0.1:0").unwrap();
    let mut numbers = Numbers(9);
    for (sent, packet) in packets.iter().cycle().enumerate().take_while(|_| Instant::now() < until) {
        let mut packet = packet.clone();
        if packet[0] == 0x80 {
            // The video goes on where it begins again.
            packet[2..4].copy_from_slice(&(sent as u16).to_be_bytes());
            let ticks = u32::from_be_bytes(packet[4..8].try_into().unwrap());
            let later = ticks.wrapping_add((sent / packets.len()) as u32 * 180_000);
            packet[4..8].copy_from_slice(&later.to_be_bytes());
        }
        if sent > packets.len() / 2 && numbers.below(20) == 0 {
            numbers.break_up(&mut packet);
            packet.truncate(60_000);
        }
        let _ = sender.send_to(&packet, port);
        std::thread::sleep(Duration::from_micros(300));
    }
}

#[test]
fn broken_packets_are_survived() {
    for line in [
        "x264enc tune=zerolatency key-int-max=10 ! rtph264pay config-interval=-1 pt=96 mtu=400",
        "x265enc tune=zerolatency key-int-max=10 ! rtph265pay config-interval=-1 pt=96 mtu=400",
        "x264enc tune=zerolatency key-int-max=10 ! mpegtsmux alignment=7",
    ] {
        let packets = crate::ports::buffers(line);
        let port = crate::ports::free_port();
        let address = SourceAddress::Udp { bind: port, format: None };
        let mut media = Media::start(Role::Source(SourceSettings { address, is_live: true }));
        let until = Instant::now() + Duration::from_secs(3);
        let sender = std::thread::spawn(move || send_broken(&packets, port, until));
        let (mut units, mut failed) = (0, None);
        while Instant::now() < until && failed.is_none() {
            let received = media.receive::<FromSource>();
            let (message, _) = match received {
                Ok(received) => received.expect("the source is silent"),
                Err(error) => panic!("{line}: {error}, {}", media.end()),
            };
            match message {
                FromSource::Unit(_) => units += 1,
                FromSource::Failed(failure) => failed = Some(failure),
                _ => {}
            }
        }
        assert!(units > 20, "{line}: {units} units, {failed:?}");
        match failed {
            // A broken synchronisation source may look like another sender; the next attempt plays.
            Some(failure) => assert!(!failure.is_final, "{failure:?}"),
            None => {
                let peak_mb = peak_mb(&media);
                assert!(peak_mb < MOST_MB, "{line}: {peak_mb} MB");
                assert!(media.close().success());
            }
        }
        sender.join().unwrap();
    }
}
