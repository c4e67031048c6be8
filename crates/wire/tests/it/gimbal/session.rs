//! A session with a gimbal manager, from the opened port to the end.

use core::time::Duration;

use barrelman_vocab::VehicleRates;
use barrelman_vocab::mavlink::{Address, MavlinkPeers, SystemId};
use barrelman_vocab::telemetry::{ControlState, LinkState, Report};
use barrelman_wire::mavlink::Gimbal;
use barrelman_wire::mavlink::gimbal_manager::{
    CameraKind, GimbalManagerSettings, Habits, MANAGER, OTHER_COMMANDER,
};
use barrelman_wire::{LinkHistory, NextAction, RestEvidence, Session as _};

use super::bench::{Bench, Sent, at, rates, sent};

const ARDUPILOT: GimbalManagerSettings = GimbalManagerSettings {
    habits: Habits::ArduPilot,
    withholds_information: false,
    denies_claims: false,
    withholds_status: false,
    names_nobody: false,
    dropped_claims: 0,
    camera: CameraKind::Zooming,
    signing: None,
};
const PX4: GimbalManagerSettings = GimbalManagerSettings { habits: Habits::Px4, ..ARDUPILOT };

fn seconds(s: f64) -> Duration {
    Duration::from_secs_f64(s)
}

#[test]
fn the_start_is_discovery_reports_a_claim_with_the_own_address_and_zeros() {
    for settings in [ARDUPILOT, PX4] {
        let bench = Bench::up(settings);
        let kinds: Vec<&Sent> = bench.sent.iter().map(|(_, sent)| sent).collect();
        let rates = kinds.iter().position(|sent| matches!(sent, Sent::Rates(..))).unwrap_or(kinds.len());
        let first =
            |id: u32| kinds.iter().position(|sent| sent.is_command(id)).expect("the command was sent");
        assert!(first(512) < first(511) && first(511) < first(1001), "{kinds:?}");
        assert!(rates > first(1001), "no rate before the control is ours: {kinds:?}");
        let own = MavlinkPeers::DEFAULT.own;
        let claim = Sent::Command(1001, MANAGER, f32::from(own.system.0), f32::from(own.component.0));
        assert_eq!(*kinds[first(1001)], claim);
        assert_eq!(bench.manager.primary(), Some(own));
        assert!(!kinds.iter().any(|sent| sent.is_motion()));
        assert!(bench.now_ms < 2_500, "up after {} ms", bench.now_ms);
    }
}

#[test]
fn after_a_session_that_may_have_left_the_gimbal_turning_zeros_go_to_everyone_first() {
    for settings in [ARDUPILOT, PX4] {
        let mut bench = Bench::new(settings);
        bench.session.resume(LinkHistory { may_be_turning: true, ..LinkHistory::default() });
        bench.run(seconds(0.2));
        let zeros: Vec<&Sent> =
            bench.sent.iter().map(|(_, sent)| sent).filter(|sent| sent.is_zeros()).collect();
        assert_eq!(bench.sent[0].1, Sent::Rates(Address::EVERYONE, 0, 0.0, 0.0));
        assert!(zeros.len() >= 3, "{zeros:?}");
        bench.take_over();
        let taken_at = bench.now_ms;
        bench.run(seconds(5.0));
        let after: Vec<_> =
            bench.since(taken_at + 1_500).filter(|(_, sent)| *sent != Sent::Heartbeat).collect();
        assert!(after.is_empty(), "another client has the control: {after:?}");
    }
}

#[test]
fn a_manager_that_names_nobody_is_taken_at_its_answer() {
    let mut bench = Bench::new(GimbalManagerSettings { names_nobody: true, ..ARDUPILOT });
    bench.run_until("the link is up", |bench| bench.session.link_state() == LinkState::Up);
    bench.session.request(rates(0.2, 0.0), None);
    bench.run(seconds(3.0));
    assert!(bench.manager.rates().yaw.radians_per_second() > 0.19);
    assert_eq!(bench.control(), Some(ControlState::Ours));
    assert_eq!(bench.claims(), 1, "a claim that was accepted is not repeated");
}

