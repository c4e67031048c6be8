//! Fits the model of one axis, dead times and a first-order lag, to a measured turn.
//!
//! For given dead times and lag, the response of the model to the commands is linear in its gain and in a
//! steady drift; both follow by least squares. Dead times and lag are searched for: a coarse grid, then ever
//! smaller steps along each of them. Turns over [`SPAN_S`] are compared instead of angles: what sways slowly
//! does not count. The repetitions of the test motions tell the standard errors; where those are too large,
//! the axis cannot be told.

use core::fmt;

use super::bars::Bars;

/// Turns over this time are compared, seconds.
const SPAN_S: f64 = 0.4;
/// Largest dead time and lag that are searched, seconds.
const MAX_DEAD_TIME_S: f64 = 1.2;
const MAX_LAG_S: f64 = 1.2;
/// Lags of the coarse grid, seconds.
const LAGS_S: [f64; 8] = [0.02, 0.05, 0.1, 0.2, 0.3, 0.45, 0.6, 0.9];
/// Least share of the variance that the motion must explain.
const MIN_EXPLAINED: f64 = 0.5;
/// Largest standard errors: of the gain, as a share of the gain, and of the dead times, seconds. What is told
/// is meant to be right within 5 % and 60 ms; five repetitions have four degrees of freedom, so that the
/// error exceeds 2.8 standard errors in one case of twenty, and four of them in one of sixty.
const MAX_ERRORS: Errors = Errors { gain: 0.0125, dead_time_s: 0.015 };
/// The same of the rate at a speed, which is one of several points.
const MAX_ERRORS_OF_RATE: Errors = Errors { gain: 0.08, dead_time_s: MAX_DEAD_TIME_S };
/// Least gain of an axis that turns.
const MIN_GAIN: f64 = 0.1;

/// Standard errors.
#[derive(Debug, Clone, Copy)]
struct Errors {
    gain: f64,
    dead_time_s: f64,
}

/// A measured angle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AngleSample {
    /// Time of capture, seconds.
    pub at_s: f64,
    /// Angle, radians; up to two components of one motion.
    pub angle: [f64; 2],
    /// Samples of different numbers are not compared: the motion between them is not known.
    pub epoch: u32,
}

/// A command of the axis: in force from a time on.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RateStep {
    /// Time, seconds.
    pub at_s: f64,
    /// Rate, rad/s.
    pub rate: f64,
}

/// The response of an axis.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AxisFit {
    /// Achieved rate divided by the commanded one, of both components of the angle.
    pub gains: [f64; 2],
    /// From a command that moves to the start of its effect, seconds.
    pub start_dead_time_s: f64,
    /// From a command that rests to the start of its effect, seconds.
    pub stop_dead_time_s: f64,
    /// Time constant, seconds.
    pub lag_s: f64,
    /// Share of the variance of the turns that the fit explains.
    pub explained: f64,
}

impl AxisFit {
    /// The size of the gain of both components together.
    pub fn gain(&self) -> f64 {
        libm::hypot(self.gains[0], self.gains[1])
    }
}

/// Why an axis cannot be told.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum CannotTell {
    /// The axis was not commanded, or the picture's motion was not measured.
    NotMeasured,
    /// The picture has black bars: gains would come out too small.
    Bars(Bars),
    /// The picture's motion does not follow the commands.
    NotFollowing {
        /// Share of the variance that the commands explain.
        explained: f64,
    },
    /// The repetitions differ.
    Unsteady {
        /// Standard error of the gain, as a share of the gain.
        gain_error: f64,
        /// Largest standard error of a dead time, seconds.
        dead_time_error_s: f64,
    },
}

impl fmt::Display for CannotTell {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NotMeasured => f.write_str(
                "the picture's motion could not be measured: point the camera at something with structure, not at even water",
            ),
            Self::Bars(bars) => write!(
                f,
                "the picture has black bars ({bars}): let the camera or the encoder send the picture without them"
            ),
            Self::NotFollowing { explained } => write!(
                f,
                "the picture does not follow the commands (they explain {:.0} % of its motion): check that the link moves this camera, and wait for less wind",
                100.0 * explained
            ),
            Self::Unsteady { gain_error, dead_time_error_s } => write!(
                f,
                "the repetitions differ: standard errors of {:.1} % in the gain and {:.0} ms in the dead times; wait for less wind, or point at something that does not move",
                100.0 * gain_error,
                1e3 * dead_time_error_s
            ),
        }
    }
}

