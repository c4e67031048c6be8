//! What is known of other things of a target's colour around it.

use super::companions::Companions;
use super::extent::Extent;

/// What is known of the things around a target, and of the target before they came near.
#[derive(Debug, Clone, Default)]
pub(super) struct Surroundings {
    pub(super) companions: Companions,
    /// Usual area of its component, pixels squared.
    pub(super) usual_area: Option<f32>,
    /// Scale and proportions while no other thing was near.
    pub(super) clear_shape: Option<(f32, Extent)>,
    /// Time since the track was moved, seconds.
    pub(super) since_exchange_s: f32,
}

impl Surroundings {
    /// Moves the predictions to the next frame, `seconds` after the last one, with the target of this size, pixels.
    pub(super) fn predict(&mut self, size: f32, seconds: f32) {
        self.companions.predict(size, seconds);
    }
}
