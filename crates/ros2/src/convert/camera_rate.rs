//! The command in force as a twist.
//!
//! The axes are those of REP 103: x ahead, y to the left, z upwards. Pan, positive to the right, is a
//! negative rotation about z. Tilt, positive upwards, is a negative rotation about y.

use crate::console::api::Rates;
use crate::messages::{Header, Twist, TwistStamped, Vector3};

/// The twist of these rates.
pub fn camera_rate(rates: Rates, header: Header) -> TwistStamped {
    // A zero has no sign.
    let negated = |rate: f64| 0.0 - rate;
    let angular = Vector3 { x: 0.0, y: negated(rates.tilt), z: negated(rates.pan) };
    TwistStamped { header, twist: Twist { linear: Vector3::default(), angular } }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[track_caller]
    fn check((pan, tilt): (f64, f64), (y, z): (f64, f64)) {
        let twist = camera_rate(Rates { pan, tilt }, Header::default()).twist;
        assert_eq!(twist.angular, Vector3 { x: 0.0, y, z }, "pan {pan}, tilt {tilt}");
        assert_eq!(twist.linear, Vector3::default());
        assert!(twist.angular.y.is_sign_positive() == (y >= 0.0), "{twist:?}");
    }

    #[test]
    fn pan_and_tilt_are_rotations_about_the_axes_of_rep_103() {
        check((0.0, 0.0), (0.0, 0.0));
        check((0.25, 0.0), (0.0, -0.25));
        check((-0.25, 0.0), (0.0, 0.25));
        check((0.0, 0.5), (-0.5, 0.0));
        check((0.125, -0.5), (0.5, -0.125));
    }
}
