//! Units decoded: live and from a file, with pictures missing, and over epochs.

use barrelman_video::decoder::UnitDecoder;
use barrelman_video::mode::DecodeMode;

use crate::clips::{decode, units};

#[test]
fn the_same_units_give_the_same_frames_live_and_from_a_file() {
    let units = units("baseline.mp4");
    let (file, _) = decode(&units, DecodeMode::File);
    let mut decoder = UnitDecoder::new(DecodeMode::Live);
    for (unit, expected) in units.iter().zip(&file) {
        let mut at_once = None;
        decoder.decode(unit, &mut |frame| at_once = Some(frame)).unwrap();
        let frame = at_once.expect("live, each unit gives its picture at once");
        assert_eq!((frame.sequence, frame.capture), (expected.sequence, unit.capture));
        assert_eq!(frame.picture, expected.picture);
    }
}

#[test]
fn a_live_stream_with_bidirectional_pictures_is_put_in_order() {
    let (frames, errors) = decode(&units("high_b.mp4"), DecodeMode::Live);
    assert_eq!(errors, []);
    assert_eq!(frames.len(), 20);
    assert!(frames.is_sorted_by_key(|frame| frame.capture.at));
}

#[test]
fn after_a_missing_picture_nothing_is_shown_until_the_next_key_frame() {
    for file in ["baseline.mp4", "high_b.mp4"] {
        for mode in [DecodeMode::Live, DecodeMode::File] {
            let units = units(file);
            let (whole, _) = decode(&units, mode);
            let mut cut = units.clone();
            let missing = cut.remove(3);
            assert!(!missing.key);
            let (frames, _) = decode(&cut, mode);
            let next_key = units.iter().skip(3).find(|unit| unit.key).unwrap();
            assert!(frames.iter().any(|frame| frame.capture.at >= next_key.capture.at), "{file}: goes on");
            for frame in &frames {
                let same = whole.iter().find(|other| other.capture.at == frame.capture.at).unwrap();
                assert!(
                    same.picture == frame.picture,
                    "{file}, {mode:?}: not intact at {}",
                    frame.capture.at
                );
            }
        }
    }
}

#[test]
fn a_new_epoch_waits_for_a_key_frame_and_goes_on_counting() {
    let mut units = units("baseline.mp4");
    units.truncate(15);
    let mut second = units.split_off(5);
    second.iter_mut().for_each(|unit| unit.epoch = 1);
    let key = second.iter().position(|unit| unit.key).unwrap();
    units.extend(second);
    let (frames, errors) = decode(&units, DecodeMode::Live);
    assert_eq!(errors, []);
    assert_eq!(frames.len(), 15 - key);
    assert!(frames.iter().enumerate().all(|(index, frame)| frame.sequence == index as u64));
}
