//! How fast a reported attitude turns: the angle from one report to the next, divided by the time between
//! them.

use core::time::Duration;

use barrelman_vocab::telemetry::Quaternion;
use barrelman_vocab::{AngularRate, Timestamp};

use crate::session::RestEvidence;

/// An attitude that turns faster than this is in motion, rad/s: about 3 degrees a second. The least useful
/// rate of the camera is above, the sway of a hovering flight unit below.
pub const MOTION_RAD_PER_S: f64 = 0.05;
/// A rate older than this tells nothing: telemetry comes at 2 Hz or more.
const EVIDENCE_LASTS: Duration = Duration::from_millis(1200);

/// The newest attitude and how fast it turned.
#[derive(Debug, Clone, Copy)]
pub(crate) struct AttitudeRate {
    /// Attitudes are compared if they were reported at least this far apart: two that were read at once give
    /// no rate.
    least_spacing: Duration,
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

impl AttitudeRate {
    /// Without a report yet.
    pub(crate) const fn new(least_spacing: Duration) -> Self {
        Self { least_spacing, last: None, rate: None }
    }

    /// Takes a reported attitude.
    pub(crate) fn on_attitude(&mut self, attitude: Quaternion, now: Timestamp) {
        if let Some((before, at)) = self.last {
            let spacing = now.since(at);
            if spacing < self.least_spacing {
                return;
            }
            let rad_per_s = before.angle_to(attitude) / spacing.as_secs_f64();
            self.rate = Some(Rate { rad_per_s, from: at, to: now });
        }
        self.last = Some((attitude, now));
    }

    /// Whether a rate was ever shown.
    pub(crate) const fn has_seen(&self) -> bool {
        self.rate.is_some()
    }

    /// The newest rate, rad/s, if both its reports came after `since`.
    pub(crate) fn rate_since(&self, since: Timestamp, now: Timestamp) -> Option<f64> {
        let is_recent = |rate: &Rate| rate.from >= since && now.since(rate.to) <= EVIDENCE_LASTS;
        self.rate.filter(is_recent).map(|rate| rate.rad_per_s)
    }
}

/// What the rate of the fastest axis shows, rad/s.
pub(crate) fn evidence(fastest_rad_per_s: f64) -> RestEvidence {
    if fastest_rad_per_s > MOTION_RAD_PER_S {
        RestEvidence::Moving { rate: AngularRate::from_radians_per_second(fastest_rad_per_s) }
    } else {
        RestEvidence::AtRest
    }
}
