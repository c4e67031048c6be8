//! What a tracker's answer is based on, for an overlay.

use barrelman_vocab::PixelBox;

/// Filled by [`Tracker::explain`](crate::Tracker::explain). The caller owns it; its memory is reused from
/// frame to frame.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Explanation {
    /// Where the next search starts, pixels of the last picture; `None` before a selection.
    pub search_window: Option<PixelBox>,
    /// How well each evaluated pixel of the last frame matches the target's colour, 0 to 255.
    pub back_projection: GreyMap,
    /// The correlation filter's response in the search window, scaled to a maximum of 255.
    pub response: GreyMap,
    /// The target's hue histogram, scaled to a maximum of 255; the first bin starts at 0 degrees (red).
    pub histogram: Vec<u8>,
    /// The tracker's state; `None` before a selection, and from a tracker without states.
    pub state: Option<TrackerState>,
    /// Confidence of the last observation, 0 to 1, also while the target is lost.
    pub confidence: f64,
}

/// A tracker's state, in more detail than the reported track.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum TrackerState {
    /// Visible in the last frame.
    Tracking,
    /// Not visible; the position is predicted.
    Coasting,
    /// Searched for in the whole picture.
    Lost,
    /// Re-detected, not confirmed yet.
    Confirming,
}

impl Explanation {
    /// Removes the content and keeps the memory.
    pub fn clear(&mut self) {
        self.search_window = None;
        self.back_projection.clear();
        self.response.clear();
        self.histogram.clear();
        self.state = None;
        self.confidence = 0.0;
    }
}

/// A greyscale map over a part of a video frame.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct GreyMap {
    /// Bounds in the video frame, pixels, filled by `width` x `height` samples of equal size.
    pub bounds: PixelBox,
    /// Samples per row.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// The samples, rows tightly packed, 0 to 255.
    pub samples: Vec<u8>,
}

impl GreyMap {
    /// Removes the samples and keeps the memory.
    pub fn clear(&mut self) {
        self.bounds = PixelBox::default();
        (self.width, self.height) = (0, 0);
        self.samples.clear();
    }
}
