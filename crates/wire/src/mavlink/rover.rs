//! The client of an ArduPilot boat: set-points in GUIDED, or manual control in MANUAL, and nothing in any
//! other mode.
//!
//! ```text
//!              heartbeat of a boat or a rover          silent for 3 s
//!   Searching ------------------------------> Up ------------------> Unresponsive (reopen the port)
//!                                              |
//!                                              +-- close() --> Closing (neutral five times) --> Closed
//! ```
//!
//! Throttle and rudder are sent as SET_POSITION_TARGET_LOCAL_NED (84) in the boat's own frame: a speed ahead
//! of throttle x [`FULL_SPEED_M_PER_S`], and a turn rate of rudder x [`FULL_TURN_RAD_PER_S`]; the autopilot
//! closes the loop. A set-point is repeated every [`SET_POINT_INTERVAL`]. ArduPilot stops the boat 3 s after
//! the last one.
//!
//! The mode and the arming are the boat's own. A mode other than GUIDED means that another program or a
//! person steers: the sticks of the remote control, or a ground station. Nothing is sent then.
//! [`Session::take_control`] asks once for GUIDED; nothing ever arms.
//!
//! A boat without a position has no GUIDED. [`RoverDrive::Manual`] sends MANUAL_CONTROL (69) instead, in
//! MANUAL alone: steering (y) and throttle (z, 0 is stop) in thousandths. ArduPilot obeys the system id of
//! its ground station alone, holds the last values for 3 s, and gives the boat back to the sticks then.

use core::time::Duration;

use barrelman_vocab::mavlink::{Address, SystemId};
use barrelman_vocab::telemetry::LinkState;
use barrelman_vocab::{Telemetry, Timestamp, VesselCommand, VesselOrder};
use mavlink::dialects::common::{
    COMMAND_LONG_DATA, MANUAL_CONTROL_DATA, MavCmd, MavFrame, MavModeFlag, MavType, PositionTargetTypemask,
    SET_POSITION_TARGET_LOCAL_NED_DATA,
};

use super::frame::FrameWriter;
use super::heartbeat::heartbeat;
use super::rover_reader::{ASKED_FOR, RoverReader};
use super::subscription::Subscription;
use crate::session::{LinkHistory, NextAction, Session, WillStep};

pub(super) use super::rover_link::GROUND_STATION;
pub use super::rover_link::{GUIDED, MANUAL, RoverDrive, RoverLink};

/// The speed of full throttle, m/s: that of a jet boat of 1.2 m.
pub const FULL_SPEED_M_PER_S: f64 = 3.6;
/// The turn rate of full rudder, rad/s.
pub const FULL_TURN_RAD_PER_S: f64 = 1.0;
/// Interval between two set-points.
pub const SET_POINT_INTERVAL: Duration = Duration::from_millis(100);
/// Shortest interval between two set-points that are not neutral.
const LEAST_INTERVAL: Duration = Duration::from_millis(40);
/// Interval between the neutral set-points of an end.
const NEUTRAL_INTERVAL: Duration = Duration::from_millis(50);
/// Neutral set-points of an end.
pub const NEUTRALS: u32 = 5;
/// A boat of which nothing was heard for this time is silent.
pub const SILENCE: Duration = Duration::from_secs(3);
/// So is one whose mode is as old as this, whatever else is heard of it. Of a line that loses 3 packets of
/// 10, ten heartbeats hardly ever get lost in a row.
pub const MODE_TIMEOUT: Duration = Duration::from_secs(10);
/// The intervals of [`ASKED_FOR`].
const SUBSCRIBED_INTERVALS: [Duration; 3] =
    [Duration::from_millis(200), Duration::from_millis(200), Duration::from_millis(1_000)];
const HEARTBEAT_INTERVAL: Duration = Duration::from_secs(1);
/// The search for a boat is told as failed after this time.
const SEARCH_TIMEOUT: Duration = Duration::from_secs(10);
/// Use the velocity along x and the yaw rate, and ignore everything else: 0x5C7.
const SPEED_AND_TURN: PositionTargetTypemask = PositionTargetTypemask::from_bits_truncate(0x5C7);

