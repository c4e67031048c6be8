//! Another gimbal in the place of the one that is moved.

use core::time::Duration;

use barrelman_vocab::mavlink::Address;
use barrelman_vocab::telemetry::{LinkState, Report};
use barrelman_vocab::{Equipment, EquipmentKind};
use barrelman_wire::Session as _;
use barrelman_wire::mavlink::frame::FrameWriter;
use barrelman_wire::mavlink::gimbal_manager::{GimbalManagerSettings, MANAGER};
use mavlink::dialects::common::{
    GIMBAL_MANAGER_INFORMATION_DATA, GIMBAL_MANAGER_STATUS_DATA, GimbalManagerCapFlags,
};

use super::bench::{Bench, Sent, at, rates};

/// What the manager says of device 2.
fn other_device(ms: u64) -> [Vec<u8>; 2] {
    let time_boot_ms = ms as u32;
    let mut writer = FrameWriter::new(MANAGER, None);
    let status = GIMBAL_MANAGER_STATUS_DATA { time_boot_ms, gimbal_device_id: 2, ..Default::default() };
    let information = GIMBAL_MANAGER_INFORMATION_DATA {
        time_boot_ms,
        gimbal_device_id: 2,
        cap_flags: GimbalManagerCapFlags::GIMBAL_MANAGER_CAP_FLAGS_HAS_YAW_AXIS
            | GimbalManagerCapFlags::GIMBAL_MANAGER_CAP_FLAGS_HAS_PITCH_AXIS,
        ..GIMBAL_MANAGER_INFORMATION_DATA::DEFAULT
    };
    [writer.write(&status), writer.write(&information)]
}

#[test]
fn a_gimbal_in_the_place_of_another_one_gets_zeros_and_is_claimed_before_it_is_moved() {
    let mut bench = Bench::up(GimbalManagerSettings::default());
    bench.session.request(rates(0.3, 0.0), None);
    bench.run(Duration::from_millis(500));
    assert!(bench.sent.iter().any(|(_, sent)| sent.is_motion()));
    // The manager's own messages are about device 1.
    bench.passes.1 = false;
    let (began, claims) = (bench.now_ms, bench.claims());
    for _ in 0..60 {
        for packet in other_device(bench.now_ms) {
            let Bench { session, reports, now_ms, .. } = &mut bench;
            let report =
                &mut |telemetry: barrelman_vocab::Telemetry| reports.push((*now_ms, telemetry.report));
            session.received(&packet, at(*now_ms), report);
        }
        bench.run(Duration::from_millis(100));
    }
    let zeros = Sent::Rates(Address::new(1, 0), 0, 0.0, 0.0);
    let first = bench.since(began).find(|(_, sent)| *sent == zeros).expect("zeros to every gimbal").0;
    assert!((2_900..3_300).contains(&(first - began)), "{first}");
    assert!(!bench.since(first).any(|(_, sent)| sent.is_motion()), "it has not answered the claim");
    assert_eq!(bench.session.link_state(), LinkState::Starting);
    assert!(bench.claims() > claims);
    let used = Report::Equipment(Equipment::new(EquipmentKind::Gimbal, "device 2 of 1/1"));
    assert!(bench.reports.iter().any(|(ms, report)| *ms >= first && *report == used));
}
