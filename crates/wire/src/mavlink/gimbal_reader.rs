//! What a gimbal manager says: messages to facts for the session, and to reports for the pilot.
//!
//! The gimbal is the one that [`GimbalChoice`] takes of those that managers describe
//! (GIMBAL_MANAGER_INFORMATION) or report (GIMBAL_MANAGER_STATUS), of the configured system where there is
//! one. Only what its system sends counts. Numbers with a private meaning (NaN, 0/0) become options and
//! variants here.

use barrelman_vocab::mavlink::{Address, MavlinkPeers, SystemId};
use barrelman_vocab::telemetry::{ControlState, Quaternion, Report};
use barrelman_vocab::{Angle, Timestamp};
use mavlink::dialects::common::{
    COMMAND_ACK_DATA, GIMBAL_DEVICE_ATTITUDE_STATUS_DATA, GIMBAL_MANAGER_INFORMATION_DATA,
    GIMBAL_MANAGER_STATUS_DATA, GimbalManagerCapFlags, HEARTBEAT_DATA, MavType,
};

use super::autopilot_reports::AutopilotReports;
use super::camera_information::{CameraInformation, StreamInformation};
use super::command::Gimbal;
use super::frame::{Frame, FrameReader};
use super::gimbal_choice::GimbalChoice;
pub use super::gimbal_information::Information;
use super::signing::Signing;

mod attitude;
mod camera;
mod control;
mod exchange;

/// The uptime may be reported this much earlier than before without a restart, seconds: packets overtake each
/// other.
const UPTIME_TOLERANCE_S: f64 = 1.0;

/// What was received.
#[derive(Debug, Clone, PartialEq)]
pub enum Received {
    /// A component is there; whether it is a ground station.
    Heartbeat(Address, bool),
    /// The gimbal was chosen.
    Gimbal(Gimbal),
    /// A manager describes a gimbal, whether or not it is the one that was chosen.
    Device(Information),
    /// The gimbal manager describes its gimbal.
    Information(Information),
    /// Who has the control.
    Holder(Holder),
    /// The answer to a claim or a release of this program.
    ClaimAnswered(Claim),
    /// The gimbal's attitude.
    Attitude(Quaternion),
    /// The vehicle's clock begins anew, or its gimbal manager has other devices than the one that was chosen:
    /// a gimbal is chosen anew.
    Restarted,
    /// Anything else of the gimbal manager.
    Other,
    /// The camera has taken a command of this program to zoom, or does not know such commands.
    ZoomAnswered,
    /// The horizontal field of view of the camera that zooms.
    FieldOfView(Angle),
    /// What a camera says of itself.
    Camera(CameraInformation),
    /// What a camera says of a stream.
    Stream(StreamInformation),
    /// A report for the pilot.
    Report(Report),
    /// The autopilot's position, or its attitude, was heard.
    Autopilot([bool; 2]),
}

/// What a gimbal manager answers to a claim.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Claim {
    /// The claim was accepted.
    Accepted,
    /// The claim was refused. A claim that is refused for the moment is not: it is repeated.
    Refused,
}

/// Who has the primary control of a gimbal.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Holder {
    /// No commander.
    Nobody,
    /// This program: by its address, or because its claim was accepted by a manager that names no commander.
    Us,
    /// Another commander.
    Other(Address),
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
    choice: GimbalChoice,
    autopilot: AutopilotReports,
    /// What the camera that zooms says of itself.
    camera_information: Option<CameraInformation>,
    /// The newest time since boot in the messages of each kind: parts of a vehicle may have clocks of their
    /// own.
    uptimes: [Option<f64>; 4],
    uptime_s: Option<f64>,
    /// When the gimbal manager spoke of the chosen device last.
    device_heard_s: f64,
    /// Whether a claim of this program was accepted, and no other commander has the control since.
    is_claimed: bool,
    /// Whether the status has named this program since.
    is_named: bool,
    control: Option<ControlState>,
    /// The uptime of the newest report of the control.
    control_reported_s: f64,
}

/// The kinds of messages that tell the time since boot.
#[derive(Debug, Clone, Copy)]
enum Timed {
    Information,
    Status,
    /// An attitude that the manager sends.
    Attitude,
    /// One that the device itself sends, by its own clock.
    DevicesAttitude,
}

