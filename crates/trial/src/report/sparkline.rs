//! Sparkline of P over time, for the list of trials.

use super::canvas::Canvas;
use super::figure::Figure;
use super::path_data;
use super::reported_trial::TrialTrace;
use super::scale::Scale;
use super::time_axis::time_span;
use crate::metrics::find_excursions;

const SIZE: (f64, f64) = (132.0, 24.0);
/// Larger values of P are clipped, so that the boundary has the same height in every row of the list.
const MAX_P: f64 = 3.0;

/// The figure of a trial.
pub(super) fn figure(trial: &str, trace: &TrialTrace) -> Figure {
    let (log, region) = (&trace.log, trace.region);
    let time = Scale { values: (0.0, log.duration_s()), paper: (1.0, SIZE.0 - 1.0) };
    let p_scale = Scale { values: (0.0, MAX_P), paper: (SIZE.1 - 1.0, 1.0) };
    let mut canvas = Canvas::default();
    let found = find_excursions(log, region);
    for excursion in &found {
        let (from_s, to_s) = time_span(log, excursion);
        canvas.rect("over", (time.at(from_s), 1.0), (time.at(to_s), SIZE.1 - 1.0), None);
    }
    let points = log.rows.iter().map(|row| {
        let p = region.p(row.position?).min(MAX_P);
        Some((time.at(row.time_s), p_scale.at(p)))
    });
    canvas.path("track", &path_data::through(points));
    canvas.line("bound", (0.0, p_scale.at(1.0)), (SIZE.0, p_scale.at(1.0)));
    let titles = (format!("{trial}: P"), format!("P over time, with {} excursions.", found.len()));
    Figure::new(String::new(), titles, SIZE, canvas)
}
