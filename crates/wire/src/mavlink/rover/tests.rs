//! The session against the other end, in steps of ten milliseconds.

use super::super::rover_boat::{HOLD, RoverBoat, RoverBoatSettings};
use super::*;
use barrelman_vocab::acceptance::Acceptance;
use barrelman_vocab::drive_mode::DriveMode;
use barrelman_vocab::mavlink::MavlinkPeers;
use barrelman_vocab::telemetry::Report;
use barrelman_vocab::vehicle_text::VehicleText;
use mavlink::dialects::common::{
    ATTITUDE_DATA, COMMAND_ACK_DATA, GLOBAL_POSITION_INT_DATA, HEARTBEAT_DATA, MavAutopilot, MavResult,
    MavSeverity, MavState, MavSysStatusSensor, STATUSTEXT_DATA, SYS_STATUS_DATA, VFR_HUD_DATA,
};

const AUTOPILOT: u8 = 1;

const AHEAD: VesselCommand = VesselCommand { throttle: 0.5, rudder: -0.5 };

fn at(ms: u64) -> Timestamp {
    Timestamp::from_nanos(ms * 1_000_000)
}

/// Session and boat, joined by a line without delay.
struct Bench {
    session: RoverSession,
    boat: RoverBoat,
    ms: u64,
    reports: Vec<Report>,
    heard: Vec<(u64, String)>,
    is_cut: bool,
    next: NextAction,
}

impl Bench {
    fn new(settings: RoverBoatSettings) -> Self {
        Self::linked(RoverLink::GUIDED, settings)
    }

    fn linked(link: RoverLink, settings: RoverBoatSettings) -> Self {
        Self {
            session: RoverSession::open(link, at(0)),
            boat: RoverBoat::new(settings, at(0)),
            ms: 0,
            reports: Vec::new(),
            heard: Vec::new(),
            is_cut: false,
            next: NextAction::WaitUntil(at(0)),
        }
    }

    fn run_to(&mut self, end_ms: u64) -> &mut Self {
        while self.ms < end_ms {
            let now = at(self.ms);
            let (mut down, mut up) = (Vec::new(), Vec::new());
            self.next = self.session.poll(now, &mut down);
            if !self.is_cut {
                for packet in &down {
                    let heard = &mut self.heard;
                    self.boat.receive(packet, now, &mut up, |text| heard.push((self.ms, text)));
                }
                self.boat.advance(now, &mut up);
                for packet in &up {
                    let reports = &mut self.reports;
                    self.session.received(packet, now, &mut |telemetry| match telemetry.report {
                        Report::DriveMode(_) | Report::Speed(_) => {}
                        report => reports.push(report),
                    });
                }
            }
            self.ms += 10;
        }
        self
    }

    fn set_points(&self, from_ms: u64) -> usize {
        let is_set_point = |(ms, text): &&(u64, String)| *ms >= from_ms && text.starts_with("SET_POSITION");
        self.heard.iter().filter(is_set_point).count()
    }

    fn manual_controls(&self, from_ms: u64) -> usize {
        let is_one = |(ms, text): &&(u64, String)| *ms >= from_ms && text.starts_with("MANUAL_CONTROL");
        self.heard.iter().filter(is_one).count()
    }

    fn go(&mut self) {
        let end = self.ms + 60_000;
        self.session.request(VesselOrder::Commanded(AHEAD), Some(at(end)));
    }
}

fn guided_boat() -> RoverBoatSettings {
    RoverBoatSettings { mode: GUIDED, ..RoverBoatSettings::default() }
}

#[test]
fn a_boat_in_guided_carries_out_throttle_and_rudder() {
    let mut bench = Bench::new(guided_boat());
    bench.run_to(500);
    assert_eq!(bench.session.link_state(), LinkState::Up);
    assert_eq!(bench.reports, [Report::Acceptance(Acceptance::Accepted)]);
    assert_eq!(bench.set_points(0), 0, "a boat that is not commanded hears no set-point");
    bench.go();
    bench.run_to(1_500);
    let carried_out = bench.boat.command(at(1_500));
    assert!((carried_out.throttle - 0.5).abs() < 1e-6 && (carried_out.rudder + 0.5).abs() < 1e-6);
    assert_eq!(bench.set_points(500), 10, "ten set-points a second");
}

