//! Foam behind a boat: a turbulent trail and the two arms of its bow wave.
//!
//! Where the stern was at an age a, foam lies that widens and fades with a. The arms have moved apart since,
//! at a fixed share of the boat's speed (the waves of a ship lie within 19.5 degrees of its course, whatever
//! its speed).

use super::canvas::{Field, MARGIN};
use super::outline::Outline;
use super::script::FRAMES_PER_SECOND;
use super::trajectory::{LEAD_FRAMES, Trajectory};
use super::view::{PlanePoint, View};

/// Frames from one patch of foam to the next.
const PATCH_SPACING: usize = 2;
/// Speed of the arms over the boat's: the tangent of 17 degrees.
const ARM_SPREAD_RATIO: f64 = 0.3;
/// Time constants of the trail and of the arms, s.
const TRAIL_FADES_S: f64 = 1.7;
const ARMS_FADE_S: f64 = 0.9;

/// Density of foam on the canvas's chroma grid, 0 to 1.
#[derive(Debug, Clone)]
pub(super) struct Wake {
    width: usize,
    height: usize,
    density: Vec<f32>,
    has_foam: Vec<bool>,
}

impl Wake {
    pub(super) fn new(grid: &Field) -> Self {
        let (width, height) = (grid.width, grid.height);
        Self { width, height, density: vec![0.0; width * height], has_foam: vec![false; height] }
    }

    /// A row of the density, if there is foam in it.
    pub(super) fn row(&self, row: usize) -> Option<&[f32]> {
        self.has_foam[row].then(|| &self.density[row * self.width..][..self.width])
    }

    /// Computes the wake of a frame.
    pub(super) fn update(&mut self, trajectory: &Trajectory, frame: i64, outline: &Outline, strength: f64) {
        for row in 0..self.height {
            if self.has_foam[row] {
                self.density[row * self.width..][..self.width].fill(0.0);
                self.has_foam[row] = false;
            }
        }
        let view = trajectory.pose(frame).view;
        let (half_length, half_beam) = (outline.half_length, outline.half_beam);
        for frames_ago in (0..LEAD_FRAMES).step_by(PATCH_SPACING) {
            let then = trajectory.pose(frame - frames_ago as i64);
            let age_s = frames_ago as f64 / f64::from(FRAMES_PER_SECOND);
            let strength_then = strength * then.speed / (then.speed + 0.8);
            let (s, c) = (libm::sin(then.heading), libm::cos(then.heading));
            let mut add_patch = |along: f64, across: f64, radius: f64, density: f64| {
                let at = then.boat.offset(along * c - across * s, along * s + across * c);
                self.add_foam(at, radius, density, &view);
            };
            let trail = strength_then * libm::exp(-age_s / TRAIL_FADES_S);
            add_patch(-half_length, 0.0, half_beam * (0.7 + 0.5 * age_s), 0.75 * trail);
            let arms = strength_then * libm::exp(-age_s / ARMS_FADE_S);
            let apart = 0.9 * half_beam + ARM_SPREAD_RATIO * then.speed * 2.0 * half_length * age_s;
            for side in [-1.0, 1.0] {
                add_patch(0.55 * half_length, side * apart, half_beam * (0.35 + 0.3 * age_s), 0.55 * arms);
            }
        }
    }

    fn add_foam(&mut self, at: PlanePoint, radius: f64, density: f64, view: &View) {
        if density < 0.02 {
            return;
        }
        let middle = view.picture(at);
        // In samples of the grid, which are two px wide.
        let (reach_u, reach_v) = (radius * view.zoom / 2.0, radius * view.zoom * view.foreshortening / 2.0);
        let (u, v) = ((middle.u + MARGIN as f64) / 2.0 - 0.5, (middle.v + MARGIN as f64) / 2.0 - 0.5);
        let span = |middle: f64, reach: f64, end: usize| {
            let begin = (middle - reach).ceil().clamp(0.0, end as f64) as usize;
            begin..((middle + reach).floor() + 1.0).clamp(begin as f64, end as f64) as usize
        };
        let columns = span(u, reach_u, self.width);
        if columns.is_empty() {
            return;
        }
        for row in span(v, reach_v, self.height) {
            self.has_foam[row] = true;
            let dv = (row as f64 - v) / reach_v;
            let line = &mut self.density[row * self.width..][..self.width];
            for column in columns.clone() {
                let du = (column as f64 - u) / reach_u;
                let share = (1.0 - du * du - dv * dv).max(0.0);
                let patch = (density * share * share) as f32;
                // Foam over foam never covers more than all of the water.
                line[column] += patch * (1.0 - line[column]);
            }
        }
    }
}
