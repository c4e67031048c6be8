//! Files to units.

use std::path::Path;

use barrelman_media_protocol::format::CodedFormat;
use barrelman_media_protocol::role::Role;
use barrelman_media_protocol::source::{FromSource, SourceAddress, SourceSettings, SourceUnit, UnitTime};
use barrelman_vocab::image::PictureSize;
use barrelman_vocab::unit::{Rotation, UnitCodec};

use crate::clip::{self, Folder, Unit};
use crate::media::Media;

/// Two seconds of small pictures with motion.
const SMALL: &str = "s=320x240:r=25:d=2";

/// What a source sends up to its end.
pub(crate) struct Played {
    pub opened: Option<String>,
    pub units: Vec<(SourceUnit, Vec<u8>)>,
    pub notes: Vec<String>,
    pub end: FromSource,
}

pub(crate) fn play(address: SourceAddress, is_live: bool) -> Played {
    let mut media = Media::start(Role::Source(SourceSettings { address, is_live }));
    let mut played = Played { opened: None, units: Vec::new(), notes: Vec::new(), end: FromSource::Alive };
    loop {
        let (message, payload) = media.receive::<FromSource>().unwrap().expect("the source is silent");
        match message {
            FromSource::Alive | FromSource::SenderReport(_) => {}
            FromSource::Opened(text) => assert!(played.opened.replace(text).is_none(), "opened twice"),
            FromSource::Note(text) => played.notes.push(text),
            FromSource::Unit(unit) => played.units.push((unit, payload)),
            end @ (FromSource::Ended | FromSource::Failed(_)) => {
                played.end = end;
                break;
            }
        }
    }
    assert!(media.end().success());
    played
}

fn play_file(path: &Path) -> Played {
    play(SourceAddress::File(path.to_owned()), false)
}

fn coded(format: CodedFormat) -> UnitCodec {
    match format {
        CodedFormat::H264 => UnitCodec::H264AnnexB,
        CodedFormat::H265 => UnitCodec::H265AnnexB,
        CodedFormat::Vp9 => UnitCodec::Vp9,
        CodedFormat::Av1 => UnitCodec::Av1,
    }
}

/// The units of a file decode to the pictures that FFmpeg sees in it.
fn check(name: &str, format: CodedFormat, encoder: &str) {
    if !clip::has_ffmpeg() {
        return;
    }
    let folder = Folder::new();
    let file = folder.file(name);
    clip::encode(SMALL, encoder, &file);
    let played = play_file(&file);
    assert_eq!(played.end, FromSource::Ended);
    assert_eq!(played.opened, Some(format!("{} from a file", format.name())));
    assert!(played.units.iter().all(|(unit, _)| unit.codec == coded(format) && !unit.follows_loss));
    assert!(played.units[0].0.key);
    let units: Vec<Unit> = played
        .units
        .iter()
        .map(|(unit, payload)| {
            let UnitTime::SinceStart(pts_ns) = unit.time else { panic!("{unit:?}") };
            Unit { payload: payload.clone(), pts_ns, key: unit.key }
        })
        .collect();
    let pictures = Media::decoder(format, false).decode_all(&units);
    let got: Vec<u8> = pictures.iter().flat_map(|(_, samples)| samples.clone()).collect();
    assert!(got == clip::pictures(&file, "yuv420p"), "{} pictures", pictures.len());
    for (index, (picture, _)) in pictures.iter().enumerate() {
        let expected = index as u64 * 40_000_000;
        let first = pictures[0].0.pts_ns;
        // Containers round times to milliseconds, or to ticks of 1/90000 s.
        assert!((picture.pts_ns - first).abs_diff(expected) <= 1_000_000, "{index}: {picture:?}");
    }
}

#[test]
fn h264_in_matroska() {
    check("clip.mkv", CodedFormat::H264, "-c:v libx264 -bf 3 -g 20 -pix_fmt yuv420p");
}

#[test]
fn h264_in_mp4() {
    check("clip.mp4", CodedFormat::H264, "-c:v libx264 -bf 3 -g 20 -pix_fmt yuv420p -movflags +faststart");
}

