//! The table `noise`: the noise of the tracked position, recorded and simulated.
//!
//! Over a third of a second a slow target moves along a parabola; the residuals of the positions are noise
//! and rounding. The error of the recorded positions lasts longer than one picture: noise that is independent
//! from picture to picture (the last row of each arena) leaves about twice as much. Nothing is judged.

use std::path::Path;

use anyhow::Result;
use barrelman_sim::Scenario;
use barrelman_sim::random::OrnsteinUhlenbeck;
use barrelman_trial::logs::TrialLog;

use super::laboratory::{load_scenario, read_recorded, simulate_all};
use super::options::Options;
use super::position_jump::is_jump;
use crate::output::print_line;
use crate::statistics::quantile;

/// Upper bounds of the two classes of speed, pixels per second; for faster targets the rows' times are not
/// exact enough.
const MAX_SPEEDS: [f64; 2] = [10.0, 40.0];
/// Half of the interval that a parabola is fitted to, seconds, and the rows that it needs.
const HALF_INTERVAL_S: f64 = 0.17;
const MIN_ROWS: usize = 6;
/// Simulated trials of each kind.
const TRIALS: u64 = 24;

/// Prints the table.
pub(super) fn run(folder: &Path, options: &Options) -> Result<()> {
    print_line(
        "\nWhat places of a slow target leave of a parabola over a third of a second, pixels: median (across, up and \
         down)",
    );
    print_line(&format!("{:44} {:>20} {:>20}", "", "below 10 px/s", "10 to 40 px/s"));
    for arena in [1, 2] {
        let scenario = load_scenario(arena, options.scenarios.as_deref())?;
        let mut white_noise = scenario.clone();
        white_noise.sensing.noise = OrnsteinUhlenbeck { time_constant_s: 0.0, ..scenario.sensing.noise };
        let simulated =
            |scenario: &Scenario| simulate_all(scenario, options.first_seed..options.first_seed + TRIALS);
        print_row(&format!("arena {arena}, recorded"), &read_recorded(folder, arena, false)?);
        print_row(&format!("arena {arena}, simulated"), &simulated(&scenario)?);
        print_row(&format!("arena {arena}, noise new with each picture"), &simulated(&white_noise)?);
    }
    Ok(())
}

fn print_row(name: &str, logs: &[TrialLog]) {
    let mut by_speed: [[Vec<f64>; 2]; 2] = Default::default();
    for residual in logs.iter().flat_map(residuals) {
        if let Some(class) = MAX_SPEEDS.iter().position(|max| residual.speed_px_per_s < *max) {
            let [across, vertical] = residual.rms_px;
            by_speed[class][0].push(across);
            by_speed[class][1].push(vertical);
        }
    }
    let [slow, faster] = by_speed
        .map(|[across, vertical]| format!("{:.2}, {:.2}", quantile(&across, 0.5), quantile(&vertical, 0.5)));
    print_line(&format!("{name:44} {slow:>20} {faster:>20}"));
}

/// What a parabola through the positions around a row leaves.
struct Residual {
    speed_px_per_s: f64,
    /// RMS residual across, and up and down.
    rms_px: [f64; 2],
}

/// The residuals around the rows of a trial; rows with too few neighbours, or near a jump, have none.
fn residuals(log: &TrialLog) -> Vec<Residual> {
    let positions: Vec<(f64, [f64; 2], bool)> = (0..log.rows.len())
        .filter_map(|row| {
            let at = log.rows[row].position?;
            Some((log.rows[row].time_s, [at.x, at.y], is_jump(log, row)))
        })
        .collect();
    (0..positions.len())
        .filter_map(|middle| {
            let middle_s = positions[middle].0;
            let near = &positions[positions
                .partition_point(|(time_s, ..)| *time_s < middle_s - HALF_INTERVAL_S)
                ..positions.partition_point(|(time_s, ..)| *time_s <= middle_s + HALF_INTERVAL_S)];
            if near.len() < MIN_ROWS || near.iter().any(|(_, _, jumped)| *jumped) {
                return None;
            }
            let fit = |axis: usize| {
                fit_parabola(near.iter().map(|(time_s, position, _)| (time_s - middle_s, position[axis])))
            };
            let (across, vertical) = (fit(0)?, fit(1)?);
            Some(Residual {
                speed_px_per_s: across.slope.hypot(vertical.slope),
                rms_px: [across.rms, vertical.rms],
            })
        })
        .collect()
}

/// A parabola fitted by least squares.
struct ParabolaFit {
    /// Slope at t = 0.
    slope: f64,
    /// RMS of the residuals.
    rms: f64,
}

/// Fits a parabola to points (t, value); `None` where the points do not determine one.
fn fit_parabola(points: impl Iterator<Item = (f64, f64)> + Clone) -> Option<ParabolaFit> {
    // Normal equations, solved by elimination; the columns are 1, t and t².
    let mut rows = [[0.0; 4]; 3];
    for (t, value) in points.clone() {
        let powers = [1.0, t, t * t];
        for i in 0..3 {
            for j in 0..3 {
                rows[i][j] += powers[i] * powers[j];
            }
            rows[i][3] += powers[i] * value;
        }
    }
    for pivot in 0..3 {
        let scale = rows[pivot][pivot];
        if scale.abs() < 1e-12 {
            return None;
        }
        let pivot_row = rows[pivot].map(|x| x / scale);
        rows[pivot] = pivot_row;
        for (index, row) in rows.iter_mut().enumerate() {
            if index != pivot {
                let share = row[pivot];
                for (x, p) in row.iter_mut().zip(pivot_row) {
                    *x -= share * p;
                }
            }
        }
    }
    let [a, b, c] = rows.map(|row| row[3]);
    let (sum, count) = points.fold((0.0, 0.0), |(sum, count), (t, value)| {
        (sum + (value - a - b * t - c * t * t).powi(2), count + 1.0)
    });
    Some(ParabolaFit { slope: b, rms: (sum / count).sqrt() })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_parabola_leaves_no_residuals() {
        let points = (0..9).map(|i| {
            let t = 0.04 * f64::from(i - 4);
            (t, 3.0 - 20.0 * t + 55.0 * t * t)
        });
        let ParabolaFit { slope, rms } = fit_parabola(points.clone()).unwrap();
        assert!((slope + 20.0).abs() < 1e-9 && rms < 1e-9, "{slope} {rms}");
        let off = |(index, (t, value)): (usize, (f64, f64))| (t, value + [0.5, -0.5][index % 2]);
        let ParabolaFit { rms, .. } = fit_parabola(points.enumerate().map(off)).unwrap();
        assert!((rms - 0.5).abs() < 0.05, "{rms}");
    }
}
