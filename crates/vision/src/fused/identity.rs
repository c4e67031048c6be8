//! Whether the followed object is the target, or a similar object.
//!
//! The refinement network judges whether a box fits an object, not which object. After an interruption of the
//! track (a loss, or a jump) the followed object may be a similar one. The confidence is halved then. Two
//! comparisons decide:
//!
//! - with the objects beside the target: the newest picture in which the target was sure is searched as if
//!   the target were lost in it. Where a similar object would be recognised there, the candidate found after
//!   the interruption may be that object.
//! - with the target: a candidate elsewhere than at the loss must be recognised clearly.
//!
//! Work: at most [`MAX_RIVALS`] + 1 search windows and one search by colour, once for each interruption. Not
//! handled: similar objects that come into view after the interruption.

use std::sync::Arc;

use super::config::FusedConfig;
use super::loss::Identity;
use super::recovery::CONFIRMING_SLACK;
use super::target::{MIN_SCORE_ELSEWHERE, Target};
use super::workspace::Workspace;
use crate::features::PatchPose;
use crate::gradients::CELL;

/// Recognition score from which on an object beside the target is similar: a candidate with this score could
/// be confirmed.
const MIN_RIVAL_SCORE: f32 = MIN_SCORE_ELSEWHERE - CONFIRMING_SLACK;
/// Recognition score from which on a candidate is clearly the target, and the same after a gap, when the
/// camera may have turned away meanwhile. Of the candidates in six clips that were cut, 18 of 44 wrong and 14
/// of 121 right ones had less than the first, 38 and 54 less than the second.
const MIN_CLEAR_SCORE: f32 = 2.5;
const MIN_CLEAR_SCORE_AFTER_GAP: f32 = 2.8;
/// Places by colour beside the target that are compared with it.
const MAX_RIVALS: usize = 6;

impl Target {
    /// Judges the identity of the candidate that was confirmed after a loss, by its place and its recognition
    /// score.
    pub(super) fn identify_found(&mut self) {
        let min_score = if self.loss.lost_at.is_in_gap { MIN_CLEAR_SCORE_AFTER_GAP } else { MIN_CLEAR_SCORE };
        if self.is_at_loss(self.geometry.centre) {
            self.identity = Identity::Sure;
        } else if self.loss.recognition.mean < min_score {
            self.identity = Identity::Doubtful;
        }
    }
}

impl Workspace {
    /// Looks for similar objects beside the target after the track was interrupted.
    pub(super) fn check_identity(&mut self, config: &FusedConfig, target: &mut Target) {
        if target.identity == Identity::Unchecked {
            let is_alone = self.best_rival_score(config, target) < MIN_RIVAL_SCORE;
            target.identity = if is_alone { Identity::Sure } else { Identity::Doubtful };
        }
    }

    /// The best recognition score of a similar object in the newest picture in which the target was sure; 0
    /// where there is none.
    fn best_rival_score(&mut self, config: &FusedConfig, target: &Target) -> f32 {
        let Some((picture, own)) = target.scene.newest() else { return 0.0 };
        let picture = Arc::clone(picture);
        let pose = target.patch_pose(config);
        let is_apart = |(u, v): (f32, f32)| {
            let (right, down) = (f64::from(u) - own.u, f64::from(v) - own.v);
            !((0.0..=own.w).contains(&right) && (0.0..=own.h).contains(&down))
        };
        let middle = own.centre();
        let around = PatchPose { centre: (middle.u as f32, middle.v as f32), ..pose };
        let at_target = self.observe(target, &picture, around);
        let is_allowed =
            |right: f32, down: f32| is_apart(around.to_picture(right * CELL as f32, down * CELL as f32));
        let beside = self.observe_other(target, &at_target, is_allowed);
        let mut best = 0.0_f32;
        if let Some(beside) = beside {
            best = self.recognition_score(config, target, &picture, &beside).unwrap_or(0.0);
        }
        let (candidates, count) = self.rank_candidates(target, &picture);
        let apart = candidates[..count].iter().filter(|candidate| is_apart(candidate.centre));
        for candidate in apart.take(MAX_RIVALS) {
            let seen = self.observe(target, &picture, PatchPose { centre: candidate.centre, ..pose });
            if is_apart(seen.centre) {
                best = best.max(self.recognition_score(config, target, &picture, &seen).unwrap_or(0.0));
            }
        }
        best
    }
}

#[cfg(test)]
mod tests {
    use barrelman_vocab::PixelBox;

    use super::super::loss::RecognitionScore;
    use super::super::test_target::{red_on_blue, selected};
    use super::*;

    #[test]
    fn a_jump_brings_doubt_once_and_takes_none_away() {
        assert_eq!(Identity::Sure.after_jump(), Identity::Unchecked);
        assert_eq!(Identity::Doubtful.after_jump(), Identity::Doubtful);
    }

    #[test]
    fn what_was_found_elsewhere_must_be_recognised_clearly_and_more_so_after_a_gap() {
        let config = FusedConfig::default();
        let is_boat = |column, row| (100..130).contains(&column) && (60..72).contains(&row);
        let boat = PixelBox { u: 100.0, v: 60.0, w: 30.0, h: 12.0 };
        let (_, target, _) = selected(&config, red_on_blue((240, 160), is_boat), boat);
        let check = |is_in_gap, is_at_loss, score, expected| {
            let mut target = target.clone();
            target.loss.lost_at.is_in_gap = is_in_gap;
            target.loss.lost_at.is_in_picture = is_at_loss;
            target.loss.recognition = RecognitionScore::default().with(score);
            target.identify_found();
            assert_eq!(target.identity, expected, "{is_in_gap} {is_at_loss} {score}");
        };
        check(false, false, MIN_CLEAR_SCORE - 0.1, Identity::Doubtful);
        check(false, false, MIN_CLEAR_SCORE, Identity::Sure);
        check(true, false, MIN_CLEAR_SCORE, Identity::Doubtful);
        check(true, false, MIN_CLEAR_SCORE_AFTER_GAP, Identity::Sure);
        check(false, true, MIN_CLEAR_SCORE - 0.1, Identity::Sure);
    }
}
