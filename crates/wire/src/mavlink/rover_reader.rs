//! What an ArduPilot boat says: whether it takes commands, and why not; its speed; its texts.
//!
//! | message | what it becomes |
//! |---|---|
//! | HEARTBEAT (0) | mode, armed or not, whether the autopilot is starting |
//! | SYS_STATUS (1) | whether the checks before arming pass |
//! | COMMAND_ACK (77) of a mode that was asked for | whether the boat has refused it |
//! | GLOBAL_POSITION_INT (33), VFR_HUD (74) | speed over ground; of the first one also the time since boot, which tells a restart |
//! | STATUSTEXT (253) | texts |

use barrelman_vocab::acceptance::Acceptance;
use barrelman_vocab::drive_mode::DriveMode;
use barrelman_vocab::mavlink::{Address, SystemId};
use barrelman_vocab::telemetry::Report;
use mavlink::MessageData as _;
use mavlink::dialects::common::{
    COMMAND_ACK_DATA, GLOBAL_POSITION_INT_DATA, HEARTBEAT_DATA, MavAutopilot, MavCmd, MavModeFlag, MavResult,
    MavState, MavSysStatusSensor, MavType, STATUSTEXT_DATA, SYS_STATUS_DATA, VFR_HUD_DATA,
};

use super::frame::{Frame, FrameReader};
use super::rover_link::RoverLink;
use super::status_texts::StatusTexts;

/// The component id of an autopilot.
const AUTOPILOT: u8 = 1;
/// A time since boot that falls by more than this tells a restart, milliseconds: packets overtake each other.
const RESTART_MS: u32 = 1_000;
/// A faster boat is a damaged number, m/s.
const MAX_SPEED_M_PER_S: f64 = 50.0;

/// What the boat's heartbeat says.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct BoatMode {
    mode: DriveMode,
    /// Whether the boat is in the mode in which it is driven.
    pub(super) is_ours: bool,
    is_armed: bool,
    is_starting: bool,
}

/// What of the boat was in received bytes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Heard {
    /// Whether there was any packet of the boat.
    pub is_any: bool,
    /// Whether there was its mode.
    pub is_mode: bool,
    /// Whether there were the messages that are asked for: [`ASKED_FOR`].
    pub asked_for: [bool; 3],
}

/// The messages that are asked for where they do not come.
pub const ASKED_FOR: [u32; 3] = [GLOBAL_POSITION_INT_DATA::ID, VFR_HUD_DATA::ID, SYS_STATUS_DATA::ID];

/// Reads what the boat reports from received bytes.
#[derive(Debug, Clone)]
pub struct RoverReader {
    pub(super) link: RoverLink,
    frames: FrameReader,
    pub(super) boat: Option<Address>,
    pub(super) mode: Option<BoatMode>,
    /// Whether the checks before arming pass; `None`: the boat does not say.
    do_checks_pass: Option<bool>,
    /// Whether the boat has refused the mode that it was asked for, and is in the same mode since.
    is_mode_refused: bool,
    uptime_ms: Option<u32>,
    texts: StatusTexts,
}

impl RoverReader {
    /// A reader that has heard nothing.
    pub fn new(link: RoverLink) -> Self {
        Self {
            link,
            frames: FrameReader::default(),
            boat: None,
            mode: None,
            do_checks_pass: None,
            is_mode_refused: false,
            uptime_ms: None,
            texts: StatusTexts::default(),
        }
    }

    /// From now on the boat is one of this system.
    pub const fn name(&mut self, vehicle: SystemId) {
        self.link.peers.vehicle = Some(vehicle);
    }

    /// The system of the boat: that of the configuration, or the one that was heard.
    pub fn vehicle(&self) -> Option<SystemId> {
        self.link.peers.vehicle.or(self.boat.map(|boat| boat.system))
    }

    /// Passes what the boat says to commands to `each`, with each of its heartbeats. Returns what was heard
    /// of the boat.
    pub fn read(&mut self, bytes: &[u8], mut each: impl FnMut(Report)) -> Heard {
        let mut frames = core::mem::take(&mut self.frames);
        let mut heard = Heard::default();
        frames.read(bytes, |frame| self.on_frame(frame, &mut heard, &mut each));
        self.frames = frames;
        heard
    }

    fn on_frame(&mut self, frame: &Frame<'_>, heard: &mut Heard, each: &mut impl FnMut(Report)) {
        if let Some(mode) = self.mode_of(frame) {
            (heard.is_any, heard.is_mode) = (true, true);
            self.on_mode(mode, each);
        }
        if self.boat != Some(frame.from) {
            return;
        }
        heard.is_any = true;
        for (message, is_heard) in ASKED_FOR.iter().zip(&mut heard.asked_for) {
            *is_heard |= frame.message == *message;
        }
        if let Some(position) = frame.read::<GLOBAL_POSITION_INT_DATA>() {
            self.on_uptime(position.time_boot_ms, each);
            // 0/0 is no position, and then there is no speed.
            if (position.lat, position.lon) != (0, 0) {
                let [north, east] = [position.vx, position.vy].map(|speed| f64::from(speed) * 1e-2);
                report_speed(libm::hypot(north, east), each);
            }
        } else if let Some(hud) = frame.read::<VFR_HUD_DATA>() {
            report_speed(f64::from(hud.groundspeed), each);
        } else if let Some(status) = frame.read::<SYS_STATUS_DATA>() {
            self.on_checks(&status, each);
        } else if let Some(answer) = frame.read::<COMMAND_ACK_DATA>() {
            self.on_answer(&answer, each);
        } else if let Some(text) = frame.read::<STATUSTEXT_DATA>() {
            self.texts.on_text(&text, |text| each(Report::Text(text)));
        }
    }

