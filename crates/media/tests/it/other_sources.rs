//! Pipelines, devices, SDP files and addresses of the network.

use std::net::UdpSocket;
use std::path::PathBuf;
use std::time::Duration;

use barrelman_media_protocol::failure::SourceFailure;
use barrelman_media_protocol::role::Role;
use barrelman_media_protocol::source::{
    DeviceSettings, FromSource, SourceAddress, SourceLogin, SourceSettings, UnitTime,
};
use barrelman_vocab::image::PictureSize;
use barrelman_vocab::unit::UnitCodec;

use gst::prelude::*;
use gstreamer as gst;
use gstreamer_app::AppSink;

use crate::clip::{self, Folder};
use crate::files::play;
use crate::media::Media;

const PICTURE: &str = "video/x-raw,width=320,height=240,framerate=25/1";

fn failure(address: SourceAddress) -> SourceFailure {
    let FromSource::Failed(failure) = play(address, true).end else { panic!("it has not failed") };
    failure
}

fn pipeline(text: &str) -> SourceAddress {
    SourceAddress::Pipeline(text.to_owned())
}

#[test]
fn a_pipeline_gives_compressed_video_as_it_is() {
    let text = format!("videotestsrc num-buffers=20 ! {PICTURE} ! x264enc tune=zerolatency");
    let played = play(pipeline(&text), false);
    assert_eq!(played.end, FromSource::Ended);
    assert_eq!(played.opened.as_deref(), Some("H.264 from a pipeline"));
    assert_eq!(played.units.len(), 20);
    for (index, (unit, _)) in played.units.iter().enumerate() {
        assert_eq!(unit.codec, UnitCodec::H264AnnexB);
        // The encoder's times begin at an hour, of which the segment knows.
        let UnitTime::SinceStart(at_ns) = unit.time else { panic!("{unit:?}") };
        let UnitTime::SinceStart(first_ns) = played.units[0].0.time else { panic!("{unit:?}") };
        assert_eq!(at_ns - first_ns, index as u64 * 40_000_000);
    }
}

#[test]
fn uncompressed_pictures_of_a_live_pipeline_become_jpeg_with_their_time_of_capture() {
    let text = format!("videotestsrc is-live=true num-buffers=10 ! {PICTURE}");
    let began_ns = monotonic_ns();
    let played = play(pipeline(&text), true);
    let ended_ns = monotonic_ns();
    assert_eq!(played.end, FromSource::Ended);
    assert_eq!(played.units.len(), 10);
    assert_eq!(played.notes.len(), 1, "{:?}", played.notes);
    for (unit, payload) in &played.units {
        assert_eq!((unit.codec, unit.key), (UnitCodec::Jpeg, true));
        assert!(payload.starts_with(&[0xff, 0xd8]));
        let UnitTime::Captured(at_ns) = unit.time else { panic!("{unit:?}") };
        assert!((began_ns..=ended_ns).contains(&at_ns), "{began_ns} {at_ns} {ended_ns}");
    }
}

/// The means of the luma and of the two chroma planes in a JPEG file.
fn means_of_jpeg(picture: &[u8], chroma_samples: usize) -> [u8; 3] {
    gst::init().unwrap();
    let folder = Folder::new();
    let file = folder.file("picture.jpg");
    std::fs::write(&file, picture).unwrap();
    let text = format!(
        "filesrc location={} ! jpegdec ! video/x-raw,format=I420 ! appsink name=end sync=false",
        file.display()
    );
    let pipeline = gst::parse::launch(&text).unwrap().downcast::<gst::Pipeline>().unwrap();
    let sink = pipeline.by_name("end").unwrap().downcast::<AppSink>().unwrap();
    pipeline.set_state(gst::State::Playing).unwrap();
    let samples = sink.pull_sample().unwrap().buffer().unwrap().map_readable().unwrap().to_vec();
    pipeline.set_state(gst::State::Null).unwrap();
    let (luma, chroma) = samples.split_at(samples.len() - 2 * chroma_samples);
    let (u, v) = chroma.split_at(chroma_samples);
    [luma, u, v].map(|plane| {
        let sum: usize = plane.iter().map(|sample| usize::from(*sample)).sum();
        (sum / plane.len()) as u8
    })
}

