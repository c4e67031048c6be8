//! Motion of the camera as telemetry shows it: the turn from one reported attitude to the next.
//!
//! The flight unit's attitude turns with yaw, the gimbal's with pitch. The angle between two unit quaternions q and p is
//! close to twice their distance, 2 |q - p|, and q means the same attitude as -q. An attitude turns at this angle divided by
//! the time between the reports.

use core::time::Duration;

use barrelman_vocab::telemetry::{Quaternion, Report};
use barrelman_vocab::{AngularRate, Timestamp};

use crate::session::RestEvidence;

/// An attitude that turns faster than this is in motion, rad/s: about 3 degrees a second. The least useful rate of the camera
/// is above, the sway of a hovering flight unit below.
pub const MOTION_RAD_PER_S: f64 = 0.05;
/// Attitudes are compared if they were reported at least this far apart: two that were read at once give no rate.
const LEAST_SPACING: Duration = Duration::from_millis(40);
/// A rate older than this tells nothing: telemetry comes at 2 Hz or more.
const EVIDENCE_LASTS: Duration = Duration::from_millis(1200);

/// The newest attitudes and how fast they turned.
#[derive(Debug, Clone, Copy, Default)]
pub struct MotionWatch {
    vehicle: Turn,
    gimbal: Turn,
}

#[derive(Debug, Clone, Copy, Default)]
struct Turn {
    last: Option<(Quaternion, Timestamp)>,
    /// The rate between two reports.
    rate: Option<Rate>,
}

/// A rate, and the times of the two reports that show it.
#[derive(Debug, Clone, Copy)]
struct Rate {
    rad_per_s: f64,
    from: Timestamp,
    to: Timestamp,
}

impl Turn {
    fn on_attitude(&mut self, attitude: Quaternion, now: Timestamp) {
        if let Some((before, at)) = self.last {
            let spacing = now.since(at);
            if spacing < LEAST_SPACING {
                return;
            }
            let rad_per_s = angle_between(before, attitude) / spacing.as_secs_f64();
            self.rate = Some(Rate { rad_per_s, from: at, to: now });
        }
        self.last = Some((attitude, now));
    }

    fn rate_since(&self, since: Timestamp, now: Timestamp) -> Option<f64> {
        let is_recent = |rate: &Rate| rate.from >= since && now.since(rate.to) <= EVIDENCE_LASTS;
        self.rate.filter(is_recent).map(|rate| rate.rad_per_s)
    }
}

impl MotionWatch {
    /// Takes a report.
    pub fn on_report(&mut self, report: &Report, now: Timestamp) {
        match *report {
            Report::VehicleAttitude(attitude) => self.vehicle.on_attitude(attitude, now),
            Report::GimbalAttitude(attitude) => self.gimbal.on_attitude(attitude, now),
            _ => {}
        }
    }

    /// Whether any motion, or rest, was ever shown.
    pub const fn has_seen(&self) -> bool {
        self.vehicle.rate.is_some() && self.gimbal.rate.is_some()
    }

    /// What the newest reports show, if they came after `since`.
    pub fn since(&self, since: Timestamp, now: Timestamp) -> RestEvidence {
        let rates = (self.vehicle.rate_since(since, now), self.gimbal.rate_since(since, now));
        let (Some(vehicle), Some(gimbal)) = rates else {
            return RestEvidence::NoTelemetry;
        };
        let fastest = vehicle.max(gimbal);
        if fastest > MOTION_RAD_PER_S {
            RestEvidence::Moving { rate: AngularRate::from_radians_per_second(fastest) }
        } else {
            RestEvidence::AtRest
        }
    }
}

fn angle_between(one: Quaternion, other: Quaternion) -> f64 {
    let distance = |sign: f64| {
        let differences =
            [one.w - sign * other.w, one.x - sign * other.x, one.y - sign * other.y, one.z - sign * other.z];
        differences.iter().map(|difference| difference * difference).sum::<f64>().sqrt()
    };
    2.0 * distance(1.0).min(distance(-1.0))
}
