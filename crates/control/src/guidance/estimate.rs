//! The Kalman filter of the boat over the water plane: place, velocity, the apparent displacement of the camera, and the velocity
//! of the water.
//!
//! A camera in the air sways, and turns differently than its model says. Near the boat both look like a displacement d of the
//! camera, which moves all fixes alike. State (p, v, d, w), two coordinates each:
//!
//! ```text
//! fix = p - d + noise
//! v' = R(turn) v + gained + (1 - exp(-dt / T)) (w + u - v)     p' = p + dt (R(turn / 2) v + gained / 2)
//! d' = exp(-dt / FORGETTING_S) d                               w' = w
//! Q of p and v = q² [dt³/3, dt²/2; dt²/2, dt] for each axis, of d: S dt, of w: WATER_NOISE² dt
//! ```
//!
//! u is the velocity through the water by the vessel's model, `gained` its change by thrust. A boat cannot jump, and a boat at rest
//! goes where the water goes. So jumps and sways of all that is seen are taken for displacements. A steady displacement cannot be
//! told from the boat's motion; only its changes matter to marks that are corrected by the same displacement.

use barrelman_vocab::{WaterCovariance, WaterPoint};

/// Largest innovation, in standard deviations of its expected length.
const INNOVATION_GATE: f64 = 4.0;
/// Time constant with which a displacement is forgotten, seconds.
const FORGETTING_S: f64 = 20.0;
/// Standard deviation of each component of the water's velocity, m/s, and the density of its changes, m/s per root of a second.
const WATER_STD_DEV: f64 = 0.3;
const WATER_NOISE: f64 = 0.02;

/// Number of states.
const N: usize = 8;
/// First index of the velocity, of the displacement, and of the water's velocity.
const V: usize = 2;
const A: usize = 4;
const W: usize = 6;

type Matrix = [[f64; N]; N];

/// The estimate at the time of the last fix.
#[derive(Debug, Clone, Copy)]
pub(super) struct Estimate {
    pub(super) at_s: f64,
    state: [f64; N],
    covariance: Matrix,
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
    /// Growth of the covariance of the camera's displacement, m²/s.
    pub(super) sway_per_s: WaterCovariance,
}

impl Estimate {
    /// A boat at rest, seen from a camera with this displacement; `speed_std_dev`: of each component, m/s.
    pub(super) fn new(at_s: f64, measured: &Measured, (a, b): (f64, f64), speed_std_dev: f64) -> Self {
        let mut covariance = [[0.0; N]; N];
        for (row, noise) in covariance.iter_mut().zip(&measured.noise) {
            row[..2].copy_from_slice(noise);
        }
        covariance[V][V] = speed_std_dev * speed_std_dev;
        covariance[V + 1][V + 1] = speed_std_dev * speed_std_dev;
        covariance[W][W] = WATER_STD_DEV * WATER_STD_DEV;
        covariance[W + 1][W + 1] = WATER_STD_DEV * WATER_STD_DEV;
        let WaterPoint { x, y } = measured.point;
        Self { at_s, state: [x + a, y + b, 0.0, 0.0, a, b, 0.0, 0.0], covariance }
    }

    pub(super) const fn point(&self) -> WaterPoint {
        WaterPoint { x: self.state[0], y: self.state[1] }
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
    pub(super) const fn displacement(&self) -> (f64, f64) {
        (self.state[A], self.state[A + 1])
    }

    /// The prediction step of the filter.
    pub(super) fn propagated(&self, at_s: f64, input: &Input) -> Self {
        let duration_s = at_s - self.at_s;
        let [x, y, vx, vy, a, b, wx, wy] = self.state;
        let half = turned((vx, vy), 0.5 * input.turn);
        let velocity = turned((vx, vy), input.turn);
        let (gx, gy) = input.gained;
        let ((ux, uy), returned) = input.through_water.map_or(((0.0, 0.0), 0.0), |through_water| {
            (through_water.velocity, 1.0 - libm::exp(-duration_s / through_water.return_s))
        });
        let kept = libm::exp(-duration_s / FORGETTING_S);
        let state = [
            x + duration_s * (half.0 + 0.5 * gx),
            y + duration_s * (half.1 + 0.5 * gy),
            velocity.0 + gx + returned * (wx + ux - velocity.0),
            velocity.1 + gy + returned * (wy + uy - velocity.1),
            kept * a,
            kept * b,
            wx,
            wy,
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
        let WaterCovariance { xx, xy, yy } = input.sway_per_s;
        for (i, row) in [[xx, xy], [xy, yy]].iter().enumerate() {
            for (j, value) in row.iter().enumerate() {
                next[A + i][A + j] += value * duration_s;
            }
        }
        Self { at_s, state, covariance: next }
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