#[test]
fn rates_are_renewed_at_10_hz_and_zeros_are_sent_at_once_and_three_times() {
    for settings in [ARDUPILOT, PX4] {
        let mut bench = Bench::up(settings);
        bench.run(seconds(0.3));
        let moves_at = bench.now_ms;
        bench.session.request(rates(0.2, -0.1), None);
        bench.run(seconds(2.0));
        assert_eq!(bench.manager.rates().yaw.radians_per_second(), f64::from(0.2_f32));
        let moving: Vec<u64> =
            bench.since(moves_at).filter(|(_, sent)| sent.is_motion()).map(|(ms, _)| *ms).collect();
        assert!(moving[0] - moves_at <= 50 && moving.windows(2).all(|pair| pair[1] - pair[0] <= 105));
        assert!(moving.len() <= 21, "{moving:?}");
        let rests_at = bench.now_ms;
        bench.session.request(VehicleRates::REST, None);
        bench.run(seconds(1.0));
        let zeros: Vec<u64> = bench
            .since(rests_at)
            .filter(|(_, sent)| *sent == Sent::Rates(MANAGER, 1, 0.0, 0.0))
            .map(|(ms, _)| *ms - rests_at)
            .collect();
        assert_eq!(zeros[..3], [0, 50, 100]);
        assert!(zeros[2..].windows(2).all(|pair| pair[1] - pair[0] == 250), "{zeros:?}");
        assert!(bench.session.may_be_turning(), "a line that loses one direction is heard as well");
        bench.run(seconds(4.1));
        assert!(!bench.session.may_be_turning());
    }
}

#[test]
fn another_commander_is_yielded_to_at_once_and_the_control_comes_back_by_request_only() {
    for settings in [ARDUPILOT, PX4] {
        let mut bench = Bench::up(settings);
        bench.session.request(rates(0.3, 0.0), None);
        bench.run(seconds(1.0));
        bench.take_over();
        let taken_at = bench.now_ms;
        bench.run(seconds(5.0));
        let after: Vec<_> = bench.since(taken_at).filter(|(_, sent)| *sent != Sent::Heartbeat).collect();
        assert!(after.is_empty(), "{after:?}");
        assert_eq!(bench.manager.primary(), Some(OTHER_COMMANDER));
        assert!(bench.session.last_will(at(bench.now_ms)).is_empty());
        assert_eq!(bench.session.link_state(), LinkState::Up);
        assert_eq!(bench.control(), Some(ControlState::Elsewhere));
        let asked_at = bench.now_ms;
        bench.session.request(VehicleRates::REST, None);
        bench.session.take_control(at(bench.now_ms));
        bench.run(seconds(1.5));
        assert_eq!(bench.manager.primary(), Some(MavlinkPeers::DEFAULT.own));
        let first =
            bench.since(asked_at).find(|(_, sent)| *sent != Sent::Heartbeat).expect("something is sent");
        assert!(first.1.is_command(1001), "{first:?}");
        let first_rates =
            bench.since(asked_at).find(|(_, sent)| matches!(sent, Sent::Rates(..))).expect("rates are sent");
        assert!(first_rates.1.is_zeros(), "{first_rates:?}");
        bench.session.request(rates(0.1, 0.0), None);
        bench.run(seconds(0.3));
        assert!(bench.manager.rates().yaw.radians_per_second() > 0.09);
    }
}

