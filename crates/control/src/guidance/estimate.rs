//! The Kalman filter of the boat over the water plane: place, velocity, the apparent displacement of the
//! camera, and the velocity of the water.
//!
//! A camera in the air sways, and turns differently than its model says. Near the boat both look like a
//! displacement d of the camera, which moves all fixes alike. State (p, v, d, w, k), two coordinates each:
//!
//! ```text
//! fix = p - d + noise
//! v' = R(turn) v + gained + (1 - exp(-dt / T)) (w + u - v)     p' = p + dt (R(turn / 2) v + gained / 2)
//! d' = exp(-dt / FORGETTING_S) d                               w' = w        k' = k
//! Q of p and v = q² [dt³/3, dt²/2; dt²/2, dt] for each axis, of d: S dt, of w: WATER_NOISE² dt
//! ```
//!
//! u is the velocity through the water by the vessel's model, `gained` its change by thrust. A boat cannot
//! jump, and a boat at rest goes where the water goes. So jumps and sways of all that is seen are taken for
//! displacements. A steady displacement cannot be told from the water's motion, but its changes can. So k is
//! the displacement at an *anchor*, a time at which a mark was set or moved, and what is asked for is p - k
//! and d - k: later fixes tell, by the covariances, what the displacement was at the anchor, too (cloned
//! states: `roumeliotis2002`).

use barrelman_vocab::{WaterCovariance, WaterPoint};

/// Largest innovation, in standard deviations of its expected length.
const INNOVATION_GATE: f64 = 4.0;
/// Time constant with which a displacement is forgotten, seconds.
const FORGETTING_S: f64 = 20.0;
/// The same for what has been added to all places at anchors: the errors of many anchors must not add up.
const OFFSET_FORGETTING_S: f64 = 120.0;
/// Standard deviation of each component of the water's velocity, m/s, and the density of its changes, m/s per
/// root of a second.
const WATER_STD_DEV: f64 = 0.3;
const WATER_NOISE: f64 = 0.02;

/// Number of states.
const N: usize = 10;
/// First index of the velocity, of the displacement, of the water's velocity, and of the displacement at the
/// anchor.
const V: usize = 2;
const A: usize = 4;
const W: usize = 6;
const K: usize = 8;

type Matrix = [[f64; N]; N];

/// The estimate at the time of the last fix.
#[derive(Debug, Clone, Copy)]
pub(super) struct Estimate {
    pub(super) at_s: f64,
    state: [f64; N],
    covariance: Matrix,
    /// What has been added to all places so that they go on smoothly over new anchors.
    offset: (f64, f64),
}

/// A measured place, with the covariance of its noise.
#[derive(Debug, Clone, Copy)]
pub(super) struct Measured {
    pub(super) point: WaterPoint,
    pub(super) noise: [[f64; 2]; 2],
}

/// A velocity through the water by the vessel's model.
#[derive(Debug, Clone, Copy)]
pub(super) struct ThroughWater {
    /// Along x and y, m/s.
    pub(super) velocity: (f64, f64),
    /// Time constant with which the velocity returns to that of the water and this one, seconds.
    pub(super) return_s: f64,
}

/// What is known of the motion between two fixes.
#[derive(Debug, Clone, Copy)]
pub(super) struct Input {
    /// Angle by which the course turns, radians, positive to the right.
    pub(super) turn: f64,
    /// Change of the velocity along x and y by thrust, m/s.
    pub(super) gained: (f64, f64),
    /// Velocity through the water by the vessel's model; `None`: not known.
    pub(super) through_water: Option<ThroughWater>,
    /// Density of the white acceleration, m/s² per root hertz.
    pub(super) acceleration_noise: f64,
    /// Growth of the covariance of the camera's displacement, m²/s; `None`: the displacement stays as it is.
    pub(super) sway_per_s: Option<WaterCovariance>,
}

impl Estimate {
    /// A boat at rest, seen from a camera whose places are offset by this; `speed_std_dev`: of each
    /// component, m/s.
    pub(super) fn new(at_s: f64, measured: &Measured, offset: (f64, f64), speed_std_dev: f64) -> Self {
        let mut covariance = [[0.0; N]; N];
        for (row, noise) in covariance.iter_mut().zip(&measured.noise) {
            row[..2].copy_from_slice(noise);
        }
        covariance[V][V] = speed_std_dev * speed_std_dev;
        covariance[V + 1][V + 1] = speed_std_dev * speed_std_dev;
        covariance[W][W] = WATER_STD_DEV * WATER_STD_DEV;
        covariance[W + 1][W + 1] = WATER_STD_DEV * WATER_STD_DEV;
        let WaterPoint { x, y } = measured.point;
        let state = [x, y, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0];
        Self { at_s, state, covariance, offset }
    }

    pub(super) fn point(&self) -> WaterPoint {
        let (x, y) = self.since_anchor(0);
        WaterPoint { x, y }
    }