#[test]
fn neutral_goes_out_at_once_and_release_ends_the_set_points() {
    let mut bench = Bench::new(guided_boat());
    bench.run_to(500);
    bench.go();
    bench.run_to(1_000);
    bench.session.request(VesselOrder::NEUTRAL, None);
    bench.run_to(1_020);
    assert!(bench.boat.command(at(1_020)).is_neutral());
    bench.go();
    bench.run_to(1_500);
    bench.session.request(VesselOrder::Released, None);
    bench.run_to(3_000);
    assert_eq!(bench.set_points(1_500), NEUTRALS as usize);
    assert!(bench.boat.command(at(3_000)).is_neutral() && !bench.session.may_be_turning());
}

#[test]
fn another_mode_is_left_alone_until_the_operator_asks() {
    let mut bench = Bench::new(RoverBoatSettings::default());
    bench.run_to(500);
    bench.go();
    bench.run_to(1_500);
    assert_eq!(bench.boat.mode(), MANUAL);
    assert_eq!(bench.reports, [Report::Acceptance(Acceptance::OtherClient); 2], "with each heartbeat");
    assert_eq!(bench.set_points(0), 0);
    bench.session.take_control(at(1_500));
    bench.run_to(2_500);
    assert_eq!(bench.boat.mode(), GUIDED);
    assert!(!bench.boat.command(at(2_500)).is_neutral());
    // The switch of the remote control.
    bench.boat.switch_to(MANUAL);
    let switched = bench.ms;
    bench.run_to(4_000);
    assert_eq!(bench.reports.last(), Some(&Report::Acceptance(Acceptance::OtherClient)));
    assert!(bench.set_points(switched + 20) == 0 && !bench.session.may_be_turning());
}

#[test]
fn a_boat_that_is_not_armed_takes_no_commands_and_is_never_armed() {
    let mut bench = Bench::new(RoverBoatSettings { is_armed: false, ..guided_boat() });
    bench.run_to(500);
    bench.session.take_control(at(500));
    bench.go();
    bench.run_to(2_000);
    assert_eq!(bench.reports, [Report::Acceptance(Acceptance::Disarmed); 2]);
    assert!(bench.boat.command(at(2_000)).is_neutral());
    assert!(bench.heard.iter().all(|(_, text)| !text.starts_with("COMMAND 400")), "no arming");
}

#[test]
fn the_end_is_neutral_and_a_boat_that_hears_nothing_stops_by_itself() {
    let mut bench = Bench::new(guided_boat());
    bench.run_to(500);
    bench.go();
    bench.run_to(1_000);
    bench.session.close(at(1_000));
    bench.run_to(1_500);
    assert_eq!(bench.next, NextAction::Closed);
    assert!(bench.boat.command(at(1_500)).is_neutral());

    let mut bench = Bench::new(guided_boat());
    bench.run_to(500);
    bench.go();
    bench.run_to(1_000);
    bench.is_cut = true;
    assert!(!bench.boat.command(at(3_890)).is_neutral());
    assert!(bench.boat.command(at(4_000)).is_neutral());
    bench.run_to(5_000);
    assert_eq!(bench.next, SILENT);
    assert!(bench.session.may_be_turning());
}

#[test]
fn a_moving_boat_that_is_no_longer_heard_is_sent_neutral_before_the_port_is_opened_again() {
    let mut bench = Bench::new(guided_boat());
    bench.run_to(500);
    bench.go();
    bench.run_to(1_000);
    assert!(!bench.boat.command(at(1_000)).is_neutral());
    let mut out = Vec::new();
    assert_eq!(bench.session.poll(at(4_500), &mut out), SILENT);
    assert_eq!(out.len(), NEUTRALS as usize);
    for packet in &out {
        bench.boat.receive(packet, at(1_010), &mut Vec::new(), |_| {});
    }
    assert!(bench.boat.command(at(1_020)).is_neutral());
    assert!(bench.session.may_be_turning(), "whether it has heard that is not known");

    let mut bench = Bench::new(guided_boat());
    bench.run_to(1_000);
    let mut out = Vec::new();
    assert_eq!((bench.session.poll(at(4_500), &mut out), out.len()), (SILENT, 0), "it was not commanded");
}

#[test]
fn a_session_commands_the_boat_of_the_session_before_and_no_other_one() {
    let mut before = Bench::new(guided_boat());
    before.run_to(500);
    let vehicle = before.session.vehicle();
    assert_eq!(vehicle, Some(SystemId(1)));
    for (vehicle, set_points) in [(vehicle, 10), (Some(SystemId(2)), 0)] {
        let mut bench = Bench::new(guided_boat());
        bench.session.resume(LinkHistory { vehicle, ..LinkHistory::default() });
        bench.run_to(500);
        bench.go();
        bench.run_to(1_500);
        assert_eq!((bench.set_points(0), bench.session.vehicle()), (set_points, vehicle));
    }
}