#[test]
fn a_gimbal_that_another_commander_has_at_the_start_is_left_alone() {
    for settings in [ARDUPILOT, PX4] {
        let mut bench = Bench::new(settings);
        bench.take_over();
        bench.run_until("the link is up", |bench| bench.session.link_state() == LinkState::Up);
        bench.session.request(rates(0.3, 0.0), None);
        bench.run(seconds(3.0));
        assert!(!bench.sent.iter().any(|(_, sent)| sent.is_motion() || sent.is_command(1001)));
        bench.session.close(at(bench.now_ms));
        bench.step();
        assert_eq!(
            bench.last,
            NextAction::Closed,
            "nothing is left to be sent to a gimbal of another client"
        );
    }
}

#[test]
fn another_commander_keeps_the_control_where_the_word_of_it_gets_lost_for_two_seconds() {
    let mut bench = Bench::new(ARDUPILOT);
    bench.passes.1 = false;
    bench.take_over();
    bench.passes.1 = true;
    bench.run_until("the gimbal is asked for", |bench| {
        bench.sent.iter().any(|(_, sent)| sent.is_command(512))
    });
    bench.passes.1 = false;
    bench.run(seconds(2.0));
    assert!(bench.sent.iter().filter(|(_, sent)| sent.is_command(511)).count() >= 4, "it was asked for");
    bench.passes.1 = true;
    bench.run(seconds(3.0));
    assert!(!bench.sent.iter().any(|(_, sent)| sent.is_motion() || sent.is_command(1001)));
    assert_eq!(bench.control(), Some(ControlState::Elsewhere));
}

#[test]
fn a_gimbal_that_turns_when_its_control_goes_to_nobody_is_stopped_and_not_claimed() {
    let mut bench = Bench::up(ARDUPILOT);
    bench.session.request(rates(0.3, 0.0), None);
    bench.run(seconds(1.0));
    // The word of another commander gets lost, and it has sent nothing when it gives the control back.
    bench.passes.1 = false;
    bench.take_over();
    bench.run(seconds(0.2));
    bench.passes.1 = true;
    let (given_back_at, claims) = (bench.now_ms, bench.claims());
    bench.give_back();
    bench.run(seconds(5.0));
    assert!(bench.manager.rates().is_rest());
    let rates_sent: Vec<_> =
        bench.since(given_back_at).filter(|(_, sent)| matches!(sent, Sent::Rates(..))).collect();
    assert!(rates_sent.len() == 3 && rates_sent.iter().all(|(_, sent)| sent.is_zeros()), "{rates_sent:?}");
    assert_eq!((bench.claims(), bench.manager.primary()), (claims, None));
}

#[test]
fn a_session_after_another_commander_had_the_control_waits_for_the_operator() {
    let mut before = Bench::new(ARDUPILOT);
    before.take_over();
    before.run(seconds(3.0));
    assert!(before.session.is_anothers());
    for is_free_by_now in [false, true] {
        let mut bench = Bench::new(ARDUPILOT);
        bench.session.resume(LinkHistory { is_anothers: true, ..LinkHistory::default() });
        assert!(bench.session.last_will(at(0)).is_empty(), "the gimbal is another commander's");
        if !is_free_by_now {
            bench.take_over();
        }
        bench.run(seconds(5.0));
        assert_eq!((bench.claims(), bench.session.link_state()), (0, LinkState::Up));
        assert!(bench.session.is_anothers());
        bench.session.take_control(at(bench.now_ms));
        bench.run(seconds(2.0));
        assert_eq!(bench.manager.primary(), Some(MavlinkPeers::DEFAULT.own));
        assert!(!bench.session.is_anothers());
    }
}

#[test]
fn a_session_moves_the_gimbal_of_the_session_before_and_no_other_one() {
    let mut before = Bench::new(PX4);
    before.run(seconds(3.0));
    let vehicle = before.session.vehicle();
    assert_eq!(vehicle, Some(MANAGER.system));
    let other = Some(SystemId(MANAGER.system.0 + 1));
    for (vehicle, state) in [(vehicle, LinkState::Up), (other, LinkState::Starting)] {
        let mut bench = Bench::new(PX4);
        bench.session.resume(LinkHistory { vehicle, ..LinkHistory::default() });
        bench.run(seconds(3.0));
        assert_eq!((bench.session.link_state(), bench.session.vehicle()), (state, vehicle));
        assert_eq!(bench.claims() > 0, state == LinkState::Up);
    }
}

