//! The parameters of the intermittent mode.

use super::circumstances::Adapted;
use crate::bearing::BearingNoise;

/// All parameters of the optimal law's intermittent mode.
///
/// Distances are in semi-axes of the region: 1 is the region's ellipse.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct IntermittentTuning {
    /// Start ellipse: a resting camera starts when the predicted target leaves it.
    pub start: Adapted,
    /// Look-ahead of the start, seconds after the effect time.
    pub start_look_ahead_s: f64,
    /// Stop ellipse: the camera stops when a camera told to rest now would keep the target inside.
    pub stop: Adapted,
    /// Look-ahead of the stop, seconds after the effect time.
    pub stop_look_ahead_s: f64,
    /// Aim ellipse of the transfer, which gives the direction of a movement and its smallest rates.
    pub aim: f64,
    /// How long after the horizon the target is to be inside the aim ellipse, seconds.
    pub aim_look_ahead_s: f64,
    /// Horizon of the transfer, seconds.
    pub horizon_s: f64,
    /// Smallest rate of the faster axis, rad/s.
    pub cruise_rate: Adapted,
    /// Largest rate of each axis, rad/s.
    pub max_rate: f64,
    /// An axis joins a movement from this share of the faster axis' rate on.
    pub join_share: f64,
    /// An axis that moves ends its part of the movement below this share of the faster axis' rate.
    pub leave_share: f64,
    /// Response time to which an axis with a shorter lag is slowed by ramps when it starts, as a share of the
    /// slower axis' lag.
    pub start_response_share: f64,
    /// The same when it stops.
    pub stop_response_share: f64,
    /// Correction ellipse: a movement is corrected when it would not bring the target into it within the
    /// horizon.
    pub correction: f64,
    /// Shortest rest between two movements, seconds.
    pub min_rest_s: f64,
    /// Time within which the target returns towards its mean direction, seconds, above 0.
    pub return_time_s: f64,
    /// Time constant of the mean direction, seconds.
    pub memory_s: f64,
    /// Noise parameters of the bearing filter.
    pub noise: BearingNoise,
}

impl IntermittentTuning {
    /// The tuning of [`OptimalMode::Intermittent`](barrelman_vocab::OptimalMode::Intermittent).
    pub const DEFAULT: Self = Self {
        start: Adapted {
            base: 0.99,
            sway: -0.18,
            steepness: 0.033,
            usual_rate: 0.092,
            delay: -0.05,
            lag: -0.15,
        },
        start_look_ahead_s: 0.181,
        stop: Adapted {
            base: 0.71,
            sway: 0.0,
            steepness: 0.036,
            usual_rate: -0.67,
            delay: -0.48,
            lag: -0.84,
        },
        stop_look_ahead_s: 1.71,
        aim: 0.494,
        aim_look_ahead_s: 1.04,
        horizon_s: 1.73,
        cruise_rate: Adapted {
            base: 0.283,
            sway: 0.3,
            steepness: -0.029,
            usual_rate: -0.4,
            delay: -0.023,
            lag: -0.179,
        },
        max_rate: 0.325,
        join_share: 0.833,
        leave_share: 0.531,
        start_response_share: 0.814,
        stop_response_share: 0.0,
        correction: 0.589,
        min_rest_s: 0.284,
        return_time_s: 2.76,
        memory_s: 78.5,
        noise: BearingNoise {
            rate_std_dev: 0.0646,
            rate_time_constant_s: 2.43,
            measurement_std_dev: 0.00228,
            max_sway_std_dev: 0.0455,
            sway_time_constant_s: 2.89,
        },
    };

    /// This tuning with another horizon.
    #[must_use]
    pub fn with_horizon(self, horizon_s: f64) -> Self {
        Self { horizon_s, ..self }
    }
}
