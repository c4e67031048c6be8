//! The rates in a recording equal the rates that the link writes.

use barrelman_station::config::{self, Configuration};
use barrelman_vocab::telemetry::LinkState;
use barrelman_vocab::{AngularRate, CameraCommand, Timestamp, VehicleProfile, VehicleRates};
use barrelman_wire::fotokite_pro::session::PROMPT;
use barrelman_wire::{ByteProtocol, ByteProtocolName, Framing, OpenSession as _};

use crate::program::{argument, barrelman, empty_folder, succeeded};

fn at(ms: u64) -> Timestamp {
    Timestamp::from_nanos(ms * 1_000_000)
}

/// The last yaw and pitch lines that a session writes for these rates.
fn written(rates: VehicleRates) -> [String; 2] {
    let protocol = ByteProtocolName::of(VehicleProfile::fotokite_pro().protocol).unwrap();
    let mut session = ByteProtocol { protocol, framing: Framing::LineFeed, baud: 115_200 }.open(at(0));
    let mut packets = Vec::new();
    for ms in 0..10_000 {
        session.poll(at(ms), &mut packets);
        if ms == 1_000 {
            session.received(PROMPT.as_bytes(), at(ms), &mut |_| {});
        }
        if session.link_state() == LinkState::Up {
            session.request(rates, Some(at(60_000)));
        }
    }
    assert_eq!(session.link_state(), LinkState::Up);
    let text = String::from_utf8(packets.concat()).unwrap();
    let last = |axis: &str| text.lines().rfind(|line| line.starts_with(axis)).unwrap().to_owned();
    [last("Yaw "), last("GimbalPitch ")]
}

fn profile(limits: &str) -> Result<VehicleProfile, String> {
    let file = config::parse(&format!("[vehicle]\n{limits}")).unwrap();
    Configuration::resolve(&file).map(|all| all.profile).map_err(|error| format!("{error:#}"))
}

#[test]
fn excessive_rates_are_recorded_as_they_are_written() {
    let mut accepted = 0;
    for limits in [
        "",
        "limit_pan_rad_per_s = 0.35\nlimit_tilt_rad_per_s = 0.3\n",
        "limit_pan_rad_per_s = 0.5\n",
        "limit_tilt_rad_per_s = 0.4\n",
        "limit_pan_rad_per_s = 3.0\nlimit_tilt_rad_per_s = 3.0\n",
    ] {
        let Ok(profile) = profile(limits) else { continue };
        accepted += 1;
        for rate in [-9.0, -0.7, -0.35, -0.2, 0.0, 0.301, 0.45, 3.0, f64::INFINITY, f64::NAN] {
            let rate = AngularRate::from_radians_per_second(rate);
            let recorded = profile.to_vehicle(CameraCommand::turning(rate, rate));
            let expected = [
                format!("Yaw {:.6}", recorded.yaw.radians_per_second()),
                format!("GimbalPitch {:.6}", recorded.pitch.radians_per_second()),
            ];
            assert_eq!(written(recorded), expected, "{rate:?} with {limits:?}");
        }
    }
    assert_eq!(accepted, 2, "limits above the vehicle's are refused");
}

#[test]
fn a_simulated_vehicle_that_is_faster_than_the_real_one_is_recorded_and_replayed() {
    let folder = empty_folder("sent-rates");
    let trial = ["trials", "lab2", "--perception", "truth", "--trials", "1", "--rate", "3", "--record"];
    succeeded(&barrelman(&[&trial[..], &[argument(&folder)]].concat()));
    succeeded(&barrelman(&["replay", argument(&folder.join("lab2-1.mcap")), "--compare"]));
}
