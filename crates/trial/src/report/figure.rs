//! A figure as SVG text, for a file or within a page.

use super::canvas::{Canvas, coordinate};
use super::style;
use super::text::escape;

/// A figure of a report.
#[derive(Debug, Clone, PartialEq)]
pub struct Figure {
    /// Name of the file, without extension.
    pub name: String,
    /// Title.
    pub title: String,
    /// Description for readers who cannot see the figure.
    pub description: String,
    /// Width, units of paper (SVG user units).
    pub width: f64,
    /// Height, units of paper.
    pub height: f64,
    body: String,
}

impl Figure {
    pub(super) fn new(
        name: String,
        (title, description): (String, String),
        (width, height): (f64, f64),
        canvas: Canvas,
    ) -> Self {
        Self { name, title, description, width, height, body: canvas.into_text() }
    }

    /// A complete SVG file; its style follows the reader's light or dark scheme.
    pub fn svg(&self) -> String {
        let (width, height) = (coordinate(self.width), coordinate(self.height));
        format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{width}\" height=\"{height}\" class=\"fig\" {}>\
             <title>{}</title><desc>{}</desc>\n<style>{}</style>\n\
             <rect class=\"sheet\" width=\"{width}\" height=\"{height}\"/>{}</svg>\n",
            self.view_box(),
            escape(&self.title),
            escape(&self.description),
            // No rule contains < or &: it needs no escaping.
            style::light_and_dark(),
            self.body
        )
    }

    /// An SVG element for a page that contains the style. The title is a label: a title element would appear
    /// as a tooltip over the whole figure.
    pub fn inline(&self) -> String {
        format!(
            "<svg class=\"fig\" style=\"max-width:{}px\" aria-label=\"{}\" {}><desc>{}</desc>{}</svg>",
            coordinate(self.width),
            escape(&self.title),
            self.view_box(),
            escape(&self.description),
            self.body
        )
    }

    fn view_box(&self) -> String {
        format!("viewBox=\"0 0 {} {}\" role=\"img\"", coordinate(self.width), coordinate(self.height))
    }
}
