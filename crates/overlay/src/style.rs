//! Colours, line widths, text sizes, and the level of detail for a size of picture.

use barrelman_vocab::PictureSize;
use tiny_skia::{Color, PremultipliedColorU8};

/// A colour with its opacity, 0 to 255 each, not premultiplied.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Rgba {
    pub(super) red: u8,
    pub(super) green: u8,
    pub(super) blue: u8,
    pub(super) opacity: u8,
}

impl Rgba {
    /// Accent: a tracked target, and camera motion.
    pub(super) const ACCENT: Self = Self::opaque(94, 234, 212);
    /// Response of the correlation filter.
    pub(super) const PATTERN: Self = Self::opaque(167, 110, 250);
    /// A coasting target; a holding pilot.
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
    pub(super) fn with_opacity(self, opacity: f32) -> Self {
        Self { opacity: (opacity * 255.0 + 0.5) as u8, ..self }
    }

    /// This colour blended over a pixel.
    pub(super) fn blend_over(self, under: PremultipliedColorU8) -> PremultipliedColorU8 {
        let opacity = u32::from(self.opacity);
        // Each channel is rounded once, as (over × opacity + under × (1 - opacity)); none can exceed the
        // opacity.
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

    pub(super) fn to_skia(self) -> Color {
        Color::from_rgba8(self.red, self.green, self.blue, self.opacity)
    }
}

/// Level of detail.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Default)]
pub(super) enum Detail {
    /// Lines only: there is no room for text below 200 x 120 pixels.
    #[default]
    Bare,
    /// The status strip, the lost banner and the tracker's panel, but no labels in the picture: below 480 x
    /// 300 pixels.
    Sparse,
    /// Everything.
    Full,
}

/// Dimensions for one size of picture, pixels.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct Style {
    /// Level of detail.
    pub(super) detail: Detail,
    /// Width of a line of weight 1.
    pub(super) line: f32,
    /// Height of a line of text from the highest to the lowest stroke.
    pub(super) text_px: u16,
    /// Distance from the picture's edges and between elements.
    pub(super) margin: f64,
}

/// Height of the reference picture, lines: the sizes of lines, text and margins are given for it and scale
/// with the picture.
const REFERENCE_LINES: f32 = 720.0;

impl Style {
    /// The dimensions for pictures of this size.
    pub(super) fn for_picture(picture: PictureSize) -> Self {
        let (width, height) = (picture.width, picture.height);
        // A narrow picture counts as one of 16:9 with its width.
        let lines = (height as f32).min(width as f32 * 9.0 / 16.0);
        let scale = lines / REFERENCE_LINES;
        Self {
            detail: match () {
                () if width >= 480 && height >= 300 => Detail::Full,
                () if width >= 200 && height >= 120 => Detail::Sparse,
                () => Detail::Bare,
            },
            line: (1.8 * scale).clamp(1.0, 6.0),
            // Text below 12 pixels is not legible.
            text_px: (18.0 * scale).clamp(12.0, 60.0) as u16,
            margin: f64::from((12.0 * scale).clamp(3.0, 40.0)),
        }
    }

    /// A length at 720 lines, scaled to this picture.
    pub(super) fn scaled(&self, px_at_720_lines: f32) -> f32 {
        px_at_720_lines * self.line / 1.8
    }
}