#[test]
fn a_boat_that_a_session_before_left_moving_is_waited_for_at_the_end() {
    let mut bench = Bench::new(guided_boat());
    bench.session.resume(LinkHistory { may_be_turning: true, ..LinkHistory::default() });
    assert!(bench.session.may_be_turning());
    bench.is_cut = true;
    bench.run_to(200);
    bench.session.close(at(200));
    bench.run_to(4_000);
    assert!(matches!(bench.next, NextAction::WaitUntil(_)), "{:?}", bench.next);
    bench.is_cut = false;
    bench.run_to(6_000);
    assert_eq!(bench.next, NextAction::Closed);
    assert_eq!(bench.set_points(0), NEUTRALS as usize);
    assert!(!bench.session.may_be_turning());

    // A boat in a mode that another program chose needs no neutral.
    let mut bench = Bench::new(RoverBoatSettings { mode: MANUAL, ..RoverBoatSettings::default() });
    bench.session.resume(LinkHistory { may_be_turning: true, ..LinkHistory::default() });
    bench.session.close(at(0));
    bench.run_to(3_000);
    assert_eq!((bench.next, bench.set_points(0)), (NextAction::Closed, 0));
    assert!(!bench.session.may_be_turning());
}

#[test]
fn a_boat_that_falls_silent_during_the_end_is_sent_all_neutrals() {
    let mut bench = Bench::new(guided_boat());
    bench.run_to(500);
    bench.go();
    bench.run_to(1_000);
    bench.is_cut = true;
    bench.run_to(3_950);
    bench.session.close(at(3_950));
    let mut out = Vec::new();
    let mut sent = 0;
    for ms in (3_950..4_300).step_by(10) {
        bench.next = bench.session.poll(at(ms), &mut out);
        sent += out.drain(..).filter(|packet| packet.len() > 40).count();
    }
    assert_eq!((bench.next, sent), (NextAction::Closed, NEUTRALS as usize));
}

/// A session after the first heartbeat of a boat in GUIDED, at 0 ms.
fn session_that_heard_its_boat() -> RoverSession {
    let mut session = RoverSession::open(RoverLink::GUIDED, at(0));
    let mut up = Vec::new();
    RoverBoat::new(guided_boat(), at(0)).advance(at(0), &mut up);
    for packet in &up {
        session.received(packet, at(0), &mut |_| {});
    }
    session
}

#[test]
fn a_boat_whose_heartbeats_get_lost_is_heard_by_its_other_packets_for_as_long_as_its_mode_is_known() {
    let mut session = session_that_heard_its_boat();
    let others = [Address::new(1, AUTOPILOT), Address::new(2, AUTOPILOT)]
        .map(|from| FrameWriter::new(from, None).write(&ATTITUDE_DATA::default()));
    for ms in (500..10_000).step_by(500) {
        session.received(&others[0], at(ms), &mut |_| {});
        assert_ne!(session.poll(at(ms), &mut Vec::new()), SILENT, "after {ms} ms");
    }
    session.received(&others[0], at(9_999), &mut |_| {});
    assert_eq!(session.poll(at(10_000), &mut Vec::new()), SILENT, "the mode is not known any more");

    // Packets of another system say nothing of the boat.
    let mut session = session_that_heard_its_boat();
    session.received(&others[1], at(2_900), &mut |_| {});
    assert_eq!(session.poll(at(3_000), &mut Vec::new()), SILENT);
}

#[test]
fn a_session_that_owes_nothing_waits() {
    let mut session = session_that_heard_its_boat();
    session.poll(at(0), &mut Vec::new());
    assert_eq!(session.poll(at(10), &mut Vec::new()), NextAction::WaitUntil(at(10).plus(SET_POINT_INTERVAL)));
}

