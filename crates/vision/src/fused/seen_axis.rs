//! The axis of the target as it is seen, and its two ends.

use barrelman_vocab::Angle;
use barrelman_vocab::track::Shape;

/// An axis, with the sides along and across it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct SeenAxis {
    /// One end, radians clockwise from image right.
    pub(super) angle: f32,
    /// Full length along and across, pixels.
    pub(super) sides: (f32, f32),
}

impl SeenAxis {
    /// The reported shape.
    pub(super) fn shape(self) -> Shape {
        let (along, across) = self.sides;
        Shape {
            major_px: f64::from(along.max(across)),
            minor_px: f64::from(along.min(across)),
            axis: to_anticlockwise(self.angle, core::f64::consts::PI),
        }
    }

    /// The reported heading of a target whose bow is at the given end, or at the other.
    pub(super) fn heading(self, is_bow_at_end: bool) -> Angle {
        let bow = if is_bow_at_end { self.angle } else { self.angle + core::f32::consts::PI };
        to_anticlockwise(bow, core::f64::consts::TAU)
    }
}

/// Converts an angle clockwise from image right to one anticlockwise, from 0 (inclusive) to `period`
/// (exclusive).
fn to_anticlockwise(clockwise: f32, period: f64) -> Angle {
    let turned = -f64::from(clockwise);
    let wrapped = turned - period * (turned / period).floor();
    // Rounding can give the period itself.
    Angle::from_radians(if wrapped < period { wrapped } else { 0.0 })
}
