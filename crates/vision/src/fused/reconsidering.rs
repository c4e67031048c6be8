//! The search for the target elsewhere in the search window, where the box that is followed is improbable.
//!
//! Away from what is followed, the highest responses of the filters of earlier views (`filter_views`) are places where the target
//! may be. The refinement network decides. Not handled: a target outside of the search window, which is found after it was lost.

use barrelman_vocab::Picture;

use super::config::FusedConfig;
use super::filter_views::{COMPARED_INTERVAL, MAX_VIEWS, MIN_KEPT_PROBABILITY};
use super::observation::Observation;
use super::phase::Phase;
use super::target::Target;
use super::vector::{difference, length};
use super::workspace::Workspace;
use crate::correlation::Peak;
use crate::gradients::CELL;

/// Below this probability of the box that is followed, the target is looked for elsewhere.
const MAX_DOUBTED_PROBABILITY: f32 = 0.5;
/// A place elsewhere has at least this share of the usual height of the response and of the usual contrast of the colour, ...
const MIN_HEIGHT: f32 = 0.15;
const MIN_CONTRAST: f32 = 0.6;
/// ... at least this probability of its box, and is more probable by this much.
const MIN_PROBABILITY: f32 = 0.45;
const CLEARLY_MORE_PROBABLE: f32 = 0.15;
/// Least probability of the box at another place for a target whose own box was never probable: the network hardly knows such a
/// target, and other things in the window often have a higher probability than the target.
const MIN_PROBABILITY_FOR_UNKNOWN: f32 = 0.65;
/// Least distance of two places: sizes of the target, and cells.
const APART_SIZES: f32 = 0.4;
const APART_CELLS: f32 = 2.0;

impl Workspace {
    /// Keeps the view of a frame that is about to be learned from, if it is a new one.
    pub(super) fn keep_view(&self, target: &mut Target) {
        let appearance = &target.appearance;
        if self.refined.probability > MIN_KEPT_PROBABILITY
            && appearance.frames_learned.is_multiple_of(COMPARED_INTERVAL)
        {
            let usual_height = appearance.usual.peak_height;
            target.views.keep_if_new(&appearance.filter, usual_height, &self.features.spectra);
        }
    }

    /// Looks for the target elsewhere in the last search window, with the filters of earlier views, if the refined box of what is
    /// followed is improbable. Where another place is clearly more probable, the target continues from there. The observation
    /// that is taken; crop, window and refined box belong to that observation.
    pub(super) fn reconsider(
        &mut self,
        config: &FusedConfig,
        target: &mut Target,
        picture: &Picture,
        followed: Observation,
    ) -> Observation {
        if self.refined.probability >= MAX_DOUBTED_PROBABILITY {
            target.views.was_probable = true;
            return followed;
        }
        if matches!(target.phase, Phase::Confirming { .. }) {
            return followed;
        }
        let (mut best, mut refined) = (followed, self.refined);
        self.best_window.copy_from(&self.window);
        // What is followed, and one place for each view.
        let mut places = [followed.centre; MAX_VIEWS + 1];
        for index in 0..target.views.kept().len() {
            let Some(other) = self.observe_view(target, index, &places[..=index]) else { continue };
            places[index + 1] = other.centre;
            let height = other.relative_height(target);
            let contrast = other.relative_contrast(target);
            if height < MIN_HEIGHT || contrast.is_some_and(|contrast| contrast < MIN_CONTRAST) {
                continue;
            }
            let its_box = self.refine_observation(config, target, picture, &other);
            if is_better(its_box.probability, refined.probability, target.views.was_probable) {
                (best, refined) = (other, its_box);
                self.best_window.copy_from(&self.window);
            }
        }
        self.return_to(target, picture, &best, refined);
        if best != followed {
            self.references.clear();
            target.continue_at(&best);
        }
        best
    }

    /// The observation at the highest response of a view in the last search window, apart from these places, pixels. Heights are
    /// those of the target's usual response.
    fn observe_view(&mut self, target: &Target, index: usize, places: &[(f32, f32)]) -> Option<Observation> {
        let view = &target.views.kept()[index];
        let (pose, cell) = (self.pose, self.pose.step * CELL as f32);
        let apart = (APART_SIZES * target.geometry.size_px() / cell).max(APART_CELLS);
        let is_apart = |right: f32, down: f32| {
            let here = pose.to_picture(right * CELL as f32, down * CELL as f32);
            places.iter().all(|&place| length(difference(here, place)) >= apart * cell)
        };
        let response = self.respond(&view.filter);
        let mut peak = Peak::find(response).find_other(response, is_apart)?;
        peak.height = view.relative(peak.height) * target.appearance.usual.peak_height;
        Some(self.observation_at(target, peak))
    }
}

