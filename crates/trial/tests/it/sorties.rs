//! The summary of a sortie from the entries of its recording.

use std::io::Cursor;

use barrelman_pilot::Mode;
use barrelman_trial::records::table::read_rows;
use barrelman_trial::records::{
    Entry, ReadError, RecordedInput, RecordedOutcome, RecordingWriter, read_sortie,
};
use barrelman_trial::sortie::{Happening, Sortie, SortieObserver, Spells};
use barrelman_vocab::{
    AngularRate, CameraCommand, CameraRequest, HoldCause, Note, OperatorRequest, PixelBox, StopCause,
    Timestamp, Track, VehicleProfile, VehicleRates,
};

use crate::entries::{outcome, read, start};
use crate::trial_logs::rates;

const TURNING: CameraCommand =
    CameraCommand::turning(AngularRate::from_radians_per_second(0.3), AngularRate::ZERO);

/// An outcome at a time, ms, with the camera turning while it follows.
fn at(ms: u64, mode: Mode) -> RecordedOutcome {
    let (command, sent) = match mode {
        Mode::Servoing => (TURNING, rates(0.3, 0.0)),
        _ => (CameraCommand::REST, VehicleRates::REST),
    };
    RecordedOutcome { at: Timestamp::from_nanos(ms * 1_000_000), mode, command, rates: sent, ..outcome(0.1) }
}

fn lost(ms: u64, mode: Mode) -> RecordedOutcome {
    let track = Track::Lost { since: Timestamp::ZERO, confidence: 0.0 };
    RecordedOutcome { track, percept: None, ..at(ms, mode) }
}

fn observed(entries: impl IntoIterator<Item = Entry>) -> Sortie {
    let mut observer = SortieObserver::new(VehicleProfile::fotokite_pro());
    entries.into_iter().for_each(|entry| observer.add(&entry));
    observer.finish()
}

/// A moment that somebody marked.
fn noted() -> Entry {
    let text = "smoke at the pier".to_owned().try_into().unwrap();
    Entry::Note { at: Timestamp::from_nanos(5_500_000_000), note: Note { text } }
}

fn sortie() -> Sortie {
    let select =
        OperatorRequest::Camera(CameraRequest::SelectNext(PixelBox { u: 1.0, v: 2.0, w: 30.0, h: 40.0 }));
    let input = RecordedInput::Request(select);
    let selected = Entry::Input { step: 1, now: Timestamp::from_nanos(2_000_000_000), input };
    let outcomes = [
        at(1_000, Mode::Idle),
        at(3_000, Mode::Servoing),
        at(5_000, Mode::Holding(HoldCause::VideoStale)),
        lost(6_000, Mode::Holding(HoldCause::TrackLost)),
        at(8_500, Mode::Servoing),
        at(9_000, Mode::Stopped(StopCause::Operator)),
        at(10_000, Mode::Idle),
        at(11_000, Mode::Stopped(StopCause::Ending)),
    ];
    let mut entries: Vec<Entry> = outcomes.map(Entry::Outcome).into();
    entries.insert(0, Entry::Start(start()));
    entries.insert(2, selected);
    entries.insert(5, noted());
    observed(entries)
}

#[test]
fn the_figures_of_a_sortie_are_those_of_its_outcomes() {
    let sortie = sortie();
    assert_eq!(sortie.began_unix_ns, start().unix_ns + 1_000_000_000);
    assert_eq!((sortie.length_s, sortie.engaged_s, sortie.followed_s), (10.0, 6.0, 3.5));
    assert_eq!(sortie.losses, Spells { count: 1, total_s: 2.5, longest_s: 2.5 });
    assert_eq!(sortie.holds["video-stale"], Spells { count: 1, total_s: 1.0, longest_s: 1.0 });
    assert_eq!(sortie.holds["track-lost"].total_s, 2.5);
    // The end of the program is no stop.
    assert_eq!(sortie.stops.iter().collect::<Vec<_>>(), [(&"operator".to_owned(), &1)]);
    assert_eq!(sortie.camera.moves, 2);
    assert!((sortie.camera.travel_rad - 0.3 * 2.5).abs() < 1e-9, "{:?}", sortie.camera);
}

