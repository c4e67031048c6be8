//! The gimbal manager's end of the protocol, for the emulator and the tests: an autopilot that moves a
//! gimbal.
//!
//! ```text
//!            1001 with an address, or another commander takes it
//!   Nobody <--------------------------------------------------> primary control of one address
//!                        1001 with -3 by the owner
//! ```
//!
//! Two habits: [`Habits::ArduPilot`] as measured (obeys rates of anybody, keeps a rate for ever, sends its
//! status at changes and on request, the attitude after it was asked for), and [`Habits::Px4`] as its source
//! says (obeys the primary control alone, sends its status at 5 Hz). The manager contains no gimbal: the
//! caller reads the rates and supplies the attitude.

use core::fmt::Write as _;
use core::time::Duration;

use barrelman_vocab::mavlink::Address;
use barrelman_vocab::{Angle, AngularRate, Timestamp, VehicleRates};
use mavlink::dialects::common::{
    COMMAND_ACK_DATA, COMMAND_LONG_DATA, GIMBAL_MANAGER_SET_PITCHYAW_DATA, GimbalManagerFlags, MavCmd,
    MavResult,
};

use super::command::Wanted;
use super::frame::{Frame, FrameReader, FrameWriter};
use super::signing::Signing;

mod camera;
mod reports;

/// The address of the gimbal manager.
pub const MANAGER: Address = Address::new(1, 1);
/// The address of the camera.
pub const CAMERA: Address = Address::new(1, 100);
/// Another commander: a ground station.
pub const OTHER_COMMANDER: Address = Address::new(255, 190);
/// The gimbal device.
pub const DEVICE: u8 = 1;
/// Interval of heartbeats.
const HEARTBEAT_INTERVAL: Duration = Duration::from_secs(1);
/// Interval of PX4's status.
const PX4_STATUS_INTERVAL: Duration = Duration::from_millis(200);

/// How a gimbal manager behaves.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Default)]
pub enum Habits {
    /// As ArduPilot.
    #[default]
    ArduPilot,
    /// As PX4.
    Px4,
}

/// What the vehicle's camera is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Default)]
pub enum CameraKind {
    /// It zooms.
    #[default]
    Zooming,
    /// It does not zoom.
    Fixed,
    /// It says nothing of itself.
    Silent,
}

/// Settings of a gimbal manager.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct GimbalManagerSettings {
    /// How it behaves.
    pub habits: Habits,
    /// Whether it does not answer requests for its information.
    pub withholds_information: bool,
    /// Whether it never says who has the control.
    pub withholds_status: bool,
    /// Whether its status names no commander.
    pub names_nobody: bool,
    /// Whether it denies claims.
    pub denies_claims: bool,
    /// Number of claims that get lost.
    pub dropped_claims: u32,
    /// What the vehicle's camera is.
    pub camera: CameraKind,
    /// How packets are signed; without it, they are not.
    pub signing: Option<Signing>,
}

/// Where the gimbal points.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GimbalAngles {
    /// To the right of the vehicle's heading.
    pub yaw: Angle,
    /// Above the horizon.
    pub pitch: Angle,
}

/// A gimbal manager.
#[derive(Debug, Clone)]
pub struct GimbalManager {
    settings: GimbalManagerSettings,
    frames: FrameReader,
    writer: FrameWriter,
    camera_writer: FrameWriter,
    booted: Timestamp,
    rates: VehicleRates,
    primary: Option<Address>,
    heartbeat_at: Timestamp,
    attitude: Stream,
    status: Stream,
    position: Stream,
    vehicle_attitude: Stream,
    /// Height above the place of the start, metres.
    height_m: f64,
    /// Field of view of the camera, of a vehicle whose camera zooms.
    field_of_view: Option<Angle>,
    field_of_view_stream: Stream,
    claims_lost: u32,
    /// The address of the camera's video; `None`: it names none.
    video: Option<String>,
}

/// A message that is sent again and again.
#[derive(Debug, Clone, Copy)]
struct Stream {
    interval: Option<Duration>,
    next_at: Timestamp,
}

impl Stream {
    fn is_due(&mut self, now: Timestamp) -> bool {
        let Some(interval) = self.interval.filter(|_| self.next_at <= now) else { return false };
        self.next_at = now.plus(interval);
        true
    }
}

impl GimbalManager {
    /// A gimbal manager that was switched on at `now`.
    pub fn boot(settings: GimbalManagerSettings, now: Timestamp) -> Self {
        let stream = |interval| Stream { interval, next_at: now };
        Self {
            settings,
            frames: FrameReader::new(settings.signing, now),
            writer: FrameWriter::new(MANAGER, settings.signing),
            camera_writer: FrameWriter::new(CAMERA, settings.signing),
            booted: now,
            rates: VehicleRates::REST,
            primary: None,
            heartbeat_at: now,
            attitude: stream(None),
            position: stream(None),
            vehicle_attitude: stream(None),
            height_m: 0.0,
            field_of_view: None,
            field_of_view_stream: stream(None),
            status: stream((settings.habits == Habits::Px4).then_some(PX4_STATUS_INTERVAL)),
            claims_lost: 0,
            video: None,
        }
    }