/// Whether the target continues from a place with a box of this probability, instead of from the best one so far. `was_probable`:
/// whether the target's box ever was.
fn is_better(probability: f32, best: f32, was_probable: bool) -> bool {
    let min = if was_probable { MIN_PROBABILITY } else { MIN_PROBABILITY_FOR_UNKNOWN };
    probability >= min && probability > best + CLEARLY_MORE_PROBABLE
}

#[cfg(test)]
mod tests {
    use barrelman_vocab::PixelBox;

    use super::super::test_target::{red_on_blue, selected};
    use super::*;

    const BOAT: PixelBox = PixelBox { u: 100.0, v: 60.0, w: 30.0, h: 12.0 };

    fn boat_on_water() -> Picture {
        red_on_blue((240, 160), |column, row| (100..130).contains(&column) && (60..72).contains(&row))
    }

    #[test]
    fn a_track_that_went_over_to_the_water_goes_back_to_the_boat_beside_it() {
        let config = FusedConfig::default();
        let (mut workspace, mut target, _) = selected(&config, boat_on_water(), BOAT);
        let picture = boat_on_water();
        target.views.was_probable = true;
        let pose = target.patch_pose(&config);
        let at_boat = workspace.observe(&target, &picture, pose);
        let (u, v) = target.geometry.centre;
        target.geometry.centre = (u, v + 30.0);
        let on_water = workspace.observation_at(&target, Peak { down: at_boat.peak.down, ..Peak::default() });
        let slipped = Observation { centre: target.geometry.centre, ..on_water };
        let refined = workspace.refine_observation(&config, &target, &picture, &slipped);
        assert!(refined.probability < MAX_DOUBTED_PROBABILITY, "{}", refined.probability);
        let taken = workspace.reconsider(&config, &mut target, &picture, slipped);
        assert!(length(difference(taken.centre, (115.0, 66.0))) < 3.0, "{:?}", taken.centre);
        let continued = target.geometry.centre;
        assert!(length(difference(continued, (115.0, 66.0))) < 3.0, "the target continues from there");
    }

    #[test]
    fn a_target_that_never_was_probable_is_left_for_a_sure_box_alone() {
        assert!(is_better(0.5, 0.2, true));
        assert!(!is_better(0.5, 0.2, false));
        assert!(is_better(0.7, 0.2, false));
    }

    #[test]
    fn a_place_that_is_hardly_more_probable_is_left_alone() {
        assert!(!is_better(0.55, 0.45, true));
        assert!(!is_better(0.4, 0.1, true));
    }

    #[test]
    fn a_view_is_kept_once_and_that_of_the_selection_stays() {
        let config = FusedConfig::default();
        let (mut workspace, mut target, _) = selected(&config, boat_on_water(), BOAT);
        let other_picture = red_on_blue((240, 160), |column, row| {
            (109..121).contains(&column) && (51..81).contains(&row) && (column / 3 + row / 5) % 2 == 0
        });
        let pose = target.patch_pose(&config);
        workspace.refined.probability = MIN_KEPT_PROBABILITY + 0.1;
        workspace.observe(&target, &boat_on_water(), pose);
        workspace.keep_view(&mut target);
        assert_eq!(target.views.kept().len(), 1, "the boat of the selection");
        workspace.observe(&target, &other_picture, pose);
        workspace.keep_view(&mut target);
        assert_eq!(target.views.kept().len(), 2, "another shape");
        for _ in 0..MAX_VIEWS {
            workspace.keep_view(&mut target);
        }
        assert!(target.views.kept().len() <= MAX_VIEWS);
        workspace.refined.probability = MIN_KEPT_PROBABILITY;
        target.views.restart(&target.appearance.filter, target.appearance.usual.peak_height);
        workspace.keep_view(&mut target);
        assert_eq!(target.views.kept().len(), 1, "not sure enough");
    }
}
