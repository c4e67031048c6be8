//! Land on one side of the boat's way, with a ragged edge and a line of surf.

use barrelman_vocab::rng::SplitMix64;

use super::canvas::{Canvas, MARGIN};
use super::choices::Choices;
use super::colour::{self, Yuv};
use super::placement::PlacementContext;
use super::view::{PlanePoint, View};
use super::water::Water;
use super::waves::{Layer, SIDE};

/// Directions tried.
const TRIES: usize = 12;
/// Distance of the shore from the boat's way, hull lengths.
const CLEAR_HULLS: f64 = 1.4;
/// Share of the clip in which the shore must be in view to be placed.
const MIN_PLACING_SHARE: f64 = 0.03;
/// Deviation of the edge from its line: standard deviation and largest value, px of the plane.
const EDGE_STD_DEV: f64 = 9.0;
pub(super) const MAX_EDGE_OFFSET: f64 = 32.0;
/// Width of the surf, px of the plane.
const SURF: f32 = 7.0;
const SURF_COLOUR: Yuv = [196.0, 128.0, 127.0];

/// Earth without a hue near red or orange: grass, rock, dark wood.
const LANDS: [[f64; 3]; 4] =
    [[82.0, 98.0, 62.0], [112.0, 114.0, 104.0], [50.0, 66.0, 46.0], [128.0, 130.0, 112.0]];

#[derive(Debug, Clone)]
pub(super) struct Shore {
    /// Unit vector of the plane that points inland.
    inland: (f64, f64),
    /// Distance of the shore's line from the plane's origin.
    line: f64,
    land: Yuv,
    edge: Layer,
    grain: Layer,
    patch: Layer,
}

impl Shore {
    /// A shore, in some of the clips.
    pub(super) fn new(context: &PlacementContext<'_>, mut rng: SplitMix64) -> Option<Self> {
        if rng.chance(0.6) {
            return None;
        }
        let hull = 2.0 * context.outline.half_length;
        let mut best: Option<(f64, (f64, f64), f64)> = None;
        for _ in 0..TRIES {
            let direction = rng.between(0.0, core::f64::consts::TAU);
            let inland = (libm::cos(direction), libm::sin(direction));
            let ahead = |at: PlanePoint| at.x * inland.0 + at.y * inland.1;
            let poses = || (0..context.frames as i64).map(|frame| context.trajectory.pose(frame));
            let line = poses().map(|pose| ahead(pose.boat)).fold(f64::NEG_INFINITY, f64::max)
                + CLEAR_HULLS * hull
                + MAX_EDGE_OFFSET * context.relative;
            // The middle of the picture is never on land; corners are, as often as possible.
            if poses().any(|pose| ahead(pose.view.camera) > line) {
                continue;
            }
            let corner = |view: &View| {
                let half =
                    view.plane_offset(f64::from(view.size.width) / 2.0, f64::from(view.size.height) / 2.0);
                ahead(view.camera) + (half.0 * inland.0).abs() + (half.1 * inland.1).abs()
            };
            let seen = poses().filter(|pose| corner(&pose.view) > line).count();
            let share = seen as f64 / context.frames as f64;
            if share > best.map_or(MIN_PLACING_SHARE, |best| best.0) {
                best = Some((share, inland, line));
            }
        }
        let (_, inland, line) = best?;
        let brightness = rng.between(0.85, 1.15);
        let land = colour::yuv(rng.choose(&LANDS).map(|sample| sample * brightness));
        let mut layer = |scale: f64| Layer {
            scale: scale * context.relative,
            drift: (0.0, 0.0),
            offset: (rng.between(0.0, SIDE as f64), rng.between(0.0, SIDE as f64)),
        };
        Some(Self { inland, line, land, edge: layer(0.55), grain: layer(0.6), patch: layer(0.9) })
    }

    /// Distance from the shore's line, inland positive, in the plane's unit.
    pub(super) fn inland(&self, at: PlanePoint) -> f64 {
        at.x * self.inland.0 + at.y * self.inland.1 - self.line
    }

    pub(super) fn render(&self, canvas: &mut Canvas, view: &View, water: &Water, relative: f64) {
        let first = 0.5 - MARGIN as f64;
        let edge = self.edge.view_from(&water.gusts, view, 0.0, (first, first));
        let grain = self.grain.view_from(&water.ripple, view, 0.0, (first, first));
        let patch = self.patch.view_from(&water.gusts, view, 0.0, (first, first));
        let width = canvas.y.width;
        let mut scratch = [0.0; SIDE + 1];
        let mut edges = vec![0.0; width];
        let mut grains = vec![0.0; width];
        let mut patches = vec![0.0; width];
        let across = view.plane_offset(1.0, 0.0).0 * self.inland.0;
        let edge_std_dev = (EDGE_STD_DEV * relative) as f32;
        let max_edge_offset = MAX_EDGE_OFFSET * relative;
        let surf = SURF * relative as f32;
        // Farther out there is neither land nor surf.
        let nearest = -(max_edge_offset as f32) - 2.0 * surf;
        for row in 0..canvas.y.height {
            let left = self.inland(view.plane(first, first + row as f64));
            let right = left + across * width as f64;
            if left.max(right) < f64::from(nearest) {
                continue;
            }
            edge.row(row, &mut scratch, &mut edges);
            grain.row(row, &mut scratch, &mut grains);
            patch.row(row, &mut scratch, &mut patches);
            for column in 0..width {
                let straight = (left + across * column as f64) as f32;
                if straight < nearest {
                    continue;
                }
                let inland = straight
                    + (edge_std_dev * edges[column]).clamp(-max_edge_offset as f32, max_edge_offset as f32);
                let land = (inland * 0.7 + 0.5).clamp(0.0, 1.0);
                let foam = (1.0 - (inland + surf).abs() / surf).max(0.0)
                    * (0.6 + 0.3 * grains[column]).clamp(0.0, 1.0);
                // Bushes: patches with a rather sharp edge.
                let bush = (2.5 * patches[column] + 0.4 * grains[column] - 0.5).clamp(0.0, 1.0);
                let level = self.land[0] * (1.0 + 0.1 * grains[column] - 0.35 * bush);
                let sample = &mut canvas.y.samples[row * width + column];
                *sample += (SURF_COLOUR[0] - *sample) * foam;
                *sample += (level - *sample) * land;
                // Each chroma sample is blended with the opacity at its top left pixel.
                if row % 2 == 0 && column % 2 == 0 {
                    let at = row / 2 * canvas.u.width + column / 2;
                    for (plane, part) in [(&mut canvas.u, 1), (&mut canvas.v, 2)] {
                        let sample = &mut plane.samples[at];
                        *sample += (SURF_COLOUR[part] - *sample) * foam;
                        *sample += (self.land[part] - *sample) * land;
                    }
                }
            }
        }
    }
}
