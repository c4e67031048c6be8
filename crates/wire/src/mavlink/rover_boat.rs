//! The other end of [`super::rover`]: an ArduPilot boat, as far as set-points, manual control, modes and
//! arming go.

use core::time::Duration;

use barrelman_vocab::mavlink::Address;
use barrelman_vocab::{Timestamp, VesselCommand};
use mavlink::MessageData as _;
use mavlink::dialects::common::{
    COMMAND_ACK_DATA, COMMAND_LONG_DATA, HEARTBEAT_DATA, MANUAL_CONTROL_DATA, MavAutopilot, MavCmd,
    MavModeFlag, MavResult, MavState, MavType, SET_POSITION_TARGET_LOCAL_NED_DATA, VFR_HUD_DATA,
};

use super::frame::{Frame, FrameReader, FrameWriter};
use super::rover::{
    BODY_FRAME, FULL_DEFLECTION, FULL_SPEED_M_PER_S, FULL_TURN_RAD_PER_S, GROUND_STATION, GUIDED, MANUAL,
};

/// ArduPilot Rover's number of the mode HOLD: the boat is stopped.
pub const HOLD: u32 = 4;
/// The boat stops after this time without a set-point, and follows its sticks after this time without manual
/// control.
pub const SET_POINT_TIMEOUT: Duration = Duration::from_secs(3);
const HEARTBEAT_INTERVAL: Duration = Duration::from_secs(1);

/// Settings of the boat.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct RoverBoatSettings {
    /// Address of the autopilot.
    pub address: Address,
    /// Whether the boat is armed at the start.
    pub is_armed: bool,
    /// The mode at the start.
    pub mode: u32,
}

impl Default for RoverBoatSettings {
    fn default() -> Self {
        Self { address: Address::new(1, 1), is_armed: true, mode: MANUAL }
    }
}

/// A boat with its autopilot.
#[derive(Debug, Clone)]
pub struct RoverBoat {
    mode: u32,
    is_armed: bool,
    address: Address,
    reader: FrameReader,
    writer: FrameWriter,
    set_point: Option<(Timestamp, VesselCommand)>,
    /// What overrides the sticks.
    manual: Option<(Timestamp, VesselCommand)>,
    heartbeat_at: Timestamp,
    /// Interval of VFR_HUD, and when the next one is due.
    hud: Option<(Duration, Timestamp)>,
}

impl RoverBoat {
    /// A boat that has just been switched on.
    pub fn new(settings: RoverBoatSettings, now: Timestamp) -> Self {
        let RoverBoatSettings { address, is_armed, mode } = settings;
        Self {
            mode,
            is_armed,
            address,
            reader: FrameReader::default(),
            writer: FrameWriter::new(address, None),
            set_point: None,
            manual: None,
            heartbeat_at: now,
            hud: None,
        }
    }

    /// The mode.
    pub const fn mode(&self) -> u32 {
        self.mode
    }

    /// Somebody else chooses the mode, by a switch of the remote control.
    pub fn switch_to(&mut self, mode: u32) {
        self.mode = mode;
        self.forget_commands();
    }

    /// Somebody else arms or disarms the boat.
    pub fn arm(&mut self, is_armed: bool) {
        self.is_armed = is_armed;
        self.forget_commands();
    }

    fn forget_commands(&mut self) {
        (self.set_point, self.manual, self.heartbeat_at) = (None, None, Timestamp::ZERO);
    }

    /// The command that the autopilot carries out.
    pub fn command(&self, now: Timestamp) -> VesselCommand {
        let heard = match self.mode {
            GUIDED => self.set_point,
            // The sticks are at rest.
            MANUAL => self.manual,
            _ => None,
        };
        let fresh = heard.filter(|(at, _)| *at <= now && now.since(*at) < SET_POINT_TIMEOUT);
        fresh.filter(|_| self.is_armed).map_or(VesselCommand::NEUTRAL, |(_, command)| command)
    }

    /// Processes received bytes, appends answers to `out`, and passes a description of each message to
    /// `on_message`.
    pub fn receive(
        &mut self,
        bytes: &[u8],
        now: Timestamp,
        out: &mut Vec<Vec<u8>>,
        mut on_message: impl FnMut(String),
    ) {
        let mut reader = core::mem::take(&mut self.reader);
        reader.read(bytes, |frame| on_message(self.on_frame(frame, now, out)));
        self.reader = reader;
    }

