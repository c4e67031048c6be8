//! The plot of the reliability curve: above, the share of correct frames over the confidence; below, the frames of each
//! bin.

use super::curve::Bin;
use crate::svg::Svg;

/// Size of the document and edges of both panels, pixels.
const WIDTH: f64 = 520.0;
const HEIGHT: f64 = 620.0;
const LEFT: f64 = 70.0;
const RIGHT: f64 = 490.0;
const CURVE: (f64, f64) = (40.0, 400.0);
const COUNTS: (f64, f64) = (450.0, 560.0);

/// The plot as an SVG document.
pub(super) fn plot(bins: &[Bin]) -> String {
    // The tallest bar leaves room for its count.
    let full_scale = bins.iter().map(|bin| bin.frames).max().unwrap_or(0).max(1) as f64 * 1.2;
    let x = |confidence: f64| LEFT + (RIGHT - LEFT) * confidence;
    let y = |(top, bottom): (f64, f64), share: f64| bottom - (bottom - top) * share;
    let mut out = Svg::new(WIDTH, HEIGHT);
    for step in 0..=5 {
        let share = f64::from(step) / 5.0;
        out.line("grid", [LEFT, y(CURVE, share), RIGHT, y(CURVE, share)]);
        out.line("grid", [x(share), CURVE.0, x(share), CURVE.1]);
        out.text("end", [LEFT - 8.0, y(CURVE, share) + 4.0], &format!("{share:.1}"));
        out.text("middle", [x(share), CURVE.1 + 18.0], &format!("{share:.1}"));
        out.text("middle", [x(share), COUNTS.1 + 18.0], &format!("{share:.1}"));
    }
    out.line("ideal", [x(0.0), y(CURVE, 0.0), x(1.0), y(CURVE, 1.0)]);
    for bin in bins.iter().filter(|bin| bin.frames > 0) {
        let top = y(COUNTS, bin.frames as f64 / full_scale);
        let (left, width) = (x(bin.low) + 2.0, x(bin.high) - x(bin.low) - 4.0);
        out.rectangle("bar", [left, top, width, COUNTS.1 - top]);
        out.text("middle", [left + width / 2.0, top - 4.0], &bin.frames.to_string());
    }
    let points: Vec<[f64; 2]> = bins
        .iter()
        .filter(|bin| bin.frames > 0)
        .map(|bin| [x(bin.mean_confidence()), y(CURVE, bin.share_correct())])
        .collect();
    out.polyline("curve", &points);
    for point in points {
        out.circle("mark", point);
    }
    for (top, bottom) in [CURVE, COUNTS] {
        out.rectangle("axis", [LEFT, top, RIGHT - LEFT, bottom - top]);
    }
    let middle = (LEFT + RIGHT) / 2.0;
    out.text("middle", [middle, 24.0], "Share of reported frames that are right (IoU at least 0.5)");
    out.text("middle", [middle, COUNTS.0 - 10.0], "Frames");
    out.text("middle", [middle, COUNTS.1 + 42.0], "Confidence");
    out.finish()
}
