//! Sun, sky and haze. Colours are linear red, green and blue; white paper in the sun is about 1.

use super::texture::Texture;
use crate::snapshot::Light;

/// A linear colour.
pub(super) type Colour = [f32; 3];

/// The light of one frame.
#[derive(Debug, Clone, Copy)]
pub(super) struct Lighting {
    /// Unit vector to the sun.
    pub(super) to_sun: [f32; 3],
    /// Irradiance by the sun on a surface that faces it, over pi.
    pub(super) sun: Colour,
    /// Irradiance by the sky on a surface that faces up, over pi.
    pub(super) ambient: Colour,
    /// Colour of the clear sky overhead and at the horizon.
    pub(super) zenith: Colour,
    pub(super) horizon: Colour,
    /// Colour of the bright side of clouds.
    pub(super) cloud: Colour,
    /// Cloud values below this are clear sky, 0 to 255.
    pub(super) cloud_floor: f32,
    /// Opacity of clouds for each step above the floor.
    pub(super) cloud_gain: f32,
    /// Drift of the clouds, texels.
    pub(super) drift: f32,
    /// Colour that distant surfaces fade into.
    pub(super) haze: Colour,
}

/// Texels of cloud for the horizontal over the vertical part of a ray.
const CLOUD_SCALE: f32 = 26.0;

pub(super) fn mix(a: Colour, b: Colour, part: f32) -> Colour {
    [a[0] + part * (b[0] - a[0]), a[1] + part * (b[1] - a[1]), a[2] + part * (b[2] - a[2])]
}

impl Lighting {
    pub(super) fn new(light: &Light, tick: u64) -> Self {
        let (sin_b, cos_b) = libm::sincos(light.sun_bearing.radians());
        let (sin_e, cos_e) = libm::sincos(light.sun_elevation.radians());
        let overcast = light.overcast.clamp(0.0, 1.0) as f32;
        let clear = 1.0 - overcast;
        let height = (sin_e as f32).max(0.0);
        // Low suns are weaker and warmer.
        let warm = (1.0 - 2.2 * height).max(0.0);
        let strength = clear * (height * 6.0).min(1.0) * 0.86;
        Self {
            to_sun: [(sin_b * cos_e) as f32, (cos_b * cos_e) as f32, sin_e as f32],
            sun: [strength, strength * (0.95 - 0.22 * warm), strength * (0.87 - 0.42 * warm)],
            ambient: mix([0.17, 0.22, 0.29], [0.56, 0.575, 0.59], overcast),
            zenith: mix([0.115, 0.25, 0.50], [0.40, 0.415, 0.43], overcast),
            horizon: mix([0.52, 0.66, 0.79], [0.50, 0.52, 0.535], overcast),
            cloud: mix([0.80, 0.82, 0.84], [0.56, 0.575, 0.585], overcast),
            cloud_floor: 122.0 - 60.0 * overcast,
            cloud_gain: (1.0 - 0.60 * overcast) / 60.0,
            drift: (tick % 1_000_000) as f32 * 0.000_8,
            haze: mix([0.56, 0.68, 0.78], [0.46, 0.48, 0.50], overcast),
        }
    }

    /// The sky in a direction (unit vector); `blur` (rad) widens its elevation.
    #[inline(always)]
    pub(super) fn sky(&self, clouds: &Texture, x: f32, y: f32, z: f32, blur: f32) -> Colour {
        let height = if z < 0.0 { -0.4 * z } else { z };
        let over = 1.0 / (height + 0.16 + 0.5 * blur);
        let value = clouds.sample(
            x * over * CLOUD_SCALE + self.drift + 1024.0,
            y * over * CLOUD_SCALE * 1.3 + 0.6 * self.drift + 1024.0,
        );
        let opacity = ((value - self.cloud_floor) * self.cloud_gain).max(0.0).min(0.92);
        // Clouds thin out into the haze of the horizon.
        let rise = height + 0.6 * blur;
        let fade = (rise * 5.0).min(1.0);
        let away = 1.0 - rise.min(1.0);
        let towards_horizon = away * away * away;
        let part = opacity * fade;
        let channel = |i: usize| {
            let clear = self.zenith[i] + towards_horizon * (self.horizon[i] - self.zenith[i]);
            clear + part * (self.cloud[i] - clear)
        };
        [channel(0), channel(1), channel(2)]
    }
}
