//! The stage that decides whether the followed object is the target, or may be a similar object.
//!
//! The refinement network judges whether a box fits an object, but not which object. After an interruption of
//! the track (a loss, or a jump) the followed object may be a similar one. Two comparisons decide. If either
//! leaves a doubt, the confidence is halved:
//!
//! - with the objects beside the target: the newest picture with a certain target is searched as if the
//!   target were lost in it. If the search recognises another object there, the candidate after the
//!   interruption may be that object.
//! - with the target: a candidate away from the place of the loss must be recognised clearly.
//!
//! Work: at most `max_rivals` + 1 search windows and one search by colour, once for each interruption. Not
//! handled: similar objects that come into view after the interruption.

use std::sync::Arc;

use super::known_scene::KnownScene;
use super::observer::Observer;
use super::recognition::Recognition;
use super::search::Search;
use super::target::Target;
use crate::features::PatchPose;

/// Settings of the check. With the check, 24 of 4,863 cut sequences of the 39 clips show another object at
/// 0.5 or more. Settings without a figure were not measured individually.
#[derive(Debug, Clone, Copy)]
pub(super) struct IdentitySettings {
    /// Minimum recognition score of a candidate that is clearly the target. Of the candidates in six clips
    /// that were cut, 18 of 44 wrong and 14 of 121 right ones had less.
    min_clear_score: f32,
    /// The same after a gap, in which the camera may have turned: 38 of the wrong and 54 of the right ones
    /// had less.
    min_clear_score_after_gap: f32,
    /// Maximum number of places of the target's colour beside the target that are compared with the target.
    max_rivals: usize,
    /// Factor on the confidence of a box that may be that of a similar object. Two similar objects are
    /// equally probable.
    doubtful_share: f64,
}

impl Default for IdentitySettings {
    fn default() -> Self {
        Self { min_clear_score: 2.5, min_clear_score_after_gap: 2.8, max_rivals: 6, doubtful_share: 0.5 }
    }
}

/// Whether the followed object, or the next candidate, is the target.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Identity {
    /// The object is the target.
    Sure,
    /// The track was interrupted, and the objects beside the target have not been compared yet.
    Unchecked,
    /// The object may be a similar one.
    Doubtful,
}

/// The check and its result.
#[derive(Debug, Clone, Copy)]
pub(super) struct IdentityCheck {
    settings: IdentitySettings,
    identity: Identity,
}

/// The inputs of a check.
pub(super) struct IdentityInput<'a> {
    pub(super) observer: &'a mut Observer,
    pub(super) recognition: &'a mut Recognition,
    pub(super) search: &'a mut Search,
    pub(super) scene: &'a KnownScene,
    pub(super) target: &'a Target,
}

impl IdentityCheck {
    pub(super) fn new() -> Self {
        Self { settings: IdentitySettings::default(), identity: Identity::Sure }
    }

    /// Begins with a target that is selected.
    pub(super) fn select(&mut self) {
        self.identity = Identity::Sure;
    }

    /// Whether the followed object is the target.
    pub(super) fn is_sure(&self) -> bool {
        self.identity == Identity::Sure
    }

    /// Factor on the confidence of the followed box.
    pub(super) fn share(&self) -> f64 {
        if self.is_sure() { 1.0 } else { self.settings.doubtful_share }
    }

    /// Records a loss of the target.
    pub(super) fn add_loss(&mut self) {
        self.identity = Identity::Unchecked;
    }

    /// Records a jump of the track within the picture.
    pub(super) fn add_jump(&mut self) {
        if self.is_sure() {
            self.identity = Identity::Unchecked;
        }
    }

