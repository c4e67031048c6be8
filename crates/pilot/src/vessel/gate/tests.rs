//! One test for each edge of the modes, and for what each command needs.

use super::*;
use crate::refusal::Refusal;
use barrelman_vocab::{HoldCause, StopCause, VesselStopper};

const AHEAD: VesselCommand = VesselCommand { throttle: 0.5, rudder: 0.25 };
const SEEN: GateInput = GateInput::Fresh(Ok(AHEAD));

fn at(ms: u64) -> Timestamp {
    Timestamp::from_nanos(ms * 1_000_000)
}

/// A gate with fresh video whose throttle may rise at once.
fn gate() -> VesselGate {
    let profile = VesselProfile { throttle_rise_per_s: 1e9, ..VesselProfile::SIMULATOR };
    let mut gate = VesselGate::new(profile, CommandPath::Simulated);
    gate.on_video(at(1_000));
    gate.decide(SEEN, at(1_000));
    gate
}

#[track_caller]
fn check(gate: &mut VesselGate, sight: GateInput, ms: u64, mode: VesselMode, command: VesselCommand) {
    if !matches!(sight, GateInput::NoObservation) {
        gate.on_video(at(ms));
    }
    let decision = gate.decide(sight, at(ms));
    assert_eq!((decision.mode, decision.command), (mode, command), "at {ms} ms");
    assert!(decision.command.is_neutral() || decision.renew_by.is_some_and(|by| by > at(ms)), "a deadline");
}

const NEUTRAL: VesselCommand = VesselCommand::NEUTRAL;

#[test]
fn a_boat_that_nobody_engages_is_not_commanded() {
    let mut gate = gate();
    check(&mut gate, SEEN, 1_030, VesselMode::Released, NEUTRAL);
    gate.stop(VesselStop::Everything(StopCause::Operator));
    check(&mut gate, SEEN, 1_060, VesselMode::Released, NEUTRAL);
}

#[test]
fn guidance_lasts_as_long_as_the_boat_is_seen() {
    let mut gate = gate();
    gate.guide(at(1_000)).unwrap();
    check(&mut gate, SEEN, 1_030, VesselMode::Guided, AHEAD);
    check(&mut gate, GateInput::Unusable(HoldCause::Coasting), 1_200, VesselMode::Guided, AHEAD);
    check(&mut gate, GateInput::NoObservation, 1_279, VesselMode::Guided, AHEAD);
    let silent = VesselMode::Holding(VesselHold::Cause(HoldCause::VideoSilent));
    check(&mut gate, GateInput::NoObservation, 1_280, silent, NEUTRAL);
    let lost = VesselMode::Holding(VesselHold::Cause(HoldCause::TrackLost));
    check(&mut gate, GateInput::Unusable(HoldCause::TrackLost), 1_300, lost, NEUTRAL);
    check(&mut gate, SEEN, 1_400, VesselMode::Guided, AHEAD);
}

#[test]
fn a_hold_that_lasts_ends_the_guidance() {
    let mut gate = gate();
    gate.guide(at(1_000)).unwrap();
    check(&mut gate, SEEN, 1_030, VesselMode::Guided, AHEAD);
    let hold = VesselHold::Cause(HoldCause::TrackLost);
    check(&mut gate, GateInput::Unusable(HoldCause::TrackLost), 1_300, VesselMode::Holding(hold), NEUTRAL);
    let stopped = VesselMode::Stopped(VesselStop::HeldTooLong(hold));
    check(&mut gate, GateInput::Unusable(HoldCause::TrackLost), 6_300, stopped, NEUTRAL);
    check(&mut gate, SEEN, 6_330, stopped, NEUTRAL);
    gate.guide(at(6_340)).unwrap();
    check(&mut gate, SEEN, 6_360, VesselMode::Guided, AHEAD);
}

#[test]
fn without_a_destination_the_boat_waits_for_one() {
    let mut gate = gate();
    gate.guide(at(1_000)).unwrap();
    let none = VesselMode::Holding(VesselHold::NoDestination);
    for ms in [1_030, 30_000] {
        check(&mut gate, GateInput::Fresh(Err(VesselHold::NoDestination)), ms, none, NEUTRAL);
    }
    check(&mut gate, SEEN, 30_030, VesselMode::Guided, AHEAD);
}

