//! Writes shapes as SVG text.

use std::fmt::Write as _;

use super::text::escape;

/// A point on the paper: x to the right, y down, units of paper.
pub(super) type Point = (f64, f64);

/// Distance between two points.
pub(super) fn distance(from: Point, to: Point) -> f64 {
    let (dx, dy) = (to.0 - from.0, to.1 - from.1);
    (dx * dx + dy * dy).sqrt()
}

/// Which part of a text is at its point.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Anchor {
    Start,
    Middle,
    End,
}

/// SVG text of shapes, in the order of drawing.
#[derive(Debug, Clone, Default)]
pub(super) struct Canvas {
    text: String,
}

/// Formats a coordinate, with one decimal where needed.
pub(super) fn coordinate(value: f64) -> String {
    let value = if value.is_finite() { (value * 10.0).round() / 10.0 } else { 0.0 };
    let text = format!("{:.1}", value + 0.0);
    text.strip_suffix(".0").map_or(text.clone(), str::to_owned)
}

impl Canvas {
    /// The SVG text.
    pub(super) fn into_text(self) -> String {
        self.text
    }

    pub(super) fn line(&mut self, class: &str, from: Point, to: Point) {
        self.write(format_args!(
            "<line class=\"{class}\" x1=\"{}\" y1=\"{}\" x2=\"{}\" y2=\"{}\"/>",
            coordinate(from.0),
            coordinate(from.1),
            coordinate(to.0),
            coordinate(to.1)
        ));
    }

    /// A rectangle between two corners, with an optional tooltip.
    pub(super) fn rect(&mut self, class: &str, from: Point, to: Point, tip: Option<&str>) {
        let (left, top) = (from.0.min(to.0), from.1.min(to.1));
        self.write(format_args!(
            "<rect class=\"{class}\" x=\"{}\" y=\"{}\" width=\"{}\" height=\"{}\"",
            coordinate(left),
            coordinate(top),
            coordinate((to.0 - from.0).abs()),
            coordinate((to.1 - from.1).abs())
        ));
        self.close_element("rect", tip);
    }

    pub(super) fn circle(&mut self, class: &str, at: Point, radius: f64, tip: Option<&str>) {
        let (x, y) = (coordinate(at.0), coordinate(at.1));
        self.write(format_args!(
            "<circle class=\"{class}\" cx=\"{x}\" cy=\"{y}\" r=\"{}\"",
            coordinate(radius)
        ));
        self.close_element("circle", tip);
    }

    pub(super) fn ellipse(&mut self, class: &str, at: Point, radii: Point) {
        self.write(format_args!(
            "<ellipse class=\"{class}\" cx=\"{}\" cy=\"{}\" rx=\"{}\" ry=\"{}\"/>",
            coordinate(at.0),
            coordinate(at.1),
            coordinate(radii.0),
            coordinate(radii.1)
        ));
    }

    /// A path, with data of [`super::path_data`]; nothing where the data is empty.
    pub(super) fn path(&mut self, class: &str, data: &str) {
        if !data.is_empty() {
            self.write(format_args!("<path class=\"{class}\" d=\"{data}\"/>"));
        }
    }

    pub(super) fn text(&mut self, class: &str, anchor: Anchor, at: Point, words: &str) {
        let anchor = match anchor {
            Anchor::Start => "",
            Anchor::Middle => " text-anchor=\"middle\"",
            Anchor::End => " text-anchor=\"end\"",
        };
        let class = if class.is_empty() { String::new() } else { format!(" class=\"{class}\"") };
        let (x, y) = (coordinate(at.0), coordinate(at.1));
        self.write(format_args!("<text{class} x=\"{x}\" y=\"{y}\"{anchor}>{}</text>", escape(words)));
    }

    /// A text that stays readable on lines: on top of its own outline in the colour of the paper.
    pub(super) fn text_on_lines(&mut self, class: &str, anchor: Anchor, at: Point, words: &str) {
        self.text(&format!("{class} halo"), anchor, at, words);
        self.text(class, anchor, at, words);
    }

    fn close_element(&mut self, element: &str, tip: Option<&str>) {
        match tip {
            Some(tip) => self.write(format_args!("><title>{}</title></{element}>", escape(tip))),
            None => self.write(format_args!("/>")),
        }
    }

    fn write(&mut self, shape: core::fmt::Arguments<'_>) {
        // Writing into a string cannot fail.
        let _ = self.text.write_fmt(shape);
    }
}