impl GimbalReader {
    /// A reader between these peers. With `signing`, packets without a right signature are not read.
    pub fn new(peers: MavlinkPeers, signing: Option<Signing>, now: Timestamp) -> Self {
        let facts = Facts {
            peers,
            gimbal: None,
            choice: GimbalChoice::new(peers.device),
            autopilot: AutopilotReports::default(),
            camera_information: None,
            uptimes: [None; 4],
            uptime_s: None,
            device_heard_s: 0.0,
            is_claimed: false,
            is_named: false,
            control: None,
            control_reported_s: 0.0,
        };
        Self { frames: FrameReader::new(signing, now), facts }
    }

    /// What finds the frames.
    pub(super) const fn frames(&self) -> &FrameReader {
        &self.frames
    }

    /// From now on only a gimbal of this system counts.
    pub const fn name(&mut self, vehicle: SystemId) {
        self.facts.peers.vehicle = Some(vehicle);
    }

    /// The system whose gimbal counts: that of the configuration, or the one that was found.
    pub const fn vehicle(&self) -> Option<SystemId> {
        self.facts.peers.vehicle
    }

    /// The gimbals that were heard.
    pub const fn choice(&self) -> &GimbalChoice {
        &self.facts.choice
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
        if let Some(heartbeat) = frame.read::<HEARTBEAT_DATA>() {
            each(Received::Heartbeat(frame.from, heartbeat.mavtype == MavType::MAV_TYPE_GCS));
        } else if let Some(information) = frame.read::<GIMBAL_MANAGER_INFORMATION_DATA>() {
            let gimbal = Gimbal { manager: frame.from, device: information.gimbal_device_id };
            let described = described(gimbal, &information);
            each(Received::Device(described));
            let chosen = self.choice.on_information(described, uptime_s(information.time_boot_ms));
            if self.gimbal.is_none() {
                self.choose(chosen, each);
            }
            if let Some(gimbal) = self.spoken_of(gimbal, uptime_s(information.time_boot_ms), each) {
                self.on_uptime(Timed::Information, information.time_boot_ms, each);
                each(Received::Information(Information { gimbal, ..described }));
            }
        } else if let Some(status) = frame.read::<GIMBAL_MANAGER_STATUS_DATA>() {
            let gimbal = Gimbal { manager: frame.from, device: status.gimbal_device_id };
            let chosen = self.choice.on_status(gimbal, uptime_s(status.time_boot_ms));
            if self.gimbal.is_none() {
                self.choose(chosen, each);
            }
            if self.spoken_of(gimbal, uptime_s(status.time_boot_ms), each).is_some() {
                // An older status may name a commander who has the control no more.
                if self.on_uptime(Timed::Status, status.time_boot_ms, each) {
                    self.on_status(&status, each);
                }
            }
        } else if let Some(attitude) = frame.read::<GIMBAL_DEVICE_ATTITUDE_STATUS_DATA>() {
            if self.is_of_gimbal(frame.from, attitude.gimbal_device_id) {
                let is_managers = self.gimbal.is_some_and(|gimbal| gimbal.manager == frame.from);
                let kind = if is_managers { Timed::Attitude } else { Timed::DevicesAttitude };
                self.on_uptime(kind, attitude.time_boot_ms, each);
                if attitude.gimbal_device_id != 0 {
                    self.device_heard_s = uptime_s(attitude.time_boot_ms);
                }
                self.on_attitude(&attitude, each);
                self.report_control_again(each);
            }
        } else if let Some(answer) = frame.read::<COMMAND_ACK_DATA>() {
            // The camera's own answer, or that of the autopilot that passes it on.
            let is_of_vehicle = self.camera().is_some_and(|camera| camera.system == frame.from.system);
            if is_of_vehicle && self.is_of_zoom(&answer) {
                each(Received::ZoomAnswered);
            } else if self.is_manager(frame.from) && self.is_of_claim(&answer) {
                self.on_claim_answered(answer.result, each);
            }
        }
        if self.gimbal.is_some_and(|gimbal| gimbal.manager.system == frame.from.system) {
            let kinds = AutopilotReports::kinds(frame);
            if kinds.contains(&true) {
                each(Received::Autopilot(kinds));
            }
            if let Some(report) = self.autopilot.read(frame) {
                each(Received::Report(report));
            }
        }
        if self.camera() == Some(frame.from) {
            self.on_camera(frame, each);
        }
        if let Some(information) = CameraInformation::of(frame) {
            self.on_camera_information(information, each);
        } else if let Some(stream) = StreamInformation::of(frame) {
            each(Received::Stream(stream));
        }
        if self.is_manager(frame.from) {
            each(Received::Other);
        }
    }

