//! Places of a video frame that the search for the target excludes: those of objects that the operator
//! rejected.

use crate::vector::distance;
/// Largest number of places.
pub(super) const MAX_PLACES: usize = 2;

/// Places in one video frame: circles, centre and radius in pixels.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct ExcludedPlaces(pub(super) [Option<((f32, f32), f32)>; MAX_PLACES]);

impl ExcludedPlaces {
    /// Whether a point lies in one of the places.
    pub(super) fn contains(&self, point: (f32, f32)) -> bool {
        self.0.iter().flatten().any(|&(centre, radius)| distance(point, centre) <= radius)
    }
}
