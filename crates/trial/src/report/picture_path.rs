//! The path in the picture: image coordinates (x right, y up, pixels), the region, the sectors at 45 degrees, and the
//! excursions.

use super::canvas::{Anchor, Canvas, Place, distance};
use super::figure::Figure;
use super::p_over_time::peak;
use super::scale::{Scale, Ticks};
use super::time_axis::in_words;
use super::{Course, line};
use crate::metrics::{Excursion, excursions};

const WIDTH: f64 = 372.0;
const LEFT: f64 = 40.0;
const TOP: f64 = 22.0;
const MARGIN: f64 = 10.0;
const BELOW: f64 = 24.0;
/// A number takes up so much room.
const APART: f64 = 11.0;
/// No more are numbered.
const MOST_NUMBERED: usize = 24;

/// The figure of a trial.
pub fn figure(name: &str, trial: &str, course: &Course) -> Figure {
    let (log, region) = (&course.log, course.region);
    let found = excursions(log, region);
    let (frame, picture) = (log.frame, log.picture);
    let (half_w, half_h) = (0.5 * f64::from(frame.width), 0.5 * f64::from(frame.height));
    let right = WIDTH - MARGIN;
    let bottom = TOP + (right - LEFT) * half_h / half_w;
    let x_scale = Scale { values: (-half_w, half_w), places: (LEFT, right) };
    let y_scale = Scale { values: (-half_h, half_h), places: (bottom, TOP) };
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
        let why = Some("frame beyond the letter-boxed picture");
        canvas.rect("margin", at(-half_w, half_h), at(half_w, pic_h), why);
        canvas.rect("margin", at(-half_w, -pic_h), at(half_w, -half_h), why);
    }
    if pic_w < half_w {
        let why = Some("frame beyond the letter-boxed picture");
        canvas.rect("margin", at(-half_w, half_h), at(-pic_w, -half_h), why);
        canvas.rect("margin", at(pic_w, half_h), at(half_w, -half_h), why);
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

    let places: Vec<Option<Place>> =
        log.rows.iter().map(|row| row.position.map(|position| at(position.x, position.y))).collect();
    let p_at = |row: usize| log.rows[row].position.map(|position| region.p(position));
    path_with_excursions(&mut canvas, &places, &found, &p_at, &|excursion| in_words(log, excursion));
    for (word, x, y) in [
        ("right", 0.94 * half_w, 0.0),
        ("left", -0.94 * half_w, 0.0),
        ("top", 0.0, 0.9 * pic_h),
        ("bottom", 0.0, -0.9 * pic_h),
    ] {
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

/// A path with its excursions marked and numbered, its start and its end.
pub(super) fn path_with_excursions(
    canvas: &mut Canvas,
    places: &[Option<Place>],
    found: &[Excursion],
    p_at: &dyn Fn(usize) -> Option<f64>,
    in_words: &dyn Fn(&Excursion) -> String,
) {
    canvas.path("track faint", &line::through(places.iter().copied()));
    for excursion in found {
        // From the last place inside to the first one back.
        let rows = excursion.first.saturating_sub(1)..(excursion.end + 1).min(places.len());
        canvas.path("out", &line::through(rows.map(|row| places[row])));
    }
    // Numbered in time; where there is no room for all, the largest ones.
    let mut order: Vec<usize> = (0..found.len()).collect();
    let size = |index: usize| found[index].h * found[index].b_s;
    order.sort_by(|a, b| size(*b).total_cmp(&size(*a)));
    let mut taken: Vec<Place> = Vec::new();
    for index in order {
        let excursion = &found[index];
        let Some(place) = places.get(peak(excursion, p_at)).copied().flatten() else { continue };
        if taken.len() >= MOST_NUMBERED || taken.iter().any(|other| distance(*other, place) < APART) {
            continue;
        }
        taken.push(place);
        canvas.circle("h", place, 1.2, Some(&in_words(excursion)));
        let label = format!("{}", index + 1);
        canvas.text_on_lines("t-out small", Anchor::Middle, (place.0, place.1 - 3.0), &label);
    }
    let mut known = places.iter().flatten();
    if let Some(first) = known.next() {
        canvas.circle("start", *first, 3.2, Some("start"));
        canvas.circle("end", *known.next_back().unwrap_or(first), 3.4, Some("end"));
    }
}
