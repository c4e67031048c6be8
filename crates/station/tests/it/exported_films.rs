//! Exports of recordings with pictures: films that could not be completed, and damaged pictures.

use std::fs;
use std::path::{Path, PathBuf};

use barrelman_pilot::{CommandPath, Input};
use barrelman_trial::records::{
    Entry, FrameFingerprint, RecordedInput, RecordedOutcome, RecordedVideo, RecordingStart, RecordingWriter,
};
use barrelman_video::decoder::UnitDecoder;
use barrelman_video::jpeg;
use barrelman_video::mode::DecodeMode;
use barrelman_vocab::unit::{Rotation, UnitCodec};
use barrelman_vocab::video::{Capture, CaptureQuality, ColourEncoding};
use barrelman_vocab::{EncodedUnit, Picture, PictureSize, VehicleProfile, VehicleRates, VideoNumber};

use crate::live_scenes::{at, pilot};
use crate::program::{argument, barrelman, empty_folder, failed, succeeded};

const SIZE: PictureSize = PictureSize::new(64, 48);
const BEGUN: &str = "annotated.mp4.begun";

fn unit(index: u64, payload: Vec<u8>) -> EncodedUnit {
    EncodedUnit {
        epoch: 0,
        index,
        capture: Capture { at: at(1_000 + index * 40), quality: CaptureQuality::Sensor },
        key: true,
        shown: true,
        rotation: Rotation::None,
        codec: UnitCodec::Jpeg,
        payload: payload.into(),
    }
}

/// The unit of an intact picture.
fn intact(index: u64) -> EncodedUnit {
    unit(index, jpeg::encode(&Picture::black(SIZE, ColourEncoding::JPEG)).unwrap())
}

/// Records a live run without a selection, whose pilot sees what can be decoded of the first video.
fn record(path: &Path, units: impl IntoIterator<Item = (VideoNumber, EncodedUnit)>) {
    let start = RecordingStart {
        program: "0.1.0".to_owned(),
        monotonic_ns: 0,
        unix_ns: 0,
        configuration: succeeded(&barrelman(&["config", "print"])),
        videos: RecordedVideo::only("file:pictures", true),
        link: String::new(),
        command_path: CommandPath::DryRun,
        trial: None,
    };
    let file = fs::File::create(path).unwrap();
    let mut writer = RecordingWriter::begin(file, &start, &VehicleProfile::fotokite_pro()).unwrap();
    let (mut decoder, mut pilot, mut step) = (UnitDecoder::new(DecodeMode::Live), pilot(), 0);
    for (number, unit) in units {
        let mut frames = Vec::new();
        if number == VideoNumber::First {
            // A live run goes on after a damaged picture.
            let _ = decoder.decode(&unit, &mut |frame| frames.push(frame));
        }
        let now = unit.capture.at;
        writer.write(&Entry::Unit(number, unit)).unwrap();
        for frame in frames {
            let outcome = pilot.step(Input::Frame(&frame), now);
            let input = RecordedInput::Frame(FrameFingerprint::from_frame(number, &frame));
            writer.write(&Entry::Input { step, now, input }).unwrap();
            let outcome = RecordedOutcome::new(step, &outcome, VehicleRates::REST);
            writer.write(&Entry::Outcome(outcome)).unwrap();
            step += 1;
        }
    }
    writer.finish().unwrap();
}

/// A folder, the recording in it, and the folder of its export.
fn scene(name: &str) -> (PathBuf, PathBuf) {
    let folder = empty_folder(name);
    (folder.join("r.mcap"), folder.join("out"))
}

#[test]
fn a_film_has_its_name_only_when_it_is_whole() {
    let (recording, out) = scene("films-failed");
    let export =
        || barrelman(&["export", "--annotated", "--force", "--output", argument(&out), argument(&recording)]);
    // The pictures of a second video that the start does not announce come after those of the first.
    let first = (0..60).map(|index| (VideoNumber::First, intact(index)));
    record(&recording, first.chain([(VideoNumber::Second, intact(60))]));
    failed(&export(), 1, &["second video"]);
    assert!(!out.join("annotated.mp4").exists() && !out.join(BEGUN).exists());
    // What an export that was killed has left is in nobody's way.
    fs::write(out.join(BEGUN), "half a film").unwrap();
    record(&recording, (0..60).map(|index| (VideoNumber::First, intact(index))));
    succeeded(&export());
    assert!(out.join("annotated.mp4").exists() && !out.join(BEGUN).exists());
}
