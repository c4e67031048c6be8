//! What a gimbal manager says: messages to facts for the session, and to reports for the pilot.
//!
//! The gimbal manager is the first component that sends GIMBAL_MANAGER_INFORMATION, of the configured system where there is one.
//! Only what its system sends counts. Numbers with a private meaning (NaN, 0/0) become options and variants here.

use barrelman_vocab::mavlink::{Address, MavlinkPeers, SystemId};
use barrelman_vocab::telemetry::EulerAxis;
use barrelman_vocab::telemetry::{ControlState, Quaternion, Report};
use mavlink::MessageData as _;
use mavlink::dialects::common::{
    COMMAND_ACK_DATA, GIMBAL_DEVICE_ATTITUDE_STATUS_DATA, GIMBAL_MANAGER_INFORMATION_DATA,
    GIMBAL_MANAGER_STATUS_DATA, GimbalManagerCapFlags, HEARTBEAT_DATA, MavCmd, MavResult, MavType,
};

use super::command::Gimbal;
use super::frame::{Frame, FrameReader};

/// The uptime may be reported this much earlier than before without a restart, seconds: packets overtake each other.
const UPTIME_TOLERANCE_S: f64 = 1.0;
/// The control is reported again after this time, seconds.
const CONTROL_REPORT_S: f64 = 0.5;
/// A quaternion whose squared norm is further from 1 is damaged.
const NORM_TOLERANCE: f64 = 0.1;

/// What was received.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Received {
    /// A component is there; whether it is a ground station.
    Heartbeat(Address, bool),
    /// The gimbal manager describes its gimbal.
    Information(Information),
    /// Who has the control.
    Holder(Holder),
    /// The answer to a claim or a release of this program.
    ClaimAnswered {
        /// Whether it was accepted.
        is_accepted: bool,
    },
    /// The gimbal's attitude.
    Attitude(Quaternion),
    /// The vehicle's clock begins anew.
    Restarted,
    /// Anything else of the gimbal manager.
    Other,
    /// A report for the pilot.
    Report(Report),
}

/// Who has the primary control of a gimbal.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Holder {
    /// Nobody.
    Nobody,
    /// This program.
    Us,
    /// Somebody else.
    Other(Address),
}

/// What a gimbal manager says of its gimbal: axes and end stops. Angles are radians, pitch above the horizon and yaw to the right.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Information {
    /// The gimbal.
    pub gimbal: Gimbal,
    /// Whether it pitches.
    pub has_pitch: bool,
    /// Whether it yaws.
    pub has_yaw: bool,
    /// Least and largest pitch; `None`: not stated.
    pub pitch_stops: Option<(f64, f64)>,
    /// Least and largest yaw; `None`: not stated, or without end.
    pub yaw_stops: Option<(f64, f64)>,
}

/// Reads the messages of a gimbal manager from received bytes.
#[derive(Debug, Clone)]
pub struct GimbalReader {
    frames: FrameReader,
    facts: Facts,
}

#[derive(Debug, Clone)]
struct Facts {
    peers: MavlinkPeers,
    gimbal: Option<Gimbal>,
    uptime_s: Option<f64>,
    control: Option<ControlState>,
    /// The uptime of the newest report of the control.
    control_reported_s: f64,
}

impl GimbalReader {
    /// A reader between these peers.
    pub fn new(peers: MavlinkPeers) -> Self {
        let facts = Facts { peers, gimbal: None, uptime_s: None, control: None, control_reported_s: 0.0 };
        Self { frames: FrameReader::default(), facts }
    }

    /// Passes what received bytes mean to `each`.
    pub fn read(&mut self, bytes: &[u8], mut each: impl FnMut(Received)) {
        let Self { frames, facts } = self;
        frames.read(bytes, |frame| facts.on_frame(frame, &mut each));
    }
}

impl Facts {
    fn on_frame(&mut self, frame: &Frame<'_>, each: &mut impl FnMut(Received)) {
        let is_ours = frame.from == self.peers.own;
        if is_ours || self.peers.vehicle.is_some_and(|vehicle| vehicle != frame.from.system) {
            return;
        }
        if frame.message == HEARTBEAT_DATA::ID {
            let is_ground_station = frame
                .read::<HEARTBEAT_DATA>()
                .is_some_and(|heartbeat| heartbeat.mavtype == MavType::MAV_TYPE_GCS);
            each(Received::Heartbeat(frame.from, is_ground_station));
        } else if let Some(information) = frame.read::<GIMBAL_MANAGER_INFORMATION_DATA>() {
            self.on_information(frame.from, &information, each);
        }
        let Some(gimbal) = self.gimbal.filter(|gimbal| gimbal.manager.system == frame.from.system) else {
            return;
        };
        let is_manager = frame.from == gimbal.manager;
        let is_device = |id: u8| id == gimbal.device || id == 0;
        if let Some(attitude) = frame.read::<GIMBAL_DEVICE_ATTITUDE_STATUS_DATA>()
            && is_device(attitude.gimbal_device_id)
        {
            self.on_uptime(attitude.time_boot_ms, each);
            on_attitude(attitude.q, each);
            self.report_control_again(each);
        }
        if !is_manager {
            return;
        }
        if let Some(status) = frame.read::<GIMBAL_MANAGER_STATUS_DATA>()
            && is_device(status.gimbal_device_id)
        {
            self.on_uptime(status.time_boot_ms, each);
            self.on_status(&status, each);
        }
        if let Some(answer) = frame.read::<COMMAND_ACK_DATA>()
            && self.is_for_us(&answer)
            && answer.result != MavResult::MAV_RESULT_IN_PROGRESS
        {
            self.on_claim_answered(answer.result == MavResult::MAV_RESULT_ACCEPTED, each);
        }
        each(Received::Other);
    }