#[test]
fn uncompressed_pictures_become_jpeg_in_its_range_and_matrix() {
    // Of the size of HD video, whose matrix is BT.709. JFIF 1.02: Y, Cb and Cr of full-range BT.601.
    for (pattern, expected) in [("white", [255, 128, 128]), ("red", [76, 85, 255]), ("black", [0, 128, 128])]
    {
        let text = format!(
            "videotestsrc is-live=true num-buffers=1 pattern={pattern} ! \
             video/x-raw,format=YUY2,width=1280,height=720,framerate=25/1"
        );
        let played = play(pipeline(&text), true);
        let means = means_of_jpeg(&played.units[0].1, 640 * 360);
        for (mean, expected) in means.into_iter().zip(expected) {
            // Two conversions round.
            assert!(mean.abs_diff(expected) <= 3, "{pattern}: {means:?}");
        }
    }
}

fn monotonic_ns() -> u64 {
    let now = rustix::time::clock_gettime(rustix::time::ClockId::Monotonic);
    now.tv_sec as u64 * 1_000_000_000 + now.tv_nsec as u64
}

#[test]
fn a_pipeline_may_end_in_an_element_that_finds_its_streams() {
    if !clip::has_ffmpeg() {
        return;
    }
    let folder = Folder::new();
    let file = folder.file("clip.mkv");
    clip::encode("s=320x240:r=25:d=1", "-c:v libx265 -x265-params log-level=0", &file);
    let text = format!("filesrc location={} ! matroskademux", file.display());
    let played = play(pipeline(&text), false);
    assert_eq!(played.units.len(), 25);
    assert!(played.units.iter().all(|(unit, _)| unit.codec == UnitCodec::H265AnnexB));
}

#[test]
fn a_large_uncompressed_picture_is_scaled_down() {
    let text = "videotestsrc num-buffers=2 ! video/x-raw,format=I420,width=5312,height=2988";
    let played = play(pipeline(text), false);
    assert_eq!(played.units.len(), 2);
    for (unit, payload) in &played.units {
        let UnitCodec::RawYuv420 { size, .. } = unit.codec else { panic!("{unit:?}") };
        assert_eq!(size, PictureSize::new(4096, 2304));
        assert_eq!(payload.len(), 4096 * 2304 * 3 / 2);
    }
}

#[test]
fn pipelines_that_cannot_be_built_fail_for_good() {
    for (text, what) in [
        ("videotestsrc !", "cannot be built"),
        ("noSuchElement ! identity", "cannot be built"),
        ("videotestsrc ! fakesink", "has no end that video comes out of"),
    ] {
        let failure = failure(pipeline(text));
        assert!(failure.is_final && failure.what.contains(what), "{text}: {failure:?}");
    }
}

#[test]
fn an_absent_device_fails_with_what_there_is() {
    let path = PathBuf::from("/dev/video-absent");
    let settings = DeviceSettings { path, size: None, fps: None, format: None };
    let failure = failure(SourceAddress::Device(settings));
    assert_eq!((failure.what.as_str(), failure.is_final), ("does not exist", false));
    assert!(failure.remedy.contains("device") || failure.remedy.contains("/dev/video"), "{failure:?}");
}

#[test]
fn an_sdp_file_opens_the_port_that_it_names() {
    let port = UdpSocket::bind("127.0.0.1:0").unwrap().local_addr().unwrap().port() & !1;
    let folder = Folder::new();
    let file = folder.file("stream.sdp");
    let sdp = format!(
        "v=0\r\no=- 1 1 IN IP4 127.0.0.1\r\ns=x\r\nc=IN IP4 127.0.0.1\r\nt=0 0\r\nm=video {port} RTP/AVP 96\r\n\
         a=rtpmap:96 H264/90000\r\n"
    );
    std::fs::write(&file, sdp).unwrap();
    let settings = SourceSettings { address: SourceAddress::Sdp(file), is_live: true };
    let mut media = Media::start(Role::Source(settings));
    let line = "x264enc tune=zerolatency key-int-max=5 ! rtph264pay config-interval=-1 pt=96";
    let sender =
        format!("videotestsrc is-live=true ! {PICTURE} ! {line} ! udpsink host=127.0.0.1 port={port}");
    gst::init().unwrap();
    let sender = gst::parse::launch(&sender).unwrap();
    sender.set_state(gst::State::Playing).unwrap();
    let (mut opened, mut units) = (None, 0);
    while units < 10 {
        match media.receive::<FromSource>().unwrap().expect("the source is silent").0 {
            FromSource::Opened(text) => opened = Some(text),
            FromSource::Unit(unit) => {
                assert!(matches!(unit.time, UnitTime::Ticks(_)));
                units += 1;
            }
            FromSource::Failed(failure) => panic!("{failure:?}"),
            _ => {}
        }
    }
    assert_eq!(opened.as_deref(), Some("H.264 by RTP over UDP"));
    sender.set_state(gst::State::Null).unwrap();
}

