//! The rates with the least energy that move the target into the aim ellipse: a small problem with an exact
//! solution.
//!
//! ```text
//! minimise |u|²   subject to   |c + H u| <= aim   and   min_i <= u_i <= max_i
//! ```
//! u are the rates of both axes, c is the target's position without them, in semi-axes of the region, and H
//! is the displacement per unit of rate. There are three cases, each solved in closed form except for one
//! root:
//!
//! 1. No limit is active. With the Lagrange multiplier λ >= 0 of the ellipse, the remaining offset is
//!    `r(λ) = (I + λ H Hᵀ)^-1 c`, and `u = -λ Hᵀ r`. For two axes the inverse is written out:
//!    `r(λ) = (c + λ adj(H Hᵀ) c) / (1 + λ tr + λ² det)`, and `|r(λ)| = aim` is the secular equation of trust
//!    regions (Moré and Sorensen, 1983). Newton's method on 1/|r|, started at λ = 0, increases monotonically
//!    to the root and converges quadratically. All sums have non-negative terms, and there is no division by
//!    a gain: a gain close to zero (a camera that looks steeply down) makes its axis ineffective, and its
//!    rate does not become infinite.
//! 2. A limit is active. The solution lies on one of the sides of the rectangle of rates that case 1's
//!    solution exceeds: elsewhere, a step towards that solution would take less energy. On each such side,
//!    the ellipse leaves an interval of the other rate. The solution is the best of at most two candidates.
//! 3. No rates within the limits reach the ellipse. The solution is the closest approach to its centre.
//!
//! Work: at most 60 Newton steps, no allocation.

/// Both axes: pan, tilt.
pub type Pair = [f64; 2];

/// The problem.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Transfer {
    /// Position of the target with zero rates, in semi-axes.
    pub offset: Pair,
    /// Displacement (x, y) per 1 rad/s of pan, in semi-axes.
    pub pan: Pair,
    /// Displacement (x, y) per 1 rad/s of tilt, in semi-axes.
    pub tilt: Pair,
    /// Radius of the aim ellipse, in semi-axes, above 0.
    pub aim: f64,
    /// Smallest rates, rad/s, at most 0: the limits for turning left and down.
    pub min_rates: Pair,
    /// Largest rates, rad/s, at least 0: the limits for turning right and up.
    pub max_rates: Pair,
}

/// The solution.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TransferSolution {
    /// Rates of pan and tilt, rad/s.
    pub rates: Pair,
    /// Whether the rates move the target into the aim ellipse.
    pub reaches_aim: bool,
}

/// Largest number of Newton steps. About five are usual; more than twelve occur only if the gains differ by
/// many orders of magnitude.
const MAX_NEWTON_STEPS: usize = 60;
/// Relative error of the distance below which the next Newton step is the last one: its error is about the
/// square.
const LAST_STEP_TOLERANCE: f64 = 1e-7;
/// Relative tolerance for rounding errors.
const ROUNDING_TOLERANCE: f64 = 1e-12;

impl Transfer {
    /// Solves the problem. Invalid numbers (NaN, infinite, or limits that exclude zero) give zero rates.
    pub fn solve(&self) -> TransferSolution {
        // A valid range of rates contains zero.
        let contains_zero = (0..2).all(|axis| self.min_rates[axis] <= 0.0 && self.max_rates[axis] >= 0.0);
        // The sum is finite only if all values are finite.
        let [sum, other] = [0, 1]
            .map(|i| self.offset[i] + self.pan[i] + self.tilt[i] + self.min_rates[i] + self.max_rates[i]);
        let is_finite = (sum + other).is_finite();
        if !is_finite || !contains_zero || self.aim.is_nan() {
            return TransferSolution { rates: [0.0; 2], reaches_aim: false };
        }
        if square(self.offset) <= self.aim * self.aim {
            return TransferSolution { rates: [0.0; 2], reaches_aim: true };
        }
        match self.solve_unlimited() {
            Some(rates) if self.is_within_limits(rates) => TransferSolution { rates, reaches_aim: true },
            beyond => {
                beyond.and_then(|rates| self.solve_at_limit(rates)).unwrap_or_else(|| self.closest_approach())
            }
        }
    }