#[test]
fn what_is_no_boat_is_not_commanded() {
    let mut session = RoverSession::open(RoverLink::GUIDED, at(0));
    let mut copter = FrameWriter::new(Address::new(1, 1), None);
    let packet = copter.write(&HEARTBEAT_DATA {
        custom_mode: GUIDED,
        mavtype: MavType::MAV_TYPE_QUADROTOR,
        autopilot: MavAutopilot::MAV_AUTOPILOT_ARDUPILOTMEGA,
        base_mode: MavModeFlag::MAV_MODE_FLAG_SAFETY_ARMED,
        ..heartbeat(MavType::MAV_TYPE_QUADROTOR)
    });
    session.received(&packet, at(10), &mut |_| {});
    assert_eq!(session.link_state(), LinkState::Starting);
    assert!(session.last_will(at(10)).is_empty());
    assert_eq!(session.poll(at(10_000), &mut Vec::new()), NO_BOAT);
}

#[test]
fn manual_control_is_that_of_the_protocol_byte_for_byte() {
    // pymavlink, MAVLink 2, sequence 0: manual_control_send(1, 0, -250, 500, 0, 0) of 255/191.
    const PINNED: [u8; 23] = [
        0xfd, 0x0b, 0x00, 0x00, 0x00, 0xff, 0xbf, 0x45, 0x00, 0x00, 0x00, 0x00, 0x06, 0xff, 0xf4, 0x01, 0x00,
        0x00, 0x00, 0x00, 0x01, 0x56, 0x69,
    ];
    let mut writer = FrameWriter::new(RoverLink::MANUAL.peers.own, None);
    let command = VesselCommand { throttle: 0.5, rudder: -0.25 };
    let packet = RoverDrive::Manual.packet(&mut writer, Address::new(1, 1), command);
    assert_eq!(packet, PINNED);
    let beyond = VesselCommand { throttle: 7.0, rudder: f64::NAN };
    let held = manual_control(Address::new(1, 1), beyond);
    assert_eq!((held.y, held.z), (0, 1000));
}

#[test]
fn a_boat_in_manual_obeys_manual_control_for_three_seconds() {
    let mut bench = Bench::linked(RoverLink::MANUAL, RoverBoatSettings::default());
    bench.run_to(500);
    assert_eq!(bench.reports, [Report::Acceptance(Acceptance::Accepted)]);
    assert_eq!(bench.manual_controls(0), 0, "a boat that is not commanded is its sticks'");
    bench.go();
    bench.run_to(1_500);
    assert_eq!(bench.boat.command(at(1_500)), AHEAD);
    assert_eq!(bench.manual_controls(500), 10, "ten a second");
    bench.is_cut = true;
    bench.run_to(2_000);
    assert_eq!(bench.boat.command(at(4_300)), AHEAD);
    assert!(bench.boat.command(at(4_500)).is_neutral(), "the sticks again");
    bench.is_cut = false;
    bench.run_to(3_000);
    bench.session.request(VesselOrder::Released, None);
    bench.run_to(5_000);
    assert_eq!(bench.manual_controls(3_000), NEUTRALS as usize);
    assert!(bench.boat.command(at(5_000)).is_neutral());
}

#[test]
fn manual_control_yields_to_every_other_mode_and_to_nobody_elses_system() {
    let mut bench = Bench::linked(RoverLink::MANUAL, RoverBoatSettings::default());
    bench.run_to(500);
    bench.go();
    bench.run_to(1_000);
    bench.boat.switch_to(HOLD);
    bench.run_to(3_000);
    assert_eq!(bench.reports.last(), Some(&Report::Acceptance(Acceptance::OtherClient)));
    assert!(bench.manual_controls(1_030) == 0, "the switch of the remote control took the boat");
    bench.session.take_control(at(3_000));
    bench.run_to(3_500);
    assert_eq!(bench.boat.mode(), MANUAL, "asked for");
    // A boat obeys the system id of its ground station alone.
    let onboard = RoverLink { peers: MavlinkPeers::DEFAULT, ..RoverLink::MANUAL };
    let mut bench = Bench::linked(onboard, RoverBoatSettings::default());
    bench.run_to(500);
    bench.go();
    bench.run_to(1_000);
    assert!(bench.manual_controls(0) > 0 && bench.boat.command(at(1_000)).is_neutral());
}

/// What a reader tells of a boat in GUIDED and armed that sends this, without its mode.
fn told(packets: &[Vec<u8>]) -> Vec<Report> {
    let mut reader = RoverReader::new(RoverLink::GUIDED);
    let mut reports = Vec::new();
    let mut boat = RoverBoat::new(guided_boat(), at(0));
    let mut out = Vec::new();
    boat.advance(at(0), &mut out);
    for packet in out.iter().chain(packets) {
        reader.read(packet, |report| match report {
            Report::DriveMode(_) | Report::Acceptance(Acceptance::Accepted) => {}
            report => reports.push(report),
        });
    }
    reports
}

