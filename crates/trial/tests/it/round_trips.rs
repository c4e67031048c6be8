//! Entries are read as they were written, to the bit.

use core::time::Duration;
use std::cell::RefCell;
use std::io::Write;
use std::rc::Rc;

use barrelman_trial::records::{
    Entry, FrameFingerprint, ReadError, RecordedInput, RecordedOutcome, RecordingStart, RecordingWriter,
};
use barrelman_vocab::unit::UnitCodec;
use barrelman_vocab::video::{Capture, CaptureQuality};
use barrelman_vocab::{
    EncodedUnit, Picture, PictureSize, Timestamp, Track, VesselCommand, VesselRequest, VideoFrame,
};
use barrelman_vocab::{VehicleProfile, VideoNumber};
use proptest::prelude::*;

use crate::entries::{
    COLOURS, SENSOR, check, entries_with, every_kind, input, outcome, read, start, unit, written,
};

#[test]
fn a_recording_of_nothing_holds_its_start() {
    check(&[]);
}

#[test]
fn every_kind_of_entry_is_read_as_it_was_written() {
    for entry in every_kind() {
        check(&[entry]);
    }
    check(&every_kind());
}

#[test]
fn floats_at_their_limits_are_kept_to_the_bit() {
    for value in [
        0.0,
        0.1,
        1.0 / 3.0,
        f64::MAX,
        f64::MIN,
        f64::MIN_POSITIVE,
        f64::from_bits(1),
        f64::EPSILON,
        f64::INFINITY,
        f64::NEG_INFINITY,
        f64::NAN,
    ] {
        check(&entries_with(value));
    }
}

#[test]
fn a_request_with_a_number_that_json_cannot_carry_is_named_when_it_is_read() {
    let steer = VesselRequest::Steer(VesselCommand { throttle: f64::NAN, rudder: 0.0 });
    let (_, error) = read(&written(&[input(RecordedInput::Request(steer.into()))]));
    let Some(ReadError::Message { reason, .. }) = error else { panic!("{error:?}") };
    assert!(reason.contains("request is unreadable: invalid type: null"), "{reason}");
}

#[test]
fn a_zero_is_kept_without_its_sign() {
    let (found, error) = read(&written(&entries_with(-0.0)));
    assert!(error.is_none());
    assert_eq!(found[1..], entries_with(0.0));
}

#[test]
fn times_at_their_end_are_kept() {
    let end = Timestamp::from_nanos(u64::MAX);
    check(&[
        Entry::Input { step: u64::MAX, now: end, input: RecordedInput::Tick },
        Entry::Outcome(RecordedOutcome {
            step: u64::MAX,
            at: end,
            age: Some(Duration::from_nanos(u64::MAX)),
            wake_at: Some(end),
            track: Track::Lost { since: end, confidence: 0.5 },
            ..outcome(1.0)
        }),
        Entry::Unit(
            VideoNumber::First,
            EncodedUnit {
                epoch: u32::MAX,
                index: u64::MAX,
                capture: Capture { at: end, quality: CaptureQuality::Arrival },
                ..unit(UnitCodec::H264AnnexB, &[1])
            },
        ),
    ]);
}

#[test]
fn a_recording_may_start_at_any_time_of_any_clock() {
    let latest = RecordingStart { monotonic_ns: u64::MAX, unix_ns: u64::MAX, ..start() };
    let mut bytes = Vec::new();
    let mut writer = RecordingWriter::begin(&mut bytes, &latest, &VehicleProfile::fotokite_pro()).unwrap();
    writer.write(&Entry::Outcome(outcome(1.0))).unwrap();
    writer.finish().unwrap();
    let (found, error) = read(&bytes);
    assert!(error.is_none(), "{error:?}");
    assert_eq!(found, [Entry::Start(latest), Entry::Outcome(outcome(1.0))]);
}

#[test]
fn texts_of_any_kind_are_kept() {
    for notice in ["", "ü\u{1F6A3}", "a\nb\r\n\"c\",;", "\0"] {
        check(&[Entry::Outcome(RecordedOutcome { notice: notice.to_owned(), ..outcome(1.0) })]);
    }
}

