//! Figure of the path in the world from above (x to the right and y ahead of the first view, m), with the
//! excursions. Simulated trials only: the figure needs the truth.

use super::canvas::{Canvas, Point};
use super::figure::Figure;
use super::path_data;
use super::picture_path::draw_path;
use super::plan_view::PlanView;
use super::reported_trial::TrialTrace;
use super::time_axis::describe;
use crate::metrics::find_excursions;

/// The figure of a trial; `None` without truth.
pub fn figure(name: &str, trial: &str, trace: &TrialTrace) -> Option<Figure> {
    let log = &trace.log;
    let truth = log.truth.as_ref().filter(|truth| !truth.is_empty() && truth.len() == log.rows.len())?;
    let found = find_excursions(log, trace.region);
    let view = PlanView::around(truth.iter().flat_map(|row| [row.target_m, row.camera_m]));
    let mut canvas = Canvas::default();
    view.draw_grid(&mut canvas);
    canvas.path("sector", &path_data::through(truth.iter().map(|row| Some(view.at(row.camera_m)))));
    if let Some(first) = truth.first() {
        view.draw_camera(&mut canvas, first.camera_m);
    }
    let points: Vec<Option<Point>> = truth.iter().map(|row| Some(view.at(row.target_m))).collect();
    let p_at = |row: usize| log.rows[row].position.map(|position| trace.region.p(position));
    draw_path(&mut canvas, &points, &found, &p_at, &|excursion| describe(log, excursion));
    let description = format!(
        "Where the target was in the world, seen from above, {:.1} m by {:.1} m, with the camera's path and {} excursions.",
        view.size_m.0,
        view.size_m.1,
        found.len()
    );
    let titles = (format!("{trial}: path in the world"), description);
    Some(Figure::new(name.to_owned(), titles, view.paper_size(), canvas))
}
