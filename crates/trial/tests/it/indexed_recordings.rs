//! Reading a recording from any time on.

use std::io::Cursor;
use std::time::Duration;

use barrelman_trial::records::{Entry, IndexedRecording, RecordedOutcome, RecordingWriter};
use barrelman_vocab::unit::UnitCodec;
use barrelman_vocab::video::{Capture, CaptureQuality};
use barrelman_vocab::{EncodedUnit, Timestamp, VehicleProfile, VideoNumber};

use crate::entries::{outcome, start, unit};

fn ms(ms: u64) -> Timestamp {
    Timestamp::ZERO.plus(Duration::from_millis(ms))
}

/// Three seconds of two videos, a unit each 100 ms, a key unit a second; an outcome 20 ms after each.
/// Flushed, and so in a chunk of its own, each half second.
fn recording() -> Vec<u8> {
    let mut bytes = Vec::new();
    let mut writer = RecordingWriter::begin(&mut bytes, &start(), &VehicleProfile::fotokite_pro()).unwrap();
    for index in 0..30_u64 {
        let at = ms(1_000 + 100 * index);
        for video in VideoNumber::ALL {
            // The second video's key units come between those of the first.
            let key = index % 10 == if video == VideoNumber::First { 0 } else { 5 };
            let capture = Capture { at, quality: CaptureQuality::Sender };
            let unit = EncodedUnit { capture, index, key, ..unit(UnitCodec::H264AnnexB, b"unit") };
            writer.write(&Entry::Unit(video, unit)).unwrap();
        }
        let at = at.plus(Duration::from_millis(20));
        writer.write(&Entry::Outcome(RecordedOutcome { at, step: index, ..outcome(1.0) })).unwrap();
        if index % 5 == 4 {
            writer.flush().unwrap();
        }
    }
    writer.finish().unwrap();
    bytes
}

fn open(bytes: &[u8]) -> IndexedRecording<Cursor<&[u8]>> {
    IndexedRecording::open(Cursor::new(bytes)).unwrap().unwrap()
}

#[test]
fn a_recording_is_read_from_a_time_on_and_no_further_than_wanted() {
    let bytes = recording();
    let mut recording = open(&bytes);
    assert_eq!(recording.start(), &start());
    let mut seen = Vec::new();
    recording
        .entries_from(ms(2_500), |entry| {
            seen.push(match entry {
                Entry::Unit(video, unit) => format!("{} {}", video.count(), unit.index),
                Entry::Outcome(outcome) => format!("step {}", outcome.step),
                other => panic!("{other:?}"),
            });
            seen.len() < 5
        })
        .unwrap();
    assert_eq!(seen, ["1 15", "2 15", "step 15", "1 16", "2 16"]);
}

#[test]
fn the_newest_key_unit_of_a_video_is_found() {
    let bytes = recording();
    let mut recording = open(&bytes);
    for (video, at, found) in [
        (VideoNumber::First, 1_000, Some(1_000)),
        (VideoNumber::First, 2_999, Some(2_000)),
        (VideoNumber::First, 3_000, Some(3_000)),
        (VideoNumber::First, 99_000, Some(3_000)),
        (VideoNumber::Second, 2_999, Some(2_500)),
        (VideoNumber::Second, 1_400, None),
    ] {
        let key = recording.key_unit_before(video, ms(at)).unwrap();
        assert_eq!(key, found.map(ms), "{video:?} {at}");
    }
}

#[test]
fn a_recording_that_was_cut_off_has_no_index_and_damage_is_an_error() {
    let bytes = recording();
    for length in (0..bytes.len()).step_by(61) {
        assert!(IndexedRecording::open(Cursor::new(&bytes[..length])).is_ok_and(|found| found.is_none()));
    }
    for at in (8..bytes.len()).step_by(101) {
        let mut damaged = bytes.clone();
        damaged[at] ^= 0x5a;
        let Ok(Some(mut recording)) = IndexedRecording::open(Cursor::new(&damaged)) else { continue };
        let _ = recording.key_unit_before(VideoNumber::First, ms(2_500));
        let _ = recording.entries_from(ms(0), |_| true);
    }
}
