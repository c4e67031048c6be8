//! The stage that evaluates the refinement network at a box, with the windows and the memory of earlier
//! windows.
//!
//! Input: the crop, the target's model and a box. Output: a [`RefinedBox`]: the edges, their expected errors,
//! and the probability that the box is right.

use std::sync::Arc;

use super::observation::Observation;
use super::target::Target;
use crate::crop::Crop;
use crate::refinement::{
    Measurements, MotionReferences, RefinedBox, RefinementNetwork, RefinementWeights, RefinementWindow,
    WindowContext, WindowMemory,
};
use crate::vector::length;

/// The network with its windows.
#[derive(Debug)]
pub(super) struct Refiner {
    network: RefinementNetwork,
    /// Window of the last refinement.
    pub(super) window: RefinementWindow,
    /// Window of the best of the compared observations.
    best_window: RefinementWindow,
    /// Earlier frames around the target.
    references: MotionReferences,
    /// The window at the selection, and the usual window.
    pub(super) memory: WindowMemory,
}

impl Refiner {
    pub(super) fn new(weights: Arc<RefinementWeights>) -> Self {
        Self {
            network: RefinementNetwork::new(weights),
            window: RefinementWindow::default(),
            best_window: RefinementWindow::default(),
            references: MotionReferences::default(),
            memory: WindowMemory::default(),
        }
    }

    /// The weights of the network.
    pub(super) fn weights(&self) -> Arc<RefinementWeights> {
        self.network.weights()
    }

    /// Begins with a selected target.
    pub(super) fn restart(&mut self) {
        self.window.measurements.fill(0.0);
        self.references.clear();
        self.memory.forget();
    }

    /// Sets the measurements of an observation that the network reads beside the window. `centre` is that of
    /// the box, `distance` that of the observation from the prediction, pixels.
    pub(super) fn set_measurements(
        &mut self,
        target: &Target,
        observation: &Observation,
        centre: (f32, f32),
        distance: f32,
    ) {
        let size = target.geometry.size_px();
        self.window.set_measurements(&Measurements {
            peak_to_sidelobe_ratio: observation.peak.peak_to_sidelobe_ratio,
            relative_height: observation.relative_height,
            relative_contrast: observation.relative_contrast,
            usual_contrast: target.appearance.usual.contrast,
            inside: observation.contrast.inside,
            ring: observation.contrast.ring,
            scale: target.geometry.scale,
            distance_sizes: distance / size,
            relative_motion_sizes: self.references.relative_motion(centre).map(|moved| length(moved) / size),
            size_px: size,
            has_silhouette: target.reference.is_some(),
            evidence: observation.evidence,
        });
    }

    /// Evaluates the network at the target's box with its centre here, pixels.
    pub(super) fn evaluate(&mut self, crop: &mut Crop, target: &Target, centre: (f32, f32)) -> RefinedBox {
        self.measure_window(crop, target, centre, centre, target.geometry.upright_box());
        self.network.evaluate(&self.window)
    }

    /// Measures the window at a box of this centre and size, pixels, while the target's box has its centre at
    /// `tracked`.
    pub(super) fn measure_window(
        &mut self,
        crop: &mut Crop,
        target: &Target,
        tracked: (f32, f32),
        centre: (f32, f32),
        box_size: (f32, f32),
    ) {
        let context = WindowContext {
            tracked,
            picture: target.geometry.picture_size(),
            memory: &self.memory,
            references: &self.references,
        };
        self.window.measure(crop, centre, box_size, context);
    }

    /// Keeps a copy of the last window.
    pub(super) fn keep_window(&mut self) {
        self.best_window.copy_from(&self.window);
    }

    /// Makes the kept window the last one again.
    pub(super) fn return_to_kept(&mut self) {
        self.window.copy_from(&self.best_window);
    }

    /// Remembers the last window as that of the selection.
    pub(super) fn remember_selection(&mut self) {
        self.window.remember_selection(&mut self.memory);
    }

    /// Adapts the usual window to the last one.
    pub(super) fn remember_usual(&mut self) {
        self.window.remember_usual(&mut self.memory);
    }

    /// Adds the background's shift since the last frame, pixels, if it is known.
    pub(super) fn add_background_shift(&mut self, shift: Option<(f32, f32)>) {
        self.references.add_background_shift(shift);
    }

    /// Takes a frame, captured at `at_s` seconds, as a reference if the last one is old enough. `centre` is
    /// that of the target's box, pixels.
    pub(super) fn update_references(&mut self, crop: &Crop, centre: (f32, f32), at_s: f64) {
        self.references.update(crop, centre, at_s);
    }

    /// Forgets the earlier frames.
    pub(super) fn clear_references(&mut self) {
        self.references.clear();
    }
}
