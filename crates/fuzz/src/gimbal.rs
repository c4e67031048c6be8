//! Both ends of MAVLink's gimbal protocol.

use core::time::Duration;

use barrelman_vocab::mavlink::{Address, MavlinkPeers};
use barrelman_vocab::profile::OWN_RATE_LIMITS;
use barrelman_vocab::telemetry::LinkState;
use barrelman_vocab::{Angle, Timestamp, VehicleRates};
use barrelman_wire::mavlink::frame::{FrameReader, FrameWriter};
use barrelman_wire::mavlink::gimbal_manager::{GimbalAngles, GimbalManagerSettings, Habits, MANAGER};
use barrelman_wire::mavlink::{GimbalManager, GimbalSession};
use barrelman_wire::{LinkHistory, Session as _};

use crate::vehicle::{check_report, goes_on, rates_of};

/// The messages of the protocol, whose payloads are any bytes: heartbeat, command, its answer, information,
/// status, attitude, rates.
const MESSAGES: [u32; 7] = [0, 76, 77, 280, 281, 285, 287];

/// Any bytes and any messages at any times, to the client and to a gimbal manager that hears the client.
/// Rates that the client sends lie within the limits, every reported number is finite, nothing moves after
/// the end, and the session says when to call it again.
pub fn mavlink(bytes: &[u8]) {
    let mut rest = bytes.iter().copied();
    let settings = rest.next().unwrap_or(0);
    let habits = if settings & 1 == 1 { Habits::Px4 } else { Habits::ArduPilot };
    let mut now = Timestamp::from_secs_f64(1.0);
    let mut talk = Talk {
        session: GimbalSession::open(MavlinkPeers::DEFAULT, None, now),
        manager: GimbalManager::boot(
            GimbalManagerSettings { habits, ..GimbalManagerSettings::default() },
            now,
        ),
        writer: FrameWriter::new(MANAGER, None),
        is_heard: settings & 2 == 0,
        is_closing: false,
    };
    if settings & 4 == 4 {
        talk.session.resume(LinkHistory { may_be_turning: true, ..LinkHistory::default() });
    }
    while let Some(byte) = rest.next() {
        let value = rest.next().unwrap_or(0);
        match byte % 8 {
            0 => now = now.plus(Duration::from_millis(u64::from(value) * 8)),
            1 => {
                let rates = rates_of(value, rest.next(), 50.0);
                talk.session.request(rates, Some(now.plus(Duration::from_millis(300))));
            }
            2 => talk.session.request(VehicleRates::REST, None),
            3 if value == 0 => {
                talk.session.close(now);
                talk.is_closing = true;
            }
            3 => talk.session.take_control(now),
            4 => {
                let mut out = Vec::new();
                talk.manager.take_over(now, &mut out);
                talk.hear(&out, now);
            }
            5 => {
                let piece: Vec<u8> = rest.by_ref().take(usize::from(value)).collect();
                talk.hear(&[piece], now);
            }
            _ => {
                let message = MESSAGES[usize::from(value) % MESSAGES.len()];
                let length = usize::from(rest.next().unwrap_or(0) % 64);
                let payload: Vec<u8> = rest.by_ref().take(length).collect();
                let packet = talk.writer.write_payload(message, &payload);
                talk.hear(std::slice::from_ref(&packet), now);
                talk.manager.receive(&packet, now, &mut Vec::new(), |_, _| {});
            }
        }
        if !talk.step(now) {
            return;
        }
    }
}

struct Talk {
    session: GimbalSession,
    manager: GimbalManager,
    /// Of messages that only look like those of the manager.
    writer: FrameWriter,
    /// Whether the session hears the manager.
    is_heard: bool,
    is_closing: bool,
}

impl Talk {
    fn hear(&mut self, packets: &[Vec<u8>], now: Timestamp) {
        for packet in packets {
            self.session.received(packet, now, &mut |telemetry| check_report(&telemetry.report));
        }
    }

    /// Returns whether the conversation goes on.
    fn step(&mut self, now: Timestamp) -> bool {
        let (mut sent, mut answers) = (Vec::new(), Vec::new());
        let next = self.session.poll(now, &mut sent);
        for packet in sent {
            check_rates(&packet, self.is_closing);
            self.manager.receive(&packet, now, &mut answers, |_, _| {});
        }
        let angles = GimbalAngles { yaw: Angle::from_radians(0.1), pitch: Angle::from_radians(-0.4) };
        self.manager.write_telemetry(angles, now, &mut answers);
        let rates = self.manager.rates();
        assert!(rates.yaw.radians_per_second().is_finite() && rates.pitch.radians_per_second().is_finite());
        if self.is_heard {
            self.hear(&answers, now);
        }
        goes_on(next, self.is_closing || self.session.link_state() == LinkState::Closed)
    }
}

/// No rate above the limits is written, no angle, and no motion after the end.
fn check_rates(packet: &[u8], is_closing: bool) {
    let mut frames = 0;
    FrameReader::default().read(packet, |frame| {
        frames += 1;
        assert!(frame.from == Address::new(245, 191), "{frame:?}");
        if let Some(rates) = frame.read::<mavlink::dialects::common::GIMBAL_MANAGER_SET_PITCHYAW_DATA>() {
            let (yaw, pitch) = (f64::from(rates.yaw_rate), f64::from(rates.pitch_rate));
            let limits = OWN_RATE_LIMITS;
            assert!(yaw.abs() <= limits.pan.radians_per_second(), "{rates:?}");
            assert!(pitch.abs() <= limits.tilt.radians_per_second(), "{rates:?}");
            assert!(rates.pitch.is_nan() && rates.yaw.is_nan(), "{rates:?}");
            assert!(!is_closing || (yaw == 0.0 && pitch == 0.0), "{rates:?}");
        }
    });
    assert!(frames == 1, "a packet is a frame");
}
