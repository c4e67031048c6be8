//! Shapes as SVG text.

use std::fmt::Write as _;

use super::text::escaped;

/// A place on paper.
pub(super) type Place = (f64, f64);

/// From one place to another.
pub(super) fn distance(from: Place, to: Place) -> f64 {
    let (dx, dy) = (to.0 - from.0, to.1 - from.1);
    (dx * dx + dy * dy).sqrt()
}

/// Where a text lies about its place.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Anchor {
    Start,
    Middle,
    End,
}

/// Shapes, one after the other.
#[derive(Debug, Clone, Default)]
pub(super) struct Canvas {
    text: String,
}

/// A coordinate: tenths are as fine as eyes are.
pub(super) fn coordinate(value: f64) -> String {
    let value = if value.is_finite() { (value * 10.0).round() / 10.0 } else { 0.0 };
    let text = format!("{:.1}", value + 0.0);
    text.strip_suffix(".0").map_or(text.clone(), str::to_owned)
}

impl Canvas {
    /// What was drawn.
    pub(super) fn into_text(self) -> String {
        self.text
    }

    pub(super) fn line(&mut self, class: &str, from: Place, to: Place) {
        self.put(format_args!(
            "<line class=\"{class}\" x1=\"{}\" y1=\"{}\" x2=\"{}\" y2=\"{}\"/>",
            coordinate(from.0),
            coordinate(from.1),
            coordinate(to.0),
            coordinate(to.1)
        ));
    }

    /// A rectangle between two corners, with a text that shows when it is pointed at.
    pub(super) fn rect(&mut self, class: &str, from: Place, to: Place, tip: Option<&str>) {
        let (left, top) = (from.0.min(to.0), from.1.min(to.1));
        self.put(format_args!(
            "<rect class=\"{class}\" x=\"{}\" y=\"{}\" width=\"{}\" height=\"{}\"",
            coordinate(left),
            coordinate(top),
            coordinate((to.0 - from.0).abs()),
            coordinate((to.1 - from.1).abs())
        ));
        self.close("rect", tip);
    }

    pub(super) fn circle(&mut self, class: &str, at: Place, radius: f64, tip: Option<&str>) {
        let (x, y) = (coordinate(at.0), coordinate(at.1));
        self.put(format_args!(
            "<circle class=\"{class}\" cx=\"{x}\" cy=\"{y}\" r=\"{}\"",
            coordinate(radius)
        ));
        self.close("circle", tip);
    }

    pub(super) fn ellipse(&mut self, class: &str, at: Place, radii: Place) {
        self.put(format_args!(
            "<ellipse class=\"{class}\" cx=\"{}\" cy=\"{}\" rx=\"{}\" ry=\"{}\"/>",
            coordinate(at.0),
            coordinate(at.1),
            coordinate(radii.0),
            coordinate(radii.1)
        ));
    }

    /// A path of data as in [`super::line`]; nothing where there is none.
    pub(super) fn path(&mut self, class: &str, data: &str) {
        if !data.is_empty() {
            self.put(format_args!("<path class=\"{class}\" d=\"{data}\"/>"));
        }
    }

    pub(super) fn text(&mut self, class: &str, anchor: Anchor, at: Place, words: &str) {
        let anchor = match anchor {
            Anchor::Start => "",
            Anchor::Middle => " text-anchor=\"middle\"",
            Anchor::End => " text-anchor=\"end\"",
        };
        let class = if class.is_empty() { String::new() } else { format!(" class=\"{class}\"") };
        let (x, y) = (coordinate(at.0), coordinate(at.1));
        self.put(format_args!("<text{class} x=\"{x}\" y=\"{y}\"{anchor}>{}</text>", escaped(words)));
    }

    /// A text that stays readable on lines: drawn on its own outline in the colour of the paper.
    pub(super) fn text_on_lines(&mut self, class: &str, anchor: Anchor, at: Place, words: &str) {
        self.text(&format!("{class} halo"), anchor, at, words);
        self.text(class, anchor, at, words);
    }

    fn close(&mut self, element: &str, tip: Option<&str>) {
        match tip {
            Some(tip) => self.put(format_args!("><title>{}</title></{element}>", escaped(tip))),
            None => self.put(format_args!("/>")),
        }
    }

    fn put(&mut self, what: core::fmt::Arguments<'_>) {
        // Writing into a string cannot fail.
        let _ = self.text.write_fmt(what);
    }
}
