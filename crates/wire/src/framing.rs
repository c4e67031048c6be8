//! The framing of text lines.

/// Where the line ends of a text line stand.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Default)]
pub enum Framing {
    /// `\r` before and after, as the paper's program sent lines.
    #[default]
    CarriageReturns,
    /// `\n` after, as the client libraries send lines.
    LineFeed,
}
