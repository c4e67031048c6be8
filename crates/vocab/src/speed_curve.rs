//! How fast an axis turns at a speed of the vehicle's own scale, for vehicles whose speeds have no unit.

use crate::angle::AngularRate;

/// Most points of a curve.
pub const MAX_POINTS: usize = 16;

/// A speed and the rate at which the axis then turns.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SpeedPoint {
    /// Share of the vehicle's largest speed, in (0, 1].
    pub speed: f64,
    /// The rate, above zero.
    pub rate: AngularRate,
}

/// The curve of one axis, the same in both directions. Between its points it is straight. The axis rests
/// below the speed of the first point.
///
/// ```
/// use barrelman_vocab::AngularRate;
/// use barrelman_vocab::speed_curve::{SpeedCurve, SpeedPoint};
///
/// let rate = AngularRate::from_radians_per_second;
/// let point = |speed, at| SpeedPoint { speed, rate: rate(at) };
/// let curve = SpeedCurve::new(vec![point(0.1, 0.05), point(1.0, 0.5)]).unwrap();
/// assert_eq!(curve.speed_for(rate(-0.05)), -0.1);
/// assert_eq!(curve.speed_for(rate(0.01)), 0.0, "less than half of the least rate");
/// assert_eq!(curve.rate_at(0.55).radians_per_second(), 0.275);
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct SpeedCurve(Vec<SpeedPoint>);

/// Why points are no curve.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SpeedCurveError {
    /// There are none, or more than [`MAX_POINTS`].
    Count(usize),
    /// The point of this number, from 0, has a speed outside of (0, 1] or a rate that is not above zero.
    Range(usize),
    /// The point of this number does not exceed the one before in both.
    Order(usize),
}

impl core::fmt::Display for SpeedCurveError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self {
            Self::Count(count) => write!(f, "it has {count} points: give 1 to {MAX_POINTS}"),
            Self::Range(at) => {
                write!(
                    f,
                    "its point {}: the speed must be above 0 and at most 1, and the rate above 0",
                    at + 1
                )
            }
            Self::Order(at) => write!(f, "its point {}: speed and rate must exceed those before", at + 1),
        }
    }
}

impl core::error::Error for SpeedCurveError {}

impl SpeedCurve {
    /// The curve through these points.
    ///
    /// # Errors
    /// [`SpeedCurveError`] says which point is unusable.
    pub fn new(points: Vec<SpeedPoint>) -> Result<Self, SpeedCurveError> {
        if points.is_empty() || points.len() > MAX_POINTS {
            return Err(SpeedCurveError::Count(points.len()));
        }
        let is_usable = |point: &SpeedPoint| {
            let rate = point.rate.radians_per_second();
            point.speed > 0.0 && point.speed <= 1.0 && rate > 0.0 && rate.is_finite()
        };
        if let Some(at) = points.iter().position(|point| !is_usable(point)) {
            return Err(SpeedCurveError::Range(at));
        }
        let rises = |pair: &[SpeedPoint]| pair[0].speed < pair[1].speed && pair[0].rate < pair[1].rate;
        match points.windows(2).position(|pair| !rises(pair)) {
            Some(before) => Err(SpeedCurveError::Order(before + 1)),
            None => Ok(Self(points)),
        }
    }

    /// A straight curve through zero, from a hundredth of the largest speed on.
    pub fn linear(at_full_speed: AngularRate) -> Self {
        let point = |speed: f64| SpeedPoint { speed, rate: at_full_speed * speed };
        Self(vec![point(0.01), point(1.0)])
    }

    /// The points, in the order of their speeds.
    pub fn points(&self) -> &[SpeedPoint] {
        &self.0
    }

    /// The least rate other than zero at which the axis turns.
    pub fn least(&self) -> AngularRate {
        self.0[0].rate
    }

    /// The largest rate.
    pub fn largest(&self) -> AngularRate {
        self.0[self.0.len() - 1].rate
    }

