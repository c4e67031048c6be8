//! A figure: SVG text, by itself or within a page.

use super::canvas::{Canvas, coordinate};
use super::style;
use super::text::escaped;

/// A figure.
#[derive(Debug, Clone, PartialEq)]
pub struct Figure {
    /// Its file's name, without the ending.
    pub name: String,
    /// What it shows, in a few words.
    pub title: String,
    /// What is to be seen in it, for those who do not see it.
    pub description: String,
    /// Width, units of paper.
    pub width: f64,
    /// Height.
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

    /// As a file of its own, by day, and by night where the reader's screen is dark.
    pub fn svg(&self) -> String {
        let (width, height) = (coordinate(self.width), coordinate(self.height));
        format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{width}\" height=\"{height}\" class=\"fig\" {}>\
             <title>{}</title><desc>{}</desc>\n<style>{}</style>\n\
             <rect class=\"sheet\" width=\"{width}\" height=\"{height}\"/>{}</svg>\n",
            self.view(),
            escaped(&self.title),
            escaped(&self.description),
            // No rule has a < or an & in it.
            style::by_day_and_night(),
            self.body
        )
    }

    /// Within a page that has the style. Its title is a label: a page would show it wherever one points.
    pub fn inline(&self) -> String {
        format!(
            "<svg class=\"fig\" style=\"max-width:{}px\" aria-label=\"{}\" {}><desc>{}</desc>{}</svg>",
            coordinate(self.width),
            escaped(&self.title),
            self.view(),
            escaped(&self.description),
            self.body
        )
    }

    fn view(&self) -> String {
        format!("viewBox=\"0 0 {} {}\" role=\"img\"", coordinate(self.width), coordinate(self.height))
    }
}