#[test]
fn a_frame_is_told_by_its_luma_alone() {
    let picture = Picture::black(PictureSize::new(5, 3), COLOURS[0]);
    let stamp = |picture: &Picture| {
        let picture = std::sync::Arc::new(picture.clone());
        FrameFingerprint::from_frame(
            VideoNumber::First,
            &VideoFrame { sequence: 4, capture: SENSOR, picture },
        )
    };
    let black = stamp(&picture);
    assert_eq!((black.sequence, black.capture, black.size), (4, SENSOR, PictureSize::new(5, 3)));
    // XXH3-64 of fifteen zero bytes: the hash must be the same in every version.
    assert_eq!(black.luma_hash, xxhash_rust::xxh3::xxh3_64(&[0; 15]));
    let (mut brighter, mut bluer) = (picture.clone(), picture);
    brighter.planes_mut()[0][14] = 1;
    bluer.planes_mut()[1][0] = 200;
    assert_ne!(stamp(&brighter).luma_hash, black.luma_hash);
    assert_eq!(stamp(&bluer), black);
}

/// An output that can be read while it is written.
#[derive(Clone, Default)]
struct Shared(Rc<RefCell<Vec<u8>>>);

impl Write for Shared {
    fn write(&mut self, bytes: &[u8]) -> std::io::Result<usize> {
        self.0.borrow_mut().extend_from_slice(bytes);
        Ok(bytes.len())
    }

    fn flush(&mut self) -> std::io::Result<()> {
        Ok(())
    }
}

#[test]
fn what_was_flushed_can_be_read_while_the_recording_goes_on() {
    let output = Shared::default();
    let mut writer =
        RecordingWriter::begin(output.clone(), &start(), &VehicleProfile::fotokite_pro()).unwrap();
    let mut expected = vec![Entry::Start(start())];
    for entry in every_kind() {
        writer.write(&entry).unwrap();
        expected.push(entry);
        writer.flush().unwrap();
        let (found, error) = read(&output.0.borrow());
        assert!(matches!(error, Some(ReadError::Truncated)), "{error:?}");
        assert_eq!(found, expected);
    }
    writer.finish().unwrap();
    let (found, error) = read(&output.0.borrow());
    assert!(error.is_none());
    assert_eq!(found, expected);
}

#[test]
fn an_output_that_fails_is_an_error() {
    struct Full;
    impl Write for Full {
        fn write(&mut self, _: &[u8]) -> std::io::Result<usize> {
            Err(std::io::ErrorKind::StorageFull.into())
        }
        fn flush(&mut self) -> std::io::Result<()> {
            Ok(())
        }
    }
    assert!(RecordingWriter::begin(Full, &start(), &VehicleProfile::fotokite_pro()).is_err());
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]
    #[test]
    fn any_numbers_are_kept_to_the_bit(values in prop::collection::vec(any::<f64>(), 1..4)) {
        // A zero loses its sign.
        let values = values.into_iter().map(|value| if value == 0.0 { 0.0 } else { value });
        let entries: Vec<Entry> = values.flat_map(entries_with).collect();
        let (found, error) = read(&written(&entries));
        prop_assert!(error.is_none());
        prop_assert_eq!(format!("{:?}", &found[1..]), format!("{:?}", entries));
    }

    #[test]
    fn any_picture_is_kept(payload in prop::collection::vec(any::<u8>(), 0..2_000), step in any::<u64>()) {
        let unit = EncodedUnit { payload: payload.into(), ..unit(UnitCodec::H264AnnexB, &[]) };
        let entries = [Entry::Unit(VideoNumber::First, unit), Entry::Input { step, now: Timestamp::ZERO, input: RecordedInput::Tick }];
        let (found, error) = read(&written(&entries));
        prop_assert!(error.is_none());
        prop_assert_eq!(&found[1..], &entries[..]);
    }
}
