//! Figure of P over time: the boundary at 1, every excursion shaded, with its height h and its duration b.

use super::canvas::{Anchor, Canvas, Point};
use super::figure::Figure;
use super::path_data;
use super::reported_trial::TrialTrace;
use super::scale::Scale;
use super::time_axis::{TimeAxis, WIDTH, describe, time_span};
use crate::metrics::{Excursion, find_excursions};

const HEIGHT: f64 = 214.0;
const TOP: f64 = 22.0;
const BOTTOM: f64 = HEIGHT - 24.0;
/// Smallest range of the scale.
const MIN_P_RANGE: f64 = 1.6;

/// The shadow does not extend the scale beyond this P.
const MAX_SHADOW_P: f64 = 4.0;

/// The figure of a trial.
pub fn figure(name: &str, trial: &str, trace: &TrialTrace) -> Figure {
    let (log, region) = (&trace.log, trace.region);
    let found = find_excursions(log, region);
    let p_at = |row: usize| log.rows[row].position.map(|position| region.p(position));
    let shadow_ps = trace.shadow.iter().flatten().flatten().map(|p| p.min(MAX_SHADOW_P));
    let max_p = (0..log.rows.len()).filter_map(p_at).chain(shadow_ps).fold(MIN_P_RANGE, f64::max);
    let axis = TimeAxis::new(log);
    let p_scale = Scale { values: (0.0, 1.06 * max_p), paper: (BOTTOM, TOP) };
    let boundary = p_scale.at(1.0);
    let mut canvas = Canvas::default();
    draw_scale(&mut canvas, &axis, &p_scale);
    axis.draw(&mut canvas, TOP, BOTTOM);
    axis.draw_gaps(&mut canvas, log, TOP, BOTTOM);
    canvas.text("name", Anchor::Start, (axis.left() - 20.0, TOP - 9.0), "P");
    canvas.text("t-region", Anchor::End, (axis.right(), TOP - 9.0), "boundary of the region: P = 1");
    if trace.shadow.is_some() {
        let at = (axis.left() + 8.0, TOP - 9.0);
        canvas.text("t-shadow", Anchor::Start, at, "dashed: as it would have been with the paper's schema");
    }

    for excursion in &found {
        axis.draw_span(&mut canvas, log, excursion, TOP, BOTTOM);
        let rows = excursion.first..excursion.end;
        let over: Vec<_> =
            rows.filter_map(|row| Some((axis.at(log.rows[row].time_s), p_scale.at(p_at(row)?)))).collect();
        canvas.path("over", &path_data::area(&over, boundary));
    }
    let shadow_points: Option<Vec<Option<Point>>> = trace.shadow.as_ref().map(|shadow| {
        let rows = log.rows.iter().zip(shadow);
        rows.map(|(row, p)| p.map(|p| (axis.at(row.time_s), p_scale.at(p.min(max_p))))).collect()
    });
    let track =
        (0..log.rows.len()).map(|row| p_at(row).map(|p| (axis.at(log.rows[row].time_s), p_scale.at(p))));
    if let Some(shadow) = &shadow_points {
        canvas.path("shadow", &path_data::through(shadow.iter().copied()));
    }
    canvas.path("track", &path_data::through(track));
    canvas.line("bound", (axis.left(), boundary), (axis.right(), boundary));

    let mut points = Vec::with_capacity(found.len());
    for excursion in &found {
        let (from_s, to_s) = time_span(log, excursion);
        let (from, to) = (axis.at(from_s), axis.at(to_s));
        let open = if excursion.is_complete { "" } else { " open" };
        canvas.line(&format!("b{open}"), (from, boundary), (to.max(from + 1.0), boundary));
        let peak = peak_row(excursion, &p_at);
        let (x, y) = (axis.at(log.rows[peak].time_s), p_scale.at(1.0 + excursion.h));
        canvas.line(&format!("h{open}"), (x, boundary), (x, y));
        points.push(((0.5 * (from + to), boundary), (x, y)));
    }
    label_excursions(&mut canvas, &found, &points);
    let description = format!(
        "P over {:.1} s with the boundary at 1. {} excursions, {} of them complete. {}",
        log.duration_s(),
        found.len(),
        found.iter().filter(|excursion| excursion.is_complete).count(),
        found.iter().map(|excursion| describe(log, excursion) + ". ").collect::<String>()
    );
    Figure::new(name.to_owned(), (format!("{trial}: P over time"), description), (WIDTH, HEIGHT), canvas)
}

/// Draws the scale of P, with the boundary's 1 in place of a tick.
fn draw_scale(canvas: &mut Canvas, axis: &TimeAxis, p_scale: &Scale) {
    let boundary = p_scale.at(1.0);
    for (value, label) in p_scale.ticks(4).labelled() {
        canvas.line("grid", (axis.left(), p_scale.at(value)), (axis.right(), p_scale.at(value)));
        if (p_scale.at(value) - boundary).abs() > 12.0 {
            canvas.text("tick", Anchor::End, (axis.left() - 7.0, p_scale.at(value) + 4.0), &label);
        }
    }
    canvas.text("t-region name", Anchor::End, (axis.left() - 7.0, boundary + 4.0), "1");
}

/// The row with the largest P of an excursion.
pub(super) fn peak_row(excursion: &Excursion, p_at: &dyn Fn(usize) -> Option<f64>) -> usize {
    let known_ps = (excursion.first..excursion.end).filter_map(|row| Some((row, p_at(row)?)));
    known_ps.max_by(|a, b| a.1.total_cmp(&b.1).then(b.0.cmp(&a.0))).map_or(excursion.first, |(row, _)| row)
}

/// Writes h and b at the points of the excursions (b, h) as far as there is room: large excursions first, the
/// largest with the letters.
fn label_excursions(canvas: &mut Canvas, found: &[Excursion], points: &[(Point, Point)]) {
    let mut order: Vec<usize> = (0..found.len()).collect();
    let area = |index: usize| found[index].b_s * found[index].h;
    order.sort_by(|a, b| area(*b).total_cmp(&area(*a)));
    let mut labelled_x: Vec<f64> = Vec::new();
    for (rank, index) in order.into_iter().enumerate() {
        let (excursion, (b, h)) = (&found[index], points[index]);
        let width = if rank == 0 { 1.6 * LABEL_WIDTH } else { LABEL_WIDTH };
        let is_visible = b.1 - h.1 > 4.0 || rank == 0;
        if !is_visible || labelled_x.iter().any(|x| (x - b.0).abs() < width) {
            continue;
        }
        labelled_x.push(b.0);
        let (named_h, named_b, unit) = if rank == 0 { ("h ", "b ", " s") } else { ("", "", "") };
        let words = format!("{named_h}{:.2}", excursion.h);
        canvas.text_on_lines("t-out small", Anchor::Middle, (h.0, (h.1 - 4.0).max(9.0)), &words);
        let words = format!("{named_b}{:.1}{unit}", excursion.b_s);
        canvas.text_on_lines("t-out small", Anchor::Middle, (b.0, b.1 + 12.0), &words);
    }
}

/// Width of a label.
const LABEL_WIDTH: f64 = 27.0;
