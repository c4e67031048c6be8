//! Replays of recordings whose video runs ahead of the steps.

use std::fs;
use std::io::BufWriter;
use std::path::Path;
use std::process::Command;

use barrelman_pilot::CommandPath;
use barrelman_station::commands::stored_video::StoredVideo;
use barrelman_trial::records::{Entry, FrameFingerprint, RecordedVideo, RecordingStart, RecordingWriter};
use barrelman_video::decoder::UnitDecoder;
use barrelman_video::mode::DecodeMode;
use barrelman_vocab::unit::{Rotation, UnitCodec};
use barrelman_vocab::video::{Capture, CaptureQuality, ColourEncoding};
use barrelman_vocab::{EncodedUnit, PictureSize, Timestamp, VideoFrame};
use barrelman_vocab::{VehicleProfile, VideoNumber};

const SIZE: PictureSize = PictureSize::new(32, 32);

fn unit(index: u64, codec: UnitCodec, payload: Vec<u8>) -> EncodedUnit {
    EncodedUnit {
        epoch: 0,
        index,
        capture: Capture { at: Timestamp::from_nanos(index), quality: CaptureQuality::Sensor },
        key: true,
        shown: true,
        rotation: Rotation::None,
        codec,
        payload: payload.into(),
    }
}

/// A raw picture; each index gives another one.
fn raw(index: u64) -> EncodedUnit {
    let codec = UnitCodec::RawYuv420 { size: SIZE, colour: ColourEncoding::JPEG };
    unit(index, codec, vec![index as u8; SIZE.area() * 3 / 2])
}

/// A black picture of 2000 x 2000 pixels in a few kilobytes.
fn black_png() -> Vec<u8> {
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, 2000, 2000);
    encoder.set_color(png::ColorType::Grayscale);
    encoder.set_depth(png::BitDepth::Eight);
    let mut writer = encoder.write_header().unwrap();
    writer.write_image_data(&vec![0; 2000 * 2000]).unwrap();
    writer.finish().unwrap();
    bytes
}

/// The decoded frames of units.
fn frames(units: &[EncodedUnit]) -> Vec<VideoFrame> {
    let mut decoder = UnitDecoder::new(DecodeMode::File);
    let mut frames = Vec::new();
    for unit in units {
        decoder.decode(unit, &mut |frame| frames.push(frame)).unwrap();
    }
    frames
}

#[test]
fn a_recording_of_many_pictures_that_no_step_takes_needs_little_memory() {
    let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join("replays-pictures.mcap");
    let configuration =
        Command::new(env!("CARGO_BIN_EXE_barrelman")).args(["config", "print"]).output().unwrap();
    assert!(configuration.status.success());
    let start = RecordingStart {
        program: "0.1.0".to_owned(),
        monotonic_ns: 0,
        unix_ns: 0,
        configuration: String::from_utf8(configuration.stdout).unwrap(),
        videos: RecordedVideo::only("file:pictures", false),
        link: String::new(),
        command_path: CommandPath::DryRun,
        trial: None,
    };
    let file = BufWriter::new(fs::File::create(&path).unwrap());
    let mut writer = RecordingWriter::begin(file, &start, &VehicleProfile::fotokite_pro()).unwrap();
    let png = black_png();
    // 400 pictures of 6 MB each when decoded.
    for index in 0..400 {
        writer.write(&Entry::Unit(VideoNumber::First, unit(index, UnitCodec::Png, png.clone()))).unwrap();
    }
    writer.finish().unwrap();
    // The process gets a gigabyte of address space.
    let output = Command::new("sh")
        .args(["-c", "ulimit -v 1000000 && exec \"$0\" replay \"$1\""])
        .arg(env!("CARGO_BIN_EXE_barrelman"))
        .arg(&path)
        .output()
        .unwrap();
    let message = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{message}");
    let found = String::from_utf8_lossy(&output.stdout);
    assert!(found.starts_with("0 steps, 0 video frames"), "{found}");
    fs::remove_file(path).unwrap();
}

#[test]
fn frames_come_as_they_are_asked_for_and_those_between_are_passed_over() {
    let units: Vec<EncodedUnit> = (0..50).map(raw).collect();
    let expected = frames(&units);
    let mut video = StoredVideo::new(DecodeMode::File, usize::MAX);
    let mut taken = 0;
    for (index, unit) in units.into_iter().enumerate() {
        video.add(unit).unwrap();
        // The pilot takes the newest frame, three units late.
        if index % 5 == 4 {
            let wanted = &expected[index - 3];
            let frame = video.frame(&FrameFingerprint::from_frame(VideoNumber::First, wanted)).unwrap();
            assert_eq!((frame.sequence, &frame.picture), (wanted.sequence, &wanted.picture));
            taken += 1;
        }
    }
    assert_eq!(taken, 10);
    let refusal = video
        .frame(&FrameFingerprint {
            sequence: 50,
            ..FrameFingerprint::from_frame(VideoNumber::First, &expected[0])
        })
        .unwrap_err();
    assert!(refusal.to_string().contains("frame 50 is not in the recording"), "{refusal}");
}

#[test]
fn video_that_runs_too_far_ahead_is_an_error_that_says_so() {
    // The queue holds twelve units.
    let bytes = size_of::<EncodedUnit>() + raw(0).payload.len();
    let mut video = StoredVideo::new(DecodeMode::File, 12 * bytes);
    let expected = frames(&(0..30).map(raw).collect::<Vec<_>>());
    // While a frame is taken for each unit, the queue never fills.
    for (index, frame) in expected.iter().enumerate() {
        video.add(raw(index as u64)).unwrap();
        video.frame(&FrameFingerprint::from_frame(VideoNumber::First, frame)).unwrap();
    }
    let refusal = (30..60).find_map(|index| video.add(raw(index)).err()).unwrap().to_string();
    assert!(refusal.contains("too far ahead") && refusal.contains("picture 42"), "{refusal}");
}