    /// The smallest distance from the centre on the way of a movement with these constant rates within the
    /// horizon.
    pub(crate) fn closest_passage(&self, rates: Pair) -> f64 {
        let way = [0, 1].map(|i| self.pan[i] * rates[0] + self.tilt[i] * rates[1]);
        let length_squared = square(way);
        let share = if length_squared > 0.0 {
            (-dot(self.offset, way) / length_squared).clamp(0.0, 1.0)
        } else {
            0.0
        };
        libm::sqrt(square([0, 1].map(|i| self.offset[i] + share * way[i])))
    }

    fn is_within_limits(&self, rates: Pair) -> bool {
        (0..2).all(|axis| (self.min_rates[axis]..=self.max_rates[axis]).contains(&rates[axis]))
    }

    fn offset_at(&self, rates: Pair) -> Pair {
        [0, 1].map(|i| self.offset[i] + self.pan[i] * rates[0] + self.tilt[i] * rates[1])
    }

    /// Case 1. `None` if no rates reach the ellipse.
    fn solve_unlimited(&self) -> Option<Pair> {
        let (pan, tilt, c) = (self.pan, self.tilt, self.offset);
        let trace = square(pan) + square(tilt);
        if trace <= 0.0 {
            return None;
        }
        // Determinant of H Hᵀ / trace, and its adjugate times c (`d`). `factor` is λ times the trace.
        let area = (pan[0] * tilt[1] - pan[1] * tilt[0]) / trace;
        let determinant = area * area;
        let beside = |axis: Pair| (axis[0] * c[1] - axis[1] * c[0]) / trace;
        let (pan_beside, tilt_beside) = (beside(pan), beside(tilt));
        let d = [-(pan_beside * pan[1] + tilt_beside * tilt[1]), pan_beside * pan[0] + tilt_beside * tilt[0]];
        let (cc, cd, dd) = (square(c), dot(c, d), square(d));
        if determinant == 0.0 && dd >= self.aim * self.aim {
            return None;
        }
        let pull = square([dot(pan, c), dot(tilt, c)]) / trace;
        let per_aim = 1.0 / self.aim;
        let (mut factor, mut shrink) = (0.0, 1.0);
        for _ in 0..MAX_NEWTON_STEPS {
            let distance_squared = cc + factor * (2.0 * cd + factor * dd);
            let slope = pull + factor * determinant * (3.0 * cc + factor * (3.0 * cd + factor * dd));
            let miss = per_aim * libm::sqrt(distance_squared) - shrink;
            let step = miss * (distance_squared / slope);
            if miss <= 0.0 || !step.is_finite() || factor + step == factor {
                break;
            }
            let is_last = miss <= LAST_STEP_TOLERANCE * shrink;
            factor += step;
            shrink = 1.0 + factor * (1.0 + factor * determinant);
            if is_last {
                break;
            }
        }
        let rest = [c[0] + factor * d[0], c[1] + factor * d[1]];
        let scale = -factor / (trace * shrink);
        let rates = [scale * dot(pan, rest), scale * dot(tilt, rest)];
        rates.iter().all(|rate| rate.is_finite()).then_some(rates)
    }

    /// Case 2: the best solution on the sides of the rectangle that `beyond` exceeds. `None` if no such side
    /// reaches the ellipse.
    fn solve_at_limit(&self, beyond: Pair) -> Option<TransferSolution> {
        let mut best: Option<(f64, Pair)> = None;
        for axis in [0, 1] {
            if (self.min_rates[axis]..=self.max_rates[axis]).contains(&beyond[axis]) {
                continue;
            }
            let rate = beyond[axis].clamp(self.min_rates[axis], self.max_rates[axis]);
            let (fixed, free) = if axis == 0 { (self.pan, self.tilt) } else { (self.tilt, self.pan) };
            let start = [0, 1].map(|i| self.offset[i] + rate * fixed[i]);
            let range = (self.min_rates[1 - axis], self.max_rates[1 - axis]);
            let Some(other) = min_rate_into_circle(start, free, self.aim, range) else { continue };
            let rates = if axis == 0 { [rate, other] } else { [other, rate] };
            let energy = square(rates);
            if best.is_none_or(|(best_energy, _)| energy < best_energy) {
                best = Some((energy, rates));
            }
        }
        best.map(|(_, rates)| TransferSolution { rates, reaches_aim: true })
    }