#[test]
fn a_boat_is_known_while_it_is_measured_or_predicted() {
    let known_s = |track: Track| {
        let engaged = [1_000, 3_000].map(|ms| RecordedOutcome { track, ..at(ms, Mode::Servoing) });
        let sortie = observed(engaged.map(Entry::Outcome));
        (sortie.engaged_s, sortie.followed_s)
    };
    let seen = *outcome(0.1).track.localisation().unwrap();
    assert_eq!(known_s(Track::Tracking(seen)), (2.0, 2.0));
    assert_eq!(known_s(Track::Coasting(seen)), (2.0, 2.0));
    assert_eq!(known_s(Track::Lost { since: Timestamp::ZERO, confidence: 0.0 }), (2.0, 0.0));
    assert_eq!(known_s(Track::Unseeded), (2.0, 0.0), "nothing is selected");
}

#[test]
fn the_moments_of_a_sortie_are_in_the_order_of_time() {
    let moments: Vec<_> = sortie().moments.iter().map(|moment| (moment.at_s, moment.what.clone())).collect();
    assert_eq!(
        moments,
        [
            (1.0, Happening::Selected),
            (2.0, Happening::Engaged),
            (4.5, Happening::Noted { text: "smoke at the pier".to_owned().try_into().unwrap() }),
            (5.0, Happening::Lost),
            (7.5, Happening::Found),
            (8.0, Happening::Stopped { cause: StopCause::Operator }),
            (10.0, Happening::Stopped { cause: StopCause::Ending }),
        ]
    );
}

#[test]
fn a_run_without_an_outcome_is_an_empty_sortie() {
    let empty = Sortie { region: [0.6, 0.5], ..Sortie::default() };
    assert_eq!(observed([]), empty);
}

#[test]
fn a_recording_gives_its_summary_back_without_its_messages() {
    let mut bytes = Vec::new();
    let mut writer = RecordingWriter::begin(&mut bytes, &start(), &VehicleProfile::fotokite_pro()).unwrap();
    writer.write(&Entry::Outcome(outcome(1.0))).unwrap();
    let sortie = writer.finish().unwrap();
    assert_eq!(sortie.video, start().videos.first.address);
    assert_eq!(read_sortie(Cursor::new(&bytes)).unwrap(), Some(sortie));
    // A summary stands at the end: a recording that was cut has none, and any cut is survived.
    for length in (0..bytes.len()).step_by(97) {
        assert_eq!(read_sortie(Cursor::new(&bytes[..length])).unwrap(), None, "{length} bytes");
    }
}

#[test]
fn what_is_no_recording_has_no_summary() {
    for bytes in [&b""[..], b"no recording at all, but longer than the magic bytes"] {
        assert_eq!(read_sortie(Cursor::new(bytes)).unwrap(), None);
    }
}

#[test]
fn what_other_programs_show_is_left_out_by_the_reader() {
    let outcomes = [at(1_000, Mode::Idle), at(2_000, Mode::Servoing), lost(3_000, Mode::Servoing)];
    let mut bytes = Vec::new();
    let mut writer = RecordingWriter::begin(&mut bytes, &start(), &VehicleProfile::fotokite_pro()).unwrap();
    outcomes.iter().for_each(|outcome| writer.write(&Entry::Outcome(outcome.clone())).unwrap());
    writer.finish().unwrap();
    let (found, error) = read(&bytes);
    assert!(error.is_none(), "{error:?}");
    assert_eq!(found[1..], outcomes.map(Entry::Outcome));
    let mut topics = Vec::new();
    let read = read_rows(&bytes[..], |row| -> Result<(), ReadError> {
        topics.push(row.topic);
        Ok(())
    });
    read.unwrap();
    let count = |topic: &str| topics.iter().filter(|found| found == &topic).count();
    // Each mode once, with the notice of every outcome; a lost boat has no box.
    assert_eq!((count("/video/annotations"), count("/log"), count("/boat/location")), (2, 3, 3));
}