#[test]
fn h264_in_a_transport_stream() {
    check("clip.ts", CodedFormat::H264, "-c:v libx264 -bf 2 -g 20 -pix_fmt yuv420p");
}

#[test]
fn h265_in_mp4() {
    check(
        "clip.mp4",
        CodedFormat::H265,
        "-c:v libx265 -x265-params log-level=0:keyint=20:open-gop=0 -tag:v hvc1",
    );
}

#[test]
fn h265_in_a_transport_stream() {
    check("clip.ts", CodedFormat::H265, "-c:v libx265 -x265-params log-level=0:keyint=20:open-gop=0");
}

#[test]
fn vp9_in_webm() {
    check("clip.webm", CodedFormat::Vp9, "-c:v libvpx-vp9 -cpu-used 8 -g 20");
}

#[test]
fn av1_in_matroska() {
    check("clip.mkv", CodedFormat::Av1, "-c:v libaom-av1 -cpu-used 8 -g 20 -t 1");
}

#[test]
fn sound_is_left_alone() {
    check("clip.mkv", CodedFormat::H264, "-f lavfi -i sine=d=2 -c:v libx264 -bf 0 -pix_fmt yuv420p -c:a aac");
    check("clip.ts", CodedFormat::H264, "-f lavfi -i sine=d=2 -c:v libx264 -bf 0 -pix_fmt yuv420p -c:a mp2");
}

#[test]
fn other_formats_of_a_file_are_decoded() {
    if !clip::has_ffmpeg() {
        return;
    }
    for (name, encoder) in [
        ("clip.avi", "-c:v mpeg4 -q:v 2"),
        ("clip.mkv", "-c:v mpeg2video -bf 2 -q:v 2"),
        ("clip.webm", "-c:v libvpx -b:v 1M -auto-alt-ref 0"),
        ("clip.mov", "-c:v prores_ks -pix_fmt yuv422p10le"),
        ("clip.y4m", "-pix_fmt yuv420p"),
    ] {
        let folder = Folder::new();
        let file = folder.file(name);
        clip::encode(SMALL, encoder, &file);
        let played = play_file(&file);
        assert_eq!(played.end, FromSource::Ended, "{name}");
        assert_eq!(played.units.len(), 50, "{name}");
        let expected = clip::pictures(&file, "yuv420p");
        for ((unit, samples), expected) in played.units.iter().zip(expected.chunks(320 * 240 * 3 / 2)) {
            let UnitCodec::RawYuv420 { size, .. } = unit.codec else { panic!("{unit:?}") };
            assert_eq!(size, PictureSize::new(320, 240));
            assert!(unit.key);
            assert_eq!(samples.len(), expected.len());
            let largest = samples.iter().zip(expected).map(|(a, b)| a.abs_diff(*b)).max().unwrap();
            // Decoders of these formats may use other transforms, whose results differ by rounding.
            assert!(largest <= 3 || name == "clip.mov", "{name}: {largest}");
        }
    }
}

#[test]
fn jpeg_pictures_pass_as_they_are() {
    if !clip::has_ffmpeg() {
        return;
    }
    let folder = Folder::new();
    let file = folder.file("clip.avi");
    clip::encode(SMALL, "-c:v mjpeg -q:v 3 -pix_fmt yuvj420p", &file);
    let played = play_file(&file);
    assert_eq!(played.units.len(), 50);
    for (unit, payload) in &played.units {
        assert_eq!((unit.codec, unit.key), (UnitCodec::Jpeg, true));
        assert!(payload.starts_with(&[0xff, 0xd8]) && payload.len() > 1000);
    }
}

