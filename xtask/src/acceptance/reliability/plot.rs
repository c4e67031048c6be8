//! The reliability curve as a picture: share of right frames over confidence above, frames in each bin below.

use std::fmt::Write;

use super::Bin;

/// Outer size and the edges of both plots, pixels.
const WIDTH: f64 = 520.0;
const HEIGHT: f64 = 620.0;
const LEFT: f64 = 70.0;
const RIGHT: f64 = 490.0;
const CURVE: (f64, f64) = (40.0, 400.0);
const COUNTS: (f64, f64) = (450.0, 560.0);

const STYLE: &str = "<style>text{font:13px sans-serif;fill:#222}.grid{stroke:#ddd}.axis{stroke:#222;fill:none}\
                     .ideal{stroke:#999;stroke-dasharray:5 4}.bar{fill:#b9c9dc}.curve{stroke:#1f4e8c;stroke-width:2;\
                     fill:none}.mark{fill:#1f4e8c}.end{text-anchor:end}.middle{text-anchor:middle}</style>";

/// An SVG document.
pub(super) fn svg(bins: &[Bin]) -> String {
    // The tallest bar leaves room for its number.
    let full = bins.iter().map(|bin| bin.frames).max().unwrap_or(0).max(1) as f64 * 1.2;
    let x = |confidence: f64| LEFT + (RIGHT - LEFT) * confidence;
    let y = |(top, bottom): (f64, f64), share: f64| bottom - (bottom - top) * share;
    let mut out = Svg(String::new());
    out.add(&format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{WIDTH}\" height=\"{HEIGHT}\" viewBox=\"0 0 {WIDTH} {HEIGHT}\">"
    ));
    out.add(STYLE);
    out.add("<rect width=\"100%\" height=\"100%\" fill=\"white\"/>");
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
        let top = y(COUNTS, bin.frames as f64 / full);
        let (left, width) = (x(bin.low) + 2.0, x(bin.high) - x(bin.low) - 4.0);
        out.add(&format!(
            "<rect class=\"bar\" x=\"{left:.1}\" y=\"{top:.1}\" width=\"{width:.1}\" height=\"{:.1}\"/>",
            COUNTS.1 - top
        ));
        out.text("middle", [left + width / 2.0, top - 4.0], &bin.frames.to_string());
    }
    let points: Vec<[f64; 2]> = bins
        .iter()
        .filter(|bin| bin.frames > 0)
        .map(|bin| [x(bin.confidence()), y(CURVE, bin.share())])
        .collect();
    let path: Vec<String> = points.iter().map(|[x, y]| format!("{x:.1},{y:.1}")).collect();
    out.add(&format!("<polyline class=\"curve\" points=\"{}\"/>", path.join(" ")));
    for [x, y] in points {
        out.add(&format!("<circle class=\"mark\" cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"4\"/>"));
    }
    for (top, bottom) in [CURVE, COUNTS] {
        let (width, height) = (RIGHT - LEFT, bottom - top);
        out.add(&format!(
            "<rect class=\"axis\" x=\"{LEFT}\" y=\"{top}\" width=\"{width}\" height=\"{height}\"/>"
        ));
    }
    let middle = (LEFT + RIGHT) / 2.0;
    out.text("middle", [middle, 24.0], "Share of reported frames that are right (IoU at least 0.5)");
    out.text("middle", [middle, COUNTS.0 - 10.0], "Frames");
    out.text("middle", [middle, COUNTS.1 + 42.0], "Confidence");
    out.add("</svg>");
    out.0
}

struct Svg(String);

impl Svg {
    fn add(&mut self, element: &str) {
        // Writing to a string does not fail.
        let _ = writeln!(self.0, "{element}");
    }

    fn line(&mut self, class: &str, [x1, y1, x2, y2]: [f64; 4]) {
        self.add(&format!(
            "<line class=\"{class}\" x1=\"{x1:.1}\" y1=\"{y1:.1}\" x2=\"{x2:.1}\" y2=\"{y2:.1}\"/>"
        ));
    }

    fn text(&mut self, class: &str, [x, y]: [f64; 2], text: &str) {
        self.add(&format!("<text class=\"{class}\" x=\"{x:.1}\" y=\"{y:.1}\">{text}</text>"));
    }
}