    /// Appends what is due: the heartbeat, and the speed where it was asked for. The boat has the speed that
    /// it is commanded.
    pub fn advance(&mut self, now: Timestamp, out: &mut Vec<Vec<u8>>) {
        if let Some((interval, at)) = self.hud.filter(|(_, at)| *at <= now) {
            self.hud = Some((interval, at.max(now).plus(interval)));
            let speed = self.command(now).throttle.abs() * FULL_SPEED_M_PER_S;
            out.push(self.writer.write(&VFR_HUD_DATA { groundspeed: speed as f32, ..VFR_HUD_DATA::DEFAULT }));
        }
        if self.heartbeat_at > now {
            return;
        }
        self.heartbeat_at = now.plus(HEARTBEAT_INTERVAL);
        let armed =
            if self.is_armed { MavModeFlag::MAV_MODE_FLAG_SAFETY_ARMED } else { MavModeFlag::empty() };
        out.push(self.writer.write(&HEARTBEAT_DATA {
            custom_mode: self.mode,
            mavtype: MavType::MAV_TYPE_SURFACE_BOAT,
            autopilot: MavAutopilot::MAV_AUTOPILOT_ARDUPILOTMEGA,
            base_mode: MavModeFlag::MAV_MODE_FLAG_CUSTOM_MODE_ENABLED | armed,
            system_status: MavState::MAV_STATE_ACTIVE,
            mavlink_version: 3,
        }));
    }

    fn is_for_us(&self, system: u8, component: u8) -> bool {
        (system == 0 || system == self.address.system.0)
            && (component == 0 || component == self.address.component.0)
    }

    fn on_frame(&mut self, frame: &Frame<'_>, now: Timestamp, out: &mut Vec<Vec<u8>>) -> String {
        let from = frame.from;
        if let Some(set) = frame.read::<SET_POSITION_TARGET_LOCAL_NED_DATA>() {
            let is_body = set.coordinate_frame == BODY_FRAME && set.type_mask.bits() == 0x5C7;
            let is_number = set.vx.is_finite() && set.yaw_rate.is_finite();
            if is_body && is_number && self.is_for_us(set.target_system, set.target_component) {
                let command = VesselCommand {
                    throttle: f64::from(set.vx) / FULL_SPEED_M_PER_S,
                    rudder: f64::from(set.yaw_rate) / FULL_TURN_RAD_PER_S,
                };
                self.set_point = Some((now, command.clamped()));
            }
            return format!("SET_POSITION_TARGET from {from} vx {} yaw_rate {}", set.vx, set.yaw_rate);
        }
        if let Some(manual) = frame.read::<MANUAL_CONTROL_DATA>() {
            if from.system.0 == GROUND_STATION && manual.target == self.address.system.0 {
                let share = |deflection: i16| f64::from(deflection) / FULL_DEFLECTION;
                let command = VesselCommand { throttle: share(manual.z), rudder: share(manual.y) };
                self.manual = Some((now, command.clamped()));
            }
            return format!("MANUAL_CONTROL from {from} y {} z {}", manual.y, manual.z);
        }
        let Some(command) = frame.read::<COMMAND_LONG_DATA>() else {
            return format!("message {} from {from}", frame.message);
        };
        if !self.is_for_us(command.target_system, command.target_component) {
            return format!("COMMAND {} from {from} to another", command.command as u32);
        }
        let result = match command.command {
            MavCmd::MAV_CMD_DO_SET_MODE => {
                self.switch_to(command.param2.max(0.0) as u32);
                MavResult::MAV_RESULT_ACCEPTED
            }
            MavCmd::MAV_CMD_SET_MESSAGE_INTERVAL => {
                if command.param1 == VFR_HUD_DATA::ID as f32 {
                    let interval = Duration::try_from_secs_f32(command.param2 * 1e-6).ok();
                    let interval = interval.filter(|interval| !interval.is_zero());
                    self.hud = interval.map(|interval| (interval, now));
                }
                MavResult::MAV_RESULT_ACCEPTED
            }
            MavCmd::MAV_CMD_COMPONENT_ARM_DISARM => {
                (self.is_armed, self.heartbeat_at) = (command.param1 == 1.0, Timestamp::ZERO);
                MavResult::MAV_RESULT_ACCEPTED
            }
            _ => MavResult::MAV_RESULT_UNSUPPORTED,
        };
        out.push(self.writer.write(&COMMAND_ACK_DATA {
            command: command.command,
            result,
            progress: 0,
            result_param2: 0,
            target_system: from.system.0,
            target_component: from.component.0,
        }));
        format!(
            "COMMAND {} from {from} parameter {} {}",
            command.command as u32, command.param1, command.param2
        )
    }
}
