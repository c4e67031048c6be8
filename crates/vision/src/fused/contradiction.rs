//! Where the network's box contradicts the target's own: silhouette and blob took in another thing of the target's colour.
//!
//! A boat that passes close to a buoy of its paint becomes one silhouette with it. The own box grows over both, the filter
//! learns both, and stays with the buoy when the boat goes on. The network's box stays with the boat for a while.

use barrelman_vocab::Picture;

use super::config::FusedConfig;
use super::target::Target;
use super::workspace::Workspace;

/// The network's box contradicts the target's own if it is at least so probable, and has at most this share of its area. The
/// own box is corrected after this many consecutive frames.
const MIN_PROBABILITY: f32 = 0.6;
const MAX_SHARE: f32 = 0.5;
const FRAMES: u32 = 4;
/// A box has grown if its area is larger than usual by this factor. The usual area follows with this time constant, seconds.
const GROWTH: f32 = 1.4;
const USUAL_AREA_S: f32 = 1.5;

/// What was seen of a contradiction until now.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(super) struct Contradiction {
    /// Logarithm of the usual area of the target's own box, pixels squared; `None` before the first frame.
    usual_log_area: Option<f32>,
    /// Consecutive frames with a contradiction.
    frames: u32,
}

impl Contradiction {
    /// Adds a frame, `seconds` after the last one, with the own box's area, pixels squared, and the network's box of this
    /// probability and share of that area. Whether the own box has to be corrected.
    fn is_confirmed(&mut self, area: f32, share: f32, probability: f32, seconds: f32) -> bool {
        let log_area = libm::logf(area);
        let usual = self.usual_log_area.get_or_insert(log_area);
        *usual += (1.0 - libm::expf(-seconds / USUAL_AREA_S)) * (log_area - *usual);
        let has_grown = log_area - *usual > libm::logf(GROWTH);
        let is_contradicted = has_grown && probability >= MIN_PROBABILITY && share <= MAX_SHARE;
        self.frames = if is_contradicted { self.frames + 1 } else { 0 };
        let is_confirmed = self.frames >= FRAMES;
        if is_confirmed {
            self.frames = 0;
        }
        is_confirmed
    }
}

impl Workspace {
    /// Moves a box with a silhouette that has grown onto the network's box where that is probable, and smaller than half of
    /// the target's own box, in several consecutive frames. The filter is retrained.
    pub(super) fn correct_contradicted_box(
        &mut self,
        config: &FusedConfig,
        target: &mut Target,
        picture: &Picture,
        seconds: f32,
    ) {
        if target.reference.is_none() {
            return;
        }
        let [left, top, right, bottom] = self.refined.edges;
        let (w, h) = target.geometry.upright_box();
        let share = (right - left) * (bottom - top) / (w * h);
        if !target.contradiction.is_confirmed(w * h, share, self.refined.probability, seconds) {
            return;
        }
        let geometry = &mut target.geometry;
        geometry.centre = (0.5 * (left + right), 0.5 * (top + bottom));
        geometry.rescale(share.sqrt());
        target.blob = None;
        let pose = target.patch_pose(config);
        self.retrain(target, picture, pose);
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use barrelman_vocab::video::{Capture, CaptureQuality};
    use barrelman_vocab::{PixelBox, Timestamp, VideoFrame};

    use super::*;
    use crate::refinement::RefinementWeights;
    use crate::test_picture::painted;

    const FRAME_S: f32 = 1.0 / 30.0;

    /// Number of frames until a box that grew by this factor is corrected, within 2 s.
    fn corrected_after(growth: f32, share: f32, probability: f32) -> Option<u32> {
        let mut contradiction = Contradiction::default();
        for _ in 0..30 {
            assert!(!contradiction.is_confirmed(600.0, 1.0, 0.9, FRAME_S));
        }
        (1..=60).find(|_| contradiction.is_confirmed(600.0 * growth, share, probability, FRAME_S))
    }

    #[test]
    fn only_a_box_that_grew_is_corrected_by_a_probable_box_of_half_its_area() {
        assert_eq!(corrected_after(4.0, 0.3, 0.7), Some(FRAMES));
        assert_eq!(corrected_after(1.2, 0.3, 0.7), None, "a part that is not hidden");
        assert_eq!(corrected_after(4.0, 0.6, 0.7), None, "it came nearer");
        assert_eq!(corrected_after(4.0, 0.3, 0.5), None, "the network does not know");
    }

    #[test]
    fn a_frame_without_contradiction_starts_the_count_anew() {
        let mut contradiction = Contradiction::default();
        assert!(!contradiction.is_confirmed(600.0, 1.0, 0.9, FRAME_S));
        for probability in [0.7, 0.7, 0.7, 0.5, 0.7, 0.7, 0.7] {
            assert!(!contradiction.is_confirmed(2400.0, 0.3, probability, FRAME_S));
        }
        assert!(contradiction.is_confirmed(2400.0, 0.3, 0.7, FRAME_S));
    }

    #[test]
    fn the_box_is_moved_onto_the_networks() {
        let config = FusedConfig::default();
        let mut workspace = Workspace::new(&config, Arc::clone(&RefinementWeights::built_in()));
        let is_boat = |column, row| (100..130).contains(&column) && (60..72).contains(&row);
        let picture = painted(
            (240, 160),
            |column, row| {
                if is_boat(column, row) { [90, 90, 240] } else { [80, 190, 100] }
            },
        );
        let capture = Capture { at: Timestamp::from_nanos(0), quality: CaptureQuality::Sensor };
        let frame = VideoFrame { sequence: 0, capture, picture: Arc::new(picture) };
        let boat = PixelBox { u: 100.0, v: 60.0, w: 30.0, h: 12.0 };
        let (mut target, _, _) = workspace.learn_selection(&config, &frame, boat);
        assert!(target.reference.is_some());
        workspace.refined.edges = [100.0, 60.0, 130.0, 72.0];
        workspace.refined.probability = 0.9;
        workspace.correct_contradicted_box(&config, &mut target, &frame.picture, FRAME_S);
        target.geometry.rescale(2.0);
        target.geometry.centre = (130.0, 70.0);
        for _ in 0..FRAMES {
            assert_eq!(target.geometry.centre, (130.0, 70.0));
            workspace.correct_contradicted_box(&config, &mut target, &frame.picture, FRAME_S);
        }
        assert_eq!(target.geometry.centre, (115.0, 66.0));
        let (w, h) = target.geometry.upright_box();
        assert!((w * h / 360.0 - 1.0).abs() < 0.05, "{w} x {h}");
    }
}
