//! P over time at the size of a word, for lists of trials.

use super::Course;
use super::canvas::Canvas;
use super::figure::Figure;
use super::line;
use super::scale::Scale;
use super::time_axis::span;
use crate::metrics::excursions;

const SIZE: (f64, f64) = (132.0, 24.0);
/// P above this is cut: the boundary lies at the same height in every row of the list.
const MOST_P: f64 = 3.0;

/// The figure of a trial.
pub fn figure(trial: &str, course: &Course) -> Figure {
    let (log, region) = (&course.log, course.region);
    let time = Scale { values: (0.0, log.duration_s()), places: (1.0, SIZE.0 - 1.0) };
    let p_scale = Scale { values: (0.0, MOST_P), places: (SIZE.1 - 1.0, 1.0) };
    let mut canvas = Canvas::default();
    let found = excursions(log, region);
    for excursion in &found {
        let (from_s, to_s) = span(log, excursion);
        canvas.rect("over", (time.at(from_s), 1.0), (time.at(to_s), SIZE.1 - 1.0), None);
    }
    let places = log.rows.iter().map(|row| {
        let p = region.p(row.position?).min(MOST_P);
        Some((time.at(row.time_s), p_scale.at(p)))
    });
    canvas.path("track", &line::through(places));
    canvas.line("bound", (0.0, p_scale.at(1.0)), (SIZE.0, p_scale.at(1.0)));
    let titles = (format!("{trial}: P"), format!("P over time, with {} excursions.", found.len()));
    Figure::new(String::new(), titles, SIZE, canvas)
}