    fn is_manager(&self, from: Address) -> bool {
        self.gimbal.is_some_and(|gimbal| gimbal.manager == from)
    }

    /// The gimbal is chosen.
    fn choose(&mut self, chosen: Option<Gimbal>, each: &mut impl FnMut(Received)) {
        let Some(gimbal) = chosen else { return };
        self.gimbal = Some(gimbal);
        // Also after a restart the gimbal is this one.
        self.peers.vehicle = Some(gimbal.manager.system);
        self.choice.want(gimbal.device);
        each(Received::Gimbal(gimbal));
        if let Some(used) = gimbal.equipment() {
            each(Received::Report(Report::Equipment(used)));
        }
    }

    /// The gimbal, if the message of a manager is about it.
    fn known(&mut self, of: Gimbal, each: &mut impl FnMut(Received)) -> Option<Gimbal> {
        let known = self.gimbal.filter(|known| known.manager == of.manager)?;
        if known.device == 0 && of.device != 0 {
            // The manager names its device now.
            self.choose(Some(of), each);
            return Some(of);
        }
        // 0 is every device of the manager.
        (known.device == of.device || of.device == 0).then_some(known)
    }

    /// Whether an attitude is that of the gimbal. A device that is a component of its own leaves the id of
    /// the device out.
    fn is_of_gimbal(&self, from: Address, device: u8) -> bool {
        let Some(gimbal) = self.gimbal.filter(|gimbal| gimbal.manager.system == from.system) else {
            return false;
        };
        // The devices 1 to 6 are the manager's own.
        let is_another_component =
            gimbal.device != 0 && from != gimbal.manager && from.component.0 != gimbal.device;
        match device {
            0 => !is_another_component,
            _ => device == gimbal.device || gimbal.device == 0,
        }
    }

    /// Returns whether the message is the newest of its kind.
    fn on_uptime(&mut self, kind: Timed, time_boot_ms: u32, each: &mut impl FnMut(Received)) -> bool {
        let uptime_s = uptime_s(time_boot_ms);
        let behind_s = self.uptimes[kind as usize].map_or(0.0, |newest_s| newest_s - uptime_s);
        if behind_s > 0.0 && behind_s <= UPTIME_TOLERANCE_S {
            return false;
        }
        self.uptimes[kind as usize] = Some(uptime_s);
        if behind_s > UPTIME_TOLERANCE_S {
            // No commander has the control of a vehicle that has just started.
            self.lose_control(ControlState::Unclaimed);
            (self.uptimes, self.uptime_s, self.gimbal) = ([None; 4], Some(uptime_s), None);
            self.device_heard_s = uptime_s;
            self.autopilot = AutopilotReports::default();
            self.choice.forget();
            each(Received::Restarted);
            self.report_control(each);
        } else {
            self.uptime_s = Some(self.uptime_s.map_or(uptime_s, |known_s| known_s.max(uptime_s)));
        }
        true
    }
}

fn uptime_s(time_boot_ms: u32) -> f64 {
    f64::from(time_boot_ms) * 1e-3
}

/// What a manager says of its gimbal. End stops that are not in order are not stated.
fn described(gimbal: Gimbal, information: &GIMBAL_MANAGER_INFORMATION_DATA) -> Information {
    let stops = |low: f32, high: f32| {
        let is_stated = low.is_finite() && high.is_finite() && low < high;
        is_stated.then_some((f64::from(low), f64::from(high)))
    };
    let has = |flag: GimbalManagerCapFlags| information.cap_flags.contains(flag);
    let is_endless = has(GimbalManagerCapFlags::GIMBAL_MANAGER_CAP_FLAGS_SUPPORTS_INFINITE_YAW);
    Information {
        gimbal,
        has_pitch: has(GimbalManagerCapFlags::GIMBAL_MANAGER_CAP_FLAGS_HAS_PITCH_AXIS),
        has_yaw: has(GimbalManagerCapFlags::GIMBAL_MANAGER_CAP_FLAGS_HAS_YAW_AXIS),
        has_roll: has(GimbalManagerCapFlags::GIMBAL_MANAGER_CAP_FLAGS_HAS_ROLL_AXIS),
        pitch_stops: stops(information.pitch_min, information.pitch_max),
        yaw_stops: stops(information.yaw_min, information.yaw_max).filter(|_| !is_endless),
    }
}