    /// Velocity along x and y, m/s.
    pub(super) const fn velocity(&self) -> (f64, f64) {
        (self.state[V], self.state[V + 1])
    }

    /// Sum of the variances of the velocity's components, (m/s)².
    pub(super) fn velocity_variance(&self) -> f64 {
        self.covariance[V][V] + self.covariance[V + 1][V + 1]
    }

    /// The camera's displacement along x and y, metres.
    pub(super) fn displacement(&self) -> (f64, f64) {
        self.since_anchor(A)
    }

    /// Two states from `first` on, less the displacement at the anchor.
    fn since_anchor(&self, first: usize) -> (f64, f64) {
        let (x, y) = self.offset;
        (x + self.state[first] - self.state[K], y + self.state[first + 1] - self.state[K + 1])
    }

    /// The same estimate with the anchor here and now: places that are measured now are kept best.
    pub(super) fn anchored(&self) -> Self {
        let mut next = Self { offset: self.displacement(), ..*self };
        for i in 0..2 {
            next.state[K + i] = next.state[A + i];
            next.covariance[K + i] = next.covariance[A + i];
        }
        for row in &mut next.covariance {
            (row[K], row[K + 1]) = (row[A], row[A + 1]);
        }
        next
    }

    /// The prediction step of the filter.
    pub(super) fn propagated(&self, at_s: f64, input: &Input) -> Self {
        let duration_s = at_s - self.at_s;
        let [x, y, vx, vy, a, b, wx, wy, anchor_x, anchor_y] = self.state;
        let half = turned((vx, vy), 0.5 * input.turn);
        let velocity = turned((vx, vy), input.turn);
        let (gx, gy) = input.gained;
        let ((ux, uy), returned) = input.through_water.map_or(((0.0, 0.0), 0.0), |through_water| {
            (through_water.velocity, 1.0 - libm::exp(-duration_s / through_water.return_s))
        });
        let (kept, offset_kept) = if input.sway_per_s.is_some() {
            (libm::exp(-duration_s / FORGETTING_S), libm::exp(-duration_s / OFFSET_FORGETTING_S))
        } else {
            (1.0, 1.0)
        };
        let state = [
            x + duration_s * (half.0 + 0.5 * gx),
            y + duration_s * (half.1 + 0.5 * gy),
            velocity.0 + gx + returned * (wx + ux - velocity.0),
            velocity.1 + gy + returned * (wy + uy - velocity.1),
            kept * a,
            kept * b,
            wx,
            wy,
            anchor_x,
            anchor_y,
        ];
        // The covariance ignores the turn, which is small between two fixes.
        let carried = |row: [f64; N]| {
            let mut next = row;
            for i in 0..2 {
                next[i] += duration_s * row[V + i];
                next[V + i] += returned * (row[W + i] - row[V + i]);
                next[A + i] *= kept;
            }
            next
        };
        let mut next = transposed(&transposed(&self.covariance.map(carried)).map(carried));
        let density = input.acceleration_noise * input.acceleration_noise;
        for i in 0..2 {
            let of_velocity = 0.5 * density * duration_s * duration_s;
            next[i][i] += density * duration_s * duration_s * duration_s / 3.0;
            next[i][V + i] += of_velocity;
            next[V + i][i] += of_velocity;
            next[V + i][V + i] += density * duration_s;
            next[W + i][W + i] += WATER_NOISE * WATER_NOISE * duration_s;
        }
        let WaterCovariance { xx, xy, yy } = input.sway_per_s.unwrap_or_default();
        for (i, row) in [[xx, xy], [xy, yy]].iter().enumerate() {
            for (j, value) in row.iter().enumerate() {
                next[A + i][A + j] += value * duration_s;
            }
        }
        let offset = (offset_kept * self.offset.0, offset_kept * self.offset.1);
        Self { at_s, state, covariance: next, offset }
    }

    /// The update step of the filter.
    pub(super) fn updated(&self, measured: &Measured) -> Self {
        let p = &self.covariance;
        // P H', whose rows are the states, and H P H' + R.
        let seen = p.map(|row| [row[0] - row[A], row[1] - row[A + 1]]);
        let s = [0, 1].map(|i| [0, 1].map(|j| seen[i][j] - seen[A + i][j] + measured.noise[i][j]));
        let scale = 1.0 / (s[0][0] * s[1][1] - s[0][1] * s[1][0]);
        let back = [[scale * s[1][1], -scale * s[0][1]], [-scale * s[1][0], scale * s[0][0]]];
        let expected = [self.state[0] - self.state[A], self.state[1] - self.state[A + 1]];
        let off = [measured.point.x - expected[0], measured.point.y - expected[1]];
        let squared = off[0] * (back[0][0] * off[0] + back[0][1] * off[1])
            + off[1] * (back[1][0] * off[0] + back[1][1] * off[1]);
        let share = if squared > INNOVATION_GATE * INNOVATION_GATE {
            INNOVATION_GATE / libm::sqrt(squared)
        } else {
            1.0
        };
        let gains = seen.map(|row| [0, 1].map(|j| row[0] * back[0][j] + row[1] * back[1][j]));
        let mut next = *self;
        for i in 0..N {
            next.state[i] += share * (gains[i][0] * off[0] + gains[i][1] * off[1]);
            // The same for both halves: rounding must not make the covariance asymmetric.
            for j in 0..=i {
                let value = p[i][j] - (gains[i][0] * seen[j][0] + gains[i][1] * seen[j][1]);
                next.covariance[i][j] = value;
                next.covariance[j][i] = value;
            }
        }
        next
    }
}