#[test]
fn a_helm_lasts_half_a_second_after_its_last_renewal() {
    let mut gate = gate();
    gate.steer(AHEAD, at(1_000)).unwrap();
    check(&mut gate, SEEN, 1_100, VesselMode::ByHand, AHEAD);
    gate.on_video(at(1_400));
    check(&mut gate, GateInput::NoObservation, 1_499, VesselMode::ByHand, AHEAD);
    check(&mut gate, GateInput::NoObservation, 1_500, VesselMode::Neutral, NEUTRAL);
    gate.steer(AHEAD, at(1_510)).unwrap();
    check(&mut gate, SEEN, 1_520, VesselMode::ByHand, AHEAD);
    gate.steer(NEUTRAL, at(1_530)).unwrap();
    check(&mut gate, SEEN, 1_540, VesselMode::Neutral, NEUTRAL);
}

#[test]
fn a_helm_needs_video_and_no_track() {
    let mut gate = gate();
    gate.steer(AHEAD, at(1_000)).unwrap();
    check(&mut gate, GateInput::Unusable(HoldCause::TrackLost), 1_100, VesselMode::ByHand, AHEAD);
    gate.steer(AHEAD, at(1_300)).unwrap();
    check(&mut gate, GateInput::NoObservation, 1_349, VesselMode::ByHand, AHEAD);
    check(&mut gate, GateInput::NoObservation, 1_350, VesselMode::Neutral, NEUTRAL);
    assert_eq!(gate.steer(AHEAD, at(1_400)), Err(Refusal::NoFreshVideo));
}

#[test]
fn the_hand_takes_the_boat_from_the_guidance() {
    let mut gate = gate();
    gate.guide(at(1_000)).unwrap();
    check(&mut gate, SEEN, 1_030, VesselMode::Guided, AHEAD);
    gate.steer(NEUTRAL, at(1_040)).unwrap();
    check(&mut gate, SEEN, 1_050, VesselMode::Guided, AHEAD);
    let left = VesselCommand { throttle: 0.3, rudder: -1.0 };
    gate.steer(left, at(1_060)).unwrap();
    check(&mut gate, SEEN, 1_070, VesselMode::ByHand, left);
    gate.steer(NEUTRAL, at(1_080)).unwrap();
    check(&mut gate, SEEN, 1_090, VesselMode::Neutral, NEUTRAL);
}

#[test]
fn a_stop_holds_against_a_helm_that_is_still_held() {
    let mut gate = gate();
    gate.steer(AHEAD, at(1_000)).unwrap();
    check(&mut gate, SEEN, 1_030, VesselMode::ByHand, AHEAD);
    gate.stop(VesselStop::Everything(StopCause::Operator));
    let stopped = VesselMode::Stopped(VesselStop::Everything(StopCause::Operator));
    check(&mut gate, SEEN, 1_040, stopped, NEUTRAL);
    assert_eq!(gate.steer(AHEAD, at(1_050)), Err(Refusal::HelmHeld));
    check(&mut gate, SEEN, 1_060, stopped, NEUTRAL);
    gate.steer(NEUTRAL, at(1_070)).unwrap();
    check(&mut gate, SEEN, 1_080, stopped, NEUTRAL);
    gate.steer(AHEAD, at(1_090)).unwrap();
    check(&mut gate, SEEN, 1_100, VesselMode::ByHand, AHEAD);
}

#[test]
fn the_first_cause_of_a_stop_counts_until_the_boat_is_released() {
    let mut gate = gate();
    gate.guide(at(1_000)).unwrap();
    gate.stop_vessel(VesselStopper::ConsoleLost);
    gate.stop_vessel(VesselStopper::Operator);
    check(&mut gate, SEEN, 1_030, VesselMode::Stopped(VesselStop::ConsoleLost), NEUTRAL);
    gate.release();
    check(&mut gate, SEEN, 1_060, VesselMode::Released, NEUTRAL);
    gate.stop_vessel(VesselStopper::ConsoleLost);
    check(&mut gate, SEEN, 1_090, VesselMode::Released, NEUTRAL);
    gate.stop_vessel(VesselStopper::Operator);
    check(&mut gate, SEEN, 1_120, VesselMode::Stopped(VesselStop::Operator), NEUTRAL);
}