/// Fits an axis to its samples; `repetitions` are the times of the repetitions, which are compared.
///
/// # Errors
/// Why the axis cannot be told.
pub fn fit_axis(
    samples: &[AngleSample],
    commands: &[RateStep],
    repetitions: &[(f64, f64)],
) -> Result<AxisFit, CannotTell> {
    fit_within(samples, commands, repetitions, MAX_ERRORS)
}

/// Fits an axis to the samples of short motions: its rate is told, dead times and lag only roughly.
///
/// # Errors
/// Why the rate cannot be told.
pub fn fit_rate(
    samples: &[AngleSample],
    commands: &[RateStep],
    repetitions: &[(f64, f64)],
) -> Result<AxisFit, CannotTell> {
    fit_within(samples, commands, repetitions, MAX_ERRORS_OF_RATE)
}

fn fit_within(
    samples: &[AngleSample],
    commands: &[RateStep],
    repetitions: &[(f64, f64)],
    max: Errors,
) -> Result<AxisFit, CannotTell> {
    let (Some(first), Some(last)) = (repetitions.first(), repetitions.last()) else {
        return Err(CannotTell::NotMeasured);
    };
    let between = |from: f64, to: f64| move |sample: &&AngleSample| (from..to).contains(&sample.at_s);
    let within: Vec<AngleSample> = samples.iter().filter(between(first.0, last.1)).copied().collect();
    let whole = fit(&within, commands).ok_or(CannotTell::NotMeasured)?;
    if whole.explained < MIN_EXPLAINED || whole.gain() < MIN_GAIN {
        return Err(CannotTell::NotFollowing { explained: whole.explained });
    }
    let mut parts = Vec::new();
    for (from, to) in repetitions {
        let is_left_out = between(*from, *to);
        let kept: Vec<AngleSample> = within.iter().filter(|sample| !is_left_out(sample)).copied().collect();
        parts.push(fit(&kept, commands).ok_or(CannotTell::NotMeasured)?);
    }
    let gain_error = jackknife(&parts, AxisFit::gain) / whole.gain();
    let dead_time_error_s =
        jackknife(&parts, |fit| fit.start_dead_time_s).max(jackknife(&parts, |fit| fit.stop_dead_time_s));
    if gain_error > max.gain || dead_time_error_s > max.dead_time_s {
        return Err(CannotTell::Unsteady { gain_error, dead_time_error_s });
    }
    Ok(whole)
}

/// The standard error of a value, from fits that each leave one repetition out (Tukey's jackknife).
fn jackknife(parts: &[AxisFit], value: impl Fn(&AxisFit) -> f64) -> f64 {
    let count = parts.len().max(1) as f64;
    let mean = parts.iter().map(&value).sum::<f64>() / count;
    let squares: f64 = parts.iter().map(|part| (value(part) - mean) * (value(part) - mean)).sum();
    libm::sqrt((count - 1.0) / count * squares)
}

/// Dead time of a start, dead time of a stop, lag, seconds.
type Shape = [f64; 3];

