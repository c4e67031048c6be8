//! The rule of motion: motion requires fresh localisations.

use core::time::Duration;

use barrelman_control::{Region, Sector};
use barrelman_pilot::Mode::{Holding, Servoing};
use barrelman_pilot::{Input, Notice};
use barrelman_vocab::HoldCause::{Coasting, NoSelection, TrackLost, VideoSilent, VideoStale};
use barrelman_vocab::{Timestamp, Track};

use crate::scenes::SceneInput::{Coasts, Engage, Lost, Reports, Seen, SeenLate, Select, Tick, Unseeded};
use crate::scenes::{
    BOTTOM, COAST_MS, FRESH_MS, INSIDE, LEFT, PAN_LEFT, PAN_RIGHT, REST, RIGHT, TILT_UP, TOP,
};
use crate::scenes::{at, check, localisation_pilot, outcomes, seen};

#[test]
fn a_rate_ends_at_coast_motion_after_the_last_fresh_look_and_not_before() {
    let last = COAST_MS + 10;
    check(&[(0, Engage), (10, Seen(RIGHT)), (last - 1, Tick)], Servoing, PAN_RIGHT);
    check(&[(0, Engage), (10, Seen(RIGHT)), (last, Tick)], Holding(VideoSilent), REST);
    check(&[(0, Engage), (10, Seen(RIGHT)), (last + 5_000, Tick)], Holding(VideoSilent), REST);
    check(&[(0, Engage), (10, Seen(RIGHT)), (last, Reports)], Holding(VideoSilent), REST);
    check(&[(0, Engage), (10, Seen(RIGHT)), (last, Engage)], Holding(VideoSilent), REST);
}

#[test]
fn the_pilot_asks_to_be_called_at_the_very_time_of_the_zeros() {
    let mut pilot = localisation_pilot();
    pilot.step(Engage.input(at(0)), at(0));
    let moving = pilot.step(Seen(RIGHT).input(at(10)), at(10));
    assert_eq!(moving.wake_at, Some(at(10 + COAST_MS)));
    let coasting = pilot.step(Coasts(RIGHT).input(at(60)), at(60));
    assert_eq!((coasting.command, coasting.wake_at), (PAN_RIGHT, moving.wake_at));
    let reported = pilot.step(Reports.input(at(70)), at(70));
    assert_eq!((reported.command, reported.wake_at), (PAN_RIGHT, moving.wake_at));
    let zeros_at = moving.wake_at.unwrap();
    let before = Timestamp::from_nanos(zeros_at.as_nanos() - 1);
    assert_eq!(pilot.step(Input::Tick, before).command, PAN_RIGHT);
    let rested = pilot.step(Input::Tick, zeros_at);
    assert_eq!((rested.command, rested.wake_at), (REST, None));
}

#[test]
fn every_fresh_look_puts_the_zeros_off() {
    let scene = [(0, Engage), (10, Seen(RIGHT)), (200, Seen(RIGHT)), (400, Tick)];
    check(&scene, Servoing, PAN_RIGHT);
    check(&[scene.as_slice(), &[(200 + COAST_MS, Tick)]].concat(), Holding(VideoSilent), REST);
}

#[test]
fn a_look_moves_the_camera_up_to_the_age_at_which_it_is_stale() {
    check(&[(0, Engage), (10, SeenLate(RIGHT, 0))], Servoing, PAN_RIGHT);
    check(&[(0, Engage), (10, SeenLate(RIGHT, FRESH_MS))], Servoing, PAN_RIGHT);
    check(&[(0, Engage), (10, SeenLate(RIGHT, FRESH_MS + 1))], Holding(VideoStale), REST);
    check(&[(0, Engage), (10, SeenLate(RIGHT, 9_000))], Holding(VideoStale), REST);
}

#[test]
fn a_stale_look_neither_starts_nor_prolongs_nor_turns_a_rate() {
    let moving = [(0, Engage), (10, Seen(RIGHT))];
    let then = |input| [moving.as_slice(), &[(100, input)]].concat();
    check(&then(SeenLate(LEFT, FRESH_MS + 1)), Servoing, PAN_RIGHT);
    check(&then(SeenLate(TOP, FRESH_MS + 1)), Servoing, PAN_RIGHT);
    let expired = |input| [then(input).as_slice(), &[(10 + COAST_MS, Tick)]].concat();
    check(&expired(SeenLate(RIGHT, FRESH_MS + 1)), Holding(VideoStale), REST);
    check(&expired(Lost), Holding(TrackLost), REST);
    check(&expired(Unseeded), Holding(NoSelection), REST);
}

#[test]
fn coasting_only_lowers_a_rate() {
    let moving = [(0, Engage), (10, Seen(RIGHT))];
    let then = |input| [moving.as_slice(), &[(20, input)]].concat();
    check(&then(Coasts(RIGHT)), Servoing, PAN_RIGHT);
    check(&then(Coasts(INSIDE)), Servoing, REST);
    check(&then(Coasts(LEFT)), Servoing, REST);
    check(&then(Coasts(TOP)), Servoing, REST);
    check(&then(Coasts(BOTTOM)), Servoing, REST);
    check(&[then(Coasts(INSIDE)).as_slice(), &[(30, Coasts(RIGHT))]].concat(), Servoing, REST);
    check(&[(0, Engage), (10, Coasts(RIGHT))], Holding(Coasting), REST);
    check(&[(0, Engage), (10, Seen(INSIDE)), (20, Coasts(RIGHT))], Servoing, REST);
}