fn from_boat<D: mavlink::MessageData>(message: &D) -> Vec<u8> {
    FrameWriter::new(Address::new(1, 1), None).write(message)
}

fn heartbeat_in(mode: u32, base: MavModeFlag, state: MavState) -> Vec<u8> {
    from_boat(&HEARTBEAT_DATA {
        custom_mode: mode,
        mavtype: MavType::MAV_TYPE_SURFACE_BOAT,
        autopilot: MavAutopilot::MAV_AUTOPILOT_ARDUPILOTMEGA,
        base_mode: base,
        system_status: state,
        mavlink_version: 3,
    })
}

#[test]
fn a_boat_that_takes_no_commands_is_told_apart_by_mode_armed_state_checks_and_refusals() {
    let armed = MavModeFlag::MAV_MODE_FLAG_SAFETY_ARMED;
    let (disarmed, active, starting) =
        (MavModeFlag::empty(), MavState::MAV_STATE_ACTIVE, MavState::MAV_STATE_CALIBRATING);
    let checks = |pass: bool| {
        let sensor = MavSysStatusSensor::MAV_SYS_STATUS_PREARM_CHECK;
        let health = if pass { sensor } else { MavSysStatusSensor::empty() };
        from_boat(&SYS_STATUS_DATA {
            onboard_control_sensors_present: sensor,
            onboard_control_sensors_enabled: sensor,
            onboard_control_sensors_health: health,
            ..SYS_STATUS_DATA::DEFAULT
        })
    };
    let answer = |result| {
        from_boat(&COMMAND_ACK_DATA {
            command: MavCmd::MAV_CMD_DO_SET_MODE,
            result,
            progress: 0,
            result_param2: 0,
            target_system: 245,
            target_component: 191,
        })
    };
    let (denied, accepted) = (answer(MavResult::MAV_RESULT_FAILED), answer(MavResult::MAV_RESULT_ACCEPTED));
    let cases: [(&[Vec<u8>], Acceptance); 9] = [
        (&[heartbeat_in(GUIDED, armed, active)], Acceptance::Accepted),
        (&[heartbeat_in(GUIDED, disarmed, active)], Acceptance::Disarmed),
        (&[heartbeat_in(GUIDED, disarmed, active), checks(true)], Acceptance::Disarmed),
        (&[heartbeat_in(GUIDED, disarmed, active), checks(false)], Acceptance::ChecksFail),
        (&[heartbeat_in(GUIDED, disarmed, starting)], Acceptance::StartingUp),
        (&[heartbeat_in(HOLD, armed, active)], Acceptance::OtherClient),
        (&[heartbeat_in(HOLD, armed, active), denied.clone()], Acceptance::ModeRefused),
        (&[heartbeat_in(HOLD, armed, active), accepted], Acceptance::OtherClient),
        // A refusal is one of the mode that the boat was in.
        (
            &[heartbeat_in(HOLD, armed, active), denied, heartbeat_in(MANUAL, armed, active)],
            Acceptance::OtherClient,
        ),
    ];
    for (packets, expected) in cases {
        let mut reader = RoverReader::new(RoverLink::GUIDED);
        let (mut said, mut mode) = (None, None);
        for packet in packets {
            reader.read(packet, |report| match report {
                Report::Acceptance(acceptance) => said = Some(acceptance),
                Report::DriveMode(heard) => mode = Some(heard),
                _ => {}
            });
        }
        assert_eq!(said, Some(expected));
        assert!(mode.is_some_and(|DriveMode(number)| [GUIDED, HOLD, MANUAL].contains(&number)));
    }
}