#[test]
fn nothing_commands_the_boat_while_its_link_is_down() {
    let mut gate = VesselGate::new(VesselProfile::SIMULATOR, CommandPath::Link);
    gate.on_video(at(1_000));
    assert_eq!(gate.guide(at(1_000)), Err(Refusal::NoVesselMotion(HoldCause::LinkDown)));
    assert_eq!(gate.steer(AHEAD, at(1_000)), Err(Refusal::NoVesselMotion(HoldCause::LinkDown)));
    gate.on_report(&Report::Link(LinkState::Up));
    gate.guide(at(1_000)).unwrap();
    gate.decide(SEEN, at(1_010));
    assert_eq!(gate.decide(SEEN, at(1_020)).mode, VesselMode::Guided);
    gate.on_report(&Report::Link(LinkState::Opening));
    let down = VesselMode::Holding(VesselHold::Cause(HoldCause::LinkDown));
    check(&mut gate, SEEN, 1_040, down, NEUTRAL);
}

#[test]
fn the_throttle_rises_slowly_and_falls_at_once() {
    let mut gate = VesselGate::new(VesselProfile::SIMULATOR, CommandPath::Simulated);
    gate.on_video(at(1_000));
    gate.decide(SEEN, at(1_000));
    gate.guide(at(1_000)).unwrap();
    let throttle = |gate: &mut VesselGate, wanted: f64, ms: u64| {
        let sight = GateInput::Fresh(Ok(VesselCommand { throttle: wanted, rudder: 0.0 }));
        gate.decide(sight, at(ms)).command.throttle
    };
    // 2 a second, and never beyond the limit of 0.6.
    for (wanted, ms, expected) in
        [(1.0, 1_100, 0.2), (1.0, 1_200, 0.4), (1.0, 1_900, 0.6), (0.1, 1_910, 0.1), (-1.0, 1_960, -0.1)]
    {
        let found = throttle(&mut gate, wanted, ms);
        assert!((found - expected).abs() < 1e-9, "{found} at {ms} ms, not {expected}");
    }
    let by_hand = VesselCommand { throttle: 1.0, rudder: 0.0 };
    for ms in [2_000, 2_200, 2_400, 2_600, 2_800] {
        gate.on_video(at(ms));
        gate.steer(by_hand, at(ms)).unwrap();
        gate.decide(SEEN, at(ms));
    }
    assert_eq!(gate.decide(SEEN, at(2_810)).command, by_hand);
}

#[test]
fn a_clock_that_goes_back_makes_the_boat_neutral() {
    let mut gate = gate();
    gate.steer(AHEAD, at(1_000)).unwrap();
    assert_eq!(gate.decide(GateInput::NoObservation, at(900)).command, NEUTRAL);
    gate.on_video(at(1_000));
    gate.guide(at(1_000)).unwrap();
    gate.decide(SEEN, at(1_010));
    assert_eq!(gate.decide(GateInput::NoObservation, at(900)).command, NEUTRAL);
}

#[test]
fn a_helm_that_is_held_at_a_stop_does_nothing_until_it_was_let_go_whatever_it_did_then() {
    let everything = VesselStop::Everything(StopCause::Operator);
    // For want of video the helm is without effect when Stop is pressed.
    let mut gate = gate();
    gate.steer(AHEAD, at(1_000)).unwrap();
    check(&mut gate, GateInput::NoObservation, 1_300, VesselMode::Neutral, NEUTRAL);
    gate.stop(everything);
    gate.on_video(at(1_400));
    assert_eq!(gate.steer(AHEAD, at(1_400)), Err(Refusal::HelmHeld));
    // A release is no letting go.
    gate.release();
    assert_eq!(gate.steer(AHEAD, at(1_410)), Err(Refusal::HelmHeld));
    check(&mut gate, SEEN, 1_420, VesselMode::Released, NEUTRAL);
    gate.steer(NEUTRAL, at(1_430)).unwrap();
    gate.steer(AHEAD, at(1_440)).unwrap();
    check(&mut gate, SEEN, 1_440, VesselMode::ByHand, AHEAD);
    // A second stop counts, too.
    assert!(!gate.is_at_rest_by_stop());
    gate.stop(everything);
    assert!(gate.is_at_rest_by_stop());
    gate.steer(NEUTRAL, at(1_450)).unwrap();
    assert_eq!(gate.steer(AHEAD, at(3_000)), Err(Refusal::NoFreshVideo));
    assert!(!gate.is_at_rest_by_stop(), "a further stop bars the helm that is held again");
    gate.stop_vessel(VesselStopper::Operator);
    assert!(gate.is_at_rest_by_stop());
    gate.on_video(at(3_010));
    assert_eq!(gate.steer(AHEAD, at(3_010)), Err(Refusal::HelmHeld));
}

