//! What the line-of-sight law knows of the vessel, and its gains.

/// A rough model of a vessel: how it answers to throttle and rudder. The values need not be exact:
/// measurements correct the estimate.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct VesselModel {
    /// Turn rate at full rudder for each unit of throttle, rad/s: a jet or a propeller wash.
    pub turn_per_throttle: f64,
    /// Turn rate at full rudder for each m/s of speed, rad/m: a rudder in the stream.
    pub turn_per_speed: f64,
    /// Time constant of the turn rate of the bow, seconds.
    pub yaw_lag_s: f64,
    /// Time constant with which the course follows the bow, seconds: the hull's drift in turns.
    pub drift_lag_s: f64,
    /// Time constant of the thrust, seconds.
    pub thrust_lag_s: f64,
    /// Time constant of the speed, seconds.
    pub surge_lag_s: f64,
    /// Speed for each unit of throttle, m/s.
    pub speed_per_throttle: f64,
    /// Radius of a full turn under full thrust, metres.
    pub turn_radius_m: f64,
    /// Deceleration of the coasting boat near rest, m/s².
    pub coasting_m_per_s2: f64,
    /// Additional deceleration of full throttle astern, m/s²; it grows with the square of the throttle.
    pub astern_m_per_s2: f64,
}

impl VesselModel {
    /// A small jet boat of 1.2 m in the class of EMILY; rounded from the simulated boat
    /// (`crates/sim/src/boat.rs`).
    pub const JET: Self = Self {
        turn_per_throttle: 1.8,
        turn_per_speed: 0.0,
        yaw_lag_s: 0.4,
        drift_lag_s: 0.7,
        thrust_lag_s: 0.25,
        surge_lag_s: 1.5,
        speed_per_throttle: 3.6,
        turn_radius_m: 1.6,
        coasting_m_per_s2: 0.1,
        astern_m_per_s2: 1.4,
    };
}

/// Gains and thresholds of the line-of-sight law.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LineOfSightTuning {
    /// Density of the acceleration that drives the estimate, m/s² per root hertz.
    pub acceleration_noise: f64,
    /// Floor of the standard deviation of a fix, metres: the boat's own motion in waves, and its size.
    pub min_fix_std_dev_m: f64,
    /// Turn rate for each radian of course error, 1/s.
    pub course_gain_per_s: f64,
    /// Share of the modelled turn to come that is taken from the course error.
    pub turn_damping: f64,
    /// The rudder stays where it would move by less than this.
    pub rudder_step: f64,
    /// Look-ahead distance as a share of the distance to the end of the leg.
    pub look_ahead_share: f64,
    /// Bounds of the look-ahead distance, metres.
    pub look_ahead_m: (f64, f64),
    /// Weight of the integral of the cross-track error, m/s.
    pub integral_gain: f64,
    /// Cross-track errors beyond this are not integrated, metres.
    pub integral_limit_m: f64,
    /// Within this distance the boat heads for the point itself, metres.
    pub pursuit_m: f64,
    /// Throttle with which the boat gets way on.
    pub way_throttle: f64,
    /// From this speed over ground on, the course is that of the velocity, m/s,
    pub course_speed_m_per_s: f64,
    /// if the modelled speed through the water is at least this, m/s: a boat at rest drifts on a course, too.
    pub way_speed_m_per_s: f64,
    /// Deceleration of the approach to a place, m/s²: the boat may run a little beyond.
    pub approach_m_per_s2: f64,
    /// A place is reached within this distance, metres.
    pub arrival_m: f64,
    /// The boat goes back to a place from this distance on, metres.
    pub hold_m: f64,
    /// A way-point is passed within this distance, metres.
    pub way_point_m: f64,
    /// The boat stops so far outside of a stand-off, metres.
    pub stand_off_margin_m: f64,
    /// The boat passes a circle at this distance from its edge, metres.
    pub keep_out_margin_m: f64,
    /// Time in which the boat goes on as before after a command to stop, seconds: lags of thrust and
    /// estimate.
    pub reaction_s: f64,
    /// Neutral if no fix arrived for this long, seconds.
    pub max_silence_s: f64,
    /// Neutral if the last fix is older than this, seconds.
    pub max_age_s: f64,
}

impl LineOfSightTuning {
    /// The default gains.
    pub const DEFAULT: Self = Self {
        acceleration_noise: 0.34,
        min_fix_std_dev_m: 0.05,
        course_gain_per_s: 4.0,
        turn_damping: 0.6,
        rudder_step: 0.05,
        look_ahead_share: 0.5,
        look_ahead_m: (2.5, 6.0),
        integral_gain: 0.1,
        integral_limit_m: 2.0,
        pursuit_m: 3.5,
        way_throttle: 0.6,
        course_speed_m_per_s: 0.4,
        way_speed_m_per_s: 0.6,
        approach_m_per_s2: 0.4,
        arrival_m: 1.2,
        hold_m: 2.0,
        way_point_m: 2.0,
        stand_off_margin_m: 1.2,
        keep_out_margin_m: 2.0,
        reaction_s: 0.6,
        max_silence_s: 0.6,
        max_age_s: 1.5,
    };
}

impl Default for LineOfSightTuning {
    fn default() -> Self {
        Self::DEFAULT
    }
}