    /// The vehicle is this high above the place of its start, metres.
    pub const fn set_height(&mut self, height_m: f64) {
        self.height_m = height_m;
    }

    /// The camera has this horizontal field of view.
    pub const fn set_field_of_view(&mut self, field_of_view: Option<Angle>) {
        self.field_of_view = field_of_view;
    }

    /// The camera names this address of its video.
    pub fn set_video(&mut self, uri: Option<String>) {
        self.video = uri;
    }

    /// Changes how the manager answers from now on.
    pub fn set_settings(&mut self, settings: GimbalManagerSettings) {
        self.settings = settings;
    }

    /// Processes received bytes, appends the answers to `out`, and passes a description of each message to
    /// `on_message`, with the rates in force after it.
    pub fn receive(
        &mut self,
        bytes: &[u8],
        now: Timestamp,
        out: &mut Vec<Vec<u8>>,
        mut on_message: impl FnMut(&str, VehicleRates),
    ) {
        self.writer.set_time(now);
        let mut frames = core::mem::take(&mut self.frames);
        frames.read(bytes, |frame| {
            let text = self.on_frame(frame, now, out);
            on_message(&text, self.rates);
        });
        self.frames = frames;
    }

    fn on_frame(&mut self, frame: &Frame<'_>, now: Timestamp, out: &mut Vec<Vec<u8>>) -> String {
        let from = frame.from;
        if let Some(message) = frame.read::<GIMBAL_MANAGER_SET_PITCHYAW_DATA>() {
            self.on_rates(from, &message);
            return format!(
                "SET_PITCHYAW from {from} to {} device {} flags {} pitch {} yaw {} pitch_rate {} yaw_rate {}",
                Address::new(message.target_system, message.target_component),
                message.gimbal_device_id,
                message.flags.bits(),
                message.pitch,
                message.yaw,
                message.pitch_rate,
                message.yaw_rate
            );
        }
        if let Some(command) = frame.read::<COMMAND_LONG_DATA>() {
            let to = Address::new(command.target_system, command.target_component);
            let is_for_camera = is_for_manager(to) && to.component == CAMERA.component;
            let result = if is_for_camera && self.settings.camera != CameraKind::Silent {
                Some(self.on_camera_command(&command, now, out))
            } else if is_for_manager(to) {
                self.on_command(from, &command, now, out)
            } else {
                None
            };
            let mut text = format!(
                "COMMAND {} from {from} to {to} parameters {} {} {}",
                command.command as u32, command.param1, command.param2, command.param7
            );
            if let Some(result) = result {
                out.push(self.writer.write(&COMMAND_ACK_DATA {
                    command: command.command,
                    result,
                    progress: 0,
                    result_param2: 0,
                    target_system: from.system.0,
                    target_component: from.component.0,
                }));
                // Writing to memory cannot fail.
                let _ = write!(text, " result {}", result as u32);
            }
            return text;
        }
        format!("message {} from {from}", frame.message)
    }

    /// Rates are carried out where both are finite and no angle is given.
    fn on_rates(&mut self, from: Address, message: &GIMBAL_MANAGER_SET_PITCHYAW_DATA) {
        let is_obeyed = match self.settings.habits {
            Habits::ArduPilot => true,
            Habits::Px4 => self.primary == Some(from),
        };
        let to = Address::new(message.target_system, message.target_component);
        let is_gimbal = message.gimbal_device_id == 0 || message.gimbal_device_id == DEVICE;
        let has_angles = message.pitch.is_finite() && message.yaw.is_finite();
        let has_rates = message.pitch_rate.is_finite() && message.yaw_rate.is_finite();
        if !is_obeyed || !is_for_manager(to) || !is_gimbal || has_angles || !has_rates {
            return;
        }
        let holds = GimbalManagerFlags::GIMBAL_MANAGER_FLAGS_RETRACT
            | GimbalManagerFlags::GIMBAL_MANAGER_FLAGS_NEUTRAL;
        let rate = |value: f32| AngularRate::from_radians_per_second(f64::from(value));
        self.rates = if message.flags.intersects(holds) {
            VehicleRates::REST
        } else {
            VehicleRates::turning(rate(message.yaw_rate), rate(message.pitch_rate))
        }
        .zooming(self.rates.zoom);
    }

