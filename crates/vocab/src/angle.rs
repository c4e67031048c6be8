//! Angles and angular rates. Each quantity that uses them documents its own positive direction.

use core::fmt;
use core::ops::{Mul, Neg};

/// An angle in radians. Zero and positive direction are documented where the angle is used.
///
/// ```
/// use barrelman_vocab::Angle;
///
/// let down = Angle::from_degrees(-90.0);
/// assert_eq!(down.radians(), -core::f64::consts::FRAC_PI_2);
/// ```
#[derive(Debug, Clone, Copy, PartialEq, PartialOrd, Default)]
pub struct Angle(f64);

impl Angle {
    /// Zero.
    pub const ZERO: Self = Self(0.0);

    /// From radians.
    pub const fn from_radians(radians: f64) -> Self {
        Self(radians)
    }

    /// From degrees.
    pub const fn from_degrees(degrees: f64) -> Self {
        Self(degrees.to_radians())
    }

    /// In radians.
    pub const fn radians(self) -> f64 {
        self.0
    }

    /// In degrees.
    pub const fn degrees(self) -> f64 {
        self.0.to_degrees()
    }
}

/// An angular rate in radians per second. A camera's pan rate is positive to the right, its tilt rate is
/// positive upwards.
///
/// ```
/// use barrelman_vocab::AngularRate;
///
/// let limit = AngularRate::from_radians_per_second(0.3);
/// let requested = AngularRate::from_radians_per_second(-0.5);
/// assert_eq!(requested.clamped(limit), -limit);
/// ```
#[derive(Debug, Clone, Copy, PartialEq, PartialOrd, Default)]
pub struct AngularRate(f64);

impl AngularRate {
    /// At rest.
    pub const ZERO: Self = Self(0.0);

    /// From radians per second.
    pub const fn from_radians_per_second(rate: f64) -> Self {
        Self(rate)
    }

    /// In radians per second.
    pub const fn radians_per_second(self) -> f64 {
        self.0
    }

    /// The absolute value.
    pub const fn abs(self) -> Self {
        Self(self.0.abs())
    }

    /// Whether the rate is zero; `-0.0` counts as zero.
    pub fn is_zero(self) -> bool {
        self.0 == 0.0
    }

    /// The rate clamped to `-|limit|..=|limit|`. The result is zero if the rate or the limit is NaN: an
    /// invalid rate must not move a camera.
    pub fn clamped(self, limit: Self) -> Self {
        if self.0.is_nan() || limit.0.is_nan() {
            Self::ZERO
        } else {
            Self(self.0.clamp(-limit.0.abs(), limit.0.abs()))
        }
    }
}

impl Neg for AngularRate {
    type Output = Self;

    /// The opposite rate. Zero stays `0.0`, so that `-0.000000` is never sent to a vehicle.
    fn neg(self) -> Self {
        if self.is_zero() { Self::ZERO } else { Self(-self.0) }
    }
}

impl Mul<f64> for AngularRate {
    type Output = Self;

    fn mul(self, factor: f64) -> Self {
        Self(self.0 * factor)
    }
}

impl fmt::Display for AngularRate {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:+.3} rad/s", self.0)
    }
}

/// The same angle within -pi to pi, radians.
pub fn wrapped(radians: f64) -> f64 {
    let turn = core::f64::consts::TAU;
    radians - turn * libm::floor(radians / turn + 0.5)
}
