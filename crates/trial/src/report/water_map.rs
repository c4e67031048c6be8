//! Figure of the water from above as the pilot knew it: the boat's way, the marks with their circles, and
//! what the picture showed at the beginning and at the end (x to the right and y ahead of pan 0, from the
//! point below the camera, m).
//!
//! The frame of reference is the pilot's: where the kite turns and sways unknown to the pilot, it differs
//! from the world's.

use barrelman_vocab::{MarkKind, WaterPoint};

use super::canvas::{Anchor, Canvas, Point};
use super::figure::Figure;
use super::path_data;
use super::plan_view::{PlanView, WIDTH};
use super::reported_trial::TrialTrace;
use crate::logs::{MarkOnWater, WaterLog};

/// The figure of a recording; `None` where no boat was commanded.
pub fn figure(name: &str, trial: &str, trace: &TrialTrace) -> Option<Figure> {
    let water = trace.log.water.as_ref().filter(|water| !water.is_empty())?;
    let view = PlanView::around(extent(water));
    let mut canvas = Canvas::default();
    view.draw_grid(&mut canvas);
    for (class, corners) in ["view open", "view"].iter().zip(water.views.iter().flatten()) {
        canvas.path(class, &path_data::polygon(&view.clipped(&corners.map(pair))));
    }
    view.draw_camera(&mut canvas, (0.0, 0.0));
    for mark in &water.marks {
        draw_mark(&mut canvas, &view, mark);
    }
    let way: Vec<Option<Point>> =
        water.boat.iter().map(|boat| boat.map(|point| view.at(pair(point)))).collect();
    canvas.path("track", &path_data::through(way.iter().copied()));
    let mut known = way.iter().flatten();
    if let Some(first) = known.next() {
        canvas.circle("start", *first, 3.2, Some("start of the boat"));
        canvas.circle("end", *known.next_back().unwrap_or(first), 3.4, Some("end of the boat"));
    }
    let people = water.marks.iter().filter(|mark| mark.kind == MarkKind::Person).count();
    let description = format!(
        "The water as the program knew it, seen from above, {:.1} m by {:.1} m: the boat's way, {} marks ({people} of \
         people) with the circles that the boat keeps out of, and what the picture showed at the beginning (dashed) and at \
         the end.",
        view.size_m.0,
        view.size_m.1,
        water.marks.len()
    );
    let titles = (format!("{trial}: map of the water"), description);
    Some(Figure::new(name.to_owned(), titles, view.paper_size(), canvas))
}

/// Points that the figure has to hold: camera, boat, and marks with their circles.
fn extent(water: &WaterLog) -> impl Iterator<Item = (f64, f64)> {
    let marks = water.marks.iter().flat_map(|mark| {
        let radius = mark.radius_m;
        let around = [(radius, radius), (-radius, -radius)];
        mark.path.iter().flat_map(move |at| around.map(|(x, y)| (at.x + x, at.y + y)))
    });
    let boat = water.boat.iter().flatten().copied().map(pair);
    [(0.0, 0.0)].into_iter().chain(boat).chain(marks)
}

/// Draws the way of a mark, its circle at the end, and its number.
fn draw_mark(canvas: &mut Canvas, view: &PlanView, mark: &MarkOnWater) {
    let Some(last) = mark.path.last() else { return };
    let class = match mark.kind {
        MarkKind::Person | MarkKind::Forbidden => "out",
        MarkKind::Place | MarkKind::WayPoint | MarkKind::Home => "bound",
    };
    let at = view.at(pair(*last));
    let tip = format!("{} {}, known to {:.1} m", mark.kind.key(), mark.id, mark.std_dev_m);
    if mark.radius_m > 0.0 {
        let open = if mark.was_destination { "ring" } else { "ring open" };
        canvas.circle(open, at, mark.radius_m * view.per_m(), Some(&tip));
    }
    canvas.path(
        &format!("{class} faint"),
        &path_data::through(mark.path.iter().map(|point| Some(view.at(pair(*point))))),
    );
    canvas.circle(if mark.was_destination { "end" } else { "start" }, at, 2.6, Some(&tip));
    let name = if mark.was_destination {
        format!("{} {}: destination", mark.kind.key(), mark.id)
    } else {
        format!("{} {}", mark.kind.key(), mark.id)
    };
    let is_near_right = at.0 > WIDTH - 90.0;
    let (anchor, off) = if is_near_right { (Anchor::End, -6.0) } else { (Anchor::Start, 6.0) };
    canvas.text_on_lines("small", anchor, (at.0 + off, at.1 + 3.0), &name);
}

const fn pair(point: WaterPoint) -> (f64, f64) {
    (point.x, point.y)
}
