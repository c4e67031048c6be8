//! What the window of the target showed at the selection, and what it usually shows.

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
    /// Forgets the selection's window.
    pub(crate) fn forget(&mut self) {
        for kept in [&mut self.selected, &mut self.selected_probability, &mut self.usual] {
            kept.clear();
        }
    }

    /// Keeps the brightness and the target probability of the selection's window.
    pub(super) fn set(&mut self, brightness: &[f32], probability: &[f32]) {
        for (kept, cells) in [
            (&mut self.selected, brightness),
            (&mut self.usual, brightness),
            (&mut self.selected_probability, probability),
        ] {
            kept.clear();
            kept.extend_from_slice(cells);
        }
    }

    /// Adapts to the brightness of the window of a frame that is learned from.
    pub(super) fn adapt(&mut self, brightness: &[f32]) {
        for (usual, new) in self.usual.iter_mut().zip(brightness) {
            *usual += USUAL_RATE * (new - *usual);
        }
    }
}
