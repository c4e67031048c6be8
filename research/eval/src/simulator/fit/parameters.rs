//! The parameters that are fitted, with their bounds.

use barrelman_sim::pursuit::PursuitScript;

/// The script of the simulated target, and factors that scale its path in addition.
#[derive(Debug, Clone)]
pub(super) struct ScaledScript {
    pub(super) pursuit: PursuitScript,
    /// Factor of all way-points.
    scale: f64,
    /// Further factor across.
    breadth: f64,
}

impl ScaledScript {
    pub(super) const fn unscaled(pursuit: PursuitScript) -> Self {
        Self { pursuit, scale: 1.0, breadth: 1.0 }
    }

    /// The script with its path scaled.
    pub(super) fn scaled(&self) -> PursuitScript {
        let scaled = |(x, y): &(f64, f64)| (self.scale * self.breadth * x, self.scale * y);
        let way_points = self.pursuit.way_points.iter().map(scaled).collect();
        PursuitScript { way_points, ..self.pursuit.clone() }
    }
}

/// A parameter: its name in the scenario's file, its lower and upper bound, and its field.
type Parameter = (&'static str, f64, f64, fn(&mut ScaledScript) -> &mut f64);

/// The parameters that are fitted.
pub(super) const PARAMETERS: [Parameter; 20] = [
    ("scale", 0.6, 1.4, |s| &mut s.scale),
    ("breadth", 0.6, 1.4, |s| &mut s.breadth),
    ("speed_m_per_s", 0.5, 3.0, |s| &mut s.pursuit.speed_m_per_s),
    ("speed_spread", 0.05, 0.4, |s| &mut s.pursuit.log_speed_std_dev),
    ("range_exponent", 0.0, 1.0, |s| &mut s.pursuit.range_exponent),
    ("gust_share", 0.0, 0.8, |s| &mut s.pursuit.speed_variation.std_dev),
    ("gust_time_s", 0.1, 5.0, |s| &mut s.pursuit.speed_variation.time_constant_s),
    ("weave_rad", 0.0, 1.0, |s| &mut s.pursuit.weave.std_dev),
    ("weave_time_s", 0.2, 3.0, |s| &mut s.pursuit.weave.time_constant_s),
    ("look_ahead_m", 0.15, 1.0, |s| &mut s.pursuit.look_ahead_m),
    ("way_point_jitter_m", 0.0, 0.4, |s| &mut s.pursuit.way_point_jitter_m),
    ("surge_lag_s", 0.02, 1.0, |s| &mut s.pursuit.surge_lag_s),
    ("corner_slow_down", 0.0, 0.95, |s| &mut s.pursuit.corner_slow_down),
    ("arrival_m", 0.0, 3.0, |s| &mut s.pursuit.arrival_m),
    ("stand_before_s", 0.0, 15.0, |s| &mut s.pursuit.stand_before_s),
    ("stand_after_s", 0.0, 3.0, |s| &mut s.pursuit.stand_after_s),
    ("pauses_per_s", 0.0, 0.5, |s| &mut s.pursuit.pauses_per_s),
    ("leg_rhythm", 0.0, 0.95, |s| &mut s.pursuit.leg_end_slow_down),
    ("corner_pauses", 0.0, 1.0, |s| &mut s.pursuit.corner_pauses),
    ("pause_s", 0.2, 3.0, |s| &mut s.pursuit.pause_s),
];

/// A point in the space of parameters: each from 0 at its lower bound to 1 at its upper bound.
pub(super) type UnitPoint = [f64; PARAMETERS.len()];

/// A script with the parameters of a point.
pub(super) fn at_point(script: &ScaledScript, point: &UnitPoint) -> ScaledScript {
    let mut script = script.clone();
    for ((_, low, high, field), share) in PARAMETERS.iter().zip(point) {
        *field(&mut script) = low + (high - low) * share;
    }
    script
}

/// The point of a script's parameters, clamped to their bounds.
pub(super) fn to_point(script: &ScaledScript) -> UnitPoint {
    let mut script = script.clone();
    PARAMETERS.map(|(_, low, high, field)| ((*field(&mut script) - low) / (high - low)).clamp(0.0, 1.0))
}
