//! Pacing: when a rate is sent.
//!
//! The vehicle keeps a rate until the next one, and a line can get lost. A zero is therefore sent first,
//! immediately, and is repeated twice at intervals of 50 ms. Non-zero rates coalesce to the newest one, with
//! at most 20 lines per second over both axes. A rate that stays in force is repeated every 0.5 s, a zero
//! every 0.25 s, which corrects even a zero that was lost three times.

use core::time::Duration;

use barrelman_vocab::{AngularRate, Timestamp, VehicleRates};

use super::command::{Command, GIMBAL_LIMIT, YAW_LIMIT, encodable};

/// Interval between a zero and its repetition.
pub const ZERO_SPACING: Duration = Duration::from_millis(50);
/// Number of repetitions of a zero.
pub const ZERO_REPEATS: u8 = 2;
/// Smallest interval between two lines with non-zero rates: 20 per second.
pub const LINE_SPACING: Duration = Duration::from_millis(50);
/// A rate in force is repeated after this time.
pub const REFRESH: Duration = Duration::from_millis(500);
/// Zero in force is repeated after this time: a line that carries again what it lost before brings rest
/// within 350 ms.
pub const ZERO_REFRESH: Duration = Duration::from_millis(250);

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum AxisName {
    Yaw,
    Pitch,
}

#[derive(Debug, Clone, Copy)]
struct Axis {
    name: AxisName,
    target: AngularRate,
    /// The last rate that was sent, and its time; `None` before the first line.
    last_sent: Option<(AngularRate, Timestamp)>,
    /// Number of pending repetitions of a zero.
    repeats_left: u8,
}

impl Axis {
    const fn new(name: AxisName) -> Self {
        Self { name, target: AngularRate::ZERO, last_sent: None, repeats_left: 0 }
    }

    fn line(&self) -> Command {
        match self.name {
            AxisName::Yaw => Command::Yaw(self.target),
            AxisName::Pitch => Command::GimbalPitch(self.target),
        }
    }

    /// When the next line of this axis is due, without the spacing of lines with non-zero rates.
    fn due(&self) -> Timestamp {
        match self.last_sent {
            Some((rate, at)) if rate == self.target => at.plus(match (self.repeats_left, rate.is_zero()) {
                (0, true) => ZERO_REFRESH,
                (0, false) => REFRESH,
                _ => ZERO_SPACING,
            }),
            _ => Timestamp::ZERO,
        }
    }

    fn send_line(&mut self, now: Timestamp, send: &mut impl FnMut(Command)) {
        send(self.line());
        let is_repetition = self.last_sent.is_some_and(|(rate, _)| rate == self.target);
        self.repeats_left = match (self.target.is_zero(), is_repetition) {
            (false, _) => 0,
            (true, false) => ZERO_REPEATS,
            (true, true) => self.repeats_left.saturating_sub(1),
        };
        self.last_sent = Some((self.target, now));
    }
}

/// The target rates, and what was sent of them.
#[derive(Debug, Clone)]
pub struct Pacing {
    axes: [Axis; 2],
    last_moving_line: Option<Timestamp>,
}

impl Default for Pacing {
    fn default() -> Self {
        Self { axes: [Axis::new(AxisName::Pitch), Axis::new(AxisName::Yaw)], last_moving_line: None }
    }
}

impl Pacing {
    /// Sets the target rates. Rates that were not sent yet are dropped.
    pub fn set_rates(&mut self, rates: VehicleRates) {
        for axis in &mut self.axes {
            axis.target = match axis.name {
                AxisName::Yaw => encodable(rates.yaw, YAW_LIMIT),
                AxisName::Pitch => encodable(rates.pitch, GIMBAL_LIMIT),
            };
        }
    }

    /// Forgets what was sent, for a vehicle that restarted: all rates are sent again.
    pub fn forget_sent(&mut self) {
        for axis in &mut self.axes {
            axis.last_sent = None;
        }
    }

    /// Sends zeros on both axes before any non-zero rate, at the start of a session.
    pub fn send_zeros_first(&mut self, now: Timestamp, send: impl FnMut(Command)) {
        let target = self.axes.map(|axis| axis.target);
        self.set_rates(VehicleRates::REST);
        self.forget_sent();
        self.poll(now, send);
        for (axis, target) in self.axes.iter_mut().zip(target) {
            axis.target = target;
        }
    }

    /// Sends the lines that are due, zeros first.
    pub fn poll(&mut self, now: Timestamp, mut send: impl FnMut(Command)) {
        for axis in self.axes.iter_mut().filter(|axis| axis.target.is_zero()) {
            if axis.due() <= now {
                axis.send_line(now, &mut send);
            }
        }
        if self.moving_line_allowed_at() > now {
            return;
        }
        // The axis that has waited longer goes first, so that neither axis can block the other.
        let waiting = self.axes.iter_mut().filter(|axis| !axis.target.is_zero() && axis.due() <= now);
        if let Some(axis) = waiting.min_by_key(|axis| axis.last_sent.map(|(_, at)| at)) {
            axis.send_line(now, &mut send);
            self.last_moving_line = Some(now);
        }
    }

    /// Whether a rate other than zero was sent last, or a zero that was not repeated yet.
    pub fn may_be_turning(&self) -> bool {
        let is_moving = |axis: &Axis| axis.last_sent.is_some_and(|(rate, _)| !rate.is_zero());
        self.axes
            .iter()
            .any(|axis| is_moving(axis) || axis.repeats_left > 0 && self.last_moving_line.is_some())
    }

    /// When the next line is due.
    pub fn wake_at(&self) -> Timestamp {
        let [pitch, yaw] = self.axes.map(|axis| {
            let due = axis.due();
            if axis.target.is_zero() { due } else { due.max(self.moving_line_allowed_at()) }
        });
        pitch.min(yaw)
    }

    fn moving_line_allowed_at(&self) -> Timestamp {
        self.last_moving_line.map_or(Timestamp::ZERO, |at| at.plus(LINE_SPACING))
    }
}
