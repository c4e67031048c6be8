//! P over time: the boundary at 1, every excursion shaded, with its height h and its duration b.

use super::canvas::{Anchor, Canvas, Place};
use super::figure::Figure;
use super::scale::Scale;
use super::time_axis::{TimeAxis, WIDTH, in_words, span};
use super::{Course, line};
use crate::metrics::{Excursion, excursions};

const HEIGHT: f64 = 214.0;
const TOP: f64 = 22.0;
const BOTTOM: f64 = HEIGHT - 24.0;
/// The scale goes up to this P at least.
const LEAST_P: f64 = 1.6;

/// What might have been does not stretch the scale beyond this P.
const MOST_OF_SHADOW: f64 = 4.0;

/// The figure of a trial.
pub fn figure(name: &str, trial: &str, course: &Course) -> Figure {
    let (log, region) = (&course.log, course.region);
    let found = excursions(log, region);
    let p_at = |row: usize| log.rows[row].position.map(|position| region.p(position));
    let of_shadow = course.shadow.iter().flatten().flatten().map(|p| p.min(MOST_OF_SHADOW));
    let most = (0..log.rows.len()).filter_map(p_at).chain(of_shadow).fold(LEAST_P, f64::max);
    let axis = TimeAxis::of(log);
    let p_scale = Scale { values: (0.0, 1.06 * most), places: (BOTTOM, TOP) };
    let boundary = p_scale.at(1.0);
    let mut canvas = Canvas::default();
    for (value, label) in p_scale.ticks(4).labelled() {
        canvas.line("grid", (axis.left(), p_scale.at(value)), (axis.right(), p_scale.at(value)));
        if (p_scale.at(value) - boundary).abs() > 12.0 {
            canvas.text("tick", Anchor::End, (axis.left() - 7.0, p_scale.at(value) + 4.0), &label);
        }
    }
    canvas.text("t-region name", Anchor::End, (axis.left() - 7.0, boundary + 4.0), "1");
    axis.draw(&mut canvas, TOP, BOTTOM);
    axis.draw_gaps(&mut canvas, log, TOP, BOTTOM);
    canvas.text("name", Anchor::Start, (axis.left() - 20.0, TOP - 9.0), "P");
    canvas.text("t-region", Anchor::End, (axis.right(), TOP - 9.0), "boundary of the region: P = 1");
    if course.shadow.is_some() {
        let at = (axis.left() + 8.0, TOP - 9.0);
        canvas.text("t-shadow", Anchor::Start, at, "dashed: as it would have been with the paper's schema");
    }

    for excursion in &found {
        axis.draw_span(&mut canvas, log, excursion, TOP, BOTTOM);
        let rows = excursion.first..excursion.end;
        let over: Vec<_> =
            rows.filter_map(|row| Some((axis.at(log.rows[row].time_s), p_scale.at(p_at(row)?)))).collect();
        canvas.path("over", &line::area(&over, boundary));
    }
    let trial_shadow: Option<Vec<Option<Place>>> = course.shadow.as_ref().map(|shadow| {
        let rows = log.rows.iter().zip(shadow);
        rows.map(|(row, p)| p.map(|p| (axis.at(row.time_s), p_scale.at(p.min(most))))).collect()
    });
    let track =
        (0..log.rows.len()).map(|row| p_at(row).map(|p| (axis.at(log.rows[row].time_s), p_scale.at(p))));
    if let Some(shadow) = &trial_shadow {
        canvas.path("shadow", &line::through(shadow.iter().copied()));
    }
    canvas.path("track", &line::through(track));
    canvas.line("bound", (axis.left(), boundary), (axis.right(), boundary));

    let mut places = Vec::with_capacity(found.len());
    for excursion in &found {
        let (from_s, to_s) = span(log, excursion);
        let (from, to) = (axis.at(from_s), axis.at(to_s));
        let open = if excursion.complete { "" } else { " open" };
        canvas.line(&format!("b{open}"), (from, boundary), (to.max(from + 1.0), boundary));
        let peak_row = peak(excursion, &p_at);
        let (x, y) = (axis.at(log.rows[peak_row].time_s), p_scale.at(1.0 + excursion.h));
        canvas.line(&format!("h{open}"), (x, boundary), (x, y));
        places.push(((0.5 * (from + to), boundary), (x, y)));
    }
    write_figures(&mut canvas, &found, &places);
    let description = format!(
        "P over {:.1} s with the boundary at 1. {} excursions, {} of them complete. {}",
        log.duration_s(),
        found.len(),
        found.iter().filter(|excursion| excursion.complete).count(),
        found.iter().map(|excursion| in_words(log, excursion) + ". ").collect::<String>()
    );
    Figure::new(name.to_owned(), (format!("{trial}: P over time"), description), (WIDTH, HEIGHT), canvas)
}

/// The row at which an excursion is farthest out.
pub(super) fn peak(excursion: &Excursion, p_at: &dyn Fn(usize) -> Option<f64>) -> usize {
    let known = (excursion.first..excursion.end).filter_map(|row| Some((row, p_at(row)?)));
    known.max_by(|a, b| a.1.total_cmp(&b.1).then(b.0.cmp(&a.0))).map_or(excursion.first, |(row, _)| row)
}

/// The places of b and h of every excursion, where their figures are written as far as there is room: large
/// excursions first, the largest with the letters.
fn write_figures(canvas: &mut Canvas, found: &[Excursion], places: &[(Place, Place)]) {
    let mut order: Vec<usize> = (0..found.len()).collect();
    let size = |index: usize| found[index].b_s * found[index].h;
    order.sort_by(|a, b| size(*b).total_cmp(&size(*a)));
    let mut taken: Vec<f64> = Vec::new();
    for (rank, index) in order.into_iter().enumerate() {
        let (excursion, (b, h)) = (&found[index], places[index]);
        let room = if rank == 0 { 1.6 * ROOM } else { ROOM };
        let is_seen = b.1 - h.1 > 4.0 || rank == 0;
        if !is_seen || taken.iter().any(|x| (x - b.0).abs() < room) {
            continue;
        }
        taken.push(b.0);
        let (named_h, named_b, unit) = if rank == 0 { ("h ", "b ", " s") } else { ("", "", "") };
        let words = format!("{named_h}{:.2}", excursion.h);
        canvas.text_on_lines("t-out small", Anchor::Middle, (h.0, (h.1 - 4.0).max(9.0)), &words);
        let words = format!("{named_b}{:.1}{unit}", excursion.b_s);
        canvas.text_on_lines("t-out small", Anchor::Middle, (b.0, b.1 + 12.0), &words);
    }
}

/// Room that a figure takes up.
const ROOM: f64 = 27.0;