/// The boat's own frame of reference by its number 8, which ArduPilot reads; MAVLink's newer name has another
/// number.
#[allow(deprecated, reason = "ArduPilot reads this frame")]
pub(super) const BODY_FRAME: MavFrame = MavFrame::MAV_FRAME_BODY_NED;

const SILENT: NextAction = NextAction::Reopen { reason: "the boat does not answer any more" };

const NO_BOAT: NextAction = NextAction::Reopen {
    reason: "no boat was heard: are address, baud rate and vessel.vehicle_system right?",
};

/// A full deflection of MANUAL_CONTROL.
pub(super) const FULL_DEFLECTION: f64 = 1000.0;

impl RoverDrive {
    /// The packet of a command.
    fn packet(self, writer: &mut FrameWriter, boat: Address, command: VesselCommand) -> Vec<u8> {
        match self {
            Self::Guided => writer.write(&set_point(boat, command)),
            Self::Manual => writer.write(&manual_control(boat, command)),
        }
    }
}

/// One session with a boat.
#[derive(Debug, Clone)]
pub struct RoverSession {
    writer: FrameWriter,
    reader: RoverReader,
    since: Timestamp,
    last_heard: Option<Timestamp>,
    last_mode: Option<Timestamp>,
    order: VesselOrder,
    last: Option<(Timestamp, VesselCommand)>,
    /// Neutral set-points that are still to be sent once the boat is no longer commanded.
    neutrals_left: u32,
    heartbeat_at: Timestamp,
    asks_for_mode: bool,
    /// The messages that the boat shall send.
    subscriptions: [Subscription; 3],
    /// Whether a session before may have left the boat moving, and neutral was not sent since.
    needs_answer: bool,
    is_closing: bool,
}

impl RoverSession {
    /// A session on a newly opened port.
    pub fn open(link: RoverLink, now: Timestamp) -> Self {
        Self {
            writer: FrameWriter::new(link.peers.own, None),
            reader: RoverReader::new(link),
            since: now,
            last_heard: None,
            last_mode: None,
            order: VesselOrder::Released,
            last: None,
            neutrals_left: 0,
            heartbeat_at: now,
            asks_for_mode: false,
            subscriptions: core::array::from_fn(|index| {
                Subscription::new(ASKED_FOR[index], SUBSCRIBED_INTERVALS[index])
            }),
            needs_answer: false,
            is_closing: false,
        }
    }

    fn is_silent(&self, now: Timestamp) -> bool {
        let is_older = |at: Option<Timestamp>, limit| at.is_some_and(|at| now.since(at) >= limit);
        is_older(self.last_heard, SILENCE) || is_older(self.last_mode, MODE_TIMEOUT)
    }

    fn is_ours(&self) -> bool {
        self.reader.mode.is_some_and(|mode| mode.is_ours)
    }

    fn set_point(&mut self, boat: Address, command: VesselCommand, now: Timestamp) -> Vec<u8> {
        self.last = Some((now, command));
        self.reader.link.drive.packet(&mut self.writer, boat, command)
    }

