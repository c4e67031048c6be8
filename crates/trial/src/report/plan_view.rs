//! The paper of a figure seen from above: equal scales along both axes in metres, with a grid.

use super::canvas::{Anchor, Canvas, Point};
use super::path_data;
use super::scale::Scale;

/// Width of a figure, and what it leaves free around the drawing, units of paper. The path in the picture has
/// the same: the page shows them beside each other.
pub(super) const WIDTH: f64 = 372.0;
pub(super) const LEFT: f64 = 40.0;
pub(super) const TOP: f64 = 22.0;
pub(super) const MARGIN: f64 = 10.0;
pub(super) const BELOW: f64 = 24.0;
/// Largest height of the drawing; the smallest is a third of it.
const MAX_HEIGHT: f64 = 340.0;

/// Scales of a view from above: x to the right, y up, metres.
#[derive(Debug, Clone, Copy)]
pub(super) struct PlanView {
    x: Scale,
    y: Scale,
    bottom: f64,
    /// Width and height that hold all points, metres.
    pub(super) size_m: (f64, f64),
}

impl PlanView {
    /// A view of all these points (metres), with a margin.
    pub(super) fn around(points: impl IntoIterator<Item = (f64, f64)>) -> Self {
        let mut points = points.into_iter().filter(|(x, y)| x.is_finite() && y.is_finite());
        let first = points.next().unwrap_or_default();
        let (low, high) = points.fold((first, first), |(low, high), (x, y)| {
            ((f64::min(low.0, x), f64::min(low.1, y)), (f64::max(high.0, x), f64::max(high.1, y)))
        });
        let margin_m = 0.05 * (high.0 - low.0).max(high.1 - low.1).max(1.0);
        let (width_m, height_m) = (high.0 - low.0 + 2.0 * margin_m, high.1 - low.1 + 2.0 * margin_m);
        let width_px = WIDTH - MARGIN - LEFT;
        let per_m = (width_px / width_m).min(MAX_HEIGHT / height_m);
        let height_px = (height_m * per_m).max(MAX_HEIGHT / 3.0);
        let bottom = TOP + height_px;
        let (middle_x, middle_y) = (0.5 * (low.0 + high.0), 0.5 * (low.1 + high.1));
        let half = (0.5 * width_px / per_m, 0.5 * height_px / per_m);
        Self {
            x: Scale { values: (middle_x - half.0, middle_x + half.0), paper: (LEFT, WIDTH - MARGIN) },
            y: Scale { values: (middle_y - half.1, middle_y + half.1), paper: (bottom, TOP) },
            bottom,
            size_m: (width_m, height_m),
        }
    }

    /// Where a point (metres) is on the paper.
    pub(super) fn at(&self, (x, y): (f64, f64)) -> Point {
        (self.x.at(x), self.y.at(y))
    }

    /// Units of paper per metre.
    pub(super) fn per_m(&self) -> f64 {
        self.x.per_value()
    }

    /// Width and height of the figure, units of paper.
    pub(super) const fn paper_size(&self) -> (f64, f64) {
        (WIDTH, self.bottom + BELOW)
    }

    /// Draws grid, ticks, frame and units.
    pub(super) fn draw_grid(&self, canvas: &mut Canvas) {
        for (value, label) in self.x.ticks(6).labelled() {
            canvas.line("grid", (self.x.at(value), TOP), (self.x.at(value), self.bottom));
            canvas.text("tick", Anchor::Middle, (self.x.at(value), self.bottom + 16.0), &label);
        }
        for (value, label) in self.y.ticks(5).labelled() {
            canvas.line("grid", (LEFT, self.y.at(value)), (WIDTH - MARGIN, self.y.at(value)));
            canvas.text("tick", Anchor::End, (LEFT - 7.0, self.y.at(value) + 4.0), &label);
        }
        canvas.rect("frame", (LEFT, TOP), (WIDTH - MARGIN, self.bottom), None);
        canvas.text("unit", Anchor::Start, (LEFT - 32.0, TOP - 9.0), "y, m");
        canvas.text("unit", Anchor::End, (WIDTH - MARGIN, TOP - 9.0), "x, m");
    }

    /// Draws the camera as a small triangle with its name.
    pub(super) fn draw_camera(&self, canvas: &mut Canvas, camera: (f64, f64)) {
        let (x, y) = self.at(camera);
        let corners = [(x - 5.0, y + 4.0), (x, y - 5.0), (x + 5.0, y + 4.0), (x - 5.0, y + 4.0)];
        canvas.path("mean", &path_data::through(corners.map(Some)));
        let (anchor, off) = if x > WIDTH - 90.0 { (Anchor::End, -9.0) } else { (Anchor::Start, 9.0) };
        canvas.text_on_lines("small", anchor, (x + off, y + 4.0), "camera");
    }

    /// The part of a polygon (metres) that the view shows, on the paper: clipped at each border after the
    /// other (`sutherland1974`).
    pub(super) fn clipped(&self, polygon: &[(f64, f64)]) -> Vec<Point> {
        let ((left, right), (low, high)) = (self.x.values, self.y.values);
        // Distance within each border.
        let within: [&dyn Fn((f64, f64)) -> f64; 4] =
            [&|p| p.0 - left, &|p| right - p.0, &|p| p.1 - low, &|p| high - p.1];
        let mut kept = polygon.to_vec();
        for inside in within {
            let corners = core::mem::take(&mut kept);
            for (index, end) in corners.iter().enumerate() {
                let start = corners[(index + corners.len() - 1) % corners.len()];
                let (from, to) = (inside(start), inside(*end));
                if (from < 0.0) != (to < 0.0) {
                    let share = from / (from - to);
                    kept.push((start.0 + share * (end.0 - start.0), start.1 + share * (end.1 - start.1)));
                }
                if to >= 0.0 {
                    kept.push(*end);
                }
            }
        }
        kept.into_iter().map(|corner| self.at(corner)).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn both_axes_have_the_same_scale() {
        let view = PlanView::around([(0.0, 0.0), (30.0, 4.0)]);
        let ((x0, y0), (x1, y1)) = (view.at((0.0, 0.0)), view.at((1.0, 1.0)));
        assert!((x1 - x0 - view.per_m()).abs() < 1e-9 && (y0 - y1 - view.per_m()).abs() < 1e-9);
    }

    #[test]
    fn a_polygon_is_cut_at_the_borders() {
        let view = PlanView::around([(0.0, 0.0), (10.0, 10.0)]);
        let all = view.clipped(&[(2.0, 2.0), (2.0, 4.0), (4.0, 4.0)]);
        assert_eq!(all.len(), 3);
        let far = view.clipped(&[(5.0, 5.0), (5.0, 500.0), (500.0, 5.0)]);
        let (right, top) = (WIDTH - MARGIN, TOP);
        assert!(far.iter().all(|(x, y)| *x <= right + 1e-6 && *y >= top - 1e-6), "{far:?}");
        assert!(far.len() >= 4, "{far:?}");
        assert!(view.clipped(&[(50.0, 50.0), (60.0, 50.0), (60.0, 60.0)]).is_empty());
    }
}
