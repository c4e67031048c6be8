//! The intermittent mode with values found for one axis, on the seeds from 3,001 to 3,048: how good its form can be.

use barrelman_control::bearing::BearingNoise;
use barrelman_control::optimal::{Adapted, IntermittentTuning};

/// The values.
pub(super) const INTERMITTENT: IntermittentTuning = IntermittentTuning {
    start: Adapted { base: 1.114, sway: 0.0, steepness: 0.0, usual_rate: 0.376, delay: 0.0, lag: 0.0 },
    start_look_ahead_s: 0.9827,
    stop: Adapted { base: 0.3014, sway: 0.0, steepness: 0.0, usual_rate: 1.088, delay: 0.0, lag: 0.0 },
    stop_look_ahead_s: 1.203,
    aim: 0.5014,
    aim_look_ahead_s: 0.7149,
    horizon_s: 2.839,
    cruise_rate: Adapted { base: 0.2773, sway: 0.0, steepness: 0.0, usual_rate: 0.0, delay: 0.0, lag: 0.0 },
    max_rate: 0.3503,
    join_share: 0.6314,
    leave_share: 0.2396,
    start_response_share: 0.395,
    stop_response_share: 0.6645,
    correction: 0.9785,
    min_rest_s: 0.4668,
    return_time_s: 13.78,
    memory_s: 101.9,
    noise: BearingNoise {
        rate_std_dev: 0.2337,
        rate_time_constant_s: 2.384,
        measurement_std_dev: 0.0005095,
        max_sway_std_dev: 0.01482,
        sway_time_constant_s: 1.195,
    },
};