    /// The mode in a heartbeat of the boat; the first boat that is heard is the boat.
    fn mode_of(&mut self, frame: &Frame<'_>) -> Option<BoatMode> {
        let is_named = self.link.peers.vehicle.is_none_or(|system| system == frame.from.system);
        let is_boat = self.boat.map_or(is_named, |boat| boat == frame.from);
        if frame.from.component.0 != AUTOPILOT || !is_boat {
            return None;
        }
        let heard = frame.read::<HEARTBEAT_DATA>()?;
        let moves_on_the_ground =
            matches!(heard.mavtype, MavType::MAV_TYPE_SURFACE_BOAT | MavType::MAV_TYPE_GROUND_ROVER);
        if heard.autopilot == MavAutopilot::MAV_AUTOPILOT_INVALID || !moves_on_the_ground {
            return None;
        }
        self.boat = Some(frame.from);
        Some(BoatMode {
            mode: DriveMode(heard.custom_mode),
            is_ours: heard.custom_mode == self.link.drive.mode(),
            is_armed: heard.base_mode.contains(MavModeFlag::MAV_MODE_FLAG_SAFETY_ARMED),
            is_starting: matches!(
                heard.system_status,
                MavState::MAV_STATE_BOOT | MavState::MAV_STATE_CALIBRATING
            ),
        })
    }

    fn on_mode(&mut self, mode: BoatMode, each: &mut impl FnMut(Report)) {
        self.is_mode_refused &= self.mode.is_some_and(|before| before.mode == mode.mode);
        self.mode = Some(mode);
        self.texts.on_heartbeat();
        // Also where nothing has changed: a report may find no room.
        each(Report::DriveMode(mode.mode));
        self.report_acceptance(each);
    }

    fn report_acceptance(&self, each: &mut impl FnMut(Report)) {
        if let Some(mode) = self.mode {
            each(Report::Acceptance(self.acceptance(mode)));
        }
    }

    fn acceptance(&self, mode: BoatMode) -> Acceptance {
        match (mode.is_ours, mode.is_armed) {
            (false, _) if self.is_mode_refused => Acceptance::ModeRefused,
            (_, false) if mode.is_starting => Acceptance::StartingUp,
            (false, _) => Acceptance::OtherClient,
            (true, false) if self.do_checks_pass == Some(false) => Acceptance::ChecksFail,
            (true, false) => Acceptance::Disarmed,
            (true, true) => Acceptance::Accepted,
        }
    }

    /// ArduPilot tells whether its checks before arming pass as the health of a sensor.
    fn on_checks(&mut self, status: &SYS_STATUS_DATA, each: &mut impl FnMut(Report)) {
        let checks = MavSysStatusSensor::MAV_SYS_STATUS_PREARM_CHECK;
        let is_told = status.onboard_control_sensors_present.contains(checks)
            && status.onboard_control_sensors_enabled.contains(checks);
        let before = self.do_checks_pass;
        self.do_checks_pass = is_told.then(|| status.onboard_control_sensors_health.contains(checks));
        if self.do_checks_pass != before {
            self.report_acceptance(each);
        }
    }

    /// The answer to a mode that was asked for.
    fn on_answer(&mut self, answer: &COMMAND_ACK_DATA, each: &mut impl FnMut(Report)) {
        let to = Address::new(answer.target_system, answer.target_component);
        let is_to_us = to == self.link.peers.own || to == Address::EVERYONE;
        if answer.command != MavCmd::MAV_CMD_DO_SET_MODE || !is_to_us {
            return;
        }
        let is_refused =
            !matches!(answer.result, MavResult::MAV_RESULT_ACCEPTED | MavResult::MAV_RESULT_IN_PROGRESS);
        self.is_mode_refused = is_refused && self.mode.is_some_and(|mode| !mode.is_ours);
        if self.is_mode_refused {
            self.report_acceptance(each);
        }
    }

    /// A time since boot that falls tells a restart, also of a boat that is armed again at once.
    fn on_uptime(&mut self, time_boot_ms: u32, each: &mut impl FnMut(Report)) {
        let last_ms = self.uptime_ms.replace(time_boot_ms);
        if last_ms.is_some_and(|last_ms| time_boot_ms.saturating_add(RESTART_MS) < last_ms) {
            each(Report::Acceptance(Acceptance::StartingUp));
        }
    }
}

fn report_speed(speed_m_per_s: f64, each: &mut impl FnMut(Report)) {
    if (0.0..=MAX_SPEED_M_PER_S).contains(&speed_m_per_s) {
        each(Report::Speed(speed_m_per_s));
    }
}
