//! A linear-quadratic regulator on the picture's centre, with the predicted state: what the mathematics of centring can
//! do at its best. A reference, not part of the product.
//!
//! Each axis has the state (e, v, w): how far the target is off, rad of that axis, how fast its bearing turns, and
//! how fast the camera does. `e' = v - w`, `v' = -v / memory`, `w' = (u - w) / lag`. The gains minimise
//! `∫ (e² + weight u²) dt`; they come from the Riccati equation, integrated until it rests.

use barrelman_control::{CameraModel, Law, LawInput};
use barrelman_vocab::{AngularRate, CameraCommand, VehicleProfile};

use super::outlook::{Ahead, Outlook};

/// Gains on e, v and w.
type Gains = [f64; 3];

/// The law with what it has seen.
#[derive(Debug, Clone)]
pub(super) struct Lqg {
    gains: [Gains; 2],
    limits: [f64; 2],
    outlook: Outlook,
}

impl Lqg {
    pub(super) fn new(weight: f64, profile: &VehicleProfile) -> Self {
        let axes = [profile.camera.pan, profile.camera.tilt];
        Self {
            gains: axes.map(|axis| gains(weight, axis.lag.as_secs_f64().max(0.02))),
            limits: [profile.limits.pan, profile.limits.tilt].map(AngularRate::radians_per_second),
            outlook: Outlook::new(),
        }
    }
}

impl Law for Lqg {
    fn command(&mut self, input: &LawInput<'_>, camera: &CameraModel) -> CameraCommand {
        const SHORTLY_S: f64 = 0.02;
        let Some(ahead) = self.outlook.look(input, camera) else { return CameraCommand::REST };
        let (view, point) = ahead.seen(0.0, [0.0; 2]);
        let (_, shortly) = ahead.seen(SHORTLY_S, [0.0; 2]);
        let jacobian = view.jacobian(point);
        // A camera that looks straight down cannot pan a point in its middle: no gain beyond a tenth of the usual.
        let per_rad = [jacobian.pan[0], jacobian.tilt[1]];
        let least = 0.1 * per_rad[1].abs();
        let per_rad = per_rad.map(|gain| -gain.abs().max(least));
        let (at, then) = ([point.x, point.y], [shortly.x, shortly.y]);
        let mut rates = [0.0; 2];
        for axis in [0, 1] {
            let state = [
                -at[axis] / per_rad[axis],
                -(then[axis] - at[axis]) / SHORTLY_S / per_rad[axis],
                ahead.rates[axis],
            ];
            let wanted: f64 = self.gains[axis].iter().zip(state).map(|(gain, value)| gain * value).sum();
            rates[axis] = wanted.clamp(-self.limits[axis], self.limits[axis]);
        }
        let [pan, tilt] = rates.map(AngularRate::from_radians_per_second);
        CameraCommand { pan, tilt }
    }

    fn reset_target(&mut self) {
        self.outlook.reset_target();
    }
}

/// `u = K (e, v, w)` that minimises the cost.
fn gains(weight: f64, lag_s: f64) -> Gains {
    const STEP_S: f64 = 2e-3;
    const STEPS: usize = 30_000;
    let a = [[0.0, 1.0, -1.0], [0.0, -1.0 / Ahead::MEMORY_S, 0.0], [0.0, 0.0, -1.0 / lag_s]];
    let b = 1.0 / lag_s;
    let mut cost = [[0.0_f64; 3]; 3];
    for _ in 0..STEPS {
        // P' = AᵀP + PA - PBBᵀP/weight + Q, backwards in time.
        let column: [f64; 3] = core::array::from_fn(|i| cost[i][2] * b);
        cost = core::array::from_fn(|i| {
            core::array::from_fn(|j| {
                let along: f64 = (0..3).map(|k| a[k][i] * cost[k][j] + cost[i][k] * a[k][j]).sum();
                let off = if (i, j) == (0, 0) { 1.0 } else { 0.0 };
                cost[i][j] + STEP_S * (along + off - column[i] * column[j] / weight)
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
            let [off, _, turning] = gains(weight, 0.02);
            assert!((off - 1.0 / weight.sqrt()).abs() < 0.05, "weight {weight}: {off}");
            assert!(turning.abs() < 0.05, "{turning}");
        }
    }

    #[test]
    fn a_target_that_turns_is_followed() {
        let [_, turns, _] = gains(1.0, 0.42);
        assert!(turns > 0.3, "{turns}");
    }
}
