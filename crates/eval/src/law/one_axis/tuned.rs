//! The intermittent mode with values found for one axis, on the seeds from 3,001 to 3,048: how good its form can be.

use barrelman_control::bearing::BearingNoise;
use barrelman_control::optimal::{Adapted, IntermittentTuning};

/// The values.
pub(super) const INTERMITTENT: IntermittentTuning = IntermittentTuning {
    start: Adapted { base: 1.054, sway: 0.0, steepness: 0.0, usual_rate: -0.01941 },
    start_look_ahead_s: 0.4216,
    stop: Adapted { base: 0.303, sway: 0.0, steepness: 0.0, usual_rate: 0.9534 },
    stop_look_ahead_s: 1.906,
    aim: 0.5171,
    aim_look_ahead_s: 0.01825,
    horizon_s: 2.532,
    cruise_rate: Adapted { base: 0.2619, sway: 0.0, steepness: 0.0, usual_rate: 0.2817 },
    max_rate: 0.3355,
    join_share: 0.6477,
    leave_share: 0.1758,
    start_response_s: 0.1937,
    stop_response_s: 0.432,
    correction: 0.6013,
    min_rest_s: 0.3032,
    return_time_s: 9.888,
    memory_s: 91.93,
    noise: BearingNoise {
        rate_std_dev: 0.2538,
        rate_time_constant_s: 2.267,
        measurement_std_dev: 0.003916,
        max_sway_std_dev: 0.01089,
        sway_time_constant_s: 1.199,
    },
};