    /// Case 3: the rates within the limits that come closest to the centre; of equally good ones, those with
    /// the least energy.
    fn closest_approach(&self) -> TransferSolution {
        let (pan, tilt) = (self.pan, self.tilt);
        let (pp, tt, pt) = (square(pan), square(tilt), dot(pan, tilt));
        let (pc, tc) = (dot(pan, self.offset), dot(tilt, self.offset));
        let area = pan[0] * tilt[1] - pan[1] * tilt[0];
        let mut best: Option<(f64, f64, Pair)> = None;
        let mut offer = |rates: Pair| {
            if !self.is_within_limits(rates) {
                return;
            }
            let (distance, energy) = (square(self.offset_at(rates)), square(rates));
            let better = best.is_none_or(|(nearest, best_energy, _)| {
                let same = ROUNDING_TOLERANCE * (nearest + square(self.offset));
                distance < nearest - same || (distance <= nearest + same && energy < best_energy)
            });
            if better {
                best = Some((distance, energy, rates));
            }
        };
        offer([0.0; 2]);
        let determinant = area * area;
        if determinant > ROUNDING_TOLERANCE * pp * tt {
            offer([(pt * tc - tt * pc) / determinant, (pt * pc - pp * tc) / determinant]);
        } else if pp + tt > 0.0 {
            // Both axes move the target along the same line: the least rates that cancel the offset along it.
            let way = if pp >= tt { pan } else { tilt };
            let along = |axis: Pair| dot(axis, way) / libm::sqrt(square(way));
            let (p, t, c) = (along(pan), along(tilt), along(self.offset));
            offer([-c * p / (p * p + t * t), -c * t / (p * p + t * t)]);
        }
        let nearest = |start: f64, gain: f64, axis: usize| {
            if gain > 0.0 { (-start / gain).clamp(self.min_rates[axis], self.max_rates[axis]) } else { 0.0 }
        };
        for limits in [self.min_rates, self.max_rates] {
            let [p, t] = limits;
            offer([p, nearest(tc + p * pt, tt, 1)]);
            offer([nearest(pc + t * pt, pp, 0), t]);
        }
        TransferSolution { rates: best.map_or([0.0; 2], |(_, _, rates)| rates), reaches_aim: false }
    }
}

/// The rate closest to zero, within a range, that moves a point into the circle of radius `aim` around the
/// origin. `None` if there is no such rate.
fn min_rate_into_circle(start: Pair, gain: Pair, aim: f64, (min, max): (f64, f64)) -> Option<f64> {
    let outside = square(start) - aim * aim;
    if outside <= 0.0 {
        return Some(0.0);
    }
    let (a, b) = (square(gain), start[0] * gain[0] + start[1] * gain[1]);
    // The distance of the line from the origin, without the difference of two nearly equal numbers.
    let across = start[0] * gain[1] - start[1] * gain[0];
    let inside = a * aim * aim - across * across;
    if a <= 0.0 || inside < 0.0 {
        return None;
    }
    // The root closer to zero, computed from the other root and the product of both.
    let far = b.abs() + libm::sqrt(inside);
    let rate = -outside / far * if b < 0.0 { -1.0 } else { 1.0 };
    (min..=max).contains(&rate).then_some(rate)
}

fn dot(a: Pair, b: Pair) -> f64 {
    a[0] * b[0] + a[1] * b[1]
}

fn square(v: Pair) -> f64 {
    dot(v, v)
}
