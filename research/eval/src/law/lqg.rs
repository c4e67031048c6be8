//! A linear-quadratic regulator that keeps the target in the picture's centre, on the predicted state: the
//! best that centring can do. A reference, not part of the product.
//!
//! Each axis has the state (e, v, w): the target's offset, rad of that axis, the rate of its bearing, and the
//! rate of the camera, rad/s. `e' = v - w`, `v' = -v / memory`, `w' = (u - w) / lag`. The gains minimise
//! `∫ (e² + weight u²) dt`. They come from the Riccati equation, integrated to its steady state.

use barrelman_control::{CameraModel, Law, LawInput};
use barrelman_vocab::{AngularRate, CameraCommand, VehicleProfile};

use super::target_predictor::{MIN_LAG_S, RATE_MEMORY_S, TargetPredictor};

/// The interval from which the rate of the bearing is computed, seconds.
const RATE_INTERVAL_S: f64 = 0.02;

/// Gains on e, v and w.
type Gains = [f64; 3];

/// The regulator of both axes.
#[derive(Debug, Clone)]
pub(super) struct Lqg {
    gains: [Gains; 2],
    max_rates: [f64; 2],
    predictor: TargetPredictor,
}

impl Lqg {
    pub(super) fn new(weight: f64, profile: &VehicleProfile) -> Self {
        let axes = [profile.camera.pan, profile.camera.tilt];
        Self {
            gains: axes.map(|axis| gains(weight, axis.lag.as_secs_f64().max(MIN_LAG_S))),
            max_rates: [profile.limits.pan, profile.limits.tilt].map(AngularRate::radians_per_second),
            predictor: TargetPredictor::new(),
        }
    }
}

impl Law for Lqg {
    fn command(&mut self, input: &LawInput<'_>, camera: &CameraModel) -> CameraCommand {
        let Some(state) = self.predictor.update(input, camera) else { return CameraCommand::REST };
        let (view, now) = state.project(0.0, [0.0; 2]);
        let (_, soon) = state.project(RATE_INTERVAL_S, [0.0; 2]);
        let jacobian = view.jacobian(now);
        // Where the camera looks straight down, pan hardly moves the target: the gain is limited to ten times
        // the usual.
        let px_per_rad = [jacobian.pan[0], jacobian.tilt[1]];
        let min_px_per_rad = 0.1 * px_per_rad[1].abs();
        let px_per_rad = px_per_rad.map(|gain| -gain.abs().max(min_px_per_rad));
        let (now, soon) = ([now.x, now.y], [soon.x, soon.y]);
        let mut rates = [0.0; 2];
        for axis in [0, 1] {
            let axis_state = [
                -now[axis] / px_per_rad[axis],
                -(soon[axis] - now[axis]) / RATE_INTERVAL_S / px_per_rad[axis],
                state.rates[axis],
            ];
            let rate: f64 = self.gains[axis].iter().zip(axis_state).map(|(gain, value)| gain * value).sum();
            rates[axis] = rate.clamp(-self.max_rates[axis], self.max_rates[axis]);
        }
        let [pan, tilt] = rates.map(AngularRate::from_radians_per_second);
        CameraCommand::turning(pan, tilt)
    }

    fn reset_target(&mut self) {
        self.predictor.reset_target();
    }
}

/// The gains K of `u = K (e, v, w)` that minimise the cost.
fn gains(weight: f64, lag_s: f64) -> Gains {
    const STEP_S: f64 = 2e-3;
    const STEPS: usize = 30_000;
    let a = [[0.0, 1.0, -1.0], [0.0, -1.0 / RATE_MEMORY_S, 0.0], [0.0, 0.0, -1.0 / lag_s]];
    let b = 1.0 / lag_s;
    let mut cost = [[0.0_f64; 3]; 3];
    for _ in 0..STEPS {
        // P' = AᵀP + PA - PBBᵀP/weight + Q, backwards in time.
        let column: [f64; 3] = core::array::from_fn(|i| cost[i][2] * b);
        cost = core::array::from_fn(|i| {
            core::array::from_fn(|j| {
                let linear: f64 = (0..3).map(|k| a[k][i] * cost[k][j] + cost[i][k] * a[k][j]).sum();
                let state_cost = if (i, j) == (0, 0) { 1.0 } else { 0.0 };
                cost[i][j] + STEP_S * (linear + state_cost - column[i] * column[j] / weight)
            })
        });
    }
    core::array::from_fn(|j| -b * cost[2][j] / weight)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn without_lag_it_is_the_regulator_of_an_integrator() {
        for weight in [1.0_f64, 10.0] {
            let [on_offset, _, on_camera_rate] = gains(weight, 0.02);
            assert!((on_offset - 1.0 / weight.sqrt()).abs() < 0.05, "weight {weight}: {on_offset}");
            assert!(on_camera_rate.abs() < 0.05, "{on_camera_rate}");
        }
    }

    #[test]
    fn a_target_that_turns_is_followed() {
        let [_, on_target_rate, _] = gains(1.0, 0.42);
        assert!(on_target_rate > 0.3, "{on_target_rate}");
    }
}
