//! The log of a trial from the outcomes of a recording.

use core::time::Duration;

use barrelman_control::{Percept, Region};
use barrelman_trial::logs::recorded::LogBuilder;
use barrelman_trial::records::{RecordedOutcome, RecordedTruth};
use barrelman_vocab::{ImagePoint, Localisation, PictureSize, Timestamp, Track};

use crate::entries::{localisation, outcome, truth};
use crate::trial_logs::command;

const POSITION: ImagePoint = ImagePoint { x: 3.0, y: 4.0 };

fn tracked(ms: u64) -> RecordedOutcome {
    let region = Region { a_px: 10.0, b_px: 10.0 };
    let track = Track::Tracking(Localisation { picture: PictureSize::new(320, 240), ..localisation(1.0) });
    let at = Timestamp::from_nanos(ms * 1_000_000);
    RecordedOutcome { at, track, percept: Some(Percept::new(POSITION, region)), ..outcome(0.25) }
}

fn lost(ms: u64) -> RecordedOutcome {
    let since = Timestamp::from_nanos(0);
    RecordedOutcome { track: Track::Lost { since, confidence: 0.0 }, percept: None, ..tracked(ms) }
}

fn collected(outcomes: &[RecordedOutcome]) -> Option<barrelman_trial::logs::TrialLog> {
    let mut builder = LogBuilder::default();
    outcomes.iter().for_each(|outcome| builder.add_outcome(outcome));
    builder.finish()
}

#[test]
fn a_recording_without_a_localisation_is_no_log() {
    assert_eq!(collected(&[]), None);
    assert_eq!(collected(&[lost(0), lost(100)]), None);
}

#[test]
fn a_log_begins_with_the_first_localisation() {
    let log = collected(&[lost(0), tracked(1_000), lost(1_250), tracked(1_500)]).unwrap();
    let rows: Vec<_> = log.rows.iter().map(|row| (row.time_s, row.position, row.command)).collect();
    let commanded = Some(command(0.25, 0.25));
    assert_eq!(
        rows,
        [(0.0, Some(POSITION), commanded), (0.25, None, commanded), (0.5, Some(POSITION), commanded)]
    );
    assert_eq!((log.last_row_duration_s, log.records_track_loss), (0.25, true));
    assert_eq!((log.frame, log.picture), (PictureSize::new(320, 240), PictureSize::new(320, 240)));
}

/// An event in a recording of a simulated world.
enum Event {
    /// A picture is captured at this time, ms, with the target in it or not.
    Picture(u64, bool),
    /// A step at this time, ms, localises the target in a picture that is 100 ms old.
    Found(u64),
    /// A step at this time, ms, has no localisation.
    Missed(u64),
}

/// Whether the target was out of the picture, row by row.
fn out_of_picture(events: &[Event]) -> Option<Vec<bool>> {
    let mut builder = LogBuilder::default();
    for event in events {
        match *event {
            Event::Picture(ms, in_picture) => {
                let at = Timestamp::from_nanos(ms * 1_000_000);
                builder.add_truth(RecordedTruth { in_picture, ..truth(at) });
            }
            Event::Found(ms) => {
                let age = Some(Duration::from_millis(100));
                builder.add_outcome(&RecordedOutcome { age, ..tracked(ms) });
            }
            Event::Missed(ms) => builder.add_outcome(&RecordedOutcome { age: None, ..lost(ms) }),
        }
    }
    let rows = builder.finish().unwrap().truth?;
    Some(rows.iter().map(|row| row.out_of_picture).collect())
}

#[test]
fn a_row_goes_by_what_was_true_as_its_picture_was_taken() {
    use Event::{Found, Missed, Picture};
    assert_eq!(out_of_picture(&[Found(100)]), None, "not a recording of a simulated world");
    let seen = [Picture(0, true), Picture(50, false), Found(100), Found(150), Picture(100, true), Found(200)];
    assert_eq!(out_of_picture(&seen), Some(vec![false, true, false]));
    // A picture without a localisation has no row: the row before stands for it.
    let gap =
        [Picture(0, true), Found(100), Picture(100, false), Missed(200), Picture(200, true), Found(300)];
    assert_eq!(out_of_picture(&gap), Some(vec![true, false]));
    let at_end = [Picture(0, true), Found(100), Picture(100, false), Missed(200)];
    assert_eq!(out_of_picture(&at_end), Some(vec![true]));
    let in_flight = [Picture(0, true), Found(100), Picture(90, false)];
    assert_eq!(out_of_picture(&in_flight), Some(vec![false]), "this picture never arrived");
    let pictures = (1..2_000).map(|index| Picture(index * 10, index == 1));
    let long: Vec<Event> = [Picture(0, true), Found(100)].into_iter().chain(pictures).collect();
    assert_eq!(
        out_of_picture(&long),
        Some(vec![true]),
        "the pictures in flight are bounded, and none is forgotten"
    );
}
