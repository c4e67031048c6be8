//! What a tracker's answer rests on, for an overlay to draw.

use barrelman_vocab::PixelBox;

/// Filled by [`Tracker::explain`](crate::Tracker::explain). It belongs to the caller and keeps its memory from one
/// frame to the next.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Explanation {
    /// Where the next frame's search starts, pixels of the picture last seen; none before a selection.
    pub search_window: Option<PixelBox>,
    /// How much each pixel that was looked at in the last frame is like the target, 0 to 255.
    pub back_projection: GreyMap,
    /// How well the target's pattern fits at each place of the search window, the best place 255.
    pub response: GreyMap,
    /// The target's histogram over the circle of hues, each bin scaled so that the largest is 255; the first bin
    /// starts at 0 degrees (red).
    pub histogram: Vec<u8>,
    /// The tracker's own word for its state; none before a selection and from a tracker without states.
    pub stage: Option<Stage>,
    /// What it believes of the last look, 0 to 1, also while it is lost.
    pub confidence: f64,
}

/// A tracker's state, finer than the track that it reports.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Stage {
    /// Seen in the last frame.
    Tracking,
    /// Carried on by prediction.
    Coasting,
    /// Searched for in the whole picture.
    Lost,
    /// Found again, not yet believed.
    Confirming,
}

impl Explanation {
    /// Nothing to show, memory kept.
    pub fn clear(&mut self) {
        self.search_window = None;
        self.back_projection.clear();
        self.response.clear();
        self.histogram.clear();
        self.stage = None;
        self.confidence = 0.0;
    }
}

/// A small grey picture cut out of a frame.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct GreyMap {
    /// Its place in the frame, pixels: `width` x `height` samples of equal size fill it.
    pub bounds: PixelBox,
    /// Samples per row.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// The samples, rows tightly packed, 0 to 255.
    pub samples: Vec<u8>,
}

impl GreyMap {
    /// No samples, memory kept.
    pub fn clear(&mut self) {
        self.bounds = PixelBox::default();
        (self.width, self.height) = (0, 0);
        self.samples.clear();
    }
}
