//! Settings of a renderer.

use barrelman_simd::Simd;

use crate::optics::Optics;
use crate::sea::Sea;

/// Settings of a renderer; constant from frame to frame.
#[derive(Debug, Clone)]
pub struct RenderSettings {
    /// Lens and picture size. Sides are even, 16 to 4096 pixels.
    pub optics: Optics,
    /// The sea; `None` renders calm water where there is water.
    pub sea: Option<Sea>,
    /// Seed of textures, ripples and noise.
    pub seed: u64,
    /// Vector instructions to use; the bits are the same with all.
    pub simd: Simd,
    /// Resolution of the waves.
    pub grid: WaveGrid,
    /// Colour of the water.
    pub water: WaterColour,
    /// From the exposure of the first row to that of the last, seconds: converts the difference of their
    /// poses into the rate that blurs the picture.
    pub readout_s: f64,
    /// Effects to render.
    pub effects: Effects,
}

impl RenderSettings {
    /// All effects, the widest vector instructions of this machine, and a rolling shutter of 18 ms.
    pub fn new(optics: Optics, sea: Option<Sea>, seed: u64) -> Self {
        Self {
            optics,
            sea,
            seed,
            simd: Simd::widest(),
            grid: WaveGrid::Coarse,
            water: WaterColour::Lake,
            readout_s: 0.018,
            effects: Effects::ALL,
        }
    }
}

/// Grid points along the sides of the tiles of waves.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum WaveGrid {
    /// 128 points: for trials.
    Coarse,
    /// 256 points: finer crests, a few milliseconds more for each frame.
    Fine,
}

impl WaveGrid {
    /// Number of grid points.
    pub const fn points(self) -> usize {
        match self {
            Self::Coarse => 128,
            Self::Fine => 256,
        }
    }
}

/// Colour of the water.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum WaterColour {
    /// Teal.
    Lake,
    /// Deep blue.
    Sea,
    /// Green, as in harbours and estuaries.
    Green,
}

/// Effects that can be left out of the picture.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Effects {
    /// The boat's wake.
    pub wake: bool,
    /// Reflections of objects in the water.
    pub reflection: bool,
    /// Shadows of objects.
    pub shadow: bool,
    /// Noise of the sensor.
    pub noise: bool,
    /// Motion blur and softness of the lens.
    pub blur: bool,
}

impl Effects {
    /// All effects.
    pub const ALL: Self = Self { wake: true, reflection: true, shadow: true, noise: true, blur: true };
    /// Surfaces and objects only, for comparing pictures.
    pub const NONE: Self = Self { wake: false, reflection: false, shadow: false, noise: false, blur: false };
}