#[test]
fn a_pilot_that_was_held_up_for_too_long_does_not_go_on_by_itself() {
    for sees_loss in [false, true] {
        let mut gate = gate();
        gate.guide(at(1_000)).unwrap();
        check(&mut gate, SEEN, 1_030, VesselMode::Guided, AHEAD);
        let mut hold = VesselHold::Cause(HoldCause::VideoSilent);
        if sees_loss {
            hold = VesselHold::Cause(HoldCause::TrackLost);
            let lost = GateInput::Unusable(HoldCause::TrackLost);
            check(&mut gate, lost, 3_000, VesselMode::Holding(hold), NEUTRAL);
        }
        let stopped = VesselMode::Stopped(VesselStop::HeldTooLong(hold));
        check(&mut gate, SEEN, 6_280, stopped, NEUTRAL);
        check(&mut gate, SEEN, 6_310, stopped, NEUTRAL);
    }
}

/// A gate of a boat behind a link that is up and takes commands.
fn linked_gate() -> VesselGate {
    let mut gate = VesselGate { vessel: VehicleState::new(CommandPath::Link), ..gate() };
    gate.on_report(&Report::Link(LinkState::Up));
    gate.on_report(&Report::Acceptance(Acceptance::Accepted));
    gate
}

#[test]
fn a_boat_that_was_disarmed_or_taken_waits_for_another_request() {
    for (said, loses_link) in [
        (Acceptance::Disarmed, false),
        (Acceptance::StartingUp, false),
        (Acceptance::OtherClient, false),
        (Acceptance::OtherClient, true),
    ] {
        let stopped = VesselMode::Stopped(VesselStop::NotAccepted(Said { acceptance: said, mode: None }));
        let mut gate = linked_gate();
        gate.guide(at(1_000)).unwrap();
        check(&mut gate, SEEN, 1_030, VesselMode::Guided, AHEAD);
        if loses_link {
            gate.on_report(&Report::Link(LinkState::Opening));
            gate.on_report(&Report::Link(LinkState::Up));
        }
        gate.on_report(&Report::Acceptance(said));
        check(&mut gate, SEEN, 1_060, stopped, NEUTRAL);
        gate.on_report(&Report::Acceptance(Acceptance::Accepted));
        check(&mut gate, SEEN, 1_090, stopped, NEUTRAL);
    }
    // The sticks took a boat whose link was lost; the helm is held all the while.
    let mut gate = linked_gate();
    gate.steer(AHEAD, at(1_000)).unwrap();
    gate.on_report(&Report::Link(LinkState::Opening));
    check(&mut gate, SEEN, 1_030, VesselMode::Neutral, NEUTRAL);
    gate.on_report(&Report::Link(LinkState::Up));
    gate.on_report(&Report::Acceptance(Acceptance::OtherClient));
    gate.on_report(&Report::Acceptance(Acceptance::Accepted));
    assert_eq!(gate.steer(AHEAD, at(1_060)), Err(Refusal::HelmHeld));
}

#[test]
fn a_throttle_that_has_no_time_to_grow_is_positive_zero() {
    let mut gate = gate();
    gate.steer(VesselCommand { throttle: -0.5, rudder: -0.0 }, at(1_000)).unwrap();
    let command = gate.decide(GateInput::NoObservation, at(1_000)).command;
    assert_eq!((command.throttle.to_bits(), command.rudder.to_bits()), (0, 0));
}

const KEEP: KeepWay = KeepWay { throttle: 0.2, lasts: Duration::from_secs(2) };
const WAY: VesselCommand = VesselCommand { throttle: 0.2, rudder: 0.0 };
const LOST: GateInput = GateInput::Unusable(HoldCause::TrackLost);
const LOST_HOLD: VesselHold = VesselHold::Cause(HoldCause::TrackLost);

