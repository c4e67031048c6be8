//! Settings of the optimal law: its modes and the tuning of each mode.

use barrelman_vocab::{Framed, OptimalMode};

use super::intermittent_tuning::IntermittentTuning;
use crate::bearing::BearingNoise;

/// Settings of the optimal law.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct OptimalSettings {
    /// What the law minimises.
    pub mode: OptimalMode,
    /// Time within which the law brings the target back, seconds. A longer horizon gives slower movements.
    /// `None` selects the horizon of the mode.
    pub horizon_s: Option<f64>,
    /// What the law shows.
    pub framed: Framed,
}

impl OptimalSettings {
    /// A mode with its own horizon.
    pub const fn new(mode: OptimalMode) -> Self {
        Self { mode, horizon_s: None, framed: Framed::Boat }
    }

    /// Valid horizons, seconds.
    pub const HORIZONS_S: core::ops::RangeInclusive<f64> = 0.5..=5.0;

    /// The tuning that corresponds to these settings.
    pub fn tuning(&self) -> ModeTuning {
        let receding = |tuning: Tuning| {
            Tuning { horizon_s: self.horizon_s.unwrap_or(tuning.horizon_s), ..tuning }.into()
        };
        match self.mode {
            OptimalMode::MinimumEnergy => receding(Tuning::MINIMUM_ENERGY),
            OptimalMode::TimeFuel => receding(Tuning::TIME_FUEL),
            OptimalMode::Eco => receding(Tuning::ECO),
            OptimalMode::Intermittent => {
                let tuning = IntermittentTuning::DEFAULT;
                self.horizon_s.map_or(tuning, |horizon_s| tuning.with_horizon(horizon_s)).into()
            }
        }
    }
}

/// The tuning of any mode.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum ModeTuning {
    /// Of a mode that computes its rates anew at each step.
    RecedingHorizon(Tuning),
    /// Of the intermittent mode.
    Intermittent(IntermittentTuning),
}

impl From<Tuning> for ModeTuning {
    fn from(tuning: Tuning) -> Self {
        Self::RecedingHorizon(tuning)
    }
}

impl From<IntermittentTuning> for ModeTuning {
    fn from(tuning: IntermittentTuning) -> Self {
        Self::Intermittent(tuning)
    }
}

/// All parameters of the receding-horizon modes.
///
/// Distances are in semi-axes of the region: 1 is the region's ellipse. A target is *slow* in proportion to
/// how far its bearing rate lies below `fast_target_rate`; at zero rate it is fully slow.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Tuning {
    /// Start ellipse: the camera starts when the predicted target leaves it.
    pub start: f64,
    /// Widening of the start ellipse for predictions, in standard deviations of the predicted position. A
    /// larger value delays uncertain starts.
    pub start_sigma: f64,
    /// Stop ellipse: the camera stops when a camera told to rest now would keep the target inside.
    pub stop: f64,
    /// Aim ellipse: the transfer moves the target into it.
    pub aim: f64,
    /// Horizon of the transfer for a fast target, seconds.
    pub horizon_s: f64,
    /// Relative increase of the horizon for a slow target. Slower movements take less energy.
    pub slow_target_gain: f64,
    /// Increase of the horizon per unit of additional turning effort relative to a level camera. Looking down
    /// steeply, pan hardly moves the picture and costs much energy.
    pub steep_view_gain: f64,
    /// Increase of the stop and aim ellipses for a slow target.
    pub slow_target_widening: f64,
    /// Look-ahead of the start for a fast target, seconds. It is shorter in proportion for slower targets.
    pub start_look_ahead_s: f64,
    /// Bearing rate from which a target counts as fast, rad/s.
    pub fast_target_rate: f64,
    /// Look-ahead of the stop, seconds.
    pub stop_look_ahead_s: f64,
    /// Time over which a target that is already inside the aim ellipse is moved into the stop ellipse,
    /// seconds. `steep_view_gain` increases it as well.
    pub recentring_time_s: f64,
    /// Smallest rate of the faster axis, rad/s.
    pub min_rate: f64,
    /// Largest rate of each axis, rad/s.
    pub max_rate: f64,
    /// An axis rests if its rate is below this share of the other axis' rate.
    pub min_axis_share: f64,
    /// Commands that differ by less than this from the command in force are suppressed, rad/s.
    pub command_deadband: f64,
    /// Shortest rest between two movements, seconds.
    pub min_rest_s: f64,
    /// Noise parameters of the bearing filter.
    pub noise: BearingNoise,
}

/// Noise parameters for the modes that move at a cruising speed.
const CRUISING_NOISE: BearingNoise = BearingNoise {
    rate_std_dev: 0.0855,
    rate_time_constant_s: 2.253,
    measurement_std_dev: 0.0013,
    max_sway_std_dev: 0.0149,
    sway_time_constant_s: 5.02,
};

impl Tuning {
    /// The tuning of [`OptimalMode::MinimumEnergy`].
    pub const MINIMUM_ENERGY: Self = Self {
        start: 0.85,
        start_sigma: 0.1,
        stop: 0.04,
        aim: 0.704,
        horizon_s: 1.22,
        slow_target_gain: 0.009,
        steep_view_gain: 1.5,
        slow_target_widening: 0.098,
        start_look_ahead_s: 1.7,
        fast_target_rate: 0.0236,
        stop_look_ahead_s: 0.165,
        recentring_time_s: 6.5,
        min_rate: 0.01,
        max_rate: 0.34,
        min_axis_share: 0.62,
        command_deadband: 0.0,
        min_rest_s: 0.11,
        noise: BearingNoise {
            rate_std_dev: 0.088,
            rate_time_constant_s: 2.4,
            measurement_std_dev: 0.002,
            max_sway_std_dev: 0.031,
            sway_time_constant_s: 4.76,
        },
    };
    /// The tuning of [`OptimalMode::TimeFuel`].
    pub const TIME_FUEL: Self = Self {
        start: 0.98,
        start_sigma: 0.0,
        stop: 0.7,
        aim: 0.7,
        horizon_s: 2.0,
        slow_target_gain: 0.0,
        steep_view_gain: 0.0,
        slow_target_widening: 0.0,
        start_look_ahead_s: 0.3,
        fast_target_rate: 0.1,
        stop_look_ahead_s: 0.6,
        recentring_time_s: 6.0,
        min_rate: 0.28,
        max_rate: 0.3,
        min_axis_share: 0.12,
        command_deadband: 0.06,
        min_rest_s: 0.3,
        noise: CRUISING_NOISE,
    };
    /// The tuning of [`OptimalMode::Eco`].
    pub const ECO: Self = Self {
        start: 1.033,
        start_sigma: 0.2,
        stop: 0.735,
        aim: 0.518,
        horizon_s: 1.806,
        slow_target_gain: 0.145,
        steep_view_gain: 0.426,
        slow_target_widening: 0.043,
        start_look_ahead_s: 0.111,
        fast_target_rate: 0.185,
        stop_look_ahead_s: 0.986,
        recentring_time_s: 6.0,
        min_rate: 0.288,
        max_rate: 0.333,
        min_axis_share: 0.59,
        command_deadband: 0.0196,
        min_rest_s: 0.335,
        noise: CRUISING_NOISE,
    };
}
