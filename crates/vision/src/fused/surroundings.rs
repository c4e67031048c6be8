//! What is known of other things around a target.

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
    pub(super) mixture: Mixture,
}

/// Longest time for which a mixed box is not learned from, seconds. If it is still mixed then, the target itself has changed.
const MAX_MIXED_S: f32 = 2.5;

/// Whether the target's box holds another thing, too, such as one that passes in front of it. A tracker that learns from such a
/// box stays with the other thing.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Mixture {
    /// Whether the box has colours that are not the target's, when they were counted last.
    pub(super) has_other_colours: bool,
    /// How long it was mixed, less how long it was not since, seconds.
    mixed_s: f32,
}

impl Mixture {
    /// Counts a frame, `seconds` after the last one.
    fn count(&mut self, seconds: f32) {
        let way = if self.has_other_colours { seconds } else { -seconds };
        self.mixed_s = (self.mixed_s + way).clamp(0.0, MAX_MIXED_S);
    }

    /// Whether nothing is to be learned from the box.
    pub(super) fn is_passing(&self) -> bool {
        self.has_other_colours && self.mixed_s < MAX_MIXED_S
    }
}

impl Surroundings {
    /// Moves the predictions to the next frame, `seconds` after the last one.
    pub(super) fn predict(&mut self, seconds: f32) {
        self.companions.predict(seconds);
        self.mixture.count(seconds);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const FRAME_S: f32 = 1.0 / 30.0;

    /// How many of so many frames are not learned from.
    fn passing_frames(mixture: &mut Mixture, frames: u32) -> u32 {
        let is_passing = |mixture: &mut Mixture| {
            mixture.count(FRAME_S);
            mixture.is_passing()
        };
        (0..frames).map(|_| u32::from(is_passing(mixture))).sum()
    }

    #[test]
    fn a_mixed_box_is_not_learned_from_until_it_stays_so() {
        let mut mixture = Mixture { has_other_colours: true, ..Mixture::default() };
        assert_eq!(passing_frames(&mut mixture, 60), 60);
        let more = passing_frames(&mut mixture, 60);
        assert!((10..20).contains(&more), "{more}");
        mixture.has_other_colours = false;
        assert_eq!(passing_frames(&mut mixture, 30), 0);
        mixture.has_other_colours = true;
        let after_a_second = passing_frames(&mut mixture, 60);
        assert!((25..35).contains(&after_a_second), "{after_a_second}");
    }
}