/// A boat that keeps way, guided since 1.03 s with room around it.
fn under_way(path: CommandPath) -> VesselGate {
    let mut gate = match path {
        CommandPath::Link => linked_gate(),
        _ => gate(),
    };
    gate.profile.fail_safe = FailSafe::KeepWay(KEEP);
    gate.guide(at(1_000)).unwrap();
    gate.set_clear(true);
    check(&mut gate, SEEN, 1_030, VesselMode::Guided, AHEAD);
    gate
}

/// The same, 300 ms after the track was lost.
fn keeping_way(path: CommandPath) -> VesselGate {
    let mut gate = under_way(path);
    check(&mut gate, LOST, 1_330, VesselMode::KeepingWay(LOST_HOLD), WAY);
    gate
}

#[test]
fn a_vessel_that_shall_keeps_way_for_a_while_and_is_neutral_then() {
    let mut gate = keeping_way(CommandPath::Simulated);
    assert_eq!(gate.decide(LOST, at(1_400)).renew_by, Some(at(1_650)), "renewed as the guidance is");
    check(&mut gate, LOST, 3_200, VesselMode::KeepingWay(LOST_HOLD), WAY);
    // The command ended at 1.28 s.
    assert_eq!(gate.decide(LOST, at(3_200)).renew_by, Some(at(3_280)));
    check(&mut gate, GateInput::NoObservation, 3_280, VesselMode::Holding(LOST_HOLD), NEUTRAL);
    check(&mut gate, LOST, 3_300, VesselMode::Holding(LOST_HOLD), NEUTRAL);
    // The hold of 5 s counts from the same moment.
    check(&mut gate, LOST, 6_280, VesselMode::Stopped(VesselStop::HeldTooLong(LOST_HOLD)), NEUTRAL);
}

#[test]
fn a_boat_that_is_found_again_goes_on_and_the_next_loss_counts_anew() {
    let mut gate = keeping_way(CommandPath::Simulated);
    check(&mut gate, SEEN, 1_900, VesselMode::Guided, AHEAD);
    check(&mut gate, LOST, 2_200, VesselMode::KeepingWay(LOST_HOLD), WAY);
    check(&mut gate, LOST, 4_149, VesselMode::KeepingWay(LOST_HOLD), WAY);
    check(&mut gate, LOST, 4_150, VesselMode::Holding(LOST_HOLD), NEUTRAL);
}

#[test]
fn way_is_kept_for_want_of_track_and_video_alone() {
    for cause in [HoldCause::TrackLost, HoldCause::Coasting, HoldCause::VideoStale, HoldCause::VideoSilent] {
        let mut gate = under_way(CommandPath::Simulated);
        let mode = VesselMode::KeepingWay(VesselHold::Cause(cause));
        check(&mut gate, GateInput::Unusable(cause), 1_330, mode, WAY);
    }
    let mut gate = under_way(CommandPath::Simulated);
    let silent = VesselMode::KeepingWay(VesselHold::Cause(HoldCause::VideoSilent));
    check(&mut gate, GateInput::NoObservation, 1_280, silent, WAY);
    for cause in [HoldCause::NoSelection, HoldCause::Confirming, HoldCause::Doubted] {
        let hold = VesselMode::Holding(VesselHold::Cause(cause));
        check(&mut under_way(CommandPath::Simulated), GateInput::Unusable(cause), 1_330, hold, NEUTRAL);
        // Also after way was kept; and it does not begin again.
        let mut gate = keeping_way(CommandPath::Simulated);
        check(&mut gate, GateInput::Unusable(cause), 1_400, hold, NEUTRAL);
        check(&mut gate, LOST, 1_430, VesselMode::Holding(LOST_HOLD), NEUTRAL);
    }
    let none = GateInput::Fresh(Err(VesselHold::NoDestination));
    let hold = VesselMode::Holding(VesselHold::NoDestination);
    check(&mut keeping_way(CommandPath::Simulated), none, 1_400, hold, NEUTRAL);
}

