//! The target: the plain data that flows from stage to stage.

use super::appearance::Appearance;
use super::geometry::TargetGeometry;
use super::reference_silhouette::ReferenceSilhouette;

/// The target as it was in the last frame.
#[derive(Debug, Clone)]
pub(super) struct Target {
    pub(super) geometry: TargetGeometry,
    pub(super) appearance: Appearance,
    /// The silhouette at the selection, if it can be trusted.
    pub(super) reference: Option<ReferenceSilhouette>,
}
