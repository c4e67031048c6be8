//! The drawing tools that the parts of an overlay share.

use super::layer::Layer;
use super::style::Style;
use super::text::Typeface;

/// The layer, typeface and style of one overlay.
#[derive(Debug, Default)]
pub(crate) struct Pen {
    pub(crate) layer: Layer,
    pub(crate) type_face: Typeface,
    pub(crate) style: Style,
}

impl Pen {
    /// Prepares a picture of this style; glyphs of another text size are dropped.
    pub(crate) fn begin(&mut self, style: Style) {
        if self.style.text_px != style.text_px {
            self.type_face.forget();
        }
        self.style = style;
    }
}