#[test]
fn every_stop_the_lost_console_and_the_lost_link_end_the_way_at_once() {
    for (stop, expected) in [
        (VesselStopper::Operator, VesselStop::Operator),
        (VesselStopper::ConsoleLost, VesselStop::ConsoleLost),
    ] {
        let mut gate = keeping_way(CommandPath::Simulated);
        gate.stop_vessel(stop);
        check(&mut gate, LOST, 1_340, VesselMode::Stopped(expected), NEUTRAL);
        // A stop before the track is lost counts as well.
        let mut gate = under_way(CommandPath::Simulated);
        gate.stop_vessel(stop);
        check(&mut gate, LOST, 1_330, VesselMode::Stopped(expected), NEUTRAL);
    }
    let everything = VesselStop::Everything(StopCause::Operator);
    let mut gate = keeping_way(CommandPath::Simulated);
    gate.stop(everything);
    check(&mut gate, LOST, 1_340, VesselMode::Stopped(everything), NEUTRAL);
    let mut gate = keeping_way(CommandPath::Simulated);
    gate.release();
    check(&mut gate, LOST, 1_340, VesselMode::Released, NEUTRAL);

    let down = VesselMode::Holding(VesselHold::Cause(HoldCause::LinkDown));
    for mut gate in [under_way(CommandPath::Link), keeping_way(CommandPath::Link)] {
        gate.on_report(&Report::Link(LinkState::Opening));
        check(&mut gate, LOST, 1_340, down, NEUTRAL);
        gate.on_report(&Report::Link(LinkState::Up));
        check(&mut gate, LOST, 1_370, VesselMode::Holding(LOST_HOLD), NEUTRAL);
    }
    let mut gate = keeping_way(CommandPath::Link);
    gate.on_report(&Report::Acceptance(Acceptance::OtherClient));
    let said = Said { acceptance: Acceptance::OtherClient, mode: None };
    let taken = VesselMode::Stopped(VesselStop::NotAccepted(said));
    check(&mut gate, LOST, 1_340, taken, NEUTRAL);
}

#[test]
fn way_is_kept_only_with_room_and_never_raises_the_throttle() {
    let neutral = VesselMode::Holding(LOST_HOLD);
    let mut gate = under_way(CommandPath::Simulated);
    gate.set_clear(false);
    check(&mut gate, LOST, 1_330, neutral, NEUTRAL);
    let mut gate = keeping_way(CommandPath::Simulated);
    gate.set_clear(false);
    check(&mut gate, LOST, 1_340, neutral, NEUTRAL);
    gate.set_clear(true);
    check(&mut gate, LOST, 1_370, neutral, NEUTRAL);

    let lost_at = |throttle: f64| {
        let mut gate = under_way(CommandPath::Simulated);
        let slow = GateInput::Fresh(Ok(VesselCommand { throttle, rudder: -1.0 }));
        gate.on_video(at(1_060));
        gate.decide(slow, at(1_060));
        gate.decide(LOST, at(1_330)).command
    };
    assert_eq!(lost_at(0.1), VesselCommand { throttle: 0.1, rudder: 0.0 });
    assert_eq!(lost_at(0.0), NEUTRAL, "a boat without way");
    assert_eq!(lost_at(-0.3), NEUTRAL, "a boat that goes astern");
}

#[test]
fn a_guidance_that_has_seen_nothing_yet_keeps_no_way() {
    let mut gate = gate();
    gate.profile.fail_safe = FailSafe::KeepWay(KEEP);
    gate.set_clear(true);
    gate.guide(at(1_000)).unwrap();
    check(&mut gate, LOST, 1_260, VesselMode::Holding(LOST_HOLD), NEUTRAL);
}

#[test]
fn a_hand_and_a_clock_that_is_wrong_keep_no_way() {
    let mut gate = gate();
    gate.profile.fail_safe = FailSafe::KeepWay(KEEP);
    gate.set_clear(true);
    gate.steer(AHEAD, at(1_000)).unwrap();
    check(&mut gate, SEEN, 1_030, VesselMode::ByHand, AHEAD);
    check(&mut gate, GateInput::NoObservation, 1_500, VesselMode::Neutral, NEUTRAL);
    // The clock goes back, before and after the loss.
    let mut gate = under_way(CommandPath::Simulated);
    assert_eq!(gate.decide(LOST, at(900)).command, NEUTRAL);
    let mut gate = keeping_way(CommandPath::Simulated);
    assert_eq!(gate.decide(LOST, at(900)).command, NEUTRAL);
    assert_eq!(gate.decide(LOST, at(1_400)).command, NEUTRAL);
    // A pilot that was held up is late with the way, too.
    let mut gate = under_way(CommandPath::Simulated);
    check(&mut gate, LOST, 3_300, VesselMode::Holding(LOST_HOLD), NEUTRAL);
    // A profile out of its limits is held to them.
    let mut gate = under_way(CommandPath::Simulated);
    gate.profile.fail_safe = FailSafe::KeepWay(KeepWay { throttle: 1.0, lasts: Duration::from_secs(60) });
    let way = VesselCommand { throttle: KeepWay::MAX_THROTTLE, rudder: 0.0 };
    check(&mut gate, LOST, 1_330, VesselMode::KeepingWay(LOST_HOLD), way);
    check(&mut gate, LOST, 4_280, VesselMode::Holding(LOST_HOLD), NEUTRAL);
}

