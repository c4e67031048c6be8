//! Lines, plates and text on a canvas.

use barrelman_vocab::PixelBox;
use tiny_skia::{LineCap, LineJoin, Path, PathBuilder, Rect, Stroke, StrokeDash};

use super::canvas::Canvas;
use super::style::Rgba;

/// Style of a line.
#[derive(Debug, Clone, Copy)]
pub(super) struct Line {
    /// Its colour.
    pub(super) colour: Rgba,
    /// Width relative to the usual line.
    pub(super) weight: f32,
    /// Whether the line is dashed.
    pub(super) dashed: bool,
}

impl Line {
    /// A solid line of the usual width.
    pub(super) const fn new(colour: Rgba) -> Self {
        Self { colour, weight: 1.0, dashed: false }
    }

    /// The line with another weight.
    pub(super) const fn with_weight(self, weight: f32) -> Self {
        Self { weight, ..self }
    }

    /// The line dashed.
    pub(super) const fn dashed(self) -> Self {
        Self { dashed: true, ..self }
    }
}

/// Opacity of the dark casing relative to its line. The casing keeps lines visible on bright water.
const CASING: f32 = 0.55;
/// Opacity of the plates behind text: enough for white letters on foam.
pub(super) const PLATE: f32 = 0.68;

impl Canvas {
    /// Draws a line along a path, on a dark casing.
    pub(super) fn line(&mut self, path: Option<Path>, line: Line) {
        let Some(path) = path else { return };
        let width = self.style.line * line.weight;
        let dash = self.style.scaled(6.0).max(3.0);
        let mut stroke = Stroke {
            width: width + self.style.line.min(2.0),
            line_cap: LineCap::Butt,
            line_join: LineJoin::Miter,
            dash: if line.dashed { StrokeDash::new(vec![dash, dash * 0.8], 0.0) } else { None },
            ..Stroke::default()
        };
        let opacity = f32::from(line.colour.opacity) / 255.0;
        self.layer.stroke(&path, &stroke, Rgba::DARK.with_opacity(CASING * opacity));
        stroke.width = width;
        self.layer.stroke(&path, &stroke, line.colour);
    }

    /// A straight line between two points.
    pub(super) fn segment(&mut self, from: (f32, f32), to: (f32, f32), line: Line) {
        self.line(polyline([from, to], false), line);
    }

    /// A dot with a dark rim.
    pub(super) fn dot(&mut self, (u, v): (f32, f32), radius: f32, colour: Rgba) {
        for (radius, colour) in
            [(radius + self.style.line.min(2.0) / 2.0, Rgba::DARK.with_opacity(CASING)), (radius, colour)]
        {
            if let Some(path) = PathBuilder::from_circle(u, v, radius) {
                self.layer.fill(&path, colour);
            }
        }
    }

    /// A dark translucent plate with rounded corners.
    pub(super) fn plate(&mut self, place: PixelBox) {
        self.rounded(place, Rgba::DARK.with_opacity(PLATE));
    }

    /// A filled box with rounded corners.
    pub(super) fn rounded(&mut self, place: PixelBox, colour: Rgba) {
        let radius = self.style.scaled(5.0).min(place.h.min(place.w) as f32 / 2.0);
        if let Some(path) = rounded_box(place, radius) {
            self.layer.fill(&path, colour);
        }
    }

    /// Size of a plate around a text.
    pub(super) fn plate_size(&self, text: &str) -> (f64, f64) {
        let size = self.style.text_px;
        (f64::from(self.type_face.width(text, size)) + f64::from(size) * 0.8, f64::from(size) * 1.3)
    }

    /// Text, centred in a box.
    pub(super) fn centred_text(&mut self, text: &str, place: PixelBox, colour: Rgba) {
        let size = self.style.text_px;
        let middle = place.centre();
        let u = middle.u as f32 - self.type_face.width(text, size) / 2.0;
        self.text(text, (u, middle.v as f32), colour);
    }

    /// Text with its left end at `u` and the middle of its capitals at `middle`; returns where it ends.
    pub(super) fn text(&mut self, text: &str, (u, middle): (f32, f32), colour: Rgba) -> f32 {
        let size = self.style.text_px;
        let baseline = middle + self.type_face.capital_height(size) / 2.0;
        self.type_face.draw(&mut self.layer, text, (u, baseline), (size, colour))
    }
}

/// A path through points.
pub(super) fn polyline(points: impl IntoIterator<Item = (f32, f32)>, closed: bool) -> Option<Path> {
    let mut path = PathBuilder::new();
    for (index, (u, v)) in points.into_iter().enumerate() {
        if index == 0 {
            path.move_to(u, v);
        } else {
            path.line_to(u, v);
        }
    }
    if closed {
        path.close();
    }
    path.finish()
}

/// The path of an axis-aligned box.
pub(super) fn upright(place: PixelBox) -> Option<Path> {
    rect(place).map(PathBuilder::from_rect)
}

fn rect(place: PixelBox) -> Option<Rect> {
    Rect::from_xywh(place.u as f32, place.v as f32, place.w as f32, place.h as f32)
}

fn rounded_box(place: PixelBox, radius: f32) -> Option<Path> {
    let rect = rect(place)?;
    let (left, top, right, bottom) = (rect.left(), rect.top(), rect.right(), rect.bottom());
    let mut path = PathBuilder::new();
    path.move_to(left + radius, top);
    path.line_to(right - radius, top);
    path.quad_to(right, top, right, top + radius);
    path.line_to(right, bottom - radius);
    path.quad_to(right, bottom, right - radius, bottom);
    path.line_to(left + radius, bottom);
    path.quad_to(left, bottom, left, bottom - radius);
    path.line_to(left, top + radius);
    path.quad_to(left, top, left + radius, top);
    path.close();
    path.finish()
}
