//! The guidance law of the paper's laboratory, exactly: proportional steering in the picture.
//!
//! In pixel coordinates (v down), angles in degrees, clockwise as seen. With the boat at (u, v), the target
//! at (U, V), and the boat's heading h, which is the direction of the last segment of the Douglas-Peucker
//! polyline (`douglas1973`) through the last 50 positions:
//!
//! ```text
//! bearing  = atan2(V - v, U - u)
//! error    = bearing - heading, wrapped once: >= 180 -> - 360, < -180 -> + 360
//! distance = |(U - u, V - v)|
//! ```
//!
//! | condition, in this order | throttle | rudder |
//! |---|---|---|
//! | no boat or no target | 0 | 0 |
//! | distance < 30 px: reached | 0 | 0 |
//! | fewer than 50 positions, or no heading | 0.2 | 0 |
//! | \|error\| < 30 | 0.6 cruise | 0.02 error |
//! | else | 0.3 turning | sign of the error |
//!
//! From 90 px on, the throttle of the last two rows is multiplied by distance / 90 px. The law runs 7.5 times
//! a second; between two steps its command stays. The later version of the laboratory has 0.7 and 0.4.
//!
//! Not handled, as in the original: perspective, current, latency, and people.

use core::time::Duration;

use barrelman_vocab::{PixelPoint, Timestamp, VesselCommand};

/// Positions that the heading is computed from.
pub const POSITIONS: usize = 50;

/// Settings of the law.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LabSettings {
    /// Time between two steps; zero: a step for each call.
    pub interval: Duration,
    /// Throttle towards the target, 0 to 1.
    pub cruise_throttle: f64,
    /// Throttle in turns, 0 to 1.
    pub turning_throttle: f64,
    /// Throttle while the heading is unknown, 0 to 1.
    pub unknown_heading_throttle: f64,
    /// Rudder for each degree of error.
    pub rudder_per_degree: f64,
    /// Errors from here on are turns, degrees.
    pub turning_error_deg: f64,
    /// The target is reached within this distance, pixels.
    pub reached_px: f64,
    /// The throttle shrinks within this multiple of `reached_px`.
    pub slowing_factor: f64,
    /// Largest distance of a position from the polyline, pixels.
    pub epsilon_px: f64,
}

impl LabSettings {
    /// The version that the paper used.
    pub const PAPER: Self = Self {
        interval: Duration::from_millis(133),
        cruise_throttle: 0.6,
        turning_throttle: 0.3,
        unknown_heading_throttle: 0.2,
        rudder_per_degree: 0.020,
        turning_error_deg: 30.0,
        reached_px: 30.0,
        slowing_factor: 3.0,
        epsilon_px: 4.0,
    };
}

impl Default for LabSettings {
    fn default() -> Self {
        Self::PAPER
    }
}

/// Input of one step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LabInput {
    /// Present time.
    pub now: Timestamp,
    /// The boat in the newest picture; `None` if it was not localised.
    pub boat: Option<PixelPoint>,
    /// The target in the same picture; `None` without one.
    pub target: Option<PixelPoint>,
}

/// The branch that a step took.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum LabBranch {
    /// No boat, or no target.
    Idle,
    /// Too few positions for a heading, or no motion.
    UnknownHeading,
    /// The error is large.
    Turning,
    /// Towards the target.
    Cruising,
    /// At the target.
    Reached,
}

/// The law with its history of positions.
#[derive(Debug, Clone)]
pub struct LabLaw {
    settings: LabSettings,
    /// The last positions, the newest at the end.
    positions: [PixelPoint; POSITIONS],
    count: usize,
    last: Option<(Timestamp, VesselCommand, LabBranch)>,
}

impl LabLaw {
    /// The law without positions.
    pub const fn new(settings: LabSettings) -> Self {
        Self { settings, positions: [PixelPoint { u: 0.0, v: 0.0 }; POSITIONS], count: 0, last: None }
    }

    /// Discards the positions: another boat was selected.
    pub const fn reset(&mut self) {
        self.count = 0;
        self.last = None;
    }

    /// Computes the command of one step. Between two steps of the law's own rate, the last command stays,
    /// except that no boat or no target is answered at once.
    pub fn step(&mut self, input: &LabInput) -> (VesselCommand, LabBranch) {
        let (Some(boat), Some(target)) = (input.boat, input.target) else {
            self.last = None;
            return (VesselCommand::NEUTRAL, LabBranch::Idle);
        };
        if let Some((at, command, branch)) = self.last
            && input.now.since(at) < self.settings.interval
            && input.now >= at
        {
            return (command, branch);
        }
        self.remember(boat);
        let (command, branch) = self.command(boat, target);
        self.last = Some((input.now, command, branch));
        (command, branch)
    }

