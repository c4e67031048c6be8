//! Exports of recordings with pictures: films that could not be completed, and damaged pictures.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Output;

use barrelman_pilot::{CommandPath, Input};
use barrelman_trial::records::{
    Entry, FrameFingerprint, RecordedInput, RecordedOutcome, RecordedVideo, RecordingReader, RecordingStart,
    RecordingWriter,
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
    let mut entries = vec![Entry::Start(start)];
    let (mut decoder, mut pilot, mut step) = (UnitDecoder::new(DecodeMode::Live), pilot(), 0);
    for (number, unit) in units {
        let mut frames = Vec::new();
        if number == VideoNumber::First {
            // A live run goes on after a damaged picture.
            let _ = decoder.decode(&unit, &mut |frame| frames.push(frame));
        }
        let now = unit.capture.at;
        entries.push(Entry::Unit(number, unit));
        for frame in frames {
            let outcome = pilot.step(Input::Frame(&frame), now);
            let input = RecordedInput::Frame(FrameFingerprint::from_frame(number, &frame));
            entries.push(Entry::Input { step, now, input });
            entries.push(Entry::Outcome(RecordedOutcome::new(step, &outcome, VehicleRates::REST)));
            step += 1;
        }
    }
    write(path, &entries);
}

/// Writes a recording of entries, of which the first is the start.
fn write(path: &Path, entries: &[Entry]) {
    let Some((Entry::Start(start), others)) = entries.split_first() else { panic!("no start") };
    let file = fs::File::create(path).unwrap();
    let mut writer = RecordingWriter::begin(file, start, &VehicleProfile::fotokite_pro()).unwrap();
    others.iter().for_each(|entry| writer.write(entry).unwrap());
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

#[test]
fn a_damaged_picture_is_left_out_and_counted() {
    let (recording, out) = scene("films-damaged");
    let units = (0..20).map(|index| match index {
        7 | 8 => unit(index, vec![0; 100]),
        _ => intact(index),
    });
    record(&recording, units.map(|unit| (VideoNumber::First, unit)));
    let output = barrelman(&["export", "--annotated", "--output", argument(&out), argument(&recording)]);
    let found = succeeded(&output);
    assert!(found.contains("as they are damaged: 2"), "{found}");
    assert!(found.contains("annotated.mp4: 18 pictures"), "{found}");
    assert!(out.join("video.mp4").exists() && out.join("annotated.mp4").exists());
}

/// The film of 20 pictures of which these decode to other ones than in the run.
fn film_with_others(name: &str, others: &[u64]) -> (Output, PathBuf) {
    let (recording, out) = scene(name);
    record(&recording, (0..20).map(|index| (VideoNumber::First, intact(index))));
    let read = fs::read(&recording).unwrap();
    let entries = RecordingReader::new(&read[..]).map(|entry| match entry.unwrap() {
        Entry::Input { step, now, input: RecordedInput::Frame(seen) } if others.contains(&step) => {
            let input = RecordedInput::Frame(FrameFingerprint { luma_hash: !seen.luma_hash, ..seen });
            Entry::Input { step, now, input }
        }
        entry => entry,
    });
    write(&recording, &entries.collect::<Vec<_>>());
    (barrelman(&["export", "--annotated", "--output", argument(&out), argument(&recording)]), out)
}

#[test]
fn a_picture_that_decodes_to_another_one_is_left_out_of_the_film() {
    let (output, _) = film_with_others("films-another", &[5]);
    let found = succeeded(&output);
    assert!(found.contains("annotated.mp4: 19 pictures"), "{found}");
    assert!(found.contains("pictures left out of annotated.mp4: 1 (video frame 5 decodes"), "{found}");
}

#[test]
fn a_film_of_which_much_is_missing_is_none() {
    let (output, out) = film_with_others("films-others", &[5, 9, 12]);
    failed(&output, 1, &["3 of 20 pictures are missing: video frame 5 decodes to another picture"]);
    assert!(!out.join("annotated.mp4").exists());
}

#[test]
fn a_video_without_an_intact_picture_is_not_written() {
    let (recording, out) = scene("films-none");
    record(&recording, (0..3).map(|index| (VideoNumber::First, unit(index, vec![0; 100]))));
    let found = succeeded(&barrelman(&["export", "--output", argument(&out), argument(&recording)]));
    assert!(found.contains("as they are damaged: 3"), "{found}");
    assert!(!out.join("video.mp4").exists() && out.join("trial.csv").exists());
}