#[test]
fn a_helm_that_is_held_while_the_boat_takes_no_commands_does_nothing_until_it_was_let_go() {
    use Acceptance::{Accepted, ChecksFail, Disarmed, ModeRefused, OtherClient, StartingUp};
    let said = Report::Acceptance;
    let edges: [&[Report]; 9] = [
        &[said(Disarmed)],
        &[said(ChecksFail)],
        &[said(OtherClient)],
        &[said(ModeRefused)],
        &[said(StartingUp)],
        &[Report::Link(LinkState::Opening), Report::Link(LinkState::Up)],
        &[Report::Link(LinkState::Silent), Report::Link(LinkState::Starting), Report::Link(LinkState::Up)],
        &[Report::Link(LinkState::Opening), Report::Link(LinkState::Up), said(Disarmed)],
        &[said(Disarmed), said(OtherClient), said(StartingUp)],
    ];
    for edge in edges {
        // The helm was held before, also one without effect for want of video; or it is pressed meanwhile.
        for (is_held_before, has_video, renews) in
            [(true, true, false), (true, true, true), (true, false, true), (false, true, true)]
        {
            let mut gate = linked_gate();
            if is_held_before {
                let before = if has_video { 1_000 } else { 1_400 };
                assert_eq!(gate.steer(AHEAD, at(before)).is_ok(), has_video);
            }
            for report in edge {
                gate.on_report(report);
                let is_open = gate.vessel.obstacle().is_none();
                if renews && !is_open {
                    assert!(gate.steer(AHEAD, at(1_410)).is_err(), "{edge:?}");
                }
            }
            gate.on_report(&said(Accepted));
            gate.on_video(at(1_440));
            assert_eq!(gate.steer(AHEAD, at(1_450)), Err(Refusal::HelmHeld), "{edge:?} {is_held_before}");
            assert!(gate.decide(SEEN, at(1_450)).command.is_neutral(), "{edge:?}");
            gate.steer(VesselCommand::NEUTRAL, at(1_460)).unwrap();
            gate.steer(AHEAD, at(1_470)).unwrap();
            check(&mut gate, SEEN, 1_480, VesselMode::ByHand, AHEAD);
        }
    }
}

#[test]
fn a_refusal_names_the_mode_or_the_armed_state_and_never_just_says_that_the_boat_takes_no_commands() {
    for (acceptance, mode, part) in [
        (Acceptance::Disarmed, Some(15), "not armed"),
        (Acceptance::ChecksFail, Some(15), "checks before arming fail"),
        (Acceptance::StartingUp, Some(16), "still starting"),
        (Acceptance::OtherClient, Some(0), "in MANUAL"),
        (Acceptance::OtherClient, Some(4), "in HOLD"),
        (Acceptance::OtherClient, Some(10), "in AUTO"),
        (Acceptance::OtherClient, Some(11), "in RTL"),
        (Acceptance::OtherClient, Some(77), "in mode 77"),
        (Acceptance::ModeRefused, Some(4), "EKF"),
    ] {
        let mut gate = linked_gate();
        gate.on_report(&Report::DriveMode(DriveMode(mode.unwrap())));
        gate.on_report(&Report::Acceptance(acceptance));
        for refusal in [gate.guide(at(1_000)).unwrap_err(), gate.steer(AHEAD, at(1_000)).unwrap_err()] {
            let text = refusal.to_string();
            assert!(text.contains(part), "{acceptance:?}: {text}");
        }
    }
}
