//! Signed packets.

use barrelman_vocab::mavlink::{Address, MavlinkPeers};
use barrelman_vocab::telemetry::LinkState;
use barrelman_vocab::{Timestamp, VehicleRates};
use barrelman_wire::Session as _;
use barrelman_wire::mavlink::frame::{FrameReader, FrameWriter};
use barrelman_wire::mavlink::gimbal_manager::GimbalManagerSettings;
use barrelman_wire::mavlink::signing::{Signing, SigningKey};
use barrelman_wire::mavlink::{Command, GimbalManager, GimbalSession};

use super::bench::{Bench, at, rates};

/// The beginning of 2015, milliseconds since that of 1970.
const EPOCH_MS: u64 = 1_420_070_400_000;
const DAY_MS: u64 = 86_400_000;
/// What `fixtures/mavlink/signed_heartbeat.py` prints.
const SIGNED_BY_PYMAVLINK: &str = "fd09010000f5bf0000000000000012080004030a5d0000f0fb0202001e273b1196d1";

fn signing(passphrase: &str) -> Signing {
    Signing::new(SigningKey::parse(passphrase).unwrap(), EPOCH_MS + DAY_MS)
}

fn heartbeat(signing: Option<Signing>) -> Vec<u8> {
    Command::Heartbeat.encode(&mut FrameWriter::new(MavlinkPeers::DEFAULT.own, signing))
}

fn read(reader: &mut FrameReader, packet: &[u8]) -> usize {
    let mut found = 0;
    reader.read(packet, |_| found += 1);
    found
}

#[test]
fn a_packet_is_signed_as_pymavlink_signs_it() {
    let packet = heartbeat(Some(signing("barrelman")));
    let hex: String = packet.iter().map(|byte| format!("{byte:02x}")).collect();
    assert_eq!(hex, SIGNED_BY_PYMAVLINK);
}

#[test]
fn a_key_is_hexadecimal_or_a_passphrase() {
    let digits = "00ff".repeat(16);
    assert_eq!(SigningKey::parse(&digits).unwrap().bytes()[..4], [0, 255, 0, 255]);
    assert_eq!(SigningKey::parse(&format!("{digits}\nmore")), SigningKey::parse(&digits));
    assert_ne!(SigningKey::parse(&digits[1..]), SigningKey::parse(&digits));
    assert!(SigningKey::parse("  \nsecret").unwrap_err().to_string().contains("passphrase"));
    assert_eq!(format!("{:?}", SigningKey::parse("secret").unwrap()), "SigningKey");
}

#[test]
fn what_is_not_signed_with_the_key_or_was_heard_before_is_not_read() {
    let packet = heartbeat(Some(signing("right")));
    let mut reader = FrameReader::new(Some(signing("right")), Timestamp::ZERO);
    assert_eq!(read(&mut reader, &heartbeat(None)), 0, "not signed");
    assert_eq!(read(&mut reader, &heartbeat(Some(signing("wrong")))), 0);
    for index in packet.len() - 13..packet.len() {
        let mut damaged = packet.clone();
        damaged[index] ^= 1;
        assert_eq!(read(&mut reader, &damaged), 0, "byte {index}");
    }
    assert_eq!(read(&mut reader, &packet), 1);
    assert_eq!(read(&mut reader, &packet), 0, "sent again by a listener");
    // Without a key, signatures are not looked at.
    assert_eq!(read(&mut FrameReader::default(), &packet), 1);
}

#[test]
fn a_sender_may_be_a_minute_behind_and_goes_on_from_there() {
    let sender = |seconds: u64| {
        let began = EPOCH_MS + DAY_MS - seconds * 1_000;
        let signing = Signing::new(SigningKey::parse("key").unwrap(), began);
        FrameWriter::new(Address::new(1, 1), Some(signing))
    };
    for (seconds, expected) in [(0, 1), (59, 1), (62, 0)] {
        let mut reader = FrameReader::new(Some(signing("key")), Timestamp::ZERO);
        let mut writer = sender(seconds);
        assert_eq!(read(&mut reader, &Command::Heartbeat.encode(&mut writer)), expected, "{seconds} s");
        writer.set_time(Timestamp::from_secs_f64(1.0));
        assert_eq!(read(&mut reader, &Command::Heartbeat.encode(&mut writer)), expected);
    }
}

#[test]
fn a_signed_session_moves_a_gimbal_that_takes_signed_packets_alone() {
    let settings =
        GimbalManagerSettings { signing: Some(signing("key")), ..GimbalManagerSettings::default() };
    let mut bench = Bench::up(settings);
    bench.session.request(rates(0.2, 0.0), None);
    bench.run(core::time::Duration::from_secs(2));
    assert!(bench.manager.rates().yaw.radians_per_second() > 0.19);

    // The will of this session, and of a new one: neither is older than what was sent before.
    let now = at(bench.now_ms);
    let new = GimbalSession::open(MavlinkPeers::DEFAULT, Some(signing("key")), now);
    for will in [bench.session.last_will(now), new.last_will(now)] {
        let mut manager = bench.manager.clone();
        for step in will {
            manager.receive(&step.packet, now, &mut Vec::new(), |_, _| {});
        }
        assert_eq!(manager.rates(), VehicleRates::REST);
    }

    let mut bench = Bench::new(settings);
    bench.session = GimbalSession::open(MavlinkPeers::DEFAULT, Some(signing("another")), at(0));
    bench.run(core::time::Duration::from_secs(5));
    assert_eq!(bench.session.link_state(), LinkState::Starting);

    let mut bench = Bench::new(settings);
    bench.manager = GimbalManager::boot(GimbalManagerSettings::default(), at(0));
    bench.run(core::time::Duration::from_secs(5));
    assert_eq!(bench.session.link_state(), LinkState::Starting, "a manager that does not sign is not heard");
}

#[test]
fn signatures_are_newer_than_those_of_a_vehicle_whose_clock_is_ahead() {
    for ahead_s in [30, 7_200] {
        let vehicle = Signing::new(SigningKey::parse("key").unwrap(), EPOCH_MS + DAY_MS + ahead_s * 1_000);
        let settings = GimbalManagerSettings { signing: Some(vehicle), ..GimbalManagerSettings::default() };
        let mut bench = Bench::new(settings);
        bench.session = GimbalSession::open(MavlinkPeers::DEFAULT, Some(signing("key")), at(0));
        bench.run_until("the link is up", |bench| bench.session.link_state() == LinkState::Up);
        bench.session.request(rates(0.1, 0.0), None);
        bench.run(core::time::Duration::from_secs(1));
        assert_ne!(bench.manager.rates(), VehicleRates::REST, "{ahead_s} s");
    }
}

#[test]
fn what_was_recorded_before_a_port_was_opened_again_is_not_read() {
    let mut writer = FrameWriter::new(Address::new(1, 1), Some(signing("key")));
    writer.set_time(Timestamp::from_secs_f64(5.0));
    let recorded = Command::Heartbeat.encode(&mut writer);
    let hour = Timestamp::from_secs_f64(3_600.0);
    let mut opened = FrameReader::new(Some(signing("key")), hour);
    assert_eq!(read(&mut opened, &recorded), 0);
    writer.set_time(hour.minus(core::time::Duration::from_secs(50)));
    let late = Command::Heartbeat.encode(&mut writer);
    assert_eq!(read(&mut opened, &late), 1, "a clock may be a little behind");
}