/// The best fit; `None`: there are too few samples.
fn fit(samples: &[AngleSample], commands: &[RateStep]) -> Option<AxisFit> {
    let pairs = pairs(samples);
    if pairs.len() < 50 {
        return None;
    }
    let score = |shape: Shape| linear(samples, &pairs, &response(samples, commands, shape));
    let mut best: Option<(Shape, Linear)> = None;
    let consider = |shape: Shape, best: &mut Option<(Shape, Linear)>| {
        let found = score(shape);
        if best.as_ref().is_none_or(|(_, known)| found.error < known.error) {
            *best = Some((shape, found));
            true
        } else {
            false
        }
    };
    let dead_times = || (0..=12).map(|step| 0.1 * f64::from(step));
    for start in dead_times() {
        for stop in dead_times().filter(|stop| *stop >= start - 0.05) {
            for lag in LAGS_S {
                consider([start, stop, lag], &mut best);
            }
        }
    }
    let mut step = 0.05;
    while step > 0.002 {
        let mut has_improved = false;
        for direction in
            [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [1.0, 1.0, -1.0], [1.0, 1.0, 0.0]]
        {
            for sign in [step, -step] {
                let (shape, _) = best?;
                let moved = [0, 1, 2].map(|k| {
                    let limit = if k == 2 { MAX_LAG_S } else { MAX_DEAD_TIME_S };
                    (shape[k] + sign * direction[k]).clamp(if k == 2 { 0.005 } else { 0.0 }, limit)
                });
                has_improved |= consider(moved, &mut best);
            }
        }
        if !has_improved {
            step *= 0.5;
        }
    }
    let ([start_dead_time_s, stop_dead_time_s, lag_s], linear) = best?;
    Some(AxisFit {
        gains: linear.gains,
        start_dead_time_s,
        stop_dead_time_s,
        lag_s,
        explained: 1.0 - linear.error / linear.total.max(f64::MIN_POSITIVE),
    })
}

/// Pairs of samples that lie [`SPAN_S`] apart.
fn pairs(samples: &[AngleSample]) -> Vec<(usize, usize)> {
    let mut earlier = 0;
    let mut pairs = Vec::new();
    for (later, sample) in samples.iter().enumerate() {
        while samples[earlier + 1..=later].first().is_some_and(|next| sample.at_s - next.at_s >= SPAN_S) {
            earlier += 1;
        }
        let before = samples[earlier];
        let span_s = sample.at_s - before.at_s;
        if before.epoch == sample.epoch && (SPAN_S..1.5 * SPAN_S).contains(&span_s) {
            pairs.push((earlier, later));
        }
    }
    pairs
}

/// The angle of an axis of gain 1 at the times of the samples.
fn response(samples: &[AngleSample], commands: &[RateStep], [start_s, stop_s, lag_s]: Shape) -> Vec<f64> {
    let mut effective: Vec<RateStep> = Vec::new();
    for command in commands {
        let at_s = command.at_s + if command.rate == 0.0 { stop_s } else { start_s };
        // A later command replaces earlier ones that have not taken effect by then.
        while effective.last().is_some_and(|last| last.at_s >= at_s) {
            effective.pop();
        }
        effective.push(RateStep { at_s, rate: command.rate });
    }
    let mut next = 0;
    let (mut now_s, mut commanded, mut rate, mut angle) = (f64::NEG_INFINITY, 0.0, 0.0, 0.0);
    let advance = |to_s: f64, now_s: &mut f64, commanded: f64, rate: &mut f64, angle: &mut f64| {
        if now_s.is_finite() {
            let seconds = to_s - *now_s;
            let decay = libm::exp(-seconds / lag_s);
            *angle += commanded * seconds + (*rate - commanded) * lag_s * (1.0 - decay);
            *rate = commanded + (*rate - commanded) * decay;
        }
        *now_s = to_s;
    };
    samples
        .iter()
        .map(|sample| {
            while let Some(step) = effective.get(next).filter(|step| step.at_s <= sample.at_s) {
                advance(step.at_s, &mut now_s, commanded, &mut rate, &mut angle);
                (commanded, next) = (step.rate, next + 1);
            }
            advance(sample.at_s, &mut now_s, commanded, &mut rate, &mut angle);
            angle
        })
        .collect()
}

/// The linear part of a fit.
#[derive(Debug, Clone, Copy)]
struct Linear {
    gains: [f64; 2],
    /// Sums of squares: what is left, and of the turns themselves.
    error: f64,
    total: f64,
}

