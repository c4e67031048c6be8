//! When a rate goes out on the line.
//!
//! The vehicle keeps a rate until the next one, and a line can get lost, so a zero goes out first and at once,
//! and twice more 50 ms apart. Other rates coalesce to the newest: at most 20 lines a second over both axes. What
//! stays, rest too, is said again twice a second: a zero that was lost three times is made good.

use core::time::Duration;

use barrelman_vocab::{AngularRate, Timestamp, VehicleRates};

use super::command::{Command, GIMBAL_LIMIT, YAW_LIMIT, encodable};

/// From a zero to its repetition.
pub const ZERO_SPACING: Duration = Duration::from_millis(50);
/// How often a zero is said again.
pub const ZERO_REPEATS: u8 = 2;
/// Least time between two lines that are not zeros: 20 a second.
pub const LINE_SPACING: Duration = Duration::from_millis(50);
/// A rate in force is said again after this time.
pub const REFRESH: Duration = Duration::from_millis(500);

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum AxisName {
    Yaw,
    Pitch,
}

#[derive(Debug, Clone, Copy)]
struct Axis {
    name: AxisName,
    target: AngularRate,
    /// What the vehicle was last_sent last, and when; `None` before the first line.
    last_sent: Option<(AngularRate, Timestamp)>,
    /// Zeros that are still to be repeated.
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

    /// When this axis next wants a line, apart from the spacing of lines that are not zeros.
    fn due(&self) -> Timestamp {
        match self.last_sent {
            Some((rate, at)) if rate == self.target => {
                at.plus(if self.repeats_left > 0 { ZERO_SPACING } else { REFRESH })
            }
            _ => Timestamp::ZERO,
        }
    }

    fn send_line(&mut self, now: Timestamp, send: &mut impl FnMut(Command)) {
        send(self.line());
        let again = self.last_sent.is_some_and(|(rate, _)| rate == self.target);
        self.repeats_left = match (self.target.is_zero(), again) {
            (false, _) => 0,
            (true, false) => ZERO_REPEATS,
            (true, true) => self.repeats_left.saturating_sub(1),
        };
        self.last_sent = Some((self.target, now));
    }
}

/// The newest rates target, and what was said of them.
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
    /// Takes the newest rates; what was waiting is forgotten.
    pub fn set_rates(&mut self, rates: VehicleRates) {
        for axis in &mut self.axes {
            axis.target = match axis.name {
                AxisName::Yaw => encodable(rates.yaw, YAW_LIMIT),
                AxisName::Pitch => encodable(rates.pitch, GIMBAL_LIMIT),
            };
        }
    }

    /// Forgets what the vehicle was last_sent, as after its restart: zeros or rates are said anew.
    pub fn forget_sent(&mut self) {
        for axis in &mut self.axes {
            axis.last_sent = None;
        }
    }

    /// Says zeros on both axes before anything that moves, whatever is target by now: how a session begins.
    pub fn send_zeros_first(&mut self, now: Timestamp, send: impl FnMut(Command)) {
        let target = self.axes.map(|axis| axis.target);
        self.set_rates(VehicleRates::REST);
        self.forget_sent();
        self.poll(now, send);
        for (axis, target) in self.axes.iter_mut().zip(target) {
            axis.target = target;
        }
    }

    /// Hands out the lines that are due: zeros first.
    pub fn poll(&mut self, now: Timestamp, mut send: impl FnMut(Command)) {
        for axis in self.axes.iter_mut().filter(|axis| axis.target.is_zero()) {
            if axis.due() <= now {
                axis.send_line(now, &mut send);
            }
        }
        if self.moving_line_allowed_at() > now {
            return;
        }
        // Whoever has waited longest goes first, so that one axis cannot keep the other off the line.
        let waiting = self.axes.iter_mut().filter(|axis| !axis.target.is_zero() && axis.due() <= now);
        if let Some(axis) = waiting.min_by_key(|axis| axis.last_sent.map(|(_, at)| at)) {
            axis.send_line(now, &mut send);
            self.last_moving_line = Some(now);
        }
    }

    /// When `poll` next has something to say.
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