    /// The speed for a rate, with the rate's sign, in [-1, 1]. A rate above the largest gives the largest;
    /// one below the least gives the least, or zero if it is less than half of it.
    pub fn speed_for(&self, rate: AngularRate) -> f64 {
        let size = rate.abs().radians_per_second();
        let at = |point: &SpeedPoint| (point.rate.radians_per_second(), point.speed);
        // A rate that is no number compares as less, and gives zero.
        let is_turning = size >= 0.5 * self.least().radians_per_second();
        let speed = if is_turning { self.interpolate(size, at) } else { 0.0 };
        if rate.radians_per_second() < 0.0 { -speed } else { speed }
    }

    /// The rate at a speed, with the speed's sign. A speed below that of the first point gives zero.
    pub fn rate_at(&self, speed: f64) -> AngularRate {
        let at = |point: &SpeedPoint| (point.speed, point.rate.radians_per_second());
        let is_turning = speed.abs() >= self.0[0].speed;
        let rate = if is_turning { self.interpolate(speed.abs(), at) } else { 0.0 };
        AngularRate::from_radians_per_second(if speed < 0.0 { -rate } else { rate })
    }

    /// The second value of `at` where its first one is `x`, held beyond both ends.
    fn interpolate(&self, x: f64, at: impl Fn(&SpeedPoint) -> (f64, f64)) -> f64 {
        let (first, last) = (at(&self.0[0]), at(&self.0[self.0.len() - 1]));
        let above = self.0.windows(2).find(|pair| x < at(&pair[1]).0);
        match above {
            _ if x <= first.0 => first.1,
            Some(pair) => {
                let ((x0, y0), (x1, y1)) = (at(&pair[0]), at(&pair[1]));
                y0 + (y1 - y0) * (x - x0) / (x1 - x0)
            }
            None => last.1,
        }
    }
}

/// The curves of a camera's axes.
#[derive(Debug, Clone, PartialEq)]
pub struct AxisSpeeds {
    /// Pan.
    pub pan: SpeedCurve,
    /// Tilt.
    pub tilt: SpeedCurve,
}

#[cfg(test)]
mod tests {
    use super::*;

    fn point(speed: f64, rate: f64) -> SpeedPoint {
        SpeedPoint { speed, rate: AngularRate::from_radians_per_second(rate) }
    }

    #[test]
    fn points_that_are_no_curve_are_named() {
        for (points, expected) in [
            (vec![], SpeedCurveError::Count(0)),
            (vec![point(0.5, 0.1); 17], SpeedCurveError::Count(17)),
            (vec![point(0.0, 0.1)], SpeedCurveError::Range(0)),
            (vec![point(0.1, 0.1), point(1.1, 0.2)], SpeedCurveError::Range(1)),
            (vec![point(0.1, f64::NAN)], SpeedCurveError::Range(0)),
            (vec![point(f64::NAN, 0.1)], SpeedCurveError::Range(0)),
            (vec![point(0.1, f64::INFINITY)], SpeedCurveError::Range(0)),
            (vec![point(0.2, 0.1), point(0.2, 0.2)], SpeedCurveError::Order(1)),
            (vec![point(0.1, 0.3), point(0.2, 0.2)], SpeedCurveError::Order(1)),
        ] {
            assert_eq!(SpeedCurve::new(points), Err(expected));
        }
    }

    #[test]
    fn speeds_and_rates_of_a_bent_curve_are_each_others() {
        let curve = SpeedCurve::new(vec![point(0.1, 0.02), point(0.3, 0.1), point(1.0, 1.4)]).unwrap();
        for speed in [-1.0, -0.42, -0.1, 0.0, 0.1, 0.2, 0.3, 0.77, 1.0] {
            let there_and_back = curve.speed_for(curve.rate_at(speed));
            assert!((there_and_back - speed).abs() < 1e-12, "{speed}: {there_and_back}");
        }
        let speed_for = |rate| curve.speed_for(AngularRate::from_radians_per_second(rate));
        assert_eq!([speed_for(9.0), speed_for(0.011), speed_for(-0.009)], [1.0, 0.1, 0.0]);
        assert_eq!(speed_for(f64::NAN), 0.0);
    }
}
