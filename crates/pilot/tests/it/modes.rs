//! Every transition of the diagram of modes.

use barrelman_pilot::Mode::{Holding, Idle, Servoing, Stopped};
use barrelman_vocab::HoldCause::{Coasting, NoSelection, TrackLost, VideoSilent, VideoStale};
use barrelman_vocab::StopCause::{Ending, Fault, Operator, VideoEnded};

use crate::scenes::SceneInput::{
    Coasts, Disengage, Engage, Lost, Reports, Seen, SeenLate, Select, Stop, Tick, Unseeded,
};
use crate::scenes::{
    BOTTOM, COAST_MS, INSIDE, LEFT, PAN_LEFT, PAN_RIGHT, REST, RIGHT, TILT_DOWN, TILT_UP, TOP,
};
use crate::scenes::{check, localisation_pilot};

#[test]
fn a_new_pilot_is_idle_and_asks_for_no_call() {
    let outcome = localisation_pilot().step(barrelman_pilot::Input::Tick, crate::scenes::at(0));
    assert_eq!((outcome.mode, outcome.command, outcome.wake_at), (Idle, REST, None));
    assert_eq!((outcome.age, outcome.percept, outcome.advice), (None, None, None));
}

#[test]
fn idle_stays_idle_until_engaged() {
    check(&[(0, Seen(RIGHT))], Idle, REST);
    check(&[(0, Coasts(RIGHT))], Idle, REST);
    check(&[(0, Lost)], Idle, REST);
    check(&[(0, Select)], Idle, REST);
    check(&[(0, Disengage)], Idle, REST);
    check(&[(0, Reports)], Idle, REST);
    check(&[(0, Seen(RIGHT)), (10, Tick)], Idle, REST);
}

#[test]
fn engaging_holds_until_there_is_something_fresh() {
    check(&[(0, Engage)], Holding(NoSelection), REST);
    check(&[(0, Lost), (10, Engage)], Holding(TrackLost), REST);
    check(&[(0, Coasts(RIGHT)), (10, Engage)], Holding(Coasting), REST);
    check(&[(0, SeenLate(RIGHT, 501)), (10, Engage)], Holding(VideoStale), REST);
    check(&[(0, Seen(RIGHT)), (COAST_MS, Engage)], Holding(VideoSilent), REST);
}

#[test]
fn engaging_on_a_fresh_look_servoes_but_moves_with_the_next_look_only() {
    check(&[(0, Seen(RIGHT)), (10, Engage)], Servoing, REST);
    check(&[(0, Seen(RIGHT)), (10, Engage), (20, Tick)], Servoing, REST);
    check(&[(0, Seen(RIGHT)), (10, Engage), (20, Coasts(RIGHT))], Servoing, REST);
    check(&[(0, Seen(RIGHT)), (10, Engage), (30, Seen(RIGHT))], Servoing, PAN_RIGHT);
}

#[test]
fn a_fresh_localisation_ends_holding() {
    check(&[(0, Engage), (10, Seen(INSIDE))], Servoing, REST);
    check(&[(0, Engage), (10, Seen(RIGHT))], Servoing, PAN_RIGHT);
    check(&[(0, Engage), (10, Seen(LEFT))], Servoing, PAN_LEFT);
    check(&[(0, Engage), (10, Seen(TOP))], Servoing, TILT_UP);
    check(&[(0, Engage), (10, Seen(BOTTOM))], Servoing, TILT_DOWN);
    check(&[(0, Engage), (10, Lost), (20, Seen(RIGHT))], Servoing, PAN_RIGHT);
}

#[test]
fn nothing_fresh_for_coast_motion_ends_servoing_and_names_the_cause() {
    let after = |input| [(0, Engage), (10, Seen(RIGHT)), (20, input), (10 + COAST_MS, Tick)];
    check(&after(Tick), Holding(VideoSilent), REST);
    check(&after(Coasts(RIGHT)), Holding(Coasting), REST);
    check(&after(Lost), Holding(TrackLost), REST);
    check(&after(Unseeded), Holding(NoSelection), REST);
    check(&after(SeenLate(RIGHT, 501)), Holding(VideoStale), REST);
}

#[test]
fn disengaging_rests_the_camera_from_every_mode() {
    check(&[(0, Disengage)], Idle, REST);
    check(&[(0, Engage), (10, Disengage)], Idle, REST);
    check(&[(0, Engage), (10, Seen(RIGHT)), (20, Disengage)], Idle, REST);
    check(&[(0, Stop(Operator)), (20, Disengage)], Idle, REST);
    check(&[(0, Engage), (10, Seen(RIGHT)), (20, Disengage), (30, Seen(RIGHT))], Idle, REST);
}

#[test]
fn a_stop_stops_from_every_mode_with_its_cause() {
    for cause in [Operator, Ending, VideoEnded, Fault] {
        check(&[(0, Stop(cause))], Stopped(cause), REST);
        check(&[(0, Engage), (10, Stop(cause))], Stopped(cause), REST);
        check(&[(0, Engage), (10, Seen(RIGHT)), (20, Stop(cause))], Stopped(cause), REST);
    }
}

#[test]
fn a_stop_keeps_its_first_cause_until_engaged_anew() {
    check(&[(0, Stop(Operator)), (0, Stop(Fault))], Stopped(Operator), REST);
    check(&[(0, Stop(Fault)), (9, Stop(Ending)), (9, Stop(Operator))], Stopped(Fault), REST);
    check(&[(0, Stop(Operator)), (1, Engage), (2, Stop(Fault))], Stopped(Fault), REST);
}

#[test]
fn a_stop_outranks_everything_also_in_the_same_instant() {
    check(&[(0, Engage), (10, Stop(Operator)), (10, Seen(RIGHT))], Stopped(Operator), REST);
    check(&[(0, Engage), (10, Seen(RIGHT)), (10, Stop(Operator))], Stopped(Operator), REST);
    check(&[(0, Engage), (10, Seen(RIGHT)), (10, Stop(Operator)), (10, Seen(TOP))], Stopped(Operator), REST);
    check(&[(0, Engage), (0, Stop(Operator)), (0, Seen(RIGHT)), (0, Tick)], Stopped(Operator), REST);
}

#[test]
fn after_a_stop_nothing_but_engage_moves_the_camera() {
    let moving = [(0, Engage), (10, Seen(RIGHT)), (20, Stop(Operator))];
    let stopped = |input| [moving.as_slice(), &[(30, input), (40, Seen(RIGHT))]].concat();
    check(&stopped(Seen(RIGHT)), Stopped(Operator), REST);
    check(&stopped(Coasts(RIGHT)), Stopped(Operator), REST);
    check(&stopped(Select), Stopped(Operator), REST);
    check(&stopped(Reports), Stopped(Operator), REST);
    check(&stopped(Tick), Stopped(Operator), REST);
    check(&stopped(Disengage), Idle, REST);
    check(&stopped(Engage), Servoing, PAN_RIGHT);
}

#[test]
fn engaging_after_a_stop_does_not_bring_the_old_rate_back() {
    let scene = [(0, Engage), (10, Seen(RIGHT)), (20, Stop(Operator)), (30, Engage)];
    check(&scene, Servoing, REST);
}

#[test]
fn engaging_twice_changes_nothing() {
    check(&[(0, Engage), (10, Seen(RIGHT)), (20, Engage)], Servoing, PAN_RIGHT);
}