fn transposed(matrix: &Matrix) -> Matrix {
    core::array::from_fn(|i| core::array::from_fn(|j| matrix[j][i]))
}

/// A vector (x right, y ahead) turned to the right.
pub(super) fn turned((x, y): (f64, f64), angle: f64) -> (f64, f64) {
    let (sin, cos) = libm::sincos(angle);
    (x * cos + y * sin, y * cos - x * sin)
}

#[cfg(test)]
mod tests {
    use super::*;

    const FRAME_S: f64 = 1.0 / 30.0;
    const SWAY: Option<WaterCovariance> = Some(WaterCovariance { xx: 0.3, xy: 0.0, yy: 0.3 });

    /// A boat at rest in the water, whose fixes are at a place that moves with the time.
    fn at_rest(
        seconds: f64,
        sway_per_s: Option<WaterCovariance>,
        seen_at: impl Fn(f64) -> WaterPoint,
    ) -> Estimate {
        let noise = [[0.01, 0.004], [0.004, 0.03]];
        let measured = |at_s| Measured { point: seen_at(at_s), noise };
        let input = Input {
            turn: 0.0,
            gained: (0.0, 0.0),
            through_water: Some(ThroughWater { velocity: (0.0, 0.0), return_s: 0.36 }),
            acceleration_noise: 0.04,
            sway_per_s,
        };
        let mut estimate = Estimate::new(0.0, &measured(0.0), (0.0, 0.0), 0.7);
        for frame in 1..=(seconds / FRAME_S) as u64 {
            let at_s = frame as f64 * FRAME_S;
            estimate = estimate.propagated(at_s, &input).updated(&measured(at_s));
            if frame % 300 == 0 {
                let before = (estimate.point(), estimate.displacement());
                estimate = estimate.anchored();
                let moved_m = before.0.distance_to(estimate.point());
                let (x, y) = estimate.displacement();
                let turned_m = libm::hypot(x - before.1.0, y - before.1.1);
                assert!(moved_m < 1e-9 && turned_m < 1e-9, "an anchor moves nothing: {moved_m} {turned_m}");
            }
        }
        estimate
    }

    #[test]
    fn a_move_of_all_that_is_seen_is_a_displacement_of_the_camera() {
        let jump = |at_s: f64| WaterPoint { x: (at_s - 10.0).clamp(0.0, 1.0), y: 20.0 };
        let estimate = at_rest(11.0, SWAY, jump);
        let ((x, y), point) = (estimate.displacement(), estimate.point());
        // A move of all that is seen to the right by 1 m within 1 s is one of the camera to the left.
        assert!((-1.05..-0.8).contains(&x) && y.abs() < 0.1, "{x} {y}");
        assert!((point.x - 1.0 - x).abs() < 0.05 && point.x < 0.2, "{point:?}");
        let known = at_rest(20.0, None, jump);
        assert_eq!(known.displacement(), (0.0, 0.0), "a camera that does not sway is not displaced");
        assert!((known.point().x - 1.0).abs() < 0.2, "{:?}", known.point());
    }

    #[test]
    fn a_boat_at_rest_goes_where_the_water_goes() {
        let estimate = at_rest(60.0, SWAY, |at_s| WaterPoint { x: 0.3 * at_s, y: 20.0 });
        let (vx, vy) = estimate.velocity();
        assert!((vx - 0.3).abs() < 0.08 && vy.abs() < 0.05, "{vx} {vy}");
    }

    #[test]
    fn the_estimate_stays_bounded_and_its_covariance_symmetric_for_an_hour() {
        let sway = |at_s: f64| WaterPoint { x: libm::sin(at_s), y: 20.0 + 0.5 * libm::cos(0.7 * at_s) };
        let estimate = at_rest(3600.0, SWAY, sway);
        let (x, y) = estimate.displacement();
        assert!(libm::hypot(x, y) < 2.0, "the errors of 360 anchors do not add up: {x} {y}");
        let covariance = estimate.covariance;
        for (i, row) in covariance.iter().enumerate() {
            for (j, value) in row.iter().enumerate() {
                assert_eq!(*value, covariance[j][i], "{i} {j}");
            }
            assert!((0.0..100.0).contains(&row[i]), "{i}: {}", row[i]);
        }
    }
}
