//! Model predictive control with a soft ellipse, solved by a conic solver for each picture. A reference, not
//! part of the product.
//!
//! The problem covers [`STEPS`] steps of [`STEP_S`] and is linearised about the camera that coasts. It
//! minimises `Σ |u|² + penalty Σ slack²` over the rates u, so that the target lies within [`AIM`] plus the
//! slack of each step, and the rates within the limits. Only the first step's rates are commanded; the next
//! picture poses the problem anew.

use barrelman_control::{CameraModel, Law, LawInput};
use barrelman_vocab::{AngularRate, CameraCommand, VehicleProfile};
use clarabel::algebra::CscMatrix;
use clarabel::solver::{
    DefaultSettingsBuilder, DefaultSolver, IPSolver, NonnegativeConeT, SecondOrderConeT, SolverStatus,
};

use super::target_predictor::{MIN_LAG_S, PredictedState, TargetPredictor};

/// Steps of the prediction horizon.
const STEPS: usize = 12;
/// Duration of a step, seconds.
const STEP_S: f64 = 0.15;
/// The ellipse that the target is to stay in, in semi-axes of the region.
const AIM: f64 = 0.75;
/// Weight of the squared slack, in squared semi-axes, beside the squared rates in rad²/s².
const PENALTY: f64 = 10.0;
/// A rate below this is commanded as zero, rad/s.
const MIN_RATE: f64 = 0.01;

/// Variables: pan rates, tilt rates, slacks.
const VARIABLES: usize = 3 * STEPS;

/// The law of both axes.
#[derive(Debug, Clone)]
pub(super) struct Mpc {
    max_rates: [f64; 2],
    lags_s: [f64; 2],
    predictor: TargetPredictor,
}

/// The end of a step, predicted for the camera that coasts.
struct PredictedStep {
    /// The target's position in semi-axes of the region.
    position: [f64; 2],
    /// How the position changes with pan and with tilt, semi-axes per radian.
    jacobian: [[f64; 2]; 2],
}

/// A constraint: the coefficients of the variables, and the bound.
type Constraint = ([f64; VARIABLES], f64);

impl Mpc {
    pub(super) fn new(profile: &VehicleProfile) -> Self {
        let axes = [profile.camera.pan, profile.camera.tilt];
        Self {
            max_rates: [profile.limits.pan, profile.limits.tilt].map(AngularRate::radians_per_second),
            lags_s: axes.map(|axis| axis.lag.as_secs_f64().max(MIN_LAG_S)),
            predictor: TargetPredictor::new(),
        }
    }

    /// By how much an axis has turned at the end of a step per rate commanded in an earlier step, seconds.
    fn step_response(&self, axis: usize, end: usize, step: usize) -> f64 {
        let turned = |time_s: f64| time_s - self.lags_s[axis] * (1.0 - (-time_s / self.lags_s[axis]).exp());
        turned((end - step + 1) as f64 * STEP_S) - turned((end - step) as f64 * STEP_S)
    }

    /// The ends of all steps, for a region with the semi-axes a and b, pixels.
    fn predict(&self, state: &PredictedState, (a, b): (f64, f64)) -> Vec<PredictedStep> {
        (0..STEPS)
            .map(|end| {
                let after_s = (end + 1) as f64 * STEP_S;
                let coasting = [0, 1].map(|axis| {
                    state.rates[axis] * self.lags_s[axis] * (1.0 - (-after_s / self.lags_s[axis]).exp())
                });
                let (view, point) = state.project(after_s, coasting);
                let jacobian = view.jacobian(point);
                PredictedStep {
                    position: [point.x / a, point.y / b],
                    jacobian: [jacobian.pan, jacobian.tilt].map(|[x, y]| [x / a, y / b]),
                }
            })
            .collect()
    }

    /// First the limits of all rates, then for each step (AIM + slack, x, y) in the second-order cone.
    fn constraints(&self, steps: &[PredictedStep]) -> Vec<Constraint> {
        let mut constraints: Vec<Constraint> = Vec::with_capacity(8 * STEPS);
        for index in 0..2 * STEPS {
            let max_rate = self.max_rates[index / STEPS];
            for sign in [1.0, -1.0] {
                let mut row = [0.0; VARIABLES];
                row[index] = sign;
                constraints.push((row, max_rate));
            }
        }
        for (end, predicted) in steps.iter().enumerate() {
            let mut slack = [0.0; VARIABLES];
            slack[2 * STEPS + end] = -1.0;
            constraints.push((slack, AIM));
            for coordinate in [0, 1] {
                let mut row = [0.0; VARIABLES];
                for step in 0..=end {
                    for axis in [0, 1] {
                        row[axis * STEPS + step] =
                            -predicted.jacobian[axis][coordinate] * self.step_response(axis, end, step);
                    }
                }
                constraints.push((row, predicted.position[coordinate]));
            }
        }
        constraints
    }

    /// The rates of the first step, rad/s; zero where the target stays within the ellipse by itself.
    fn first_rates(&self, state: &PredictedState, semi_axes_px: (f64, f64)) -> [f64; 2] {
        let steps = self.predict(state, semi_axes_px);
        if steps.iter().all(|step| step.position[0].hypot(step.position[1]) <= AIM) {
            return [0.0; 2];
        }
        solve(&self.constraints(&steps)).unwrap_or([0.0; 2])
    }
}

/// Solves the problem. `None` where a number is not finite: the slack makes every other problem solvable.
fn solve(constraints: &[Constraint]) -> Option<[f64; 2]> {
    let matrix: Vec<Vec<f64>> = constraints.iter().map(|(row, _)| row.to_vec()).collect();
    let bounds: Vec<f64> = constraints.iter().map(|(_, bound)| *bound).collect();
    let weights: Vec<Vec<f64>> = (0..VARIABLES)
        .map(|row| {
            let weight = if row < 2 * STEPS { 2.0 } else { 2.0 * PENALTY };
            (0..VARIABLES).map(|column| if row == column { weight } else { 0.0 }).collect()
        })
        .collect();
    let mut cones = vec![NonnegativeConeT(4 * STEPS)];
    cones.extend((0..STEPS).map(|_| SecondOrderConeT(3)));
    let settings = DefaultSettingsBuilder::default().verbose(false).build().ok()?;
    let mut solver = DefaultSolver::new(
        &CscMatrix::from(&weights),
        &[0.0; VARIABLES],
        &CscMatrix::from(&matrix),
        &bounds,
        &cones,
        settings,
    )
    .ok()?;
    solver.solve();
    match solver.solution.status {
        SolverStatus::Solved | SolverStatus::AlmostSolved => {
            Some([solver.solution.x[0], solver.solution.x[STEPS]])
        }
        _ => None,
    }
}

impl Law for Mpc {
    fn command(&mut self, input: &LawInput<'_>, camera: &CameraModel) -> CameraCommand {
        let Some(state) = self.predictor.update(input, camera) else { return CameraCommand::REST };
        let rates = self.first_rates(&state, (input.region.a_px, input.region.b_px));
        let [pan, tilt] = rates
            .map(|rate| AngularRate::from_radians_per_second(if rate.abs() < MIN_RATE { 0.0 } else { rate }));
        CameraCommand::turning(pan, tilt)
    }

    fn reset_target(&mut self) {
        self.predictor.reset_target();
    }
}