#[test]
fn network_addresses_that_cannot_be_played_are_told() {
    let network = |url: &str, login| SourceAddress::Network { url: url.to_owned(), login };
    let login = SourceLogin { user: "a".to_owned(), password: "b".to_owned(), permits_basic: false };
    let in_clear = failure(network("http://127.0.0.1:9/video", Some(login)));
    assert!(in_clear.is_final && in_clear.what.contains("in clear text"), "{in_clear:?}");
    let unknown = failure(network("gopher://127.0.0.1/", None));
    assert!(unknown.is_final && unknown.what.contains("gopher"), "{unknown:?}");
    let absent = failure(network("http://127.0.0.1:9/video", None));
    assert!(!absent.is_final && absent.what.starts_with("refuses the connection"), "{absent:?}");
}

#[test]
fn video_in_segments_is_refused() {
    use std::io::{Read as _, Write as _};
    let listener = std::net::TcpListener::bind("127.0.0.1:0").unwrap();
    let url = format!("http://{}/live.m3u8", listener.local_addr().unwrap());
    let list =
        "#EXTM3U\n#EXT-X-VERSION:3\n#EXT-X-TARGETDURATION:2\n#EXTINF:2.0,\none.ts\n#EXTINF:2.0,\ntwo.ts\n";
    std::thread::spawn(move || {
        for stream in listener.incoming() {
            let mut stream = stream.unwrap();
            let _ = stream.read(&mut [0; 4096]);
            let head =
                format!("HTTP/1.1 200 OK\r\nContent-Length: {}\r\nConnection: close\r\n\r\n", list.len());
            let _ = stream.write_all(&[head.as_bytes(), list.as_bytes()].concat());
        }
    });
    let failure = failure(SourceAddress::Network { url, login: None });
    assert!(failure.is_final && failure.what.contains("HLS"), "{failure:?}");
}

#[test]
fn jpeg_pictures_come_by_http() {
    use std::io::{Read as _, Write as _};
    const PAUSE: Duration = Duration::from_millis(100);
    if !clip::has_ffmpeg() {
        return;
    }
    let folder = Folder::new();
    let file = folder.file("picture.jpg");
    clip::encode("s=320x240:r=25:d=1", "-frames:v 1 -q:v 3", &file);
    let picture = std::fs::read(file).unwrap();
    let listener = std::net::TcpListener::bind("127.0.0.1:0").unwrap();
    let url = format!("http://{}/video", listener.local_addr().unwrap());
    std::thread::spawn(move || {
        let (mut stream, _) = listener.accept().unwrap();
        let _ = stream.read(&mut [0; 4096]);
        let head = "HTTP/1.1 200 OK\r\nContent-Type: multipart/x-mixed-replace; boundary=next\r\n\r\n";
        stream.write_all(head.as_bytes()).unwrap();
        for _ in 0..10 {
            let part =
                format!("--next\r\nContent-Type: image/jpeg\r\nContent-Length: {}\r\n\r\n", picture.len());
            stream.write_all(&[part.as_bytes(), &picture, b"\r\n"].concat()).unwrap();
            std::thread::sleep(PAUSE);
        }
    });
    let played = play(SourceAddress::Network { url, login: None }, true);
    assert!(played.units.len() >= 9, "{} {:?}", played.units.len(), played.end);
    for (unit, _) in &played.units {
        assert_eq!((unit.codec, unit.time), (UnitCodec::Jpeg, UnitTime::Unknown));
    }
    assert_eq!(played.opened.as_deref(), Some("JPEG by HTTP"));
    // The pictures come one after the other, not all of them with the last one.
    let arrival_ns = |index: usize| played.units[index].0.arrival_ns;
    let took = Duration::from_nanos(arrival_ns(played.units.len() - 1) - arrival_ns(0));
    assert!(took >= 5 * PAUSE, "{took:?}");
    // A camera that closes its connection is lost: such a stream has no end of its own.
    let FromSource::Failed(failure) = played.end else { panic!("{:?}", played.end) };
    assert_eq!((failure.what.as_str(), failure.is_final), ("ended its stream", false));
}
