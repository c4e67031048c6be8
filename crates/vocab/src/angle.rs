//! Angles and angular rates. Which way is positive belongs to the quantity and is stated where it is named.

use core::fmt;
use core::ops::{Mul, Neg};

/// An angle in radians. Zero and sense are stated where the angle is named.
#[derive(Debug, Clone, Copy, PartialEq, PartialOrd, Default)]
pub struct Angle(f64);

impl Angle {
    /// No turn.
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

/// A rate of turn in radians per second. A camera's pan rate is positive where the view turns right, its tilt
/// rate where the view rises.
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

    /// The size of the rate, without its sense.
    pub const fn abs(self) -> Self {
        Self(self.0.abs())
    }

    /// Whether this asks for no motion at all. `-0.0` is zero.
    pub fn is_zero(self) -> bool {
        self.0 == 0.0
    }

    /// This rate held within `limit` on both sides. What is not a number, rate or limit, becomes zero: a rate that
    /// cannot be understood must not move a camera.
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

    /// The opposite rate. Zero stays `0.0`: a vehicle is never sent `-0.000000`.
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