    /// Direction of the boat's last segment, degrees clockwise from image right as seen, -180 to 180; `None`
    /// while there are fewer than 50 positions, or where the segment has no length.
    pub fn heading_deg(&self) -> Option<f64> {
        if self.count < POSITIONS {
            return None;
        }
        let start = last_segment_start(&self.positions, self.settings.epsilon_px);
        let (from, to) = (self.positions[start], self.positions[POSITIONS - 1]);
        let (du, dv) = (to.u - from.u, to.v - from.v);
        (du != 0.0 || dv != 0.0).then(|| libm::atan2(dv, du).to_degrees())
    }

    fn remember(&mut self, position: PixelPoint) {
        self.positions.copy_within(1.., 0);
        self.positions[POSITIONS - 1] = position;
        self.count = (self.count + 1).min(POSITIONS);
    }

    fn command(&self, boat: PixelPoint, target: PixelPoint) -> (VesselCommand, LabBranch) {
        let settings = &self.settings;
        let (du, dv) = (target.u - boat.u, target.v - boat.v);
        let distance_px = libm::sqrt(du * du + dv * dv);
        if distance_px < settings.reached_px {
            return (VesselCommand::NEUTRAL, LabBranch::Reached);
        }
        let Some(heading_deg) = self.heading_deg() else {
            let throttle = settings.unknown_heading_throttle;
            return (VesselCommand { throttle, rudder: 0.0 }, LabBranch::UnknownHeading);
        };
        let error_deg = wrapped_once(libm::atan2(dv, du).to_degrees() - heading_deg);
        let (throttle, rudder, branch) = if error_deg.abs() < settings.turning_error_deg {
            (settings.cruise_throttle, settings.rudder_per_degree * error_deg, LabBranch::Cruising)
        } else {
            (settings.turning_throttle, if error_deg > 0.0 { 1.0 } else { -1.0 }, LabBranch::Turning)
        };
        let slowing_px = settings.slowing_factor * settings.reached_px;
        let share = if distance_px < slowing_px { distance_px / slowing_px } else { 1.0 };
        (VesselCommand { throttle: throttle * share, rudder: rudder.clamp(-1.0, 1.0) }, branch)
    }
}

/// The laboratory's wrap: once, and 180 becomes -180.
fn wrapped_once(error_deg: f64) -> f64 {
    if error_deg >= 180.0 {
        error_deg - 360.0
    } else if error_deg < -180.0 {
        error_deg + 360.0
    } else {
        error_deg
    }
}

/// Where the last segment of the Douglas-Peucker polyline of an open curve starts: while a position is
/// farther than `epsilon` from the chord to the end, the farthest splits the curve there, and the part behind
/// it goes on.
fn last_segment_start(points: &[PixelPoint], epsilon: f64) -> usize {
    let last = points.len() - 1;
    let mut start = 0;
    while last - start > 1 {
        let (mut farthest, mut max_squared) = (start, epsilon * epsilon);
        for (index, point) in points.iter().enumerate().take(last).skip(start + 1) {
            let squared = squared_distance(*point, points[start], points[last]);
            if squared > max_squared {
                (farthest, max_squared) = (index, squared);
            }
        }
        if farthest == start {
            break;
        }
        start = farthest;
    }
    start
}

/// Squared distance of a point from the line through two others; from the first of them, where they coincide.
fn squared_distance(point: PixelPoint, from: PixelPoint, to: PixelPoint) -> f64 {
    let (du, dv) = (to.u - from.u, to.v - from.v);
    let (pu, pv) = (point.u - from.u, point.v - from.v);
    let squared_length = du * du + dv * dv;
    if squared_length > 0.0 {
        let across = pv * du - pu * dv;
        across * across / squared_length
    } else {
        pu * pu + pv * pv
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn point(u: f64, v: f64) -> PixelPoint {
        PixelPoint { u, v }
    }

    #[test]
    fn the_last_segment_starts_at_the_last_kept_position() {
        let check = |points: &[(f64, f64)], expected: usize| {
            let points: Vec<PixelPoint> = points.iter().map(|(u, v)| point(*u, *v)).collect();
            assert_eq!(last_segment_start(&points, 4.0), expected, "{points:?}");
        };
        check(&[(0.0, 0.0), (10.0, 3.9), (20.0, 0.0)], 0);
        check(&[(0.0, 0.0), (10.0, 4.1), (20.0, 0.0)], 1);
        check(&[(0.0, 0.0), (10.0, 0.0), (20.0, 0.0), (20.0, 10.0), (20.0, 20.0)], 2);
        check(&[(0.0, 0.0), (50.0, 0.0), (50.0, 50.0), (0.0, 50.0), (0.0, 100.0)], 3);
        check(&[(0.0, 0.0), (9.0, 9.0), (0.0, 0.0)], 1);
        check(&[(0.0, 0.0), (1.0, 1.0)], 0);
    }

    #[test]
    fn angles_are_wrapped_once() {
        for (error, expected) in [
            (0.0, 0.0),
            (179.9, 179.9),
            (180.0, -180.0),
            (190.0, -170.0),
            (-180.0, -180.0),
            (-180.5, 179.5),
            (-350.0, 10.0),
            (350.0, -10.0),
        ] {
            assert_eq!(wrapped_once(error), expected, "{error}");
        }
    }
}
