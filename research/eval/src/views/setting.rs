//! The sea, the lens and the renderer of a view.

use anyhow::{Context, Result};
use barrelman_sim::render::{RenderSettings, Renderer};
use barrelman_sim::{Optics, Sea, SeaState, Wind};
use barrelman_vocab::{Angle, PictureSize};

use super::catalogue::View;

/// Focal length as a share of the picture's width.
const FOCAL_SHARE: f64 = 0.83;
/// Barrel distortion of the lens.
const BARREL: f64 = 0.06;
/// Steps of the wake before the picture is rendered, ticks.
pub(super) const WAKE_STEP_TICKS: usize = 4;

/// The sea of a view, and the renderer of its pictures.
pub(super) struct Setting {
    pub(super) sea: Sea,
    pub(super) renderer: Renderer,
}

impl Setting {
    /// The setting of pictures of this size, pixels.
    ///
    /// # Errors
    /// If the view's sea state is not from 0 to 4.
    pub(super) fn new(view: &View, size: PictureSize) -> Result<Self> {
        let optics = Optics { picture: size, focal_px: FOCAL_SHARE * f64::from(size.width), barrel: BARREL };
        let state = SeaState::new(view.sea_state).context("a sea state from 0 to 4")?;
        let wind = Wind { speed_mps: state.wind_mps(), towards: Angle::from_degrees(-115.0) };
        let sea = Sea::new(state, wind, 4);
        let renderer = Renderer::new(RenderSettings {
            water: view.water,
            ..RenderSettings::new(optics, Some(sea.clone()), 11)
        });
        Ok(Self { sea, renderer })
    }
}