#[test]
fn the_operator_may_take_the_control_while_the_gimbal_is_searched() {
    let mut bench = Bench::new(ARDUPILOT);
    bench.session.resume(LinkHistory { is_anothers: true, ..LinkHistory::default() });
    bench.session.take_control(at(0));
    bench.run(seconds(3.0));
    assert_eq!(bench.manager.primary(), Some(MavlinkPeers::DEFAULT.own));
}

#[test]
fn a_claim_that_gets_lost_is_repeated_and_a_denied_one_is_not() {
    let mut bench = Bench::new(GimbalManagerSettings { dropped_claims: 3, ..PX4 });
    bench.run_until("the link is up", |bench| bench.session.link_state() == LinkState::Up);
    assert_eq!(bench.claims(), 4);
    assert_eq!(bench.manager.primary(), Some(MavlinkPeers::DEFAULT.own));

    let mut bench = Bench::new(GimbalManagerSettings { denies_claims: true, ..PX4 });
    bench.session.request(rates(0.3, 0.0), None);
    bench.run(seconds(5.0));
    assert_eq!(bench.claims(), 1);
    assert!(!bench.sent.iter().any(|(_, sent)| sent.is_motion()));
}

#[test]
fn a_gimbal_manager_that_withholds_its_information_is_found_by_its_status() {
    for settings in [ARDUPILOT, PX4] {
        let mut bench = Bench::new(GimbalManagerSettings { withholds_information: true, ..settings });
        bench.run_until("the link is up", |bench| bench.session.link_state() == LinkState::Up);
        assert!(bench.now_ms < 4_000, "up after {} ms", bench.now_ms);
        let asked = bench
            .sent
            .iter()
            .filter(|(_, sent)| matches!(sent, Sent::Command(512, _, id, _) if *id == 280.0));
        assert!(asked.count() >= 1);
        bench.session.request(rates(0.2, 0.0), None);
        bench.run(seconds(0.3));
        assert!(bench.manager.rates().yaw.radians_per_second() > 0.19);
    }
}

#[test]
fn an_autopilot_without_a_gimbal_is_named() {
    let mut bench = Bench::new(GimbalManagerSettings {
        withholds_information: true,
        withholds_status: true,
        ..ARDUPILOT
    });
    bench.run_until("the end", |bench| matches!(bench.last, NextAction::Reopen { .. }));
    let NextAction::Reopen { reason } = bench.last else { panic!("{:?}", bench.last) };
    assert!(reason.contains("no gimbal manager answers"), "{reason}");
    assert!(bench.sent.iter().filter(|(_, sent)| sent.is_command(512)).count() >= 10);
    assert_eq!(bench.session.link_state(), LinkState::Opening);
}

#[test]
fn silence_ends_the_session_after_three_seconds() {
    let mut bench = Bench::up(ARDUPILOT);
    bench.session.request(rates(0.3, 0.0), None);
    bench.run(seconds(1.0));
    bench.passes = (true, false);
    let silent_at = bench.now_ms;
    bench.run_until("the end", |bench| matches!(bench.last, NextAction::Reopen { .. }));
    let taken = bench.now_ms - silent_at;
    assert!((2_900..=3_100).contains(&taken), "{taken} ms");
    assert_eq!(bench.session.link_state(), LinkState::Silent);
    assert!(bench.session.may_be_turning());
    let will: Vec<Sent> =
        bench.session.last_will(at(bench.now_ms)).iter().map(|step| sent(&step.packet)).collect();
    assert!(will.len() == 6 && will.iter().all(Sent::is_zeros), "{will:?}");
}