#[test]
fn speed_comes_from_a_position_or_from_the_display_and_a_clock_that_falls_is_a_restart() {
    let position = |ms: u32, lat: i32| {
        from_boat(&GLOBAL_POSITION_INT_DATA {
            time_boot_ms: ms,
            lat,
            lon: 1,
            vx: 300,
            vy: 400,
            ..GLOBAL_POSITION_INT_DATA::DEFAULT
        })
    };
    let nowhere = from_boat(&GLOBAL_POSITION_INT_DATA { vx: 300, ..GLOBAL_POSITION_INT_DATA::DEFAULT });
    let hud = from_boat(&VFR_HUD_DATA { groundspeed: 2.5, ..VFR_HUD_DATA::DEFAULT });
    let damaged = from_boat(&VFR_HUD_DATA { groundspeed: f32::NAN, ..VFR_HUD_DATA::DEFAULT });
    assert_eq!(told(&[position(5_000, 540_000_000)]), [Report::Speed(5.0)]);
    assert_eq!(told(&[nowhere, hud, damaged]), [Report::Speed(2.5)]);
    let restarted = told(&[position(60_000, 1), position(59_500, 1), position(2_000, 1)]);
    let speed = Report::Speed(5.0);
    assert_eq!(restarted, [speed, speed, Report::Acceptance(Acceptance::StartingUp), speed]);
}

#[test]
fn texts_are_put_together_made_printable_and_bounded() {
    let chunk = |id: u16, chunk_seq: u8, text: &[u8]| {
        let mut bytes = [0; 50];
        bytes[..text.len()].copy_from_slice(text);
        let severity = MavSeverity::MAV_SEVERITY_CRITICAL;
        from_boat(&STATUSTEXT_DATA { severity, text: bytes.into(), id, chunk_seq })
    };
    let whole = [b'a'; 50];
    let text = |text: &str| Report::Text(VehicleText::of(2, text.as_bytes()));
    let a = "a".repeat(50);
    for (chunks, expected) in [
        (vec![chunk(0, 0, b"PreArm: GPS")], vec![text("PreArm: GPS")]),
        (vec![chunk(0, 0, b"bell\x07 <b>\xff")], vec![text("bell? <b>?")]),
        (vec![chunk(0, 0, b""), chunk(0, 0, b"  ")], vec![]),
        (vec![chunk(7, 0, &whole), chunk(7, 1, b" end")], vec![text(&format!("{a} end"))]),
        // Lost and mixed chunks.
        (vec![chunk(7, 0, &whole), chunk(8, 0, b"b")], vec![text(&format!("{a}...")), text("b")]),
        (vec![chunk(7, 1, b"end")], vec![text("...end")]),
        (
            vec![chunk(7, 0, &whole), chunk(7, 1, &whole), chunk(7, 2, &whole), chunk(7, 3, b"more")],
            vec![text(&"a".repeat(120)), text("...more")],
        ),
        // A flood.
        ((0..100).map(|_| chunk(0, 0, b"x")).collect(), vec![text("x"); 4]),
    ] {
        assert_eq!(told(&chunks), expected);
    }
}

#[test]
fn what_does_not_come_is_asked_for_and_what_comes_is_left_alone() {
    let asked = |speaks: bool, ms: u64| {
        let mut bench = Bench::new(guided_boat());
        bench.run_to(500);
        while bench.ms < ms {
            bench.run_to(bench.ms + 100);
            if speaks {
                let position = GLOBAL_POSITION_INT_DATA { lat: 1, ..GLOBAL_POSITION_INT_DATA::DEFAULT };
                bench.session.received(&from_boat(&position), at(bench.ms), &mut |_| {});
            }
        }
        let is_position = |text: &str| text.starts_with("COMMAND 511") && text.contains("parameter 33 ");
        bench.heard.iter().filter(|(_, text)| is_position(text)).count()
    };
    assert!((4..=6).contains(&asked(false, 5_000)), "{}", asked(false, 5_000));
    assert!(asked(false, 60_000) <= 16, "less often in the end: {}", asked(false, 60_000));
    assert!(asked(true, 5_000) <= 1, "{}", asked(true, 5_000));
}

#[test]
fn a_boat_that_was_released_is_left_alone_at_the_end() {
    for (drive, boat) in
        [(RoverDrive::Manual, RoverBoatSettings::default()), (RoverDrive::Guided, guided_boat())]
    {
        let mut bench = Bench::linked(RoverLink { drive, ..RoverLink::GUIDED }, boat);
        bench.run_to(500);
        bench.go();
        bench.run_to(1_000);
        assert_eq!(bench.session.last_will(at(bench.ms)).len(), 5);
        bench.session.request(VesselOrder::Released, None);
        bench.run_to(3_000);
        assert_eq!(bench.session.last_will(at(bench.ms)).len(), 0);
        let (closed, set_points) = (bench.ms, bench.set_points(3_000));
        bench.session.close(at(closed));
        bench.run_to(closed + 2_000);
        assert_eq!((bench.manual_controls(closed), bench.set_points(3_000)), (0, set_points));
    }
}
