//! How much the tracked place jitters: the recorded tracker's noise beside the simulated one's.
//!
//! Over a third of a second a slow target goes along a parabola; what the places leave of that is noise and rounding.
//! The recorded places keep their error for longer than a picture: noise that were new with each picture would leave
//! about twice as much.

use std::path::Path;

use anyhow::Result;
use barrelman_sim::Scenario;
use barrelman_sim::random::OrnsteinUhlenbeck;
use barrelman_trial::logs::TrialLog;

use super::Options;
use super::recorded::{JUMP_PX, read, scenario, simulated_from, step_px};
use crate::say;
use crate::tracker::figures::quantile;

/// Speeds up to which the place is looked at, pixels per second; beyond, the rows' times are not known well enough.
const SPEEDS: [f64; 2] = [10.0, 40.0];
/// Half of the span that a parabola is laid through, seconds, and the rows that it needs.
const HALF_S: f64 = 0.17;
const ROWS: usize = 6;
/// Simulated trials of each kind.
const TRIALS: u64 = 24;

/// Prints the table.
pub(super) fn run(folder: &Path, options: &Options) -> Result<()> {
    say(
        "\nWhat places of a slow target leave of a parabola over a third of a second, pixels: median (across, up and down)",
    );
    say(&format!("{:44} {:>20} {:>20}", "", "below 10 px/s", "10 to 40 px/s"));
    for arena in [1, 2] {
        let scenario = scenario(arena, options.scenarios.as_deref())?;
        let mut anew = scenario.clone();
        anew.sensing.noise = OrnsteinUhlenbeck { time_constant_s: 0.0, ..scenario.sensing.noise };
        let trials = |scenario: &Scenario| simulated_from(scenario, options.first_seed, TRIALS);
        let recorded: Vec<_> = read(folder, arena, false)?.into_iter().map(|trial| trial.log).collect();
        row(&format!("arena {arena}, recorded"), &recorded);
        row(&format!("arena {arena}, simulated"), &trials(&scenario)?);
        row(&format!("arena {arena}, noise new with each picture"), &trials(&anew)?);
    }
    Ok(())
}

fn row(name: &str, logs: &[TrialLog]) {
    let mut left: [[Vec<f64>; 2]; 2] = Default::default();
    for log in logs {
        for (speed, [across, upward]) in residuals(log) {
            if let Some(class) = SPEEDS.iter().position(|most| speed < *most) {
                left[class][0].push(across);
                left[class][1].push(upward);
            }
        }
    }
    let [slow, faster] =
        left.map(|[across, upward]| format!("{:.2}, {:.2}", quantile(&across, 0.5), quantile(&upward, 0.5)));
    say(&format!("{name:44} {slow:>20} {faster:>20}"));
}

/// Speed, and RMS of what is left of each coordinate, around rows of a trial.
fn residuals(log: &TrialLog) -> Vec<(f64, [f64; 2])> {
    let places: Vec<_> = (0..log.rows.len())
        .filter_map(|row| {
            let at = log.rows[row].position?;
            Some((log.rows[row].time_s, [at.x, at.y], row > 0 && step_px(log, row) > JUMP_PX))
        })
        .collect();
    (0..places.len())
        .filter_map(|middle| {
            let at_s = places[middle].0;
            let near = &places[places.partition_point(|place| place.0 < at_s - HALF_S)
                ..places.partition_point(|place| place.0 <= at_s + HALF_S)];
            if near.len() < ROWS || near.iter().any(|(_, _, jumped)| *jumped) {
                return None;
            }
            let of = |axis: usize| parabola(near.iter().map(|place| (place.0 - at_s, place.1[axis])));
            let (across, upward) = (of(0)?, of(1)?);
            Some((across.0.hypot(upward.0), [across.1, upward.1]))
        })
        .collect()
}

/// Slope in the middle of the parabola through some points, and the RMS distance of the points from it.
fn parabola(points: impl Iterator<Item = (f64, f64)> + Clone) -> Option<(f64, f64)> {
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
    Some((b, (sum / count).sqrt()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_parabola_leaves_nothing_of_itself() {
        let points = (0..9).map(|i| {
            let t = 0.04 * f64::from(i - 4);
            (t, 3.0 - 20.0 * t + 55.0 * t * t)
        });
        let (slope, left) = parabola(points.clone()).unwrap();
        assert!((slope + 20.0).abs() < 1e-9 && left < 1e-9, "{slope} {left}");
        let off = |(index, (t, value)): (usize, (f64, f64))| (t, value + [0.5, -0.5][index % 2]);
        let (_, left) = parabola(points.enumerate().map(off)).unwrap();
        assert!((left - 0.5).abs() < 0.05, "{left}");
    }
}
