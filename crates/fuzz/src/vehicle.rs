//! Both ends of the Fotokite Pro's protocol.

use core::time::Duration;

use barrelman_vocab::telemetry::{LinkState, Quaternion, Report};
use barrelman_vocab::{AngularRate, Timestamp, VehicleRates};
use barrelman_wire::fotokite_pro::GroundStation;
use barrelman_wire::fotokite_pro::ground_station::{GroundStationSettings, SensorReadings};
use barrelman_wire::{ByteProtocol, ByteProtocolName, Framing, NextAction, OpenSession as _};

/// The bytes that stand for a time, a request or an end are followed by their arguments; every other byte is
/// received.
const CONTROL: u8 = 0xf8;

/// The client's end: any bytes at any times. Rates that are sent lie within the protocol's limits, every
/// reported number is finite, and the session says when to call it again.
pub fn session(bytes: &[u8]) {
    let framing = if bytes.first().is_some_and(|byte| byte & 1 == 1) {
        Framing::LineFeed
    } else {
        Framing::CarriageReturns
    };
    let mut now = Timestamp::from_secs_f64(1.0);
    let mut session =
        ByteProtocol { protocol: ByteProtocolName::FotokitePro, framing, baud: 115_200 }.open(now);
    let mut is_closing = false;
    let mut sent = Vec::new();
    let mut rest = bytes.iter().copied();
    while let Some(byte) = rest.next() {
        match byte {
            CONTROL.. => {
                let value = rest.next().unwrap_or(0);
                match byte & 3 {
                    0 => now = now.plus(Duration::from_millis(u64::from(value) * 8)),
                    1 => {
                        let rates = rates_of(value, rest.next(), 100.0);
                        session.request(rates, Some(now.plus(Duration::from_millis(300))));
                    }
                    2 => session.request(VehicleRates::REST, None),
                    _ if value == 0 => {
                        session.close(now);
                        is_closing = true;
                    }
                    _ => {}
                }
            }
            received => session.received(&[received], now, &mut |telemetry| check_report(&telemetry.report)),
        }
        match session.poll(now, &mut sent) {
            NextAction::WaitUntil(at) => assert!(at > now || !sent.is_empty() || at == now),
            NextAction::Reopen { reason } => return assert!(!reason.is_empty()),
            NextAction::Closed => return assert!(is_closing || session.link_state() != LinkState::Up),
        }
        for packet in sent.drain(..) {
            check_rates(&packet);
        }
    }
    assert!(!session.last_will(now).is_empty());
}

/// Rates of both axes from two bytes, 128 being none. `steps` are one rad/s.
pub(crate) fn rates_of(yaw: u8, pitch: Option<u8>, steps: f64) -> VehicleRates {
    let rate = |share: u8| AngularRate::from_radians_per_second((f64::from(share) - 128.0) / steps);
    VehicleRates::turning(rate(yaw), rate(pitch.unwrap_or(128)))
}

/// No rate above the limits of the protocol is written.
fn check_rates(packet: &[u8]) {
    let text = std::str::from_utf8(packet).expect("the client writes ASCII");
    for line in text.split(['\r', '\n']) {
        for (name, limit) in [("Yaw ", 0.4), ("GimbalPitch ", 0.3)] {
            if let Some(rate) = line.strip_prefix(name) {
                let rate: f64 = rate.trim().parse().expect("a rate is a number");
                assert!(rate.abs() <= limit, "{line}");
            }
        }
    }
}

/// Whether a conversation goes on after this. It ends only where that was asked for, or for a reason.
pub(crate) fn goes_on(next: NextAction, is_closing: bool) -> bool {
    match next {
        NextAction::WaitUntil(_) => true,
        NextAction::Reopen { reason } => {
            assert!(!reason.is_empty());
            false
        }
        NextAction::Closed => {
            assert!(is_closing, "the end was not asked for");
            false
        }
    }
}

/// Every reported number is finite.
pub(crate) fn check_report(report: &Report) {
    let numbers: Vec<f64> = match report {
        Report::Ground { uptime_s, battery_v, tether_m, .. } => vec![*uptime_s, *battery_v, *tether_m],
        Report::VehicleAttitude(q) | Report::GimbalAttitude(q) => vec![q.w, q.x, q.y, q.z],
        Report::CameraTilt(angle)
        | Report::CameraPan(angle)
        | Report::CameraHeading(angle)
        | Report::FieldOfView(angle) => vec![angle.radians()],
        Report::Position { latitude, longitude, altitude_m, height_m, heading } => {
            let heading = heading.map_or(0.0, |heading| heading.radians());
            vec![latitude.radians(), longitude.radians(), *altitude_m, *height_m, heading]
        }
        Report::Tether { elevation, azimuth, altitude_m } => {
            vec![elevation.radians(), azimuth.radians(), *altitude_m]
        }
        Report::Flight { on_time_s, backup_battery_v, .. } => vec![*on_time_s, *backup_battery_v],
        Report::Control { uptime_s, .. } => vec![*uptime_s],
        Report::CameraHeight(number) | Report::Speed(number) => vec![*number],
        Report::Text(text) => {
            assert!(text.as_str().bytes().all(|byte| (b' '..=b'~').contains(&byte)), "{text:?}");
            vec![]
        }
        Report::Link(_)
        | Report::Acceptance(_)
        | Report::FlightState { .. }
        | Report::DriveMode(_)
        | Report::Equipment(_)
        | Report::Zoom(_)
        | Report::OtherVideo(_) => vec![],
    };
    assert!(numbers.iter().all(|number| number.is_finite()), "{report:?}");
}

/// The ground station's end: any bytes at any times. Its rates are finite.
pub fn ground_station(bytes: &[u8]) {
    let mut now = Timestamp::from_secs_f64(1.0);
    let level = Quaternion { w: 1.0, x: 0.0, y: 0.0, z: 0.0 };
    let readings = SensorReadings {
        attitude: level,
        gimbal: level,
        elevation_rad: 0.2,
        azimuth_rad: 0.1,
        altitude_m: 10.0,
        tether_m: 12.0,
        ground_battery_v: 15.0,
        backup_battery_v: 8.0,
        flight_mode: 2,
        flags: 0,
    };
    let mut station = GroundStation::boot(GroundStationSettings::default(), now);
    let mut out = Vec::new();
    let mut rest = bytes.iter().copied();
    while let Some(byte) = rest.next() {
        if byte >= CONTROL {
            now = now.plus(Duration::from_millis(u64::from(rest.next().unwrap_or(0)) * 8));
            station.tick(now);
            station.write_telemetry(&readings, now, &mut out);
        } else {
            station.receive(&[byte], now, &mut out, |_| {});
        }
        let rates = station.rates();
        for rate in [rates.yaw, rates.pitch, rates.roll] {
            assert!(rate.radians_per_second().is_finite());
        }
        out.clear();
    }
}