#[test]
fn a_rotated_video_says_so() {
    if !clip::has_ffmpeg() {
        return;
    }
    let folder = Folder::new();
    let (upright, rotated) = (folder.file("upright.mp4"), folder.file("rotated.mp4"));
    clip::encode(SMALL, "-c:v libx264 -bf 0 -pix_fmt yuv420p", &upright);
    for (degrees, rotation) in
        [(270, Rotation::Clockwise90), (180, Rotation::Half), (90, Rotation::Clockwise270)]
    {
        clip::remux(&upright, &format!("-metadata:s:v rotate={degrees}"), &rotated);
        let played = play_file(&rotated);
        assert_eq!(played.units.len(), 50);
        let wrong = played.units.iter().find(|(unit, _)| unit.rotation != rotation);
        assert!(wrong.is_none(), "{degrees}: {:?}", wrong.unwrap().0);
    }
}

fn failure(played: Played) -> (String, bool) {
    let FromSource::Failed(failure) = played.end else { panic!("{:?}", played.end) };
    (failure.what, failure.is_final)
}

#[test]
fn what_is_no_video_fails_for_good() {
    let folder = Folder::new();
    let (garbage, text, empty) = (folder.file("a.mkv"), folder.file("a.txt"), folder.file("a"));
    let bytes: Vec<u8> = (0..200_000_u32).map(|at| (at.wrapping_mul(2_654_435_761) >> 13) as u8).collect();
    std::fs::write(&garbage, bytes).unwrap();
    std::fs::write(&text, "This is no video.\n".repeat(100)).unwrap();
    std::fs::write(&empty, "").unwrap();
    for file in [&garbage, &text, &empty] {
        let (what, is_final) = failure(play_file(file));
        assert!(is_final, "{what}");
    }
    assert_eq!(failure(play_file(&folder.file("absent"))), ("does not exist".to_owned(), true));
    assert_eq!(failure(play_file(&std::env::temp_dir())), ("is a folder".to_owned(), true));
    if clip::has_ffmpeg() {
        let sound = folder.file("sound.wav");
        clip::encode(SMALL, "-f lavfi -i sine=d=1 -map 1", &sound);
        assert_eq!(failure(play_file(&sound)), ("has no video".to_owned(), true));
    }
}

#[test]
fn a_file_is_read_at_the_pace_of_its_reader() {
    if !clip::has_ffmpeg() {
        return;
    }
    let folder = Folder::new();
    let file = folder.file("clip.y4m");
    clip::encode("s=1280x720:r=25:d=4", "-pix_fmt yuv420p", &file);
    let address = SourceAddress::File(file);
    let mut media = Media::start(Role::Source(SourceSettings { address, is_live: false }));
    let mut units = 0;
    loop {
        let (message, _) = media.receive::<FromSource>().unwrap().unwrap();
        match message {
            FromSource::Unit(_) => {
                units += 1;
                // Longer than the channel waits for a live reader.
                if units == 5 {
                    std::thread::sleep(std::time::Duration::from_millis(1500));
                }
            }
            FromSource::Ended => break,
            FromSource::Failed(failure) => panic!("{failure:?}"),
            _ => {}
        }
    }
    assert_eq!(units, 100);
}

#[test]
fn a_pipe_is_read_and_may_have_no_writer_yet() {
    if !clip::has_ffmpeg() {
        return;
    }
    let folder = Folder::new();
    let (file, pipe) = (folder.file("clip.ts"), folder.file("pipe"));
    clip::encode(SMALL, "-c:v libx264 -bf 0 -pix_fmt yuv420p", &file);
    let mode = rustix::fs::Mode::from_raw_mode(0o600);
    rustix::fs::mknodat(rustix::fs::CWD, &pipe, rustix::fs::FileType::Fifo, mode, 0).unwrap();
    let address = SourceAddress::File(pipe.clone());
    let mut waiting = Media::start(Role::Source(SourceSettings { address, is_live: true }));
    assert_eq!(waiting.receive::<FromSource>().unwrap().unwrap().0, FromSource::Alive);
    assert!(waiting.close().success());
    let writer = std::thread::spawn(move || std::fs::copy(file, pipe).unwrap());
    let played = play(SourceAddress::File(folder.file("pipe")), false);
    writer.join().unwrap();
    assert_eq!((played.units.len(), played.end), (50, FromSource::Ended));
    assert_eq!(played.opened.as_deref(), Some("H.264 from a pipe"));
}