#[test]
fn a_coasting_look_that_is_stale_changes_nothing() {
    let mut pilot = localisation_pilot();
    pilot.step(Engage.input(at(0)), at(0));
    pilot.step(Seen(RIGHT).input(at(10)), at(10));
    let stale = Track::Coasting(seen(INSIDE, at(0).minus(Duration::from_millis(FRESH_MS))));
    assert_eq!(pilot.step(Input::Localisation(stale), at(20)).command, PAN_RIGHT);
}

#[test]
fn the_step_that_sees_the_target_back_inside_gives_the_zeros() {
    for (outside, _) in [(RIGHT, 0), (LEFT, 1), (TOP, 2), (BOTTOM, 3)] {
        check(&[(0, Engage), (10, Seen(outside)), (43, Seen(INSIDE))], Servoing, REST);
    }
}

#[test]
fn a_change_of_sector_zeroes_the_axis_that_is_left() {
    check(&[(0, Engage), (10, Seen(RIGHT)), (43, Seen(TOP))], Servoing, TILT_UP);
    check(&[(0, Engage), (10, Seen(TOP)), (43, Seen(RIGHT))], Servoing, PAN_RIGHT);
    check(&[(0, Engage), (10, Seen(RIGHT)), (43, Seen(LEFT))], Servoing, PAN_LEFT);
}

#[test]
fn a_new_selection_rests_the_camera_until_its_target_is_seen() {
    let selecting = [(0, Engage), (10, Seen(RIGHT)), (20, Select)];
    let last = outcomes(&selecting).pop().unwrap();
    assert_eq!((last.command, last.wake_at), (REST, None));
    let then = |input| [selecting.as_slice(), &[(30, input)]].concat();
    assert_eq!(outcomes(&then(Tick)).pop().unwrap().command, REST);
    assert_eq!(outcomes(&then(Coasts(RIGHT))).pop().unwrap().command, REST);
    check(&then(Seen(LEFT)), Servoing, PAN_LEFT);
}

#[test]
fn advice_is_given_whether_or_not_the_camera_may_move() {
    let idle = outcomes(&[(0, Seen(RIGHT))]).pop().unwrap();
    let advice = idle.advice.unwrap();
    assert_eq!((idle.command, advice.command, advice.sector), (REST, PAN_RIGHT, Some(Sector::Right)));
    let inside = outcomes(&[(0, Seen(INSIDE))]).pop().unwrap();
    assert_eq!(inside.advice.unwrap().sector, None);
    assert_eq!(inside.percept.unwrap().position, INSIDE);
    let lost = outcomes(&[(0, Seen(RIGHT)), (10, Lost)]).pop().unwrap();
    assert_eq!((lost.percept, lost.advice), (None, None));
}

#[test]
fn the_age_is_that_of_what_was_seen_in_this_step() {
    let ages: Vec<_> =
        outcomes(&[(0, Seen(RIGHT)), (10, SeenLate(RIGHT, 40)), (20, Tick), (30, Coasts(RIGHT)), (40, Lost)])
            .iter()
            .map(|outcome| outcome.age)
            .collect();
    let ms = |ms| Some(Duration::from_millis(ms));
    assert_eq!(ages, [ms(200), ms(40), None, ms(200), None]);
}

#[test]
fn a_video_clock_that_runs_back_is_noticed_once() {
    let notices: Vec<_> = outcomes(&[
        (0, SeenLate(RIGHT, 100)),
        (10, SeenLate(RIGHT, 110)),
        (20, SeenLate(RIGHT, 121)),
        (30, SeenLate(RIGHT, 100)),
    ])
    .into_iter()
    .map(|outcome| outcome.notice)
    .collect();
    assert_eq!(notices, [None, None, Some(Notice::VideoClockWentBack), None]);
}

#[test]
fn a_lost_track_says_nothing_of_the_video_clock() {
    let outcomes =
        outcomes(&[(0, Seen(RIGHT)), (33, Lost), (66, Seen(RIGHT)), (99, Unseeded), (132, Seen(RIGHT))]);
    for outcome in outcomes {
        assert_eq!(outcome.notice, None, "at {}", outcome.at);
    }
}

#[test]
fn a_clock_that_runs_back_rests_the_camera() {
    let scene = [(0, Engage), (1_000, Seen(RIGHT)), (900, Tick)];
    let last = outcomes(&scene).pop().unwrap();
    assert_eq!((last.command, last.wake_at), (REST, None));
    check(&[scene.as_slice(), &[(910, Seen(RIGHT))]].concat(), Servoing, PAN_RIGHT);
}

#[test]
fn the_region_is_that_of_the_newest_picture() {
    let regions: Vec<_> = outcomes(&[(0, Tick), (10, Lost), (20, Seen(RIGHT)), (30, Tick), (40, Lost)])
        .into_iter()
        .map(|outcome| outcome.region)
        .collect();
    let region = Some(Region { a_px: 192.0, b_px: 120.0 });
    assert_eq!(regions, [None, None, region, region, region]);
}
