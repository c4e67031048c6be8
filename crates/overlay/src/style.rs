//! Colours, line widths and text sizes, and how much is shown at which size of picture.

use barrelman_vocab::PictureSize;
use tiny_skia::{Color, PremultipliedColorU8};

/// A colour with its opacity, 0 to 255 each, not premultiplied.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Ink {
    pub(super) red: u8,
    pub(super) green: u8,
    pub(super) blue: u8,
    pub(super) opacity: u8,
}

impl Ink {
    /// The accent: the target while it is tracked, and whatever the camera is made to do.
    pub(super) const ACCENT: Self = Self::opaque(94, 234, 212);
    /// Where the target's pattern fits.
    pub(super) const PATTERN: Self = Self::opaque(167, 110, 250);
    /// The target while it coasts; a pilot that holds.
    pub(super) const CAUTION: Self = Self::opaque(251, 191, 36);
    /// A lost target; a stop.
    pub(super) const ALARM: Self = Self::opaque(239, 68, 68);
    /// Values and geometry.
    pub(super) const LIGHT: Self = Self::opaque(241, 245, 249);
    /// The names of values.
    pub(super) const QUIET: Self = Self::opaque(148, 163, 184);
    /// Plates behind text, and the casing of lines.
    pub(super) const DARK: Self = Self::opaque(8, 15, 23);

    const fn opaque(red: u8, green: u8, blue: u8) -> Self {
        Self { red, green, blue, opacity: 255 }
    }

    /// The same colour at another opacity, 0 to 1.
    pub(super) fn at(self, opacity: f32) -> Self {
        Self { opacity: (opacity * 255.0 + 0.5) as u8, ..self }
    }

    /// This colour laid over a pixel.
    pub(super) fn over(self, under: PremultipliedColorU8) -> PremultipliedColorU8 {
        let opacity = u32::from(self.opacity);
        // Each channel is rounded once, as (over × opacity + under × (1 - opacity)); none can exceed the opacity.
        let mix = |over: u8, under: u8| {
            ((u32::from(over) * opacity + u32::from(under) * (255 - opacity) + 127) / 255) as u8
        };
        let mixed = PremultipliedColorU8::from_rgba(
            mix(self.red, under.red()),
            mix(self.green, under.green()),
            mix(self.blue, under.blue()),
            mix(255, under.alpha()),
        );
        mixed.unwrap_or(under)
    }

    pub(super) fn colour(self) -> Color {
        Color::from_rgba8(self.red, self.green, self.blue, self.opacity)
    }
}

/// How much is shown.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Default)]
pub(super) enum Detail {
    /// Lines only: below 200 x 120 pixels there is no room for words.
    #[default]
    Bare,
    /// The status strip, the lost banner and the tracker's panel, but no labels in the picture: below 480 x 300 pixels.
    Sparse,
    /// Everything.
    Full,
}

/// Measures of one size of picture, pixels.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct Style {
    /// How much is shown.
    pub(super) detail: Detail,
    /// Width of a usual line.
    pub(super) line: f32,
    /// Height of a line of text from the highest to the lowest stroke.
    pub(super) text_px: u16,
    /// What is kept free along the picture's edges and between things.
    pub(super) margin: f64,
}

/// Lines, texts and margins count in pixels of a picture with this many lines, and grow and shrink with it.
const REFERENCE_LINES: f32 = 720.0;

impl Style {
    /// The measures for pictures of that size.
    pub(super) fn of(picture: PictureSize) -> Self {
        let (width, height) = (picture.width, picture.height);
        // A narrow picture is measured by its width, as one of 16:9 would be.
        let lines = (height as f32).min(width as f32 * 9.0 / 16.0);
        let scale = lines / REFERENCE_LINES;
        Self {
            detail: match () {
                () if width >= 480 && height >= 300 => Detail::Full,
                () if width >= 200 && height >= 120 => Detail::Sparse,
                () => Detail::Bare,
            },
            line: (1.8 * scale).clamp(1.0, 6.0),
            // Smaller letters than 12 pixels cannot be read.
            text_px: (18.0 * scale).clamp(12.0, 60.0) as u16,
            margin: f64::from((12.0 * scale).clamp(3.0, 40.0)),
        }
    }

    /// Lengths of the drawing at 720 lines, brought to this picture.
    pub(super) fn scaled(&self, px_at_720_lines: f32) -> f32 {
        px_at_720_lines * self.line / 1.8
    }
}
