//! What a frame is rendered from.

use super::camera::Camera;
use super::frame_objects::FrameObjects;
use super::light::Lighting;
use super::settings::RenderSettings;
use super::texture::Textures;
use super::wake::Wake;
use super::waves::WaveTile;
use crate::sea::Sea;
use crate::snapshot::Snapshot;

/// Everything that a frame is rendered from.
pub(super) struct FrameView<'a> {
    pub(super) settings: &'a RenderSettings,
    pub(super) sea: &'a Sea,
    pub(super) camera: &'a Camera,
    pub(super) textures: &'a Textures,
    pub(super) tiles: [&'a WaveTile; 3],
    /// Variance of slope along one axis that no tile carries.
    pub(super) unresolved_variance: f32,
    pub(super) wake: Option<&'a Wake>,
    pub(super) objects: &'a FrameObjects,
    pub(super) light: &'a Lighting,
    pub(super) snapshot: &'a Snapshot,
}
