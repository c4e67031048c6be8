//! What the window of the target showed at the selection, and what it usually shows.

use super::window::{Channel, RefinementWindow};

/// Rate at which the usual brightness follows that of a learned frame.
const USUAL_RATE: f32 = 0.05;

/// Channels of earlier windows. Empty before the selection.
#[derive(Debug, Clone, Default)]
pub(crate) struct WindowMemory {
    /// Brightness at the selection.
    pub(super) selected: Vec<f32>,
    /// Target probability at the selection.
    pub(super) selected_probability: Vec<f32>,
    /// Running mean of the brightness.
    pub(super) usual: Vec<f32>,
}

impl WindowMemory {
    /// Keeps the window of the selection.
    pub(crate) fn set(&mut self, window: &RefinementWindow) {
        let copy = |to: &mut Vec<f32>, channel| {
            to.clear();
            to.extend_from_slice(window.channel(channel));
        };
        copy(&mut self.selected, Channel::Brightness);
        copy(&mut self.usual, Channel::Brightness);
        copy(&mut self.selected_probability, Channel::TargetProbability);
    }

    /// Adapts to the window of a frame that is learned from.
    pub(crate) fn adapt(&mut self, window: &RefinementWindow) {
        for (usual, new) in self.usual.iter_mut().zip(window.channel(Channel::Brightness)) {
            *usual += USUAL_RATE * (new - *usual);
        }
    }
}
