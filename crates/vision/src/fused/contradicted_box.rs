//! The correction of a target's own box that the network's box contradicts.

use barrelman_vocab::Picture;

use super::config::FusedConfig;
use super::target::Target;
use super::workspace::Workspace;

impl Workspace {
    /// Moves a box with a silhouette onto the network's box where that is probable, and in several consecutive frames less than half
    /// as large as the target's own box, which has grown, or more than twice as large. The filter is retrained.
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
        self.retrain_at_box(config, target, picture);
    }
}

#[cfg(test)]
mod tests {
    use barrelman_vocab::PixelBox;

    use super::super::contradiction::FRAMES;
    use super::super::test_target::{red_on_blue, selected};
    use super::*;

    const FRAME_S: f32 = 1.0 / 30.0;

    #[test]
    fn the_box_is_moved_onto_the_networks() {
        let config = FusedConfig::default();
        let is_boat = |column, row| (100..130).contains(&column) && (60..72).contains(&row);
        let boat = PixelBox { u: 100.0, v: 60.0, w: 30.0, h: 12.0 };
        let (mut workspace, mut target, frame) = selected(&config, red_on_blue((240, 160), is_boat), boat);
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
