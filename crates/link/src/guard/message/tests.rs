//! Messages that are read as they were written, and what is no message.

use barrelman_vocab::mavlink::{ComponentId, MavlinkPeers, SystemId};
use barrelman_vocab::{AngularRate, VesselOrder};
use barrelman_wire::mavlink::rover::RoverLink;
use barrelman_wire::{Signing, SigningKey};

use super::packets::STATES;
use super::*;

type Camera = ToGuard<VehicleRates>;

fn rate(value: f64) -> AngularRate {
    AngularRate::from_radians_per_second(value)
}

#[test]
fn every_message_is_read_as_it_was_written() {
    let at = Timestamp::from_nanos(12_345_678_901);
    let rates = VehicleRates::turning(rate(-0.3), rate(0.1)).zooming(0.2);
    let settings = Settings {
        clock_start_ns: 77,
        vehicle: GuardedVehicle::Camera {
            limits: rates,
            protocol: ByteProtocolName::FotokitePro,
            framing: Framing::LineFeed,
        },
        history: LinkHistory { may_be_turning: true, ..LinkHistory::default() },
        url: "tcp://[::1]:5000?fault=stall@3".to_owned(),
    };
    let named = MavlinkPeers {
        vehicle: Some(SystemId(3)),
        device: Some(2),
        camera: Some(ComponentId(100)),
        ..MavlinkPeers::DEFAULT
    };
    let signing = Some(Signing { key: SigningKey::new([7; 32]), began: 1 << 40 });
    let gimbals = [(MavlinkPeers::DEFAULT, None), (named, None), (named, signing)].map(|(peers, signing)| {
        let protocol = ByteProtocolName::MavlinkGimbal { peers, signing };
        let vehicle = GuardedVehicle::Camera { limits: rates, protocol, framing: Framing::CarriageReturns };
        let history = LinkHistory { may_be_turning: false, is_anothers: true, vehicle: Some(SystemId(3)) };
        Settings { vehicle, history, ..settings.clone() }
    });
    let vehicle = GuardedVehicle::Vessel {
        limits: VesselCommand { throttle: 0.6, rudder: 1.0 },
        protocol: VesselProtocol::LabUdp,
    };
    let boat = Settings { vehicle, ..settings.clone() };
    let rovers = [RoverLink { peers: named, ..RoverLink::GUIDED }, RoverLink::MANUAL].map(|link| {
        let vehicle = GuardedVehicle::Vessel {
            limits: VesselCommand { throttle: 1.0, rudder: 1.0 },
            protocol: VesselProtocol::MavlinkRover(link),
        };
        Settings { vehicle, ..settings.clone() }
    });
    for other in gimbals.into_iter().chain([boat]).chain(rovers) {
        let message: ToGuard = ToGuard::Settings(other);
        assert_eq!(ToGuard::decode(&message.encode()), Ok(message));
    }
    let order = VesselOrder::Commanded(VesselCommand { throttle: 0.5, rudder: -0.25 });
    for command in [order, VesselOrder::Released, VesselOrder::NEUTRAL] {
        let message = ToGuard::Request(RequestedCommand { command, renew_by: Some(at) });
        assert_eq!(ToGuard::decode(&message.encode()), Ok(message));
    }
    for message in [
        ToGuard::Settings(settings),
        ToGuard::Request(RequestedCommand { command: rates, renew_by: Some(at) }),
        ToGuard::Request(RequestedCommand::REST),
        ToGuard::TakeControl,
        ToGuard::Close,
    ] {
        assert_eq!(ToGuard::decode(&message.encode()), Ok(message));
    }
    let states = STATES.map(|state| FromGuard::State(state, at));
    let others = [
        FromGuard::Opened,
        FromGuard::NotOpened { may_pass: true, reason: "no such port".to_owned() },
        FromGuard::Received(at, b"!GSStatus 10".to_vec()),
        FromGuard::Lost { may_be_turning: true, reason: "unplugged".to_owned() },
        FromGuard::Control { is_anothers: true },
        FromGuard::HeldUp,
        FromGuard::Suspended(Duration::from_millis(1_500)),
        FromGuard::Stopped(RestEvidence::AtRest),
        FromGuard::Stopped(RestEvidence::Moving { rate: rate(0.2) }),
        FromGuard::Stopped(RestEvidence::NoTelemetry),
        FromGuard::Panicked,
        FromGuard::Alive,
        FromGuard::OpensPort,
        FromGuard::Ended { is_stop_sent: false },
    ];
    for message in states.into_iter().chain(others) {
        assert_eq!(FromGuard::decode(&message.encode()), Ok(message));
    }
}

#[test]
fn what_is_no_message_is_refused() {
    let whole = ToGuard::<VehicleRates>::Request(RequestedCommand::REST).encode();
    for length in 0..whole.len() {
        assert!(Camera::decode(&whole[..length]).is_err(), "{length} bytes");
    }
    let too_long = [&whole[..], &[0]].concat();
    assert_eq!(Camera::decode(&too_long), Err(MessageError::Malformed));
    assert_eq!(Camera::decode(&[99]), Err(MessageError::Malformed));
    assert_eq!(Camera::decode(&[1, 0xff, 0xff]), Err(MessageError::Version));
    for first in 0..=255 {
        let _ = FromGuard::decode(&[first, 7, 7]);
    }
    assert_eq!(FromGuard::decode(&[3, 6, 0, 0, 0, 0, 0, 0, 0, 0]), Err(MessageError::Malformed));
}

#[test]
fn a_text_that_is_too_long_is_cut_between_characters() {
    let long = FromGuard::NotOpened { may_pass: false, reason: "ü".repeat(MAX_MESSAGE_BYTES) }.encode();
    assert!(long.len() <= MAX_MESSAGE_BYTES);
    assert!(matches!(FromGuard::decode(&long), Ok(FromGuard::NotOpened { .. })));
}
