//! Zoom: how fast a camera's focal length changes, and what the zoom of a vehicle's camera can do.

use core::ops::Neg;
use core::time::Duration;

/// A rate of the zoom: the change of the focal length's logarithm in a second, positive to a closer view.
/// At 0.1 the focal length grows by a tenth in a second.
///
/// ```
/// use barrelman_vocab::ZoomRate;
///
/// let limit = ZoomRate::from_per_second(0.2);
/// assert_eq!(ZoomRate::from_per_second(-0.5).clamped(limit), -limit);
/// ```
#[derive(Debug, Clone, Copy, PartialEq, PartialOrd, Default)]
pub struct ZoomRate(f64);

impl ZoomRate {
    /// At rest.
    pub const ZERO: Self = Self(0.0);

    /// From the change of the logarithm in a second.
    pub const fn from_per_second(rate: f64) -> Self {
        Self(rate)
    }

    /// The change of the logarithm in a second.
    pub const fn per_second(self) -> f64 {
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

    /// The share of a largest rate, -1 to 1; zero where that one is zero, or where one of them is no number.
    pub fn share_of(self, largest: Self) -> f64 {
        let clamped = self.clamped(largest);
        if clamped.is_zero() { 0.0 } else { clamped.0 / largest.0.abs() }
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

impl Neg for ZoomRate {
    type Output = Self;

    /// The opposite rate. Zero stays `0.0`.
    fn neg(self) -> Self {
        if self.is_zero() { Self::ZERO } else { Self(-self.0) }
    }
}

/// Whether a vehicle's camera zooms by command, as far as the vehicle has told.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Default)]
pub enum ZoomAbility {
    /// The vehicle has not told yet: nothing is zoomed.
    #[default]
    NotKnown,
    /// It does not.
    Absent,
    /// It does.
    Present,
}

impl ZoomAbility {
    /// Of a vehicle that has told.
    pub const fn told(is_present: bool) -> Self {
        if is_present { Self::Present } else { Self::Absent }
    }
}

/// The zoom of a vehicle's camera. Its widest view is that of
/// [`CameraDynamics::focal_share`](crate::profile::CameraDynamics::focal_share).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ZoomDynamics {
    /// The focal length of the closest view over that of the widest, above 1.
    pub ratio: f64,
    /// The largest rate, above zero.
    pub max_rate: ZoomRate,
    /// Time from a command to its effect, without the video latency.
    pub dead_time: Duration,
}

impl ZoomDynamics {
    /// A zoom of this ratio that moves as a camera whose zoom was not measured is assumed to: a factor of two
    /// takes 2.3 s.
    pub const fn usual(ratio: f64) -> Self {
        Self { ratio, max_rate: ZoomRate::from_per_second(0.3), dead_time: Duration::from_millis(200) }
    }
}