    /// Judges the candidate that was confirmed after a loss, by its recognition score. `is_at_loss`: whether
    /// its place is that of the loss.
    pub(super) fn add_found(&mut self, recognition: &Recognition, is_at_loss: bool) {
        let min_score = if recognition.lost_at.is_in_gap {
            self.settings.min_clear_score_after_gap
        } else {
            self.settings.min_clear_score
        };
        if is_at_loss {
            self.identity = Identity::Sure;
        } else if recognition.score.mean < min_score {
            self.identity = Identity::Doubtful;
        }
    }

    /// Looks for similar objects beside the target after the track was interrupted.
    pub(super) fn check(&mut self, mut input: IdentityInput<'_>) {
        if self.identity == Identity::Unchecked {
            let is_alone = self.best_rival_score(&mut input) < input.recognition.min_confirmed_score();
            self.identity = if is_alone { Identity::Sure } else { Identity::Doubtful };
        }
    }

    /// The best recognition score of a similar object in the newest picture with a certain target; 0 if there
    /// is none.
    fn best_rival_score(&self, input: &mut IdentityInput<'_>) -> f32 {
        let Some((picture, own)) = input.scene.newest() else { return 0.0 };
        let picture = Arc::clone(picture);
        let (target, observer) = (input.target, &mut *input.observer);
        let pose = observer.patch_pose(target);
        let is_apart = |(u, v): (f32, f32)| {
            let (right, down) = (f64::from(u) - own.u, f64::from(v) - own.v);
            !((0.0..=own.w).contains(&right) && (0.0..=own.h).contains(&down))
        };
        let middle = own.centre();
        let around = PatchPose { centre: (middle.u as f32, middle.v as f32), ..pose };
        let at_target = observer.observe(target, &picture, around);
        let is_allowed = |right: f32, down: f32| is_apart(around.cell_to_picture(right, down));
        let beside = observer.observe_other(target, &at_target, is_allowed);
        let mut best = 0.0_f32;
        if let Some(beside) = beside {
            best = input.recognition.compare(target, &picture, &beside).unwrap_or(0.0);
        }
        let (candidates, count) = input.search.rank_candidates(target, &picture);
        let apart = candidates[..count].iter().filter(|candidate| is_apart(candidate.centre));
        for candidate in apart.take(self.settings.max_rivals) {
            let seen = observer.observe(target, &picture, PatchPose { centre: candidate.centre, ..pose });
            if is_apart(seen.centre) {
                best = best.max(input.recognition.compare(target, &picture, &seen).unwrap_or(0.0));
            }
        }
        best
    }
}

#[cfg(test)]
mod tests {
    use super::super::config::FusedConfig;
    use super::super::recognition::RecognitionScore;
    use super::*;

    #[test]
    fn a_jump_brings_doubt_once_and_takes_none_away() {
        let after_jump = |identity| {
            let mut check = IdentityCheck { identity, ..IdentityCheck::new() };
            check.add_jump();
            check.identity
        };
        assert_eq!(after_jump(Identity::Sure), Identity::Unchecked);
        assert_eq!(after_jump(Identity::Doubtful), Identity::Doubtful);
    }

    #[test]
    fn what_was_found_elsewhere_must_be_recognised_clearly_and_more_so_after_a_gap() {
        let (clear, after_gap) = (
            IdentitySettings::default().min_clear_score,
            IdentitySettings::default().min_clear_score_after_gap,
        );
        let check = |is_in_gap, is_at_loss, score, expected| {
            let mut recognition = Recognition::new(&FusedConfig::default());
            recognition.lost_at.is_in_gap = is_in_gap;
            recognition.score = RecognitionScore::default().with(score);
            let mut check = IdentityCheck::new();
            check.add_found(&recognition, is_at_loss);
            assert_eq!(check.identity, expected, "{is_in_gap} {is_at_loss} {score}");
        };
        check(false, false, clear - 0.1, Identity::Doubtful);
        check(false, false, clear, Identity::Sure);
        check(true, false, clear, Identity::Doubtful);
        check(true, false, after_gap, Identity::Sure);
        check(false, true, clear - 0.1, Identity::Sure);
    }
}
