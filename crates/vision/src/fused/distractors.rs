//! Objects that the operator rejected. Each is followed further, so that the search for the target can
//! exclude its place.
//!
//! Work per frame: that of one tracked target for each distractor, two at most. Not handled: a distractor
//! that is hidden for longer than `kept_s`, or crosses the target.

use barrelman_vocab::{MotionPrior, VideoFrame};

use super::excluded_places::{ExcludedPlaces, MAX_PLACES};
use super::follower::Follower;
use crate::vector::length;

/// Largest number of distractors; a further one takes the place of the oldest.
const MAX_DISTRACTORS: usize = MAX_PLACES;

/// Settings of the distractors. Settings without a figure were not measured individually.
#[derive(Debug, Clone, Copy)]
pub(super) struct DistractorSettings {
    /// Time after which a distractor that is lost is forgotten, seconds. Until then its place is predicted.
    kept_s: f64,
    /// Radius of the excluded place, half diagonals of the distractor's box.
    radius_share: f32,
}

impl Default for DistractorSettings {
    fn default() -> Self {
        Self { kept_s: 10.0, radius_share: 0.9 }
    }
}

/// The rejected objects, the oldest first.
#[derive(Debug, Default)]
pub(super) struct Distractors {
    settings: DistractorSettings,
    followers: Vec<Follower>,
}

impl Distractors {
    /// Forgets all.
    pub(super) fn clear(&mut self) {
        self.followers.clear();
    }

    /// Whether there is none.
    pub(super) fn is_empty(&self) -> bool {
        self.followers.is_empty()
    }

    /// Adds an object that was followed as the target.
    pub(super) fn add(&mut self, rejected: Follower) {
        if self.followers.len() >= MAX_DISTRACTORS {
            self.followers.remove(0);
        }
        self.followers.push(rejected);
    }

    /// Follows all distractors in a frame. Returns their places.
    pub(super) fn advance(&mut self, frame: &VideoFrame, prior: Option<&MotionPrior>) -> ExcludedPlaces {
        let now = frame.capture.at;
        for follower in &mut self.followers {
            // A lost distractor is not searched for, since the search could find the target.
            if follower.phase.is_followed() {
                follower.advance(frame, prior);
            } else {
                follower.adopt_picture_size(frame.picture.size());
                follower.motion.predict_unseen(now, prior, &follower.target.geometry);
            }
        }
        let is_kept = |since| now.since(since).as_secs_f64() <= self.settings.kept_s;
        self.followers.retain(|follower| follower.phase.lost_since().is_none_or(is_kept));
        self.places()
    }

    /// The places of the distractors in the last frame.
    pub(super) fn places(&self) -> ExcludedPlaces {
        let mut places = ExcludedPlaces::default();
        for (place, follower) in places.0.iter_mut().zip(&self.followers) {
            let diagonal = length(follower.target.geometry.upright_box());
            let radius = self.settings.radius_share * 0.5 * diagonal;
            *place = Some((follower.motion.position(), radius));
        }
        places
    }
}
