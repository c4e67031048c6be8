//! Plots as SVG: lines, polylines, rectangles, circles and text.

use std::fmt::Write as _;
use std::path::Path;

use anyhow::{Context, Result};

use crate::output::print_line;
use crate::workspace::workspace_root;

const STYLE: &str = "<style>text{font:13px sans-serif;fill:#222}.grid{stroke:#ddd}.axis{stroke:#222;fill:none}\
                     .ideal{stroke:#999;stroke-dasharray:5 4}.bar{fill:#b9c9dc}.pale-bar{fill:#e3e9f0}.curve{stroke:#1f4e8c;stroke-width:2;\
                     fill:none}.mark{fill:#1f4e8c}.other{stroke:#b3541e;stroke-width:2;fill:none}\
                     .other-mark{fill:#b3541e}.end{text-anchor:end}.middle{text-anchor:middle}</style>";

/// An SVG document to which elements are appended. Coordinates are pixels from the upper left corner.
pub(crate) struct Svg(String);

impl Svg {
    /// A white document of this size, pixels.
    pub(crate) fn new(width: f64, height: f64) -> Self {
        let mut svg = Self(String::new());
        svg.add(&format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{width}\" height=\"{height}\" viewBox=\"0 0 {width} {height}\">"
        ));
        svg.add(STYLE);
        svg.add("<rect width=\"100%\" height=\"100%\" fill=\"white\"/>");
        svg
    }

    /// Closes the document and returns its text.
    pub(crate) fn finish(mut self) -> String {
        self.add("</svg>");
        self.0
    }

    fn add(&mut self, element: &str) {
        // Writing to a string does not fail.
        let _ = writeln!(self.0, "{element}");
    }

    pub(crate) fn line(&mut self, class: &str, [x1, y1, x2, y2]: [f64; 4]) {
        self.add(&format!(
            "<line class=\"{class}\" x1=\"{x1:.1}\" y1=\"{y1:.1}\" x2=\"{x2:.1}\" y2=\"{y2:.1}\"/>"
        ));
    }

    pub(crate) fn polyline(&mut self, class: &str, points: &[[f64; 2]]) {
        let path: Vec<String> = points.iter().map(|[x, y]| format!("{x:.1},{y:.1}")).collect();
        self.add(&format!("<polyline class=\"{class}\" points=\"{}\"/>", path.join(" ")));
    }

    /// A rectangle given by left, top, width and height.
    pub(crate) fn rectangle(&mut self, class: &str, [x, y, width, height]: [f64; 4]) {
        self.add(&format!(
            "<rect class=\"{class}\" x=\"{x:.1}\" y=\"{y:.1}\" width=\"{width:.1}\" height=\"{height:.1}\"/>"
        ));
    }

    pub(crate) fn circle(&mut self, class: &str, [x, y]: [f64; 2]) {
        self.add(&format!("<circle class=\"{class}\" cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"4\"/>"));
    }

    pub(crate) fn text(&mut self, class: &str, [x, y]: [f64; 2], text: &str) {
        self.add(&format!("<text class=\"{class}\" x=\"{x:.1}\" y=\"{y:.1}\">{text}</text>"));
    }
}

/// Writes a plot to `target/acceptance/NAME` in the workspace and prints the path.
///
/// # Errors
/// If the file cannot be written.
pub(crate) fn save_plot(name: &str, svg: &str) -> Result<()> {
    let relative = Path::new("target/acceptance").join(name);
    let path = workspace_root()?.join(&relative);
    let folder = path.parent().context("the plot lies in a folder")?;
    std::fs::create_dir_all(folder).with_context(|| folder.display().to_string())?;
    std::fs::write(&path, svg).with_context(|| path.display().to_string())?;
    print_line(&format!("\nThe curve is drawn in {}", relative.display()));
    Ok(())
}
