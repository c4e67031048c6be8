//! Outcomes as a trial log.

use barrelman_control::{Percept, Region};
use barrelman_trial::logs::recorded::Collector;
use barrelman_trial::records::RecordedOutcome;
use barrelman_vocab::{ImagePoint, Localisation, PictureSize, Timestamp, Track};

use crate::entries::{outcome, seen};
use crate::trial_logs::rates;

const POSITION: ImagePoint = ImagePoint { x: 3.0, y: 4.0 };

fn tracked(ms: u64) -> RecordedOutcome {
    let region = Region { a_px: 10.0, b_px: 10.0 };
    let track = Track::Tracking(Localisation { picture: PictureSize::new(320, 240), ..seen(1.0) });
    let at = Timestamp::from_nanos(ms * 1_000_000);
    RecordedOutcome { at, track, percept: Some(Percept::new(POSITION, region)), ..outcome(0.25) }
}

fn lost(ms: u64) -> RecordedOutcome {
    let since = Timestamp::from_nanos(0);
    RecordedOutcome { track: Track::Lost { since, confidence: 0.0 }, percept: None, ..tracked(ms) }
}

fn collected(outcomes: &[RecordedOutcome]) -> Option<barrelman_trial::logs::TrialLog> {
    let mut collector = Collector::default();
    outcomes.iter().for_each(|outcome| collector.take(outcome));
    collector.finish()
}

#[test]
fn a_recording_without_a_localisation_is_no_log() {
    assert_eq!(collected(&[]), None);
    assert_eq!(collected(&[lost(0), lost(100)]), None);
}

#[test]
fn a_log_begins_with_the_first_localisation() {
    let log = collected(&[lost(0), tracked(1_000), lost(1_250), tracked(1_500)]).unwrap();
    let rows: Vec<_> = log.rows.iter().map(|row| (row.time_s, row.position, row.rates)).collect();
    let told = Some(rates(0.25, 0.25));
    assert_eq!(rows, [(0.0, Some(POSITION), told), (0.25, None, told), (0.5, Some(POSITION), told)]);
    assert_eq!((log.last_row_s, log.knows_lost), (0.25, true));
    assert_eq!((log.frame, log.picture), (PictureSize::new(320, 240), PictureSize::new(320, 240)));
}
