//! The plot of the reliability curve: above, the share of correct frames over the confidence, with the
//! differences that are allowed; below, the frames of each tenth.

use super::calibration::{Calibration, MAX_CALIBRATION_ERROR, MIN_JUDGED_FRAMES};
use super::curve::{Bin, Curve};
use crate::svg::Svg;

/// Size of the document and edges of both panels, pixels.
const WIDTH: f64 = 520.0;
const HEIGHT: f64 = 660.0;
const LEFT: f64 = 70.0;
const RIGHT: f64 = 490.0;
const CURVE: (f64, f64) = (40.0, 400.0);
const COUNTS: (f64, f64) = (450.0, 560.0);

fn x(confidence: f64) -> f64 {
    LEFT + (RIGHT - LEFT) * confidence
}

fn y((top, bottom): (f64, f64), share: f64) -> f64 {
    bottom - (bottom - top) * share
}

/// The plot as an SVG document: the exact selections, and the loose ones where they were measured.
pub(super) fn plot(exact: &Calibration, loose: Option<&Calibration>) -> String {
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
    let allowed = MAX_CALIBRATION_ERROR;
    out.line("grid", [x(allowed), y(CURVE, 0.0), x(1.0), y(CURVE, 1.0 - allowed)]);
    out.line("grid", [x(0.0), y(CURVE, allowed), x(1.0 - allowed), y(CURVE, 1.0)]);
    plot_counts(&mut out, &exact.curve);
    if let Some(loose) = loose {
        plot_curve(&mut out, &loose.curve, "other", "other-mark");
    }
    plot_curve(&mut out, &exact.curve, "curve", "mark");
    for (top, bottom) in [CURVE, COUNTS] {
        out.rectangle("axis", [LEFT, top, RIGHT - LEFT, bottom - top]);
    }
    let middle = f64::midpoint(LEFT, RIGHT);
    out.text("middle", [middle, 24.0], "Share of reported frames that are right (IoU at least 0.5)");
    out.text("middle", [middle, COUNTS.0 - 10.0], "Frames");
    out.text("middle", [middle, COUNTS.1 + 42.0], "Confidence");
    out.text("middle", [WIDTH / 2.0, COUNTS.1 + 66.0], &legend("exact (blue)", exact));
    if let Some(loose) = loose {
        out.text("middle", [WIDTH / 2.0, COUNTS.1 + 86.0], &legend("loose (brown)", loose));
    }
    out.finish()
}

fn legend(name: &str, figures: &Calibration) -> String {
    let wrong = 100.0 * figures.sure_and_wrong_share();
    format!(
        "{name}: {wrong:.2} % sure and wrong, {:.2} of the right sure, AUROC {:.3}",
        figures.correct_sure_share, figures.auroc
    )
}

fn with_frames(curve: &Curve) -> impl Iterator<Item = &Bin> {
    curve.bins.iter().filter(|bin| bin.frames > 0)
}

/// The bars below; paler where there are too few frames for a judgement.
fn plot_counts(out: &mut Svg, curve: &Curve) {
    // The tallest bar leaves room for its count.
    let full_scale = curve.bins.iter().map(|bin| bin.frames).max().unwrap_or(0).max(1) as f64 * 1.2;
    for bin in with_frames(curve) {
        let top = y(COUNTS, bin.frames as f64 / full_scale);
        let (left, width) = (x(bin.low) + 2.0, x(bin.high) - x(bin.low) - 4.0);
        let class = if bin.frames >= MIN_JUDGED_FRAMES { "bar" } else { "pale-bar" };
        out.rectangle(class, [left, top, width, COUNTS.1 - top]);
        out.text("middle", [left + width / 2.0, top - 4.0], &bin.frames.to_string());
    }
}

fn plot_curve(out: &mut Svg, curve: &Curve, line: &str, mark: &str) {
    let points: Vec<[f64; 2]> =
        with_frames(curve).map(|bin| [x(bin.mean_confidence()), y(CURVE, bin.share_correct())]).collect();
    out.polyline(line, &points);
    for point in points {
        out.circle(mark, point);
    }
}
