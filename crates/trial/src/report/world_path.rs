//! Figure of the path in the world from above (x to the right and y ahead of the first view, m), with the excursions.
//! Simulated trials only: the figure needs the truth.

use super::canvas::{Anchor, Canvas, Point};
use super::figure::Figure;
use super::path_data;
use super::picture_path::draw_path;
use super::reported_trial::TrialTrace;
use super::scale::Scale;
use super::time_axis::describe;
use crate::metrics::find_excursions;

const WIDTH: f64 = 372.0;
const LEFT: f64 = 40.0;
const TOP: f64 = 22.0;
const MARGIN: f64 = 10.0;
const BELOW: f64 = 24.0;
/// Largest height of the drawing; the smallest is a third of it.
const MAX_HEIGHT: f64 = 340.0;

/// The figure of a trial; `None` without truth.
pub fn figure(name: &str, trial: &str, trace: &TrialTrace) -> Option<Figure> {
    let log = &trace.log;
    let truth = log.truth.as_ref().filter(|truth| !truth.is_empty() && truth.len() == log.rows.len())?;
    let found = find_excursions(log, trace.region);
    let extreme = |is_minimum: bool, coordinate: fn((f64, f64)) -> f64| {
        let values = truth.iter().flat_map(|row| [coordinate(row.target_m), coordinate(row.camera_m)]);
        values.reduce(if is_minimum { f64::min } else { f64::max }).unwrap_or(0.0)
    };
    let (low, high) = (
        (extreme(true, |p| p.0), extreme(true, |p| p.1)),
        (extreme(false, |p| p.0), extreme(false, |p| p.1)),
    );
    let margin_m = 0.05 * (high.0 - low.0).max(high.1 - low.1).max(1.0);
    let (width_m, height_m) = (high.0 - low.0 + 2.0 * margin_m, high.1 - low.1 + 2.0 * margin_m);
    let width_px = WIDTH - MARGIN - LEFT;
    let per_m = (width_px / width_m).min(MAX_HEIGHT / height_m);
    let height_px = (height_m * per_m).max(MAX_HEIGHT / 3.0);
    let bottom = TOP + height_px;
    let (middle_x, middle_y) = (0.5 * (low.0 + high.0), 0.5 * (low.1 + high.1));
    let half = (0.5 * width_px / per_m, 0.5 * height_px / per_m);
    let x_scale = Scale { values: (middle_x - half.0, middle_x + half.0), paper: (LEFT, WIDTH - MARGIN) };
    let y_scale = Scale { values: (middle_y - half.1, middle_y + half.1), paper: (bottom, TOP) };
    let mut canvas = Canvas::default();
    for (value, label) in x_scale.ticks(6).labelled() {
        canvas.line("grid", (x_scale.at(value), TOP), (x_scale.at(value), bottom));
        canvas.text("tick", Anchor::Middle, (x_scale.at(value), bottom + 16.0), &label);
    }
    for (value, label) in y_scale.ticks(5).labelled() {
        canvas.line("grid", (LEFT, y_scale.at(value)), (WIDTH - MARGIN, y_scale.at(value)));
        canvas.text("tick", Anchor::End, (LEFT - 7.0, y_scale.at(value) + 4.0), &label);
    }
    canvas.rect("frame", (LEFT, TOP), (WIDTH - MARGIN, bottom), None);
    canvas.text("unit", Anchor::Start, (LEFT - 32.0, TOP - 9.0), "y, m");
    canvas.text("unit", Anchor::End, (WIDTH - MARGIN, TOP - 9.0), "x, m");
    let to_paper = |(x, y): (f64, f64)| (x_scale.at(x), y_scale.at(y));
    let camera: Vec<Point> = truth.iter().map(|row| to_paper(row.camera_m)).collect();
    canvas.path("sector", &path_data::through(camera.iter().copied().map(Some)));
    if let Some((x, y)) = camera.first().copied() {
        canvas.path(
            "mean",
            &path_data::through(
                [(x - 5.0, y + 4.0), (x, y - 5.0), (x + 5.0, y + 4.0), (x - 5.0, y + 4.0)].map(Some),
            ),
        );
        let near_right = x > WIDTH - 90.0;
        let (anchor, off) = if near_right { (Anchor::End, -9.0) } else { (Anchor::Start, 9.0) };
        canvas.text_on_lines("small", anchor, (x + off, y + 4.0), "camera");
    }
    let points: Vec<Option<Point>> = truth.iter().map(|row| Some(to_paper(row.target_m))).collect();
    let p_at = |row: usize| log.rows[row].position.map(|position| trace.region.p(position));
    draw_path(&mut canvas, &points, &found, &p_at, &|excursion| describe(log, excursion));
    let description = format!(
        "Where the target was in the world, seen from above, {width_m:.1} m by {height_m:.1} m, with the camera's to_paper \
         and {} excursions.",
        found.len()
    );
    let titles = (format!("{trial}: path in the world"), description);
    Some(Figure::new(name.to_owned(), titles, (WIDTH, bottom + BELOW), canvas))
}
