//! What a policy knows and decides, and the base policy: a start ellipse, a stop ellipse and held rates between them.

use super::super::axis_model::{Axis, DEAD_TIME_S, FOCAL_PX, MAX_RATE, REGION};
use super::target::{SeenBearing, Target, reach_s};

/// What a policy knows when it decides.
#[derive(Debug, Clone, Copy)]
pub(super) struct Situation {
    /// The target now.
    pub(super) target: Target,
    /// Pan and tilt at the time at which a command that is given now takes effect.
    pub(super) ahead: [Axis; 2],
    /// The commands in force, rad/s.
    pub(super) command: [f64; 2],
}

/// Decides the commands ten times a second.
pub(super) trait Policy {
    /// The commands at a tick, rad/s.
    fn decide(&mut self, situation: &Situation, tick: usize) -> [f64; 2];
}

/// The values of the base policy. Radii are shares of the region's ellipse, look-ahead times count from the effect of a command.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct BaseValues {
    /// A movement starts when the predicted radius exceeds this.
    pub(super) start: f64,
    pub(super) start_look_ahead_s: f64,
    /// A movement stops when the predicted radius falls below this.
    pub(super) stop: f64,
    pub(super) stop_look_ahead_s: f64,
    /// The movement goes towards the target as predicted so far ahead.
    pub(super) aim_look_ahead_s: f64,
    /// The rate of both axes together, rad/s.
    pub(super) cruise_rate: f64,
    /// An axis rests in a movement if its offset is below this share of the other's; offsets count in shares of the region.
    pub(super) join_share: f64,
    /// An axis stops when its predicted offset along its way falls below this share of the region.
    pub(super) leave_share: f64,
}

impl BaseValues {
    /// The values that the search begins with.
    pub(super) const FIRST: Self = Self {
        start: 1.1,
        start_look_ahead_s: 0.5,
        stop: 0.4,
        stop_look_ahead_s: 0.8,
        aim_look_ahead_s: 0.7,
        cruise_rate: 0.3,
        join_share: 0.5,
        leave_share: 0.1,
    };

    /// The values with their ranges in the search.
    pub(super) fn ranges(&mut self) -> [(&mut f64, [f64; 2]); 8] {
        [
            (&mut self.start, [0.7, 1.6]),
            (&mut self.start_look_ahead_s, [0.0, 2.0]),
            (&mut self.stop, [0.0, 1.0]),
            (&mut self.stop_look_ahead_s, [0.0, 3.0]),
            (&mut self.aim_look_ahead_s, [0.0, 3.0]),
            (&mut self.cruise_rate, [0.15, 0.48]),
            (&mut self.join_share, [0.0, 1.01]),
            (&mut self.leave_share, [-0.3, 0.8]),
        ]
    }
}

/// What the base policy predicts of a target: for a start and for a stop how it is seen, for a stop and for the aim its bearing.
#[derive(Debug, Clone, Copy)]
pub(super) struct Prospect {
    start: SeenBearing,
    stop: SeenBearing,
    stop_bearing: [f64; 2],
    aim_bearing: [f64; 2],
}

/// The base policy.
#[derive(Debug, Clone, Copy)]
pub(super) struct BasePolicy {
    values: BaseValues,
    /// [`reach_s`] of the start, the stop and the aim.
    reaches_s: [f64; 3],
    /// The region's semi-axes, radians.
    edges: [f64; 2],
}

impl BasePolicy {
    pub(super) fn new(values: BaseValues) -> Self {
        let ahead = [values.start_look_ahead_s, values.stop_look_ahead_s, values.aim_look_ahead_s];
        Self {
            values,
            reaches_s: ahead.map(|ahead_s| reach_s(DEAD_TIME_S + ahead_s)),
            edges: [REGION.a_px, REGION.b_px].map(|semi_axis| (semi_axis / FOCAL_PX).atan()),
        }
    }

    /// What the policy predicts of a target.
    pub(super) fn prospect(&self, target: &Target) -> Prospect {
        let [start, stop_bearing, aim_bearing] = self.reaches_s.map(|reach_s| target.bearing_after(reach_s));
        Prospect {
            start: SeenBearing::of(start),
            stop: SeenBearing::of(stop_bearing),
            stop_bearing,
            aim_bearing,
        }
    }

    /// The commands, rad/s, for a prospect, the axes at the time of their effect, and the commands in force.
    pub(super) fn rates(&self, prospect: &Prospect, ahead: [Axis; 2], command: [f64; 2]) -> [f64; 2] {
        let rest = ahead.map(Axis::rest_angle);
        if command == [0.0; 2] {
            return if prospect.start.radius(rest) <= self.values.start {
                [0.0; 2]
            } else {
                self.towards(prospect.aim_bearing, rest, self.values.cruise_rate)
            };
        }
        if prospect.stop.radius(rest) < self.values.stop {
            return [0.0; 2];
        }
        [0, 1].map(|axis| {
            let to_go = (prospect.stop_bearing[axis] - rest[axis]) * command[axis].signum();
            let has_arrived = to_go < self.values.leave_share * self.edges[axis];
            if has_arrived { 0.0 } else { command[axis] }
        })
    }

    /// Rates of this sum of squares towards a bearing from a pointing; an axis with little to do rests.
    pub(super) fn towards(&self, bearing: [f64; 2], pointing: [f64; 2], rate: f64) -> [f64; 2] {
        let offsets = [0, 1].map(|axis| bearing[axis] - pointing[axis]);
        let shares = [0, 1].map(|axis| (offsets[axis] / self.edges[axis]).abs());
        let least = self.values.join_share.min(1.0) * shares[0].max(shares[1]);
        let ways = [0, 1].map(|axis| if shares[axis] < least { 0.0 } else { offsets[axis] });
        let length = ways[0].hypot(ways[1]).max(f64::MIN_POSITIVE);
        ways.map(|way| (rate * way / length).clamp(-MAX_RATE, MAX_RATE))
    }

    /// The bearing that a movement goes towards, with another look-ahead time than the policy's, seconds.
    pub(super) fn aim(target: &Target, look_ahead_s: f64) -> [f64; 2] {
        target.bearing_after(reach_s(DEAD_TIME_S + look_ahead_s))
    }
}

impl Policy for BasePolicy {
    fn decide(&mut self, situation: &Situation, _: usize) -> [f64; 2] {
        self.rates(&self.prospect(&situation.target), situation.ahead, situation.command)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rates(bearing: [f64; 2], command: [f64; 2]) -> [f64; 2] {
        let policy = BasePolicy::new(BaseValues::FIRST);
        let target = Target { bearing, rates: [0.0; 2] };
        policy.rates(&policy.prospect(&target), [Axis { angle: 0.0, rate: 0.0 }; 2], command)
    }

    #[test]
    fn a_movement_starts_outside_of_the_start_ellipse_and_stops_within_the_stop_ellipse() {
        let edge = (REGION.a_px / FOCAL_PX).atan();
        assert_eq!(rates([edge, 0.0], [0.0; 2]), [0.0; 2]);
        assert_eq!(rates([1.2 * edge, 0.0], [0.0; 2]), [BaseValues::FIRST.cruise_rate, 0.0]);
        assert_eq!(rates([0.8 * edge, 0.0], [0.3, 0.0]), [0.3, 0.0]);
        assert_eq!(rates([0.3 * edge, 0.0], [0.3, 0.0]), [0.0; 2]);
    }

    #[test]
    fn an_axis_that_has_arrived_leaves_the_movement() {
        assert_eq!(rates([0.5, 0.0], [0.2, 0.2]), [0.2, 0.0]);
    }
}