    /// Carries a command out; `None`: it is not answered.
    fn on_command(
        &mut self,
        from: Address,
        command: &COMMAND_LONG_DATA,
        now: Timestamp,
        out: &mut Vec<Vec<u8>>,
    ) -> Option<MavResult> {
        let wanted = |message: Wanted| command.param1 == message.id() as f32;
        Some(match command.command {
            MavCmd::MAV_CMD_REQUEST_MESSAGE if wanted(Wanted::ManagerInformation) => {
                if self.settings.withholds_information {
                    return None;
                }
                let information = self.information(now);
                out.push(self.writer.write(&information));
                MavResult::MAV_RESULT_ACCEPTED
            }
            MavCmd::MAV_CMD_REQUEST_MESSAGE
                if wanted(Wanted::ManagerStatus) && !self.settings.withholds_status =>
            {
                self.send_status(now, out);
                MavResult::MAV_RESULT_ACCEPTED
            }
            MavCmd::MAV_CMD_SET_MESSAGE_INTERVAL if wanted(Wanted::Attitude) => {
                self.attitude = stream_of(command.param2, now);
                MavResult::MAV_RESULT_ACCEPTED
            }
            MavCmd::MAV_CMD_SET_MESSAGE_INTERVAL if wanted(Wanted::ManagerStatus) => {
                if !self.settings.withholds_status {
                    self.status = stream_of(command.param2, now);
                }
                MavResult::MAV_RESULT_ACCEPTED
            }
            MavCmd::MAV_CMD_SET_MESSAGE_INTERVAL if wanted(Wanted::Position) => {
                self.position = stream_of(command.param2, now);
                MavResult::MAV_RESULT_ACCEPTED
            }
            MavCmd::MAV_CMD_SET_MESSAGE_INTERVAL if wanted(Wanted::VehicleAttitude) => {
                self.vehicle_attitude = stream_of(command.param2, now);
                MavResult::MAV_RESULT_ACCEPTED
            }
            MavCmd::MAV_CMD_REQUEST_MESSAGE | MavCmd::MAV_CMD_SET_MESSAGE_INTERVAL => {
                MavResult::MAV_RESULT_FAILED
            }
            MavCmd::MAV_CMD_DO_GIMBAL_MANAGER_CONFIGURE => return self.on_configure(from, command, now, out),
            _ => MavResult::MAV_RESULT_UNSUPPORTED,
        })
    }

    fn on_configure(
        &mut self,
        from: Address,
        command: &COMMAND_LONG_DATA,
        now: Timestamp,
        out: &mut Vec<Vec<u8>>,
    ) -> Option<MavResult> {
        if self.claims_lost < self.settings.dropped_claims {
            self.claims_lost += 1;
            return None;
        }
        if command.param7 != 0.0 && command.param7 != f32::from(DEVICE) {
            return Some(MavResult::MAV_RESULT_FAILED);
        }
        let primary = if command.param1 == -3.0 {
            self.primary.filter(|primary| *primary != from)
        } else if command.param1 > 0.0 || command.param1 == -2.0 {
            if self.settings.denies_claims {
                return Some(MavResult::MAV_RESULT_DENIED);
            }
            let is_named = command.param1 > 0.0;
            Some(if is_named { Address::new(command.param1 as u8, command.param2 as u8) } else { from })
        } else {
            self.primary
        };
        self.set_primary(primary, now, out);
        Some(MavResult::MAV_RESULT_ACCEPTED)
    }

    fn set_primary(&mut self, primary: Option<Address>, now: Timestamp, out: &mut Vec<Vec<u8>>) {
        if self.primary != primary {
            self.primary = primary;
            self.send_status(now, out);
        }
    }

    /// Another commander takes the control. The rates go on until its first command.
    pub fn take_over(&mut self, now: Timestamp, out: &mut Vec<Vec<u8>>) {
        self.set_primary(Some(OTHER_COMMANDER), now, out);
    }

    /// The commander that has the control gives it back. The rates go on.
    pub fn give_back(&mut self, now: Timestamp, out: &mut Vec<Vec<u8>>) {
        self.set_primary(None, now, out);
    }

    /// The rates in force: yaw to the right, pitch upwards.
    pub const fn rates(&self) -> VehicleRates {
        self.rates
    }

    /// Who has the primary control.
    pub const fn primary(&self) -> Option<Address> {
        self.primary
    }
}

/// A stream with this interval, microseconds; one that is no time, or 0, ends it.
fn stream_of(interval_us: f32, now: Timestamp) -> Stream {
    let interval = Duration::try_from_secs_f32(interval_us * 1e-6).ok();
    Stream { interval: interval.filter(|interval| !interval.is_zero()), next_at: now }
}

/// Whether a message with this target is for the gimbal manager. 0 is everyone, and the autopilot takes what
/// is for a component that is not there.
fn is_for_manager(to: Address) -> bool {
    to.system == MANAGER.system || to.system.0 == 0
}