/// Gain and drift of each component by least squares.
fn linear(samples: &[AngleSample], pairs: &[(usize, usize)], response: &[f64]) -> Linear {
    let mut result = Linear { gains: [0.0; 2], error: 0.0, total: 0.0 };
    for component in 0..2 {
        let (mut xx, mut xt, mut tt, mut xy, mut ty, mut yy) = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0);
        for (before, after) in pairs {
            let t = samples[*after].at_s - samples[*before].at_s;
            let x = response[*after] - response[*before];
            let y = samples[*after].angle[component] - samples[*before].angle[component];
            (xx, xt, tt) = (xx + x * x, xt + x * t, tt + t * t);
            (xy, ty, yy) = (xy + x * y, ty + t * y, yy + y * y);
        }
        let determinant = xx * tt - xt * xt;
        let (gain, drift) = if determinant > 1e-12 * tt * tt {
            ((xy * tt - ty * xt) / determinant, (ty * xx - xy * xt) / determinant)
        } else {
            (0.0, if tt > 0.0 { ty / tt } else { 0.0 })
        };
        result.gains[component] = gain;
        result.error += (yy - gain * xy - drift * ty).max(0.0);
        // A steady drift alone explains nothing of the motion.
        result.total += if tt > 0.0 { yy - ty * ty / tt } else { yy };
    }
    result
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The commands of three repetitions, and their times.
    fn commands() -> (Vec<RateStep>, Vec<(f64, f64)>) {
        let mut steps = Vec::new();
        for part in 0..6 {
            let at_s = 1.0 + 4.5 * f64::from(part);
            let rate = if part % 2 == 1 { -0.1 } else { 0.1 };
            steps.extend([RateStep { at_s, rate }, RateStep { at_s: at_s + 2.5, rate: 0.0 }]);
        }
        (steps, (0..3).map(|k| (1.0 + 9.0 * f64::from(k), 10.0 + 9.0 * f64::from(k))).collect())
    }

    fn samples(shape: Shape, gains: [f64; 2], noise: impl Fn(u32) -> f64) -> Vec<AngleSample> {
        let at = |index: u32| f64::from(index) / 30.0;
        let empty = |index| AngleSample { at_s: at(index), angle: [0.0; 2], epoch: 0 };
        let times: Vec<_> = (0..900).map(empty).collect();
        let response = response(&times, &commands().0, shape);
        let measured = |(index, angle): (usize, f64)| {
            let noise = noise(index as u32);
            AngleSample {
                angle: gains.map(|gain| gain * angle + noise + 0.002 * times[index].at_s),
                ..times[index]
            }
        };
        response.into_iter().enumerate().map(measured).collect()
    }

    #[test]
    fn the_shape_of_an_axis_is_found_again() {
        let (commands, repetitions) = commands();
        for (shape, gains) in [
            ([0.2, 0.4, 0.42], [1.0, 0.0]),
            ([0.1, 0.4, 0.1], [-0.9, 0.3]),
            ([0.38, 0.38, 0.2], [0.0, 1.1]),
            ([0.0, 0.0, 0.05], [0.5, -0.5]),
        ] {
            let noise = |index: u32| 0.0005 * f64::from(index * 7919 % 13) / 13.0;
            let found = fit_axis(&samples(shape, gains, noise), &commands, &repetitions).unwrap();
            for (seen, expected) in found.gains.into_iter().zip(gains) {
                assert!((seen - expected).abs() < 0.01, "{shape:?}: {found:?}");
            }
            assert!((found.start_dead_time_s - shape[0]).abs() < 0.02, "{shape:?}: {found:?}");
            assert!((found.stop_dead_time_s - shape[1]).abs() < 0.02, "{shape:?}: {found:?}");
            assert!((found.lag_s - shape[2]).abs() < 0.03, "{shape:?}: {found:?}");
        }
    }

    #[test]
    fn what_does_not_follow_the_commands_is_not_told() {
        let (commands, repetitions) = commands();
        let sways = samples([0.2, 0.4, 0.4], [0.0, 0.0], |index| 0.05 * libm::sin(f64::from(index) / 25.0));
        let refused = fit_axis(&sways, &commands, &repetitions);
        assert!(matches!(refused, Err(CannotTell::NotFollowing { .. })), "{refused:?}");
        let changes = samples([0.2, 0.4, 0.4], [1.0, 0.0], |index| {
            if index > 600 {
                0.004 * f64::from(index - 600) / 10.0 * libm::sin(f64::from(index) / 9.0)
            } else {
                0.0
            }
        });
        let refused = fit_axis(&changes, &commands, &repetitions);
        assert!(
            matches!(refused, Err(CannotTell::Unsteady { .. } | CannotTell::NotFollowing { .. })),
            "{refused:?}"
        );
        assert_eq!(fit_axis(&[], &commands, &repetitions), Err(CannotTell::NotMeasured));
    }
}
