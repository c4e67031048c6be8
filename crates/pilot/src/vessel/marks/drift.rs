//! How a marked person drifts, as the places tell at which the person was marked or seen.

use core::time::Duration;

use barrelman_vocab::{Timestamp, WaterFix, WaterPoint};

/// Least time between two places of a mark that tell a drift.
const DRIFT_AFTER: Duration = Duration::from_secs(2);

/// Standard deviation of each component of a person's drift before it is known, m/s.
const DRIFT_STD_DEV_M_PER_S: f64 = 0.3;
/// Growth of the variance of a known drift, (m/s)² per second: wind and current change.
const DRIFT_NOISE: f64 = 0.0004;
/// Standard deviation of each coordinate of a mark, beside what the camera's geometry tells, metres: the
/// kite's sway, the hand.
const MARK_STD_DEV_M: f64 = 0.8;
/// Largest drift that is believed, m/s: a fast tidal current.
const MAX_DRIFT_M_PER_S: f64 = 1.5;

/// An estimate of a drift over the water frame: a Kalman filter with the states place and velocity, the same
/// for x and y. What it measures are the places of the mark. It starts at rest.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Drift {
    /// Along x and y, m/s.
    pub velocity_m_per_s: (f64, f64),
    place: (f64, f64),
    /// Time of capture of the newest place.
    observed: Timestamp,
    /// Variances of place (m²) and velocity ((m/s)²), and their covariance.
    variances: [f64; 2],
    covariance: f64,
}

impl Drift {
    /// At rest where a mark is.
    pub(super) fn at_rest(fix: &WaterFix, captured: Timestamp) -> Self {
        let (WaterPoint { x, y }, std_dev_m) = (fix.point, std_dev_of(fix));
        let speed_variance = DRIFT_STD_DEV_M_PER_S * DRIFT_STD_DEV_M_PER_S;
        Self {
            velocity_m_per_s: (0.0, 0.0),
            place: (x, y),
            observed: captured,
            variances: [std_dev_m * std_dev_m, speed_variance],
            covariance: 0.0,
        }
    }

    /// The place was corrected: the velocity stays as it is.
    fn correct(&mut self, fix: &WaterFix, captured: Timestamp) {
        let velocity_variance = self.variances[1];
        let Self { place, variances: [place_variance, _], .. } = Self::at_rest(fix, captured);
        (self.place, self.variances, self.covariance) = (place, [place_variance, velocity_variance], 0.0);
        self.observed = captured;
    }

    /// Takes in that the operator moved the mark to a place. Places close in time tell nothing of the drift.
    pub(super) fn move_to(&mut self, fix: &WaterFix, captured: Timestamp) {
        if !self.see(fix, captured) {
            self.correct(fix, captured);
        }
    }

    /// Takes in that what drifts was seen at a place. Returns whether the place tells of the drift: it is no
    /// sooner than [`DRIFT_AFTER`] after the last one.
    pub(super) fn see(&mut self, fix: &WaterFix, captured: Timestamp) -> bool {
        let since = captured.since(self.observed);
        let is_told = since >= DRIFT_AFTER;
        if is_told {
            self.observe(fix.point, since.as_secs_f64(), std_dev_of(fix));
            self.observed = captured;
        }
        is_told
    }

    /// Standard deviation of each component of the velocity, m/s.
    pub(super) fn std_dev_m_per_s(&self) -> f64 {
        libm::sqrt(self.variances[1])
    }

    /// Takes in that what drifts is at a place after a time.
    fn observe(&mut self, WaterPoint { x, y }: WaterPoint, duration_s: f64, std_dev_m: f64) {
        let [place, velocity] = self.variances;
        let covariance = self.covariance + duration_s * velocity;
        let place = place + duration_s * (self.covariance + covariance);
        let velocity = velocity + DRIFT_NOISE * duration_s;
        let total = place + std_dev_m * std_dev_m;
        let gains = (place / total, covariance / total);
        let (vx, vy) = self.velocity_m_per_s;
        let expected = (self.place.0 + duration_s * vx, self.place.1 + duration_s * vy);
        let off = (x - expected.0, y - expected.1);
        self.place = (expected.0 + gains.0 * off.0, expected.1 + gains.0 * off.1);
        let mixed = (vx + gains.1 * off.0, vy + gains.1 * off.1);
        let scale = (MAX_DRIFT_M_PER_S / libm::hypot(mixed.0, mixed.1).max(1e-9)).min(1.0);
        self.velocity_m_per_s = (scale * mixed.0, scale * mixed.1);
        self.variances = [(1.0 - gains.0) * place, velocity - gains.1 * covariance];
        self.covariance = (1.0 - gains.0) * covariance;
    }
}

/// Standard deviation of each coordinate of a mark's place, metres.
fn std_dev_of(fix: &WaterFix) -> f64 {
    libm::hypot(MARK_STD_DEV_M, fix.covariance.max_std_dev_m())
}
