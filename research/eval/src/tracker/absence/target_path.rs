//! The target's box in a clip that is played forwards and backwards in turn.

use barrelman_vocab::{PixelBox, VideoFrame};

use crate::tracker::clips::Clip;
use crate::tracker::scoring::Label;

/// The path of the target through the pictures of a clip.
#[derive(Clone)]
pub(super) struct TargetPath {
    /// The target's box in every frame that is used.
    boxes: Vec<PixelBox>,
    /// The frame at time 0, from 0 to twice the number of frames.
    first: usize,
    /// Seconds from frame to frame.
    pub(super) frame_s: f64,
}

impl TargetPath {
    /// The path from the first labelled frame to the last, or to the limit.
    pub(super) fn from_clip(clip: &Clip, max_frames: Option<usize>) -> Self {
        Self { boxes: interpolate_labels(clip, max_frames), first: 0, frame_s: frame_interval_s(clip) }
    }

    /// The path that begins at this frame. Frames from the number of frames on are those played backwards.
    pub(super) fn starting_at(&self, first: usize) -> Self {
        Self { first, ..self.clone() }
    }

    /// How many frames of the clip are used.
    pub(super) fn frames(&self) -> usize {
        self.boxes.len()
    }

    /// The frame of the clip at a time, counted from the clip's start.
    pub(super) fn clip_frame(&self, time_s: f64) -> usize {
        let last = self.boxes.len() - 1;
        // Half a frame is added so that rounding does not repeat a frame.
        let at = (self.first + (time_s / self.frame_s + 0.5) as usize) % (2 * last).max(1);
        if at > last { 2 * last - at } else { at }
    }

    /// The target's box at a time.
    pub(super) fn at(&self, time_s: f64) -> PixelBox {
        self.boxes[self.clip_frame(time_s)]
    }
}

/// Seconds from frame to frame.
fn frame_interval_s(clip: &Clip) -> f64 {
    let time_s = |frame: &VideoFrame| frame.capture.at.as_secs_f64();
    match &clip.frames[..] {
        [first, .., last] => (time_s(last) - time_s(first)) / (clip.frames.len() - 1) as f64,
        _ => 1.0,
    }
}

/// The target's box in every frame from the first labelled one to the last, or to the limit.
fn interpolate_labels(clip: &Clip, max_frames: Option<usize>) -> Vec<PixelBox> {
    let mut boxes: Vec<PixelBox> = Vec::new();
    for (index, label) in clip.labels[clip.start..].iter().enumerate() {
        let Some(Label::Visible(bounds)) = *label else { continue };
        if let Some(last) = boxes.last().copied() {
            let steps = index + 1 - boxes.len();
            for step in 1..=steps {
                boxes.push(interpolate(last, bounds, step as f64 / steps as f64));
            }
        } else {
            boxes.push(bounds);
        }
    }
    boxes.truncate(max_frames.unwrap_or(usize::MAX));
    boxes
}

fn interpolate(a: PixelBox, b: PixelBox, share: f64) -> PixelBox {
    let mix = |a: f64, b: f64| a + (b - a) * share;
    PixelBox { u: mix(a.u, b.u), v: mix(a.v, b.v), w: mix(a.w, b.w), h: mix(a.h, b.h) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tracker::test_clip::test_clip;

    #[test]
    fn labels_are_interpolated_up_to_the_last() {
        let boxes = interpolate_labels(&test_clip(), None);
        assert_eq!((boxes.len(), boxes[3].u, boxes[45].u), (46, 566.0, 650.0));
        assert_eq!(interpolate_labels(&test_clip(), Some(20)).len(), 20);
    }
}