#[test]
fn a_shut_down_that_was_not_heard_may_leave_the_gimbal_turning() {
    let mut bench = Bench::up(ARDUPILOT);
    bench.session.request(rates(0.3, 0.0), None);
    bench.run(seconds(1.0));
    bench.passes = (false, false);
    bench.session.close(at(bench.now_ms));
    bench.run(seconds(5.0));
    assert_eq!(bench.session.link_state(), LinkState::Closing, "zeros go on until the gimbal is heard");
    assert!(bench.session.may_be_turning());
    bench.passes = (true, true);
    bench.run_until("the end", |bench| bench.last == NextAction::Closed);
    assert!(bench.manager.rates().is_rest() && !bench.session.may_be_turning());
}

#[test]
fn a_restart_of_the_vehicle_begins_anew_with_zeros() {
    let mut bench = Bench::up(ARDUPILOT);
    bench.run(seconds(4.0));
    bench.session.request(rates(0.3, 0.0), None);
    bench.run(seconds(1.0));
    let restarted_at = bench.now_ms;
    bench.manager = barrelman_wire::mavlink::GimbalManager::boot(ARDUPILOT, at(restarted_at));
    bench.run_until("the restart is known", |bench| bench.session.link_state() != LinkState::Up);
    assert!(bench.now_ms - restarted_at < 3_100, "after {} ms", bench.now_ms - restarted_at);
}

#[test]
fn the_end_is_zeros_until_the_gimbal_rests_and_a_release() {
    let mut bench = Bench::up(ARDUPILOT);
    bench.session.request(rates(0.3, 0.0), None);
    bench.run(seconds(1.0));
    assert!(matches!(bench.session.rest_evidence(at(bench.now_ms)), RestEvidence::Moving { .. }));
    let closed_at = bench.now_ms;
    bench.session.close(at(closed_at));
    bench.run_until("the end", |bench| bench.last == NextAction::Closed);
    let zeros: Vec<u64> =
        bench.since(closed_at).filter(|(_, sent)| sent.is_zeros()).map(|(ms, _)| *ms).collect();
    assert!(zeros.len() >= 12 && zeros[0] == closed_at, "{zeros:?}");
    let releases: Vec<_> = bench.since(closed_at).filter(|(_, sent)| sent.is_command(1001)).collect();
    assert_eq!(releases.len(), 1, "{releases:?}");
    assert_eq!(releases[0].1, Sent::Command(1001, MANAGER, -3.0, -3.0));
    assert_eq!(bench.manager.primary(), None);

    let mut bench = Bench::up(ARDUPILOT);
    bench.run(seconds(1.0));
    bench.is_stuck_moving = true;
    bench.run(seconds(0.5));
    let closed_at = bench.now_ms;
    bench.session.close(at(closed_at));
    bench.run(seconds(6.0));
    assert_eq!(bench.session.link_state(), LinkState::Closing, "zeros go on while the gimbal turns");
    assert!(bench.since(closed_at).filter(|(_, sent)| sent.is_zeros()).count() >= 58);
    bench.is_stuck_moving = false;
    bench.run_until("the end", |bench| bench.last == NextAction::Closed);
}

#[test]
fn the_tilt_is_the_pitch_above_the_horizon() {
    let mut bench = Bench::up(ARDUPILOT);
    bench.session.request(rates(0.3, 0.2), None);
    bench.run(seconds(1.0));
    let tilts: Vec<f64> = bench
        .reports
        .iter()
        .filter_map(
            |(_, report)| if let Report::CameraTilt(tilt) = report { Some(tilt.radians()) } else { None },
        )
        .collect();
    assert!((tilts[0] + 0.4).abs() < 1e-3, "{}", tilts[0]);
    let risen = tilts[tilts.len() - 1] + 0.4;
    assert!((0.15..0.21).contains(&risen), "{risen}");
}

