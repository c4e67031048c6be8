//! Objects that the operator rejected: each is followed by a tracker of its own, so that the search for the target does not
//! take it again, wherever it moves.
//!
//! Work per frame: that of one tracked target for each distractor, two at most. Not handled: a distractor that is hidden
//! for longer than [`KEPT_S`], or that crosses the target.

use std::sync::Arc;

use barrelman_vocab::{MotionPrior, VideoFrame};

use super::config::FusedConfig;
use super::excluded_places::{ExcludedPlaces, MAX_PLACES};
use super::phase::Phase;
use super::target::Target;
use super::workspace::Workspace;
use crate::refinement::RefinementWeights;

/// Largest number of distractors; a further one takes the place of the oldest.
const MAX_DISTRACTORS: usize = MAX_PLACES;
/// A distractor that was not seen for longer is forgotten, seconds. Its place is predicted meanwhile.
const KEPT_S: f64 = 10.0;
/// Radius of the place that is excluded, in half diagonals of the distractor's box.
const RADIUS_SHARE: f32 = 0.9;

/// A rejected object with the buffers for following it.
#[derive(Debug)]
struct Distractor {
    workspace: Workspace,
    target: Target,
}

/// The rejected objects.
#[derive(Debug, Default)]
pub(super) struct Distractors(Vec<Distractor>);

impl Distractors {
    /// Forgets all.
    pub(super) fn clear(&mut self) {
        self.0.clear();
    }

    /// Whether there is none.
    pub(super) fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// Adds an object that was followed as the target.
    pub(super) fn add(&mut self, config: &FusedConfig, weights: Arc<RefinementWeights>, target: Target) {
        if self.0.len() >= MAX_DISTRACTORS {
            self.0.remove(0);
        }
        self.0.push(Distractor { workspace: Workspace::new(config, weights), target });
    }

    /// Follows all distractors in a frame; their places.
    pub(super) fn advance(
        &mut self,
        config: &FusedConfig,
        frame: &VideoFrame,
        prior: Option<&MotionPrior>,
    ) -> ExcludedPlaces {
        for distractor in &mut self.0 {
            // A distractor that is lost is not searched for: the search could find the target.
            match distractor.target.phase {
                Phase::Tracking | Phase::Coasting { .. } => {
                    distractor.workspace.advance(config, &mut distractor.target, frame, prior);
                }
                Phase::Lost { .. } | Phase::Confirming { .. } => {
                    distractor.target.rescale_to_picture(frame.picture.size());
                    distractor.target.predict_unseen(config, frame.capture.at, prior);
                }
            }
        }
        let now = frame.capture.at;
        self.0.retain(|distractor| match distractor.target.phase {
            Phase::Lost { since } | Phase::Confirming { since, .. } => {
                now.since(since).as_secs_f64() <= KEPT_S
            }
            Phase::Tracking | Phase::Coasting { .. } => true,
        });
        self.places()
    }

    /// The places of the distractors in the last frame.
    pub(super) fn places(&self) -> ExcludedPlaces {
        let mut places = ExcludedPlaces::default();
        for (place, distractor) in places.0.iter_mut().zip(&self.0) {
            let geometry = &distractor.target.geometry;
            let (w, h) = geometry.upright_box();
            let radius = RADIUS_SHARE * 0.5 * libm::hypotf(w, h);
            *place = Some((distractor.target.motion.position_f32(), radius));
        }
        places
    }
}
