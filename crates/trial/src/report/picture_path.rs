//! Figure of the path in the picture: image coordinates (x right, y up, pixels), the region, the sectors at
//! 45 degrees, and the excursions.

use super::canvas::{Anchor, Canvas, Point, distance};
use super::figure::Figure;
use super::p_over_time::peak_row;
use super::path_data;
use super::plan_view::{BELOW, LEFT, MARGIN, TOP, WIDTH};
use super::reported_trial::TrialTrace;
use super::scale::{Scale, Ticks};
use super::time_axis::describe;
use crate::metrics::{Excursion, find_excursions};

/// Smallest distance between two excursion numbers.
const MIN_NUMBER_DISTANCE: f64 = 11.0;
/// Upper bound of the numbered excursions.
const MAX_NUMBERED: usize = 24;

/// The figure of a trial.
pub fn figure(name: &str, trial: &str, trace: &TrialTrace) -> Figure {
    let (log, region) = (&trace.log, trace.region);
    let found = find_excursions(log, region);
    let (frame, picture) = (log.frame, log.picture);
    let (half_w, half_h) = (0.5 * f64::from(frame.width), 0.5 * f64::from(frame.height));
    let right = WIDTH - MARGIN;
    let bottom = TOP + (right - LEFT) * half_h / half_w;
    let x_scale = Scale { values: (-half_w, half_w), paper: (LEFT, right) };
    let y_scale = Scale { values: (-half_h, half_h), paper: (bottom, TOP) };
    let at = |x: f64, y: f64| (x_scale.at(x), y_scale.at(y));
    let mut canvas = Canvas::default();
    for (value, label) in Ticks::within(-half_w, half_w, 6).labelled() {
        canvas.line("grid", (x_scale.at(value), bottom), (x_scale.at(value), bottom + 4.0));
        canvas.text("tick", Anchor::Middle, (x_scale.at(value), bottom + 16.0), &label);
    }
    for (value, label) in Ticks::within(-half_h, half_h, 5).labelled() {
        canvas.line("grid", (LEFT - 4.0, y_scale.at(value)), (LEFT, y_scale.at(value)));
        canvas.text("tick", Anchor::End, (LEFT - 7.0, y_scale.at(value) + 4.0), &label);
    }
    canvas.text("unit", Anchor::Start, (LEFT - 32.0, TOP - 9.0), "y, px");
    canvas.text("unit", Anchor::End, (right, TOP - 9.0), "x, px");
    let (pic_w, pic_h) = (0.5 * f64::from(picture.width), 0.5 * f64::from(picture.height));
    if pic_h < half_h {
        let tip = Some("frame beyond the letter-boxed picture");
        canvas.rect("margin", at(-half_w, half_h), at(half_w, pic_h), tip);
        canvas.rect("margin", at(-half_w, -pic_h), at(half_w, -half_h), tip);
    }
    if pic_w < half_w {
        let tip = Some("frame beyond the letter-boxed picture");
        canvas.rect("margin", at(-half_w, half_h), at(-pic_w, -half_h), tip);
        canvas.rect("margin", at(pic_w, half_h), at(half_w, -half_h), tip);
    }
    canvas.rect("frame", at(-half_w, half_h), at(half_w, -half_h), None);
    let reach = half_w.min(half_h);
    canvas.line("sector", at(-reach, -reach), at(reach, reach));
    canvas.line("sector", at(-reach, reach), at(reach, -reach));
    canvas.ellipse(
        "region",
        at(0.0, 0.0),
        (region.a_px * x_scale.per_value(), region.b_px * y_scale.per_value()),
    );

    let points: Vec<Option<Point>> =
        log.rows.iter().map(|row| row.position.map(|position| at(position.x, position.y))).collect();
    let p_at = |row: usize| log.rows[row].position.map(|position| region.p(position));
    draw_path(&mut canvas, &points, &found, &p_at, &|excursion| describe(log, excursion));
    name_sectors(&mut canvas, (0.94 * half_w, 0.9 * pic_h), &at);
    let description = format!(
        "Where the target was in a frame of {frame}, with the elliptical region of {:.0} by {:.0} px half axes, the \
         sectors at 45 degrees, and {} excursions.",
        region.a_px,
        region.b_px,
        found.len()
    );
    let titles = (format!("{trial}: path in the picture"), description);
    Figure::new(name.to_owned(), titles, (WIDTH, bottom + BELOW), canvas)
}

/// Names the sectors, at these distances from the centre along x and y.
fn name_sectors(canvas: &mut Canvas, (far_x, far_y): Point, at: &dyn Fn(f64, f64) -> Point) {
    for (word, x, y) in
        [("right", far_x, 0.0), ("left", -far_x, 0.0), ("top", 0.0, far_y), ("bottom", 0.0, -far_y)]
    {
        let anchor = if x > 0.0 {
            Anchor::End
        } else if x < 0.0 {
            Anchor::Start
        } else {
            Anchor::Middle
        };
        let (x, y) = at(x, y);
        canvas.text_on_lines("unit small", anchor, (x, y + 3.0), word);
    }
}

/// Draws a path with its excursions marked and numbered, its start and its end.
pub(super) fn draw_path(
    canvas: &mut Canvas,
    points: &[Option<Point>],
    found: &[Excursion],
    p_at: &dyn Fn(usize) -> Option<f64>,
    describe: &dyn Fn(&Excursion) -> String,
) {
    canvas.path("track faint", &path_data::through(points.iter().copied()));
    for excursion in found {
        // From the last point inside to the first one back inside.
        let rows = excursion.first.saturating_sub(1)..(excursion.end + 1).min(points.len());
        canvas.path("out", &path_data::through(rows.map(|row| points[row])));
    }
    // Numbers in the order of time; where there is no room for all, those of the largest excursions.
    let mut order: Vec<usize> = (0..found.len()).collect();
    let area = |index: usize| found[index].h * found[index].b_s;
    order.sort_by(|a, b| area(*b).total_cmp(&area(*a)));
    let mut numbered: Vec<Point> = Vec::new();
    for index in order {
        let excursion = &found[index];
        let Some(point) = points.get(peak_row(excursion, p_at)).copied().flatten() else { continue };
        if numbered.len() >= MAX_NUMBERED
            || numbered.iter().any(|other| distance(*other, point) < MIN_NUMBER_DISTANCE)
        {
            continue;
        }
        numbered.push(point);
        canvas.circle("h", point, 1.2, Some(&describe(excursion)));
        let label = format!("{}", index + 1);
        canvas.text_on_lines("t-out small", Anchor::Middle, (point.0, point.1 - 3.0), &label);
    }
    let mut known = points.iter().flatten();
    if let Some(first) = known.next() {
        canvas.circle("start", *first, 3.2, Some("start"));
        canvas.circle("end", *known.next_back().unwrap_or(first), 3.4, Some("end"));
    }
}