    fn is_for_us(&self, answer: &COMMAND_ACK_DATA) -> bool {
        let own = self.peers.own;
        let to = Address::new(answer.target_system, answer.target_component);
        answer.command == MavCmd::MAV_CMD_DO_GIMBAL_MANAGER_CONFIGURE
            && (to == own || to == Address::EVERYONE)
    }

    fn on_information(
        &mut self,
        from: Address,
        information: &GIMBAL_MANAGER_INFORMATION_DATA,
        each: &mut impl FnMut(Received),
    ) {
        let gimbal = Gimbal { manager: from, device: information.gimbal_device_id };
        if *self.gimbal.get_or_insert(gimbal) != gimbal {
            return;
        }
        self.on_uptime(information.time_boot_ms, each);
        let stops = |low: f32, high: f32| {
            let is_stated = low.is_finite() && high.is_finite() && low < high;
            is_stated.then_some((f64::from(low), f64::from(high)))
        };
        let has = |flag: GimbalManagerCapFlags| information.cap_flags.contains(flag);
        let is_endless = has(GimbalManagerCapFlags::GIMBAL_MANAGER_CAP_FLAGS_SUPPORTS_INFINITE_YAW);
        let yaw_stops = stops(information.yaw_min, information.yaw_max);
        each(Received::Information(Information {
            gimbal,
            has_pitch: has(GimbalManagerCapFlags::GIMBAL_MANAGER_CAP_FLAGS_HAS_PITCH_AXIS),
            has_yaw: has(GimbalManagerCapFlags::GIMBAL_MANAGER_CAP_FLAGS_HAS_YAW_AXIS),
            pitch_stops: stops(information.pitch_min, information.pitch_max),
            yaw_stops: yaw_stops.filter(|_| !is_endless),
        }));
    }

    fn on_uptime(&mut self, time_boot_ms: u32, each: &mut impl FnMut(Received)) {
        let uptime_s = f64::from(time_boot_ms) * 1e-3;
        let last_s = self.uptime_s.unwrap_or(0.0);
        if uptime_s < last_s - UPTIME_TOLERANCE_S {
            // Nobody has the control of a vehicle that has just started.
            (self.uptime_s, self.control) = (Some(uptime_s), Some(ControlState::NotOurs));
            each(Received::Restarted);
            self.report_control(each);
        } else {
            self.uptime_s = Some(uptime_s.max(last_s));
        }
    }

    fn on_status(&mut self, status: &GIMBAL_MANAGER_STATUS_DATA, each: &mut impl FnMut(Received)) {
        let primary = Address::new(status.primary_control_sysid, status.primary_control_compid);
        let holder = match primary {
            Address { system: SystemId(0), .. } => Holder::Nobody,
            primary if primary == self.peers.own => Holder::Us,
            primary => Holder::Other(primary),
        };
        each(Received::Holder(holder));
        let is_ours = holder == Holder::Us;
        self.control = Some(if is_ours { ControlState::Ours } else { ControlState::NotOurs });
        self.report_control(each);
    }

    fn on_claim_answered(&mut self, is_accepted: bool, each: &mut impl FnMut(Received)) {
        each(Received::ClaimAnswered { is_accepted });
        self.control = Some(if is_accepted { ControlState::Ours } else { ControlState::NotOurs });
        self.report_control(each);
    }

    fn report_control(&mut self, each: &mut impl FnMut(Received)) {
        if let (Some(control), Some(uptime_s)) = (self.control, self.uptime_s) {
            self.control_reported_s = uptime_s;
            each(Received::Report(Report::Control { control, uptime_s }));
        }
    }

    /// Reports the control again now and then: a manager may send its status at changes only.
    fn report_control_again(&mut self, each: &mut impl FnMut(Received)) {
        if self.uptime_s.is_some_and(|uptime_s| uptime_s >= self.control_reported_s + CONTROL_REPORT_S) {
            self.report_control(each);
        }
    }
}

fn on_attitude(q: [f32; 4], each: &mut impl FnMut(Received)) {
    let [w, x, y, z] = q.map(f64::from);
    let norm = w * w + x * x + y * y + z * z;
    if norm.is_nan() || (norm - 1.0).abs() > NORM_TOLERANCE {
        return;
    }
    let attitude = Quaternion { w, x, y, z };
    each(Received::Attitude(attitude));
    each(Received::Report(Report::GimbalAttitude(attitude)));
    if let Some(tilt) = attitude.angle_about(EulerAxis::Y) {
        each(Received::Report(Report::CameraTilt(tilt)));
    }
}