    /// Appends the set-point that is due, and returns when the next one is.
    fn write_set_point(&mut self, boat: Address, now: Timestamp, out: &mut Vec<Vec<u8>>) -> Timestamp {
        let command = self.order.command();
        let since = self.last.map(|(at, _)| now.since(at));
        let has_changed = self.last.is_none_or(|(_, sent)| sent != command);
        let is_after = |interval: Duration| since.is_none_or(|since| since >= interval);
        match self.order {
            VesselOrder::Commanded(_) if !self.is_closing => {
                let may_change = command.is_neutral() || is_after(LEAST_INTERVAL);
                if is_after(SET_POINT_INTERVAL) || (has_changed && may_change) {
                    out.push(self.set_point(boat, command, now));
                }
                self.neutrals_left = NEUTRALS;
            }
            _ if self.neutrals_left > 0 && (has_changed || is_after(NEUTRAL_INTERVAL)) => {
                out.push(self.set_point(boat, VesselCommand::NEUTRAL, now));
                self.neutrals_left -= 1;
                self.needs_answer &= self.neutrals_left > 0;
            }
            // Nothing is owed.
            _ if self.neutrals_left == 0 => return now.plus(SET_POINT_INTERVAL),
            _ => {}
        }
        let wait = if self.last.is_some_and(|(_, sent)| sent != command) {
            LEAST_INTERVAL
        } else if self.is_closing || self.order == VesselOrder::Released {
            NEUTRAL_INTERVAL
        } else {
            SET_POINT_INTERVAL
        };
        self.last.map_or(now, |(at, _)| at).plus(wait)
    }
}

/// The set-point of a command.
pub fn set_point(to: Address, command: VesselCommand) -> SET_POSITION_TARGET_LOCAL_NED_DATA {
    let VesselCommand { throttle, rudder } = command.clamped();
    SET_POSITION_TARGET_LOCAL_NED_DATA {
        time_boot_ms: 0,
        x: 0.0,
        y: 0.0,
        z: 0.0,
        // Positive zero for both zeros.
        vx: (throttle * FULL_SPEED_M_PER_S) as f32 + 0.0,
        vy: 0.0,
        vz: 0.0,
        afx: 0.0,
        afy: 0.0,
        afz: 0.0,
        yaw: 0.0,
        yaw_rate: (rudder * FULL_TURN_RAD_PER_S) as f32 + 0.0,
        type_mask: SPEED_AND_TURN,
        target_system: to.system.0,
        target_component: to.component.0,
        coordinate_frame: BODY_FRAME,
    }
}

/// The manual control of a command.
pub fn manual_control(to: Address, command: VesselCommand) -> MANUAL_CONTROL_DATA {
    let VesselCommand { throttle, rudder } = command.clamped();
    let deflection = |share: f64| libm::round(share * FULL_DEFLECTION) as i16;
    MANUAL_CONTROL_DATA {
        y: deflection(rudder),
        z: deflection(throttle),
        target: to.system.0,
        ..MANUAL_CONTROL_DATA::DEFAULT
    }
}

/// Asks for a mode.
fn mode_request(to: Address, mode: u32) -> COMMAND_LONG_DATA {
    COMMAND_LONG_DATA {
        // The mode is the autopilot's own number.
        param1: f32::from(MavModeFlag::MAV_MODE_FLAG_CUSTOM_MODE_ENABLED.bits()),
        param2: mode as f32,
        param3: 0.0,
        param4: 0.0,
        param5: 0.0,
        param6: 0.0,
        param7: 0.0,
        command: MavCmd::MAV_CMD_DO_SET_MODE,
        target_system: to.system.0,
        target_component: to.component.0,
        confirmation: 0,
    }
}

impl Session for RoverSession {
    type Sent = Vec<u8>;
    type Received = [u8];
    type Command = VesselOrder;

