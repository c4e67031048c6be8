//! The commands that this program can send to a gimbal manager.
//!
//! [`Command`] contains all of them. Arming, take-off, modes, missions, positions, and the gimbal's retract
//! and neutral are not in it, so that they cannot be sent.

use core::time::Duration;

use barrelman_vocab::mavlink::Address;
use barrelman_vocab::profile::OWN_RATE_LIMITS;
use barrelman_vocab::{AngularRate, Equipment, EquipmentKind, VehicleRates};
use mavlink::dialects::common::{
    COMMAND_LONG_DATA, GIMBAL_MANAGER_SET_PITCHYAW_DATA, GimbalManagerFlags, MavCmd, MavType,
};

use super::command_long::{command_long, request_message, set_interval};
use super::frame::FrameWriter;
use super::heartbeat::heartbeat;

/// A gimbal of a gimbal manager.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Gimbal {
    /// The gimbal manager.
    pub manager: Address,
    /// The gimbal device; 0: all devices of the manager.
    pub device: u8,
}

impl Gimbal {
    /// All gimbals that hear it.
    pub const ALL: Self = Self { manager: Address::EVERYONE, device: 0 };

    /// The gimbal by its name; `None`: its manager has not named its device.
    pub fn equipment(self) -> Option<Equipment> {
        let Self { manager, device } = self;
        let name = (device != 0).then(|| format!("device {device} of {manager}"))?;
        Some(Equipment::new(EquipmentKind::Gimbal, &name))
    }
}

/// A message that can be asked for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Wanted {
    /// GIMBAL_MANAGER_INFORMATION (280): axes and end stops.
    ManagerInformation,
    /// GIMBAL_MANAGER_STATUS (281): who has the control.
    ManagerStatus,
    /// GIMBAL_DEVICE_ATTITUDE_STATUS (285).
    Attitude,
    /// GLOBAL_POSITION_INT (33): where the vehicle is, and how high.
    Position,
    /// ATTITUDE (30) of the vehicle.
    VehicleAttitude,
    /// CAMERA_FOV_STATUS (271).
    FieldOfView,
    /// CAMERA_INFORMATION (259): what the camera is, and can do.
    CameraInformation,
    /// VIDEO_STREAM_INFORMATION (269): all streams of the camera.
    StreamInformation,
}

impl Wanted {
    /// The id of the message.
    pub const fn id(self) -> u32 {
        match self {
            Self::ManagerInformation => 280,
            Self::ManagerStatus => 281,
            Self::Attitude => 285,
            Self::Position => 33,
            Self::VehicleAttitude => 30,
            Self::FieldOfView => 271,
            Self::CameraInformation => 259,
            Self::StreamInformation => 269,
        }
    }
}

/// A command of this program.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Command {
    /// HEARTBEAT (0): this program is there, as an onboard controller.
    Heartbeat,
    /// MAV_CMD_REQUEST_MESSAGE (512).
    Request {
        /// Who is asked.
        to: Address,
        /// What for.
        message: Wanted,
    },
    /// MAV_CMD_SET_MESSAGE_INTERVAL (511).
    SetInterval {
        /// Who is asked.
        to: Address,
        /// What for.
        message: Wanted,
        /// The time between two of them.
        interval: Duration,
    },
    /// MAV_CMD_DO_GIMBAL_MANAGER_CONFIGURE (1001) with this program's own address: takes the control.
    Claim(Gimbal),
    /// MAV_CMD_DO_GIMBAL_MANAGER_CONFIGURE (1001) with -3: gives the control back.
    Release(Gimbal),
    /// MAV_CMD_SET_CAMERA_ZOOM (531), continuous.
    Zoom {
        /// The camera.
        camera: Address,
        /// -1 to 1 of its largest speed, positive to a closer view; a speed that is no number is zero.
        speed: f64,
    },
    /// GIMBAL_MANAGER_SET_PITCHYAW (287): rates, clamped to the protocol's limits; roll and pitch stay
    /// against the horizon.
    Rates(Gimbal, VehicleRates),
}

impl Command {
    /// The command as a packet of this sender.
    pub fn encode(self, writer: &mut FrameWriter) -> Vec<u8> {
        let own = writer.address();
        match self {
            Self::Heartbeat => writer.write(&heartbeat(MavType::MAV_TYPE_ONBOARD_CONTROLLER)),
            Self::Request { to, message } => writer.write(&request_message(to, message.id())),
            Self::SetInterval { to, message, interval } => {
                writer.write(&set_interval(to, message.id(), interval))
            }
            Self::Claim(gimbal) => {
                let (system, component) = (f32::from(own.system.0), f32::from(own.component.0));
                writer.write(&configure(gimbal, [system, component]))
            }
            Self::Release(gimbal) => writer.write(&configure(gimbal, [-3.0, -3.0])),
            Self::Zoom { camera, speed } => {
                let speed = if speed.is_nan() { 0.0 } else { speed.clamp(-1.0, 1.0) };
                let parameters = [CONTINUOUS_ZOOM, speed as f32 + 0.0, 0.0, 0.0, 0.0, 0.0, 0.0];
                writer.write(&command_long(camera, MavCmd::MAV_CMD_SET_CAMERA_ZOOM, parameters))
            }
            Self::Rates(gimbal, rates) => {
                let limits = OWN_RATE_LIMITS;
                writer.write(&GIMBAL_MANAGER_SET_PITCHYAW_DATA {
                    flags: GimbalManagerFlags::GIMBAL_MANAGER_FLAGS_ROLL_LOCK
                        | GimbalManagerFlags::GIMBAL_MANAGER_FLAGS_PITCH_LOCK,
                    // Angles that are numbers would win over the rates.
                    pitch: f32::NAN,
                    yaw: f32::NAN,
                    pitch_rate: encodable(rates.pitch, limits.tilt),
                    yaw_rate: encodable(rates.yaw, limits.pan),
                    target_system: gimbal.manager.system.0,
                    target_component: gimbal.manager.component.0,
                    gimbal_device_id: gimbal.device,
                })
            }
        }
    }
}

/// ZOOM_TYPE_CONTINUOUS: a speed, until the next one.
pub(super) const CONTINUOUS_ZOOM: f32 = 1.0;

/// A rate within the limit; a rate that is not a number is zero.
fn encodable(rate: AngularRate, limit: AngularRate) -> f32 {
    // Positive zero for both zeros.
    rate.clamped(limit).radians_per_second() as f32 + 0.0
}

fn configure(gimbal: Gimbal, primary: [f32; 2]) -> COMMAND_LONG_DATA {
    const KEEP: f32 = -1.0;
    let parameters = [primary[0], primary[1], KEEP, KEEP, 0.0, 0.0, f32::from(gimbal.device)];
    command_long(gimbal.manager, MavCmd::MAV_CMD_DO_GIMBAL_MANAGER_CONFIGURE, parameters)
}
