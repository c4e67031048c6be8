//! The net yaw: by how much the vehicle has turned about the vertical, which twists its tether.
//!
//! The net yaw is the pan of the camera model, integrated from the rates that left, plus an offset. The
//! offset is set by the operator, and corrected by the yaw of the vehicle's reported attitude where the
//! profile knows its sense. The net yaw keeps counting while the link is down: the tether stays twisted.

use barrelman_vocab::profile::{NetYawLimits, Sign};
use barrelman_vocab::telemetry::{EulerAxis, Quaternion};
use barrelman_vocab::{Angle, AngularRate, CameraCommand, wrapped};

/// Share of the difference to a reported yaw that one report corrects.
const REPORT_SHARE: f64 = 0.2;

/// How far the net yaw has come.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Default)]
pub enum NetYawLevel {
    /// Within the limits.
    #[default]
    Free,
    /// The operator is warned.
    Warned,
    /// The vehicle turns back only.
    Refused,
}

/// The net yaw after a step.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct NetYawState {
    /// Positive to the right.
    pub angle: Angle,
    /// How far that is.
    pub level: NetYawLevel,
}

/// Counts the net yaw.
#[derive(Debug, Clone)]
pub(crate) struct NetYaw {
    limits: NetYawLimits,
    sense: Option<Sign>,
    /// The net yaw less the pan of the camera model, radians.
    offset: f64,
    reported: Option<ReportedYaw>,
}

/// The yaw that the vehicle reports, over several turns.
#[derive(Debug, Clone, Copy)]
struct ReportedYaw {
    /// As reported, -pi to pi, positive to the right.
    newest: f64,
    /// The net yaw by the reports.
    net: f64,
}

impl NetYaw {
    pub(crate) const fn new(limits: NetYawLimits, sense: Option<Sign>) -> Self {
        Self { limits, sense, offset: 0.0, reported: None }
    }

    /// The net yaw at a pan of the camera model, radians.
    pub(crate) fn state(&self, pan: f64) -> NetYawState {
        let angle = Angle::from_radians(pan + self.offset);
        let size = angle.radians().abs();
        let level = if size >= self.limits.refuse.radians() {
            NetYawLevel::Refused
        } else if size >= self.limits.warn.radians() {
            NetYawLevel::Warned
        } else {
            NetYawLevel::Free
        };
        NetYawState { angle, level }
    }

    /// The operator states the net yaw. An angle that is not finite changes nothing.
    pub(crate) fn set(&mut self, net: Angle, pan: f64) {
        if net.radians().is_finite() {
            self.offset = net.radians() - pan;
            self.reported = self.reported.map(|reported| ReportedYaw { net: net.radians(), ..reported });
        }
    }

    /// The vehicle reports its attitude.
    pub(crate) fn on_attitude(&mut self, attitude: Quaternion, pan: f64) {
        let Some((sense, yaw)) = self.sense.zip(attitude.angle_about(EulerAxis::Z)) else { return };
        let yaw = match sense {
            Sign::Same => yaw.radians(),
            Sign::Opposite => -yaw.radians(),
        };
        let reported = match self.reported {
            // The first report is the zero of the reports: what was before is not known.
            None => ReportedYaw { newest: yaw, net: pan + self.offset },
            Some(last) => ReportedYaw { newest: yaw, net: last.net + wrapped(yaw - last.newest) },
        };
        self.offset += REPORT_SHARE * (reported.net - (pan + self.offset));
        self.reported = Some(reported);
    }

    /// The vehicle's clock begins anew: the zero of its attitude is another one.
    pub(crate) fn forget_reports(&mut self) {
        self.reported = None;
    }

    /// The command without a pan that turns further beyond the limit.
    pub(crate) fn limited(&self, command: CameraCommand, pan: f64) -> CameraCommand {
        let net = self.state(pan);
        let turns_on = command.pan.radians_per_second() * net.angle.radians() > 0.0;
        if net.level == NetYawLevel::Refused && turns_on {
            CameraCommand { pan: AngularRate::ZERO, ..command }
        } else {
            command
        }
    }

    /// The pan angles of the camera model within the limit: lower and upper, radians.
    pub(crate) fn pan_range(&self) -> (f64, f64) {
        let refuse = self.limits.refuse.radians();
        (-refuse - self.offset, refuse - self.offset)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const LIMITS: NetYawLimits =
        NetYawLimits { warn: Angle::from_radians(2.0), refuse: Angle::from_radians(4.0) };

    fn pan(rate: f64) -> CameraCommand {
        CameraCommand::turning(
            AngularRate::from_radians_per_second(rate),
            AngularRate::from_radians_per_second(0.1),
        )
    }

    #[test]
    fn beyond_the_limit_only_the_way_back_is_free() {
        let net_yaw = NetYaw::new(LIMITS, None);
        for (at, rate, left) in [
            (0.0, 0.3, 0.3),
            (3.9, 0.3, 0.3),
            (4.0, 0.3, 0.0),
            (4.0, -0.3, -0.3),
            (-4.5, -0.3, 0.0),
            (-4.5, 0.3, 0.3),
        ] {
            let limited = net_yaw.limited(pan(rate), at);
            assert_eq!(limited.pan.radians_per_second(), left, "{at} {rate}");
            assert_eq!(limited.tilt, pan(rate).tilt, "the tilt is free");
        }
    }

    #[test]
    fn the_levels_are_told_apart_and_the_operator_sets_the_zero() {
        let mut net_yaw = NetYaw::new(LIMITS, None);
        let level = |net_yaw: &NetYaw, pan| net_yaw.state(pan).level;
        assert_eq!(
            [1.9, -2.0, 4.0].map(|pan| level(&net_yaw, pan)),
            [NetYawLevel::Free, NetYawLevel::Warned, NetYawLevel::Refused]
        );
        net_yaw.set(Angle::from_radians(f64::NAN), 4.0);
        assert_eq!(level(&net_yaw, 4.0), NetYawLevel::Refused);
        net_yaw.set(Angle::from_radians(-1.0), 4.0);
        assert_eq!(net_yaw.state(4.5).angle.radians(), -0.5);
        assert_eq!(net_yaw.pan_range(), (1.0, 9.0));
    }

    fn attitude(yaw: f64) -> Quaternion {
        Quaternion { w: libm::cos(0.5 * yaw), x: 0.0, y: 0.0, z: libm::sin(0.5 * yaw) }
    }

    #[test]
    fn reports_of_the_attitude_correct_the_count_over_several_turns() {
        for (sense, sign) in [(Sign::Same, 1.0), (Sign::Opposite, -1.0)] {
            let mut net_yaw = NetYaw::new(LIMITS, Some(sense));
            // The vehicle turns to the right by 10 rad; the model believes 8.
            for step in 0..=500 {
                let share = f64::from(step) / 500.0;
                net_yaw.on_attitude(attitude(sign * 10.0 * share), 8.0 * share);
            }
            let net = net_yaw.state(8.0).angle.radians();
            assert!((net - 10.0).abs() < 0.1, "{sense:?}: {net}");
        }
        let mut unknown = NetYaw::new(LIMITS, None);
        unknown.on_attitude(attitude(1.0), 0.0);
        unknown.on_attitude(attitude(2.0), 0.0);
        assert_eq!(unknown.state(0.5).angle.radians(), 0.5, "a sense that is not known is not used");
    }
}
