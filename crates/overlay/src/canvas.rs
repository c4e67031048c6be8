//! The canvas that the parts of an overlay share.

use super::layer::Layer;
use super::style::Style;
use super::text::Typeface;

/// Layer, typeface and style of one overlay.
#[derive(Debug, Default)]
pub(crate) struct Canvas {
    pub(crate) layer: Layer,
    pub(crate) type_face: Typeface,
    pub(crate) style: Style,
}

impl Canvas {
    /// Sets the style of the next picture. Glyphs of another text size are dropped.
    pub(crate) fn begin(&mut self, style: Style) {
        if self.style.text_px != style.text_px {
            self.type_face.clear_cache();
        }
        self.style = style;
    }
}