    fn poll(&mut self, now: Timestamp, out: &mut Vec<Vec<u8>>) -> NextAction {
        // A boat that is not heard may hear: at the end, neutral goes out in any case.
        if !self.is_closing && self.is_silent(now) {
            // The next session sends nothing before it hears the boat. These packets do not count as sent:
            // whether one arrived is not known.
            if self.last.is_some_and(|(_, sent)| !sent.is_neutral()) {
                out.extend(self.last_will(now).into_iter().map(|step| step.packet));
            }
            return SILENT;
        }
        if self.reader.boat.is_none() && !self.is_closing && now.since(self.since) >= SEARCH_TIMEOUT {
            return NO_BOAT;
        }
        let mut next = self.heartbeat_at;
        if let Some(boat) = self.reader.boat {
            if core::mem::take(&mut self.asks_for_mode) {
                out.push(self.writer.write(&mode_request(boat, self.reader.link.drive.mode())));
            }
            if !self.is_closing && self.reader.mode.is_some() {
                let requests = self.subscriptions.each_mut().map(|subscription| subscription.due(boat, now));
                out.extend(requests.iter().flatten().map(|request| self.writer.write(request)));
            }
            if self.is_ours() {
                next = self.write_set_point(boat, now, out).min(next);
            }
        }
        let is_waiting_for_the_boat = self.needs_answer && self.reader.mode.is_none();
        if self.is_closing && !is_waiting_for_the_boat && (!self.is_ours() || self.neutrals_left == 0) {
            return NextAction::Closed;
        }
        if self.heartbeat_at <= now {
            out.push(self.writer.write(&heartbeat(MavType::MAV_TYPE_ONBOARD_CONTROLLER)));
            self.heartbeat_at = now.plus(HEARTBEAT_INTERVAL);
        }
        NextAction::WaitUntil(next.max(now.plus(Duration::from_millis(1))).min(self.heartbeat_at))
    }

    fn received(&mut self, packet: &[u8], now: Timestamp, report: &mut dyn FnMut(Telemetry)) {
        let heard = self.reader.read(packet, |content| report(Telemetry { at: now, report: content }));
        if heard.is_any {
            self.last_heard = Some(now);
        }
        for (subscription, _) in self.subscriptions.iter_mut().zip(heard.asked_for).filter(|(_, is)| *is) {
            subscription.on_heard(now);
        }
        if heard.is_mode {
            self.last_mode = Some(now);
        }
        if heard.is_mode && !self.is_ours() {
            // The operator who chose another mode steers: no neutral set-point is owed.
            (self.last, self.neutrals_left, self.needs_answer) = (None, 0, false);
        }
    }

    fn request(&mut self, order: VesselOrder, _: Option<Timestamp>) {
        self.order = order;
    }

    /// Asks for the mode in which the boat is driven, once. A boat that is not heard now is not asked later,
    /// when a person may be steering it.
    fn take_control(&mut self, _: Timestamp) {
        self.asks_for_mode = self.reader.mode.is_some_and(|mode| !mode.is_ours);
    }

    fn close(&mut self, _: Timestamp) {
        (self.is_closing, self.order) = (true, VesselOrder::NEUTRAL);
    }

    fn link_state(&self) -> LinkState {
        match (self.is_closing, self.reader.boat) {
            (true, _) => LinkState::Closing,
            (false, None) => LinkState::Starting,
            (false, Some(_)) => LinkState::Up,
        }
    }

    fn resume(&mut self, history: LinkHistory) {
        if history.may_be_turning {
            (self.needs_answer, self.neutrals_left) = (true, NEUTRALS);
        }
        if let Some(vehicle) = history.vehicle {
            self.reader.name(vehicle);
        }
    }

    fn vehicle(&self) -> Option<SystemId> {
        self.reader.vehicle()
    }

    fn may_be_turning(&self) -> bool {
        self.needs_answer
            || self.last.is_some_and(|(_, sent)| !sent.is_neutral())
            || (1..NEUTRALS).contains(&self.neutrals_left)
    }

    fn last_will(&self, _: Timestamp) -> Vec<WillStep<Vec<u8>>> {
        // A boat that was released is not kept neutral against a person who steers it.
        let is_owed = self.needs_answer || self.neutrals_left > 0;
        let Some(boat) = self.reader.boat.filter(|_| is_owed && self.is_ours()) else { return Vec::new() };
        let mut writer = self.writer.clone();
        let mut neutral = || WillStep {
            packet: self.reader.link.drive.packet(&mut writer, boat, VesselCommand::NEUTRAL),
            pause: NEUTRAL_INTERVAL,
        };
        (0..NEUTRALS).map(|_| neutral()).collect()
    }
}

#[cfg(test)]
mod tests;
