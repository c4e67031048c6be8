//! A session and a gimbal manager in virtual time, with a gimbal that turns at the rates in force.

use core::time::Duration;

use barrelman_vocab::mavlink::{Address, MavlinkPeers};
use barrelman_vocab::telemetry::{ControlState, LinkState, Report};
use barrelman_vocab::{Angle, AngularRate, Timestamp, VehicleRates};
use barrelman_wire::mavlink::frame::FrameReader;
use barrelman_wire::mavlink::gimbal_manager::{GimbalAngles, GimbalManagerSettings};
use barrelman_wire::mavlink::{GimbalManager, GimbalSession};
use barrelman_wire::{NextAction, Session as _};
use mavlink::MessageData as _;
use mavlink::dialects::common::{COMMAND_LONG_DATA, GIMBAL_MANAGER_SET_PITCHYAW_DATA, HEARTBEAT_DATA};

pub(super) fn at(ms: u64) -> Timestamp {
    Timestamp::from_nanos(ms * 1_000_000)
}

pub(super) fn rates(yaw: f64, pitch: f64) -> VehicleRates {
    let rate = AngularRate::from_radians_per_second;
    VehicleRates::turning(rate(yaw), rate(pitch))
}

/// A message that the session sent, at this time in ms.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Sent {
    Heartbeat,
    /// Target, device, yaw rate, pitch rate.
    Rates(Address, u8, f32, f32),
    /// Command, target, first two parameters.
    Command(u32, Address, f32, f32),
}

impl Sent {
    pub(super) fn is_zeros(&self) -> bool {
        matches!(self, Self::Rates(_, _, yaw, pitch) if *yaw == 0.0 && *pitch == 0.0)
    }

    pub(super) fn is_motion(&self) -> bool {
        matches!(self, Self::Rates(..)) && !self.is_zeros()
    }

    pub(super) fn is_command(&self, id: u32) -> bool {
        matches!(self, Self::Command(command, ..) if *command == id)
    }
}

/// What is in a packet of the session: one frame, with the address of an onboard computer.
pub(super) fn sent(packet: &[u8]) -> Sent {
    let mut found = Vec::new();
    FrameReader::default().read(packet, |frame| {
        assert_eq!(frame.from, MavlinkPeers::DEFAULT.own);
        let message = if frame.message == HEARTBEAT_DATA::ID {
            Sent::Heartbeat
        } else if let Some(message) = frame.read::<GIMBAL_MANAGER_SET_PITCHYAW_DATA>() {
            assert!(message.pitch.is_nan() && message.yaw.is_nan(), "an angle would win over the rates");
            assert_eq!(message.flags.bits(), 12, "roll and pitch against the horizon, and nothing else");
            let to = Address::new(message.target_system, message.target_component);
            Sent::Rates(to, message.gimbal_device_id, message.yaw_rate, message.pitch_rate)
        } else {
            let command = frame.read::<COMMAND_LONG_DATA>().expect("no other message leaves");
            let to = Address::new(command.target_system, command.target_component);
            Sent::Command(command.command as u32, to, command.param1, command.param2)
        };
        found.push(message);
    });
    assert_eq!(found.len(), 1, "a packet is one frame: {packet:02x?}");
    found.remove(0)
}

pub(super) struct Bench {
    pub(super) session: GimbalSession,
    pub(super) manager: GimbalManager,
    pub(super) now_ms: u64,
    /// Whether packets pass, to the manager and from it.
    pub(super) passes: (bool, bool),
    /// Whether the gimbal turns on, whatever it is told.
    pub(super) is_stuck_moving: bool,
    pub(super) sent: Vec<(u64, Sent)>,
    pub(super) reports: Vec<(u64, Report)>,
    pub(super) last: NextAction,
    angles: (f64, f64),
}

impl Bench {
    pub(super) fn new(settings: GimbalManagerSettings) -> Self {
        Self::with_peers(settings, MavlinkPeers::DEFAULT)
    }

    pub(super) fn with_peers(settings: GimbalManagerSettings, peers: MavlinkPeers) -> Self {
        Self {
            session: GimbalSession::open(peers, settings.signing, at(0)),
            manager: GimbalManager::boot(settings, at(0)),
            now_ms: 0,
            passes: (true, true),
            is_stuck_moving: false,
            sent: Vec::new(),
            reports: Vec::new(),
            last: NextAction::WaitUntil(at(0)),
            angles: (0.0, -0.4),
        }
    }

    /// A session that is up.
    pub(super) fn up(settings: GimbalManagerSettings) -> Self {
        let mut bench = Self::new(settings);
        bench.run_until("the link is up", |bench| bench.session.link_state() == LinkState::Up);
        bench
    }

    pub(super) fn step(&mut self) {
        const STEP_MS: u64 = 5;
        let now = at(self.now_ms);
        let in_force = if self.is_stuck_moving { rates(0.3, 0.0) } else { self.manager.rates() };
        let step_s = STEP_MS as f64 * 1e-3;
        self.angles.0 += in_force.yaw.radians_per_second() * step_s;
        self.angles.1 += in_force.pitch.radians_per_second() * step_s;
        let angles = GimbalAngles {
            yaw: Angle::from_radians(self.angles.0),
            pitch: Angle::from_radians(self.angles.1),
        };
        let mut answers = Vec::new();
        let mut out = Vec::new();
        self.last = self.session.poll(now, &mut out);
        for packet in out {
            self.sent.push((self.now_ms, sent(&packet)));
            if self.passes.0 {
                self.manager.receive(&packet, now, &mut answers, |_, _| {});
            }
        }
        self.manager.write_telemetry(angles, now, &mut answers);
        self.deliver(&answers);
        self.now_ms += STEP_MS;
    }

    pub(super) fn deliver(&mut self, packets: &[Vec<u8>]) {
        let now = at(self.now_ms);
        let (reports, now_ms) = (&mut self.reports, self.now_ms);
        if self.passes.1 {
            for packet in packets {
                self.session.received(packet, now, &mut |telemetry| reports.push((now_ms, telemetry.report)));
            }
        }
    }

    pub(super) fn run(&mut self, time: Duration) {
        let end = self.now_ms + time.as_millis() as u64;
        while self.now_ms < end {
            self.step();
        }
    }

    #[track_caller]
    pub(super) fn run_until(&mut self, what: &str, is_there: impl Fn(&Self) -> bool) {
        let end = self.now_ms + 20_000;
        while !is_there(self) {
            assert!(self.now_ms < end, "not within 20 s: {what}; sent {:?}", self.sent.last());
            self.step();
        }
    }

    /// What was sent from then on.
    pub(super) fn since(&self, ms: u64) -> impl Iterator<Item = &(u64, Sent)> {
        self.sent.iter().filter(move |(at, _)| *at >= ms)
    }

    /// Who has the control, as reported last.
    pub(super) fn control(&self) -> Option<ControlState> {
        self.reports.iter().rev().find_map(|(_, report)| match report {
            Report::Control { control, .. } => Some(*control),
            _ => None,
        })
    }

    /// Another commander takes the control.
    pub(super) fn take_over(&mut self) {
        let mut out = Vec::new();
        self.manager.take_over(at(self.now_ms), &mut out);
        self.deliver(&out);
    }

    /// The commander that has the control gives it back.
    pub(super) fn give_back(&mut self) {
        let mut out = Vec::new();
        self.manager.give_back(at(self.now_ms), &mut out);
        self.deliver(&out);
    }

    /// Number of claims that were sent.
    pub(super) fn claims(&self) -> usize {
        self.sent.iter().filter(|(_, sent)| sent.is_command(1001)).count()
    }
}
