//! Model predictive control with a soft ellipse, solved by a conic solver at each picture. A reference, not part of the
//! product.
//!
//! Over [`STEPS`] steps of [`STEP_S`], linearised about the camera that coasts: the rates with the least
//! `Σ |u|² + penalty Σ slack²` for which the target lies within [`AIM`] plus the slack of each step, within the limits.
//! Only the first step's rates are asked for, and at the next picture all of it is asked anew.

use barrelman_control::{CameraModel, Law, LawInput};
use barrelman_vocab::{AngularRate, CameraCommand, VehicleProfile};
use clarabel::algebra::CscMatrix;
use clarabel::solver::{
    DefaultSettingsBuilder, DefaultSolver, IPSolver, NonnegativeConeT, SecondOrderConeT, SolverStatus,
};

use super::outlook::{Ahead, Outlook};

/// Steps that it looks ahead.
const STEPS: usize = 12;
/// How long each is, seconds.
const STEP_S: f64 = 0.15;
/// The ellipse that the target is to stay in, in semi-axes of the region.
const AIM: f64 = 0.75;
/// What a step outside costs, squared semi-axes, beside squared rates in rad²/s².
const PENALTY: f64 = 10.0;
/// What is slower than this is no movement, rad/s.
const LEAST_RATE: f64 = 0.01;

/// Variables: pan rates, tilt rates, slacks.
const VARIABLES: usize = 3 * STEPS;

/// The law with what it has seen.
#[derive(Debug, Clone)]
pub(super) struct Mpc {
    limits: [f64; 2],
    lags_s: [f64; 2],
    outlook: Outlook,
}

impl Mpc {
    pub(super) fn new(profile: &VehicleProfile) -> Self {
        let axes = [profile.camera.pan, profile.camera.tilt];
        Self {
            limits: [profile.limits.pan, profile.limits.tilt].map(AngularRate::radians_per_second),
            lags_s: axes.map(|axis| axis.lag.as_secs_f64().max(0.02)),
            outlook: Outlook::new(),
        }
    }

    /// By how much an axis has turned at the end of a step per rate asked for in an earlier one.
    fn reach(&self, axis: usize, end: usize, step: usize) -> f64 {
        let turned = |span_s: f64| span_s - self.lags_s[axis] * (1.0 - (-span_s / self.lags_s[axis]).exp());
        turned((end - step + 1) as f64 * STEP_S) - turned((end - step) as f64 * STEP_S)
    }

    fn solve(&self, ahead: &Ahead, (a, b): (f64, f64)) -> [f64; 2] {
        let steps: Vec<_> = (0..STEPS)
            .map(|end| {
                let after_s = (end + 1) as f64 * STEP_S;
                let coasting = [0, 1].map(|axis| {
                    ahead.rates[axis] * self.lags_s[axis] * (1.0 - (-after_s / self.lags_s[axis]).exp())
                });
                let (view, point) = ahead.seen(after_s, coasting);
                let moves = view.jacobian(point);
                ([point.x / a, point.y / b], [moves.pan, moves.tilt].map(|[x, y]| [x / a, y / b]))
            })
            .collect();
        if steps.iter().all(|(at, _)| at[0].hypot(at[1]) <= AIM) {
            return [0.0; 2];
        }
        let mut rows: Vec<([f64; VARIABLES], f64)> = Vec::with_capacity(8 * STEPS);
        for index in 0..2 * STEPS {
            let limit = self.limits[index / STEPS];
            for sign in [1.0, -1.0] {
                let mut row = [0.0; VARIABLES];
                row[index] = sign;
                rows.push((row, limit));
            }
        }
        for (end, (at, moves)) in steps.iter().enumerate() {
            // (AIM + slack, x, y) in the second-order cone.
            let mut slack = [0.0; VARIABLES];
            slack[2 * STEPS + end] = -1.0;
            rows.push((slack, AIM));
            for coordinate in [0, 1] {
                let mut row = [0.0; VARIABLES];
                for step in 0..=end {
                    for axis in [0, 1] {
                        row[axis * STEPS + step] = -moves[axis][coordinate] * self.reach(axis, end, step);
                    }
                }
                rows.push((row, at[coordinate]));
            }
        }
        let matrix: Vec<Vec<f64>> = rows.iter().map(|(row, _)| row.to_vec()).collect();
        let bounds: Vec<f64> = rows.iter().map(|(_, bound)| *bound).collect();
        let weights: Vec<Vec<f64>> = (0..VARIABLES)
            .map(|row| {
                let weight = if row < 2 * STEPS { 2.0 } else { 2.0 * PENALTY };
                (0..VARIABLES).map(|column| if row == column { weight } else { 0.0 }).collect()
            })
            .collect();
        let mut cones = vec![NonnegativeConeT(4 * STEPS)];
        cones.extend((0..STEPS).map(|_| SecondOrderConeT(3)));
        let settings = DefaultSettingsBuilder::default().verbose(false).build();
        let Ok(settings) = settings else { return [0.0; 2] };
        let solver = DefaultSolver::new(
            &CscMatrix::from(&weights),
            &[0.0; VARIABLES],
            &CscMatrix::from(&matrix),
            &bounds,
            &cones,
            settings,
        );
        let Ok(mut solver) = solver else { return [0.0; 2] };
        solver.solve();
        match solver.solution.status {
            SolverStatus::Solved | SolverStatus::AlmostSolved => {
                [solver.solution.x[0], solver.solution.x[STEPS]]
            }
            // The slack makes every problem solvable: what is left are numbers that are none.
            _ => [0.0; 2],
        }
    }
}

impl Law for Mpc {
    fn command(&mut self, input: &LawInput<'_>, camera: &CameraModel) -> CameraCommand {
        let Some(ahead) = self.outlook.look(input, camera) else { return CameraCommand::REST };
        let rates = self.solve(&ahead, (input.region.a_px, input.region.b_px));
        let [pan, tilt] = rates.map(|rate| {
            AngularRate::from_radians_per_second(if rate.abs() < LEAST_RATE { 0.0 } else { rate })
        });
        CameraCommand { pan, tilt }
    }

    fn reset_target(&mut self) {
        self.outlook.reset_target();
    }
}
