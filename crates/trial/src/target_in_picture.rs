//! What a picture shows of the target: the truth beside which a tracker is judged.

use barrelman_vocab::{ImagePoint, PixelBox, Track};

/// What a picture of a simulated world shows of the target.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct TargetInPicture {
    /// Bounds of the visible part of the target, pixels of the video frame; `None` where no part is visible.
    pub bounds: Option<PixelBox>,
    /// Visible share of the target, 0 to 1: of what would be seen on still water, unhidden and wholly in the
    /// picture.
    pub visible_share: f64,
}

/// A track beside the truth of the picture that it rests on.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct JudgedTrack {
    /// True position of the target, also beyond the picture's border.
    pub position: ImagePoint,
    /// Visible share of the target, 0 to 1.
    pub visible_share: f64,
    /// Whether the tracker measured the target in this picture.
    pub is_tracking: bool,
    /// IoU of the track's box and the visible part of the target, 0 where no part is visible; `None`: the
    /// track has no box.
    pub iou: Option<f64>,
    /// The tracker's confidence, 0 to 1.
    pub confidence: f64,
}

impl JudgedTrack {
    /// Judges a track about a picture in which the target has this true position.
    pub fn new(track: Track, target: &TargetInPicture, position: ImagePoint) -> Self {
        let localisation = track.localisation();
        let iou_of = |bounds: PixelBox| target.bounds.map_or(0.0, |target| bounds.iou(target));
        Self {
            position,
            visible_share: target.visible_share,
            is_tracking: matches!(track, Track::Tracking(_)),
            iou: localisation.map(|localisation| iou_of(localisation.bounds)),
            confidence: localisation.map_or(0.0, |localisation| localisation.confidence),
        }
    }
}
