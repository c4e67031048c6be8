//! The least energy that brings a point into the ellipse: a small problem with an exact solution.
//!
//! ```text
//! minimise |u|²   subject to   |c + H u| <= aim   and   least_i <= u_i <= most_i
//! ```
//! u are the rates of both axes, c is where the target will be without them, in semi-axes of the region, and H by how
//! much the rates move it there. Three cases, each solved in closed form but for one root:
//!
//! 1. The limits do not matter. With the Lagrange factor λ >= 0 of the ellipse the remaining offset is
//!    `r(λ) = (I + λ H Hᵀ)^-1 c` and `u = -λ Hᵀ r`. For two axes the inverse is written out:
//!    `r(λ) = (c + λ adj(H Hᵀ) c) / (1 + λ tr + λ² det)`, and `|r(λ)| = aim` is the secular equation of trust regions
//!    (Moré and Sorensen, 1983). Newton's method on 1/|r|, from λ = 0, rises monotonically to the root, twice as many
//!    digits with each step. Every sum in it is one of terms that are not negative, and nothing is divided by a gain: one
//!    that is nearly zero (a camera that looks steeply down) makes its axis worthless, not infinite.
//! 2. A limit holds: then the answer lies on one of those sides of the rectangle of rates beyond which case 1's answer
//!    lies (anywhere else a step towards that would take less energy), and on each the ellipse leaves an interval of the
//!    other rate. The least of at most two.
//! 3. Nothing within the limits reaches the ellipse: then what comes closest to its centre.
//!
//! No allocation.

/// Both axes: pan, tilt.
pub type Pair = [f64; 2];

/// What is asked.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Transfer {
    /// Where the point will be without any rate, in semi-axes.
    pub offset: Pair,
    /// By how many semi-axes (across, up) a rate of 1 rad/s of pan moves it.
    pub pan: Pair,
    /// The same of tilt.
    pub tilt: Pair,
    /// How near to the centre it is to come, in semi-axes, above 0.
    pub aim: f64,
    /// Least rates, rad/s, at most 0: how fast each axis may turn left, or down.
    pub min_rates: Pair,
    /// Largest rates, rad/s, at least 0: how fast each may turn right, or up.
    pub max_rates: Pair,
}

/// The answer.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TransferSolution {
    /// rad/s: pan, tilt.
    pub rates: Pair,
    /// Whether the point comes as near as was asked.
    pub reaches_aim: bool,
}

/// Newton steps at most; a handful is usual, and the gains must differ by many powers of ten for more than a dozen.
const MAX_NEWTON_STEPS: usize = 60;
/// Relative error of the distance from which on one more step is the last: it leaves about the square of that.
const LAST_STEP_TOLERANCE: f64 = 1e-7;
/// By how much the constraint may be missed for rounding's sake.
const ROUNDING_TOLERANCE: f64 = 1e-12;

impl Transfer {
    /// Solves it. Numbers that are none give rest.
    pub fn solve(&self) -> TransferSolution {
        // An empty range, or one without zero, is no range of rates.
        let ordered = (0..2).all(|axis| self.min_rates[axis] <= 0.0 && self.max_rates[axis] >= 0.0);
        // A sum with one that is not finite is not finite.
        let [sum, other] = [0, 1]
            .map(|i| self.offset[i] + self.pan[i] + self.tilt[i] + self.min_rates[i] + self.max_rates[i]);
        let usable = (sum + other).is_finite();
        if !usable || !ordered || self.aim.is_nan() {
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

    fn is_within_limits(&self, rates: Pair) -> bool {
        (0..2).all(|axis| (self.min_rates[axis]..=self.max_rates[axis]).contains(&rates[axis]))
    }

    fn offset_with(&self, rates: Pair) -> Pair {
        [0, 1].map(|i| self.offset[i] + self.pan[i] * rates[0] + self.tilt[i] * rates[1])
    }

    /// Case 1; `None` where no rates reach the ellipse.
    fn solve_unlimited(&self) -> Option<Pair> {
        let (pan, tilt, c) = (self.pan, self.tilt, self.offset);
        let trace = square(pan) + square(tilt);
        if trace <= 0.0 {
            return None;
        }
        // Of H Hᵀ / trace: the determinant, and the adjugate times c. The factor is λ times the trace.
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

    /// Case 2: the least on those sides of the rectangle that `beyond` lies beyond, if any reaches the ellipse.
    fn solve_at_limit(&self, beyond: Pair) -> Option<TransferSolution> {
        let mut best: Option<(f64, Pair)> = None;
        for held in [0, 1] {
            if (self.min_rates[held]..=self.max_rates[held]).contains(&beyond[held]) {
                continue;
            }
            let rate = beyond[held].clamp(self.min_rates[held], self.max_rates[held]);
            let (fixed, free) = if held == 0 { (self.pan, self.tilt) } else { (self.tilt, self.pan) };
            let start = [0, 1].map(|i| self.offset[i] + rate * fixed[i]);
            let range = (self.min_rates[1 - held], self.max_rates[1 - held]);
            let Some(other) = min_rate_into_circle(start, free, self.aim, range) else { continue };
            let rates = if held == 0 { [rate, other] } else { [other, rate] };
            let energy = square(rates);
            if best.is_none_or(|(least, _)| energy < least) {
                best = Some((energy, rates));
            }
        }
        best.map(|(_, rates)| TransferSolution { rates, reaches_aim: true })
    }

    /// Case 3: the rates within the limits that come closest; of several, the least.
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
            let (distance, energy) = (square(self.offset_with(rates)), square(rates));
            let better = best.is_none_or(|(nearest, least, _)| {
                let same = ROUNDING_TOLERANCE * (nearest + square(self.offset));
                distance < nearest - same || (distance <= nearest + same && energy < least)
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
            // Both axes push the same way: the shortest rates that cancel what lies along it.
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

/// The rate nearest to zero within a range that brings a point into the circle of the radius `aim` around the origin.
fn min_rate_into_circle(start: Pair, gain: Pair, aim: f64, (least, most): (f64, f64)) -> Option<f64> {
    let outside = square(start) - aim * aim;
    if outside <= 0.0 {
        return Some(0.0);
    }
    let (a, b) = (square(gain), start[0] * gain[0] + start[1] * gain[1]);
    // The miss distance of the line, without the difference of two like numbers.
    let across = start[0] * gain[1] - start[1] * gain[0];
    let inside = a * aim * aim - across * across;
    if a <= 0.0 || inside < 0.0 {
        return None;
    }
    // The root nearer to zero, as what the far root leaves of their product.
    let far = b.abs() + libm::sqrt(inside);
    let rate = -outside / far * if b < 0.0 { -1.0 } else { 1.0 };
    (least..=most).contains(&rate).then_some(rate)
}

fn dot(a: Pair, b: Pair) -> f64 {
    a[0] * b[0] + a[1] * b[1]
}

fn square(v: Pair) -> f64 {
    dot(v, v)
}
