//! What a renderer is made for.

use barrelman_simd::Simd;

use crate::optics::Optics;
use crate::sea::Sea;

/// What a renderer is made for; none of it changes from frame to frame.
#[derive(Debug, Clone)]
pub struct RenderSettings {
    /// Lens and picture. Sides are even, 16 to 4096 pixels.
    pub optics: Optics,
    /// The sea; `None` draws calm water where there is water at all.
    pub sea: Option<Sea>,
    /// Where textures, ripples and noise come from.
    pub seed: u64,
    /// Which vector instructions to use: the bits are the same with all.
    pub simd: Simd,
    /// How finely waves are computed.
    pub grid: WaveGrid,
    /// What the water looks like below its surface.
    pub water: WaterColour,
    /// From the first row's exposure to the last one's, seconds: what turns the difference of their poses into the
    /// rate that blurs the picture.
    pub readout_s: f64,
    /// What may be left out.
    pub effects: Effects,
}

impl RenderSettings {
    /// Everything drawn, by what this machine has, with a rolling shutter of 18 ms.
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
    /// 128: what trials want.
    Coarse,
    /// 256: finer crests, a few milliseconds more for each frame.
    Fine,
}

impl WaveGrid {
    /// The number.
    pub const fn points(self) -> usize {
        match self {
            Self::Coarse => 128,
            Self::Fine => 256,
        }
    }
}

/// The water's own colour.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum WaterColour {
    /// Teal.
    Lake,
    /// Deep blue.
    Sea,
    /// Green, as in harbours and estuaries.
    Green,
}

/// What may be left out of the picture.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Effects {
    /// The boat's wake.
    pub wake: bool,
    /// Mirror images of things in the water.
    pub reflection: bool,
    /// Shadows of things.
    pub shadow: bool,
    /// The sensor's noise.
    pub noise: bool,
    /// Motion blur and the softness of the lens.
    pub blur: bool,
}

impl Effects {
    /// All of it.
    pub const ALL: Self = Self { wake: true, reflection: true, shadow: true, noise: true, blur: true };
    /// Nothing but surfaces and things: what a comparison of pictures wants.
    pub const NONE: Self = Self { wake: false, reflection: false, shadow: false, noise: false, blur: false };
}