#[test]
fn the_configured_vehicle_alone_is_asked() {
    let peers = MavlinkPeers { vehicle: Some(SystemId(7)), ..MavlinkPeers::DEFAULT };
    let mut bench = Bench::with_peers(ARDUPILOT, peers);
    bench.run_until("the end", |bench| matches!(bench.last, NextAction::Reopen { .. }));
    for (_, sent) in &bench.sent {
        assert_eq!(*sent, Sent::Heartbeat);
    }
}

#[test]
fn the_messages_that_can_leave_are_these() {
    let mut bench = Bench::up(ARDUPILOT);
    bench.session.request(rates(0.3, 0.2), None);
    bench.run(seconds(1.0));
    bench.take_over();
    bench.run(seconds(1.0));
    bench.session.take_control(at(bench.now_ms));
    bench.run(seconds(3.0));
    bench.session.close(at(bench.now_ms));
    bench.run_until("the end", |bench| bench.last == NextAction::Closed);
    for (_, sent) in &bench.sent {
        let may_leave = match sent {
            Sent::Heartbeat | Sent::Rates(..) => true,
            Sent::Command(id, _, parameter, _) => match id {
                511 => [281.0, 285.0, 33.0, 30.0].contains(parameter),
                512 => [280.0, 281.0].contains(parameter),
                1001 => [245.0, -3.0].contains(parameter),
                _ => false,
            },
        };
        assert!(may_leave, "{sent:?}");
    }
    assert_eq!(Gimbal::ALL.manager, Address::EVERYONE);
}

#[test]
fn position_and_attitude_of_the_vehicle_are_asked_for_until_they_come_and_again_when_they_stop() {
    let mut bench = Bench::up(ARDUPILOT);
    bench.run(seconds(5.0));
    let asked = |bench: &Bench, from_ms: u64, id: f32| {
        let is_request = |sent: &Sent| matches!(sent, Sent::Command(511, _, message, _) if *message == id);
        bench.since(from_ms).filter(|(_, sent)| is_request(sent)).count()
    };
    for id in [33.0, 30.0] {
        assert_eq!(asked(&bench, 0, id), 1, "what comes is not asked for again");
    }
    assert!(bench.reports.iter().any(|(_, report)| matches!(report, Report::CameraHeight(_))));
    // The vehicle forgets the intervals.
    bench.manager = barrelman_wire::mavlink::GimbalManager::boot(ARDUPILOT, at(bench.now_ms));
    let restarted_ms = bench.now_ms;
    bench.run(seconds(10.0));
    for id in [33.0, 30.0] {
        assert!(asked(&bench, restarted_ms, id) >= 1, "{id}");
    }
}

#[test]
fn zeros_go_on_while_commands_are_lost_and_reports_come_and_the_pan_is_reported_all_the_while() {
    let mut bench = Bench::up(ARDUPILOT);
    bench.session.request(rates(0.3, 0.0), None);
    bench.run(seconds(1.0));
    bench.passes = (false, true);
    let lost_ms = bench.now_ms;
    bench.session.request(VehicleRates::REST, None);
    bench.run(seconds(8.0));
    assert_eq!(bench.session.link_state(), LinkState::Up);
    let zeros = bench.since(lost_ms).filter(|(_, sent)| sent.is_zeros()).count();
    assert!(zeros >= 32, "{zeros} zeros in 8 s");
    assert!(matches!(bench.session.rest_evidence(at(bench.now_ms)), RestEvidence::Moving { .. }));
    let pans: Vec<f64> = bench
        .reports
        .iter()
        .filter(|(ms, _)| *ms >= lost_ms)
        .filter_map(|(_, report)| match report {
            Report::CameraPan(pan) => Some(pan.radians()),
            _ => None,
        })
        .collect();
    assert!(pans.len() >= 140, "{}", pans.len());
    assert!(pans.windows(2).all(|pair| pair[0] != pair[1]), "each report shows the motion");
}
